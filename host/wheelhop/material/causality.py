"""Kramers and Kronig: what dynamic and loss modulus must have to do with each other.

For functions of log ω both of the source's relations, (3.12) and its expansion (3.16), say the
same: with θ = d/d(log ω), M_l = tan(πθ/2) M_d, as M_d = cos(πθ/2) G and M_l = sin(πθ/2) G for the
G that is real on the positive real s axis. A polynomial in log s with real coefficients is causal
whatever they are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import factorial, pi

import numpy as np
from scipy import optimize, special

from wheelhop.material.data import ModulusData
from wheelhop.material.model import Array, ComplexArray

REACH, STEP = 50.0, 0.05  # of the integral over log(ω'/ω): the integrand falls like its exponential
BEST_ACCURACY = 1e-3
"""No rig measures a modulus better than this: a smaller disagreement means nothing."""
SURE = 1e-5
"""Data are called inconsistent if chance would do that less often than this."""
HIGHEST_DEGREE = 7
PASSIVE_HZ = np.logspace(-4, 5, 721)


def loss_of_dynamic(dynamic: Callable[[Array], Array], omega: Array) -> Array:
    """The loss modulus (f,) that causality demands beside M_d(ω), by (3.12).

    With ω' = ω eᵘ and one subtraction, M_l(ω) = 1/π ∫ (M_d(ω eᵘ) − M_d(ω)) / sinh u du over all u:
    smooth at u = 0, and finite for every M_d that grows less than in proportion to ω.
    """
    u = (np.arange(-REACH / STEP, REACH / STEP) + 0.5) * STEP
    values = dynamic((omega[:, None] * np.exp(u)).ravel()).reshape(len(omega), len(u))
    integrand = (values - dynamic(omega)[:, None]) / np.sinh(u)
    return np.asarray(integrand.sum(axis=1) * STEP / pi)


def violation(modulus: Callable[[Array], ComplexArray], omega: Array) -> float:
    """Largest |M_l demanded − M_l| / M_l of a model over ω (f,); zero for a causal one."""
    demanded = loss_of_dynamic(lambda w: np.asarray(modulus(w).real), omega)
    loss = modulus(omega).imag
    return float(np.abs(demanded / loss - 1).max())


def passive_range_hz(
    modulus: Callable[[Array], ComplexArray], inside_hz: tuple[float, float]
) -> tuple[float, float] | None:
    """Frequencies around `inside_hz` between which the model loses energy, from 0.1 mHz to 100 kHz;
    None if it does not everywhere inside."""
    loses = modulus(2 * pi * PASSIVE_HZ).imag >= 0.0
    first = int(np.searchsorted(PASSIVE_HZ, inside_hz[0]))
    last = int(np.searchsorted(PASSIVE_HZ, inside_hz[1])) - 1
    if not loses[first : last + 1].all():
        return None
    while first > 0 and loses[first - 1]:
        first -= 1
    while last < len(loses) - 1 and loses[last + 1]:
        last += 1
    return float(PASSIVE_HZ[first]), float(PASSIVE_HZ[last])


@dataclass(frozen=True, eq=False)
class Consistency:
    """Whether dynamic and loss moduli as measured can belong to one causal specimen.

    ``probability`` is how often chance alone makes causal data disagree as much; ``disagreement``
    the rms difference, a fraction, between the smooth course of the data and the nearest causal
    one; ``expansion`` the loss (f,) by (3.16) and ``expansion_residual`` its rms distance from the
    measured loss, a fraction of that.
    """

    probability: float
    disagreement: float
    expansion: Array
    expansion_residual: float

    @property
    def causal(self) -> bool:
        """Whether the data may be those of a causal specimen."""
        return self.probability >= SURE


def consistency(data: ModulusData) -> Consistency:
    """Compare two smooth descriptions of the data: both moduli tied by causality, or each free.

    Free, they are a polynomial of degree d in log ω and another of degree d − 1, the degree being
    the one that AICc asks for. Tied, they are one polynomial of degree d in log s, or, where that
    comes nearer, a spring, a damper and a spectrum of relaxations of any positive strengths. An F
    test asks whether freedom, d numbers more, is worth it.
    """
    x = np.log(data.omega)
    x = x - x.mean()
    target = np.ones(2 * len(x))
    weight = np.concatenate([1 / data.modulus.real, 1 / data.modulus.imag])[:, None]
    n = len(target)
    best = np.inf
    degree, free = 1, np.zeros(n)
    for d in range(1, min(HIGHEST_DEGREE, (len(x) - 1) // 2) + 1):
        smooth = _projected(_free(x, d) * weight, target)
        k = 2 * d + 2
        rss = float(((target - smooth) ** 2).sum()) + n * (0.1 * BEST_ACCURACY) ** 2
        criterion = n * np.log(rss / n) + 2 * k + 2 * k * (k + 1) / max(n - k - 1, 1e-9)
        if criterion < best:
            best, degree, free = criterion, d, smooth
    causal = (
        _projected(_tied(x, degree) * weight, target),
        _relaxing(data.omega, weight, target),
    )
    tied = min(causal, key=lambda smooth: float(((target - smooth) ** 2).sum()))
    spare = n - (2 * degree + 1)
    noise = max(float(((target - free) ** 2).sum()) / spare, BEST_ACCURACY**2)
    lost = float(((target - tied) ** 2).sum() - ((target - free) ** 2).sum())
    expansion = loss_by_expansion(data, degree)
    return Consistency(
        float(special.fdtrc(degree, spare, max(lost, 0.0) / degree / noise)),
        float(np.sqrt(((tied - free) ** 2).mean())),
        expansion,
        float(np.sqrt(((expansion / data.modulus.imag - 1) ** 2).mean())),
    )


def loss_by_expansion(data: ModulusData, degree: int) -> Array:
    """The loss (f,) by (3.16), π/2 θ M_d + π³/24 θ³ M_d, of the polynomial of this degree in log ω
    through the measured M_d, each relative to its size."""
    log = np.log(data.omega)
    dynamic = np.polynomial.Polynomial.fit(log, data.modulus.real, degree, w=1 / data.modulus.real)
    return np.asarray(pi / 2 * dynamic.deriv(1)(log) + pi**3 / 24 * dynamic.deriv(3)(log))


def _free(x: Array, degree: int) -> Array:
    """Columns (2f, 2d+1): powers of x for the dynamic, and for the loss up to one less."""
    powers = np.vander(x, degree + 1, increasing=True)
    none = np.zeros_like(powers)
    return np.block([[powers, none[:, :-1]], [none, powers[:, :-1]]])


def _tied(x: Array, degree: int) -> Array:
    """Columns (2f, d+1): real parts above imaginary parts of (x + iπ/2)ᵏ."""
    powers = np.stack([(x + 0.5j * pi) ** k / factorial(k) for k in range(degree + 1)], axis=1)
    return np.concatenate([powers.real, powers.imag])


def _relaxing(omega: Array, weight: Array, target: Array) -> Array:
    """The nearest to the target (2f,) that relaxations from two decades below the data to two
    above, a damper and a spring of either sign make."""
    times = np.geomspace(1e-2 / omega.max(), 1e2 / omega.min(), 80)
    phase = 1j * omega[:, None] * times
    one = np.ones((len(omega), 1))
    basis = np.concatenate([one, -one, 1j * omega[:, None], phase / (1 + phase)], axis=1)
    columns = np.concatenate([basis.real, basis.imag]) * weight
    columns = columns / np.sqrt((columns**2).sum(axis=0))
    return np.asarray(columns @ optimize.nnls(columns, target)[0])


def _projected(columns: Array, target: Array) -> Array:
    return np.asarray(columns @ np.linalg.lstsq(columns, target, rcond=1e-12)[0])
