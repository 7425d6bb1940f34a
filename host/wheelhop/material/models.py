"""Models of a bushing's complex modulus with few parameters, from chapter 3 of the source."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import cos, pi, sin, tan

import numpy as np

from wheelhop.material.model import Array, Coefficient, ComplexArray, ModulusModel

THESIS = "Kanchwala, Studies in simplified dynamic modeling … of vehicle suspensions, chapter 3"
EXPONENTS = np.array([0.01, 0.02, 0.03, 0.045, 0.06, 0.08, 0.11, 0.15, 0.2, 0.3, 0.4, 0.55, 0.75])
WEIGHT = "N/m"


class LogarithmicPolynomial(ModulusModel):
    """M = A₀ + A₁ log ω + A₂ log² ω + iπ (A₁/2 + A₂ log ω), (3.39) and (3.40).

    Exactly causal: it is a polynomial in log s, less a constant (3.38).
    """

    id = "logarithmic-polynomial"
    title = "logarithmic polynomial"
    equation = r"M = A_0 + A_1\ln\omega + A_2\ln^2\omega + i\pi\,(A_1/2 + A_2\ln\omega)"
    source = f"{THESIS}, (3.39), (3.40)"
    coefficients = tuple(Coefficient(name, WEIGHT) for name in ("A0", "A1", "A2"))

    def modulus(self, omega: Array, parameters: Array) -> ComplexArray:
        """(3.39) + i (3.40)."""
        return np.asarray(self.derivatives(omega, parameters) @ parameters)

    def derivatives(self, omega: Array, parameters: Array) -> ComplexArray:
        """The basis itself: the model is linear."""
        return self.basis(omega, np.empty(0))

    def shapes(self, omega: Array) -> Iterable[Array]:
        """None to choose."""
        return [np.empty(0)]

    def basis(self, omega: Array, shape: Array) -> ComplexArray:
        """1, log ω + iπ/2, log² ω + iπ log ω."""
        log = np.log(omega)
        return np.stack([np.ones(len(omega)), log + 0.5j * pi, log**2 + 1j * pi * log], axis=1)

    def admits(self, shape: Array) -> bool:
        """There is none."""
        return True

    def assembled(self, weights: Array, shape: Array) -> Array:
        """A₀, A₁, A₂."""
        return weights


class ModifiedPowerLaw(ModulusModel):
    """M = M₀ + (a(log ω) + i b(log ω)) A₀ ω^β, (3.31)–(3.33) as published.

    A₁ and A₂ follow from A₀ and β by (3.29) and (3.31) as printed, B₀ … B₂ from (3.22) with its B₁
    corrected to κ A₁ + (π + π³β²/4) A₂: with the B₁ that is printed the loss modulus falls short of
    the other columns of Table 3.2 by 20 to 28 %. Causal up to terms of order β⁴.
    """

    id = "modified-power-law"
    title = "modified power law"
    equation = (
        r"M = M_0 + (A_0 + A_1\ln\omega + A_2\ln^2\omega)\,\omega^\beta"
        r" + i\,(B_0 + B_1\ln\omega + B_2\ln^2\omega)\,\omega^\beta"
    )
    source = f"{THESIS}, (3.22), (3.29), (3.31)–(3.33)"
    coefficients = (
        Coefficient("A0", WEIGHT),
        Coefficient("beta", "1", 1e-4, 0.6),
        Coefficient("M0", WEIGHT),
    )

    def modulus(self, omega: Array, parameters: Array) -> ComplexArray:
        """(3.32) + i (3.33)."""
        a0, beta, m0 = parameters
        return np.asarray(m0 + a0 * self._curve(omega, beta)[0])

    def derivatives(self, omega: Array, parameters: Array) -> ComplexArray:
        """By A₀, β, M₀."""
        a0, beta, _ = parameters
        value, slope = self._curve(omega, beta)
        return np.stack([value, a0 * slope, np.ones(len(omega))], axis=1)

    def shapes(self, omega: Array) -> Iterable[Array]:
        """Exponents."""
        return EXPONENTS[EXPONENTS < 0.6, None]

    def basis(self, omega: Array, shape: Array) -> ComplexArray:
        """What A₀ and M₀ are multiplied with."""
        return np.stack([self._curve(omega, shape[0])[0], np.ones(len(omega))], axis=1)

    def admits(self, shape: Array) -> bool:
        """0 < β < 0.6: (3.26) holds for small β only."""
        return bool(1e-4 <= shape[0] <= 0.6)

    def assembled(self, weights: Array, shape: Array) -> Array:
        """A₀, β, M₀."""
        return np.array([weights[0], shape[0], weights[1]])

    @staticmethod
    def _curve(omega: Array, beta: float) -> tuple[ComplexArray, ComplexArray]:
        """(M − M₀)/A₀ (f,) and its derivative by β."""
        a, a_rate = _ratios(beta)
        first_rate = pi**3 * beta / 4
        kappa_rate = pi / 2 + pi**3 * beta**2 / 8
        b_rate = loss_coefficients(a_rate, beta) + np.array(
            [
                kappa_rate * a[0] + first_rate * a[1] + pi**3 / 4 * a[2],
                kappa_rate * a[1] + 2 * first_rate * a[2],
                kappa_rate * a[2],
            ]
        )
        log = np.log(omega)
        powers = np.stack([np.ones(len(omega)), log, log**2], axis=1) * (omega**beta)[:, None]
        value = powers @ (a + 1j * loss_coefficients(a, beta))
        return np.asarray(value), np.asarray(log * value + powers @ (a_rate + 1j * b_rate))


class CausalPowerLaw(ModifiedPowerLaw):
    """The member of the exact family whose dynamic modulus is that of the modified power law.

    M_d = M₀ + (A₀ + A₁ log ω + A₂ log² ω) ω^β with (3.29) and (3.31), and the loss modulus that
    causality demands beside it: M = M₀ + (G₀ + G₁ log s + G₂ log² s) s^β, where the G follow from
    M_d = cos(πθ/2) G, θ = ω d/dω. Same parameters, and no expansion.
    """

    id = "causal-power-law"
    title = "modified power law, exact"
    equation = (
        r"M = M_0 + (G_0 + G_1\ln s + G_2\ln^2 s)\,s^\beta,\quad"
        r" \mathrm{Re}\,M = M_0 + (A_0 + A_1\ln\omega + A_2\ln^2\omega)\,\omega^\beta"
    )
    source = f"{THESIS}, (3.29), (3.31), (3.32); docs/bushings.md"

    @staticmethod
    def _curve(omega: Array, beta: float) -> tuple[ComplexArray, ComplexArray]:
        a, a_rate = _ratios(beta)
        # sec x and its derivatives: 1/cos(πθ/2) acts on a square of log ω by the first three.
        sec, t = 1 / cos(pi * beta / 2), tan(pi * beta / 2)
        secants = [sec, sec * t, sec * (t**2 + sec**2), sec * t * (t**2 + 5 * sec**2)]
        g = _without_cosine(secants, a)
        g_rate = _without_cosine(secants, a_rate) + pi / 2 * _without_cosine(secants[1:], a)
        log = np.log(omega) + 0.5j * pi
        powers = np.stack([np.ones(len(omega)), log, log**2], axis=1) * np.exp(beta * log)[:, None]
        value = powers @ g
        return np.asarray(value), np.asarray(log * value + powers @ g_rate)


def _without_cosine(f: Sequence[float], a: Array) -> Array:
    """Coefficients of f(π/2 (β + d/dℓ)) applied to a₀ + a₁ ℓ + a₂ ℓ², from f and its derivatives
    at πβ/2."""
    first, second = pi / 2 * f[1], (pi / 2) ** 2 * f[2]
    return np.array(
        [f[0] * a[0] + first * a[1] + second * a[2], f[0] * a[1] + 2 * first * a[2], f[0] * a[2]]
    )


def loss_coefficients(a: Array, beta: float) -> Array:
    """B₀, B₁, B₂ (3.22) of a = (A₀, A₁, A₂), with B₁ corrected.

    The operator of (3.16), π/2 θ + π³/24 θ³ with θ = ω d/dω, acts on (log ω)ᵏ ω^β as on a
    polynomial in log ω with θ = β + d/d(log ω).
    """
    kappa = pi * beta / 2 + pi**3 * beta**3 / 24
    first = pi / 2 + pi**3 * beta**2 / 8
    second = pi**3 * beta / 4
    return np.array(
        [kappa * a[0] + first * a[1] + second * a[2], kappa * a[1] + 2 * first * a[2], kappa * a[2]]
    )


def _ratios(beta: float) -> tuple[Array, Array]:
    """1, A₁/A₀ and A₂/A₀ of (3.31) and (3.29) as printed, and their derivatives by β."""
    d = 24 * pi**2 - 96 + 14 * pi**4 * beta**2 + pi**6 * beta**4
    d_rate = 28 * pi**4 * beta + 4 * pi**6 * beta**3
    a1 = 4 * pi**4 * beta**3 / d
    a2 = 8 * pi**2 * beta**2 / d  # (3.29): 2 A₁/(π²β)
    rate = [
        0.0,
        12 * pi**4 * beta**2 / d - a1 * d_rate / d,
        16 * pi**2 * beta / d - a2 * d_rate / d,
    ]
    return np.array([1.0, a1, a2]), np.array(rate)


class PowerLogarithm(ModulusModel):
    """M = M₀ + (A₀ + A₁ log s + A₂ log² s) s^β at s = iω, the exact family; `order` 0, 1 or 2 is
    the highest power of log s.

    Causal for every choice of its real coefficients. Order 0 is the fractional Kelvin–Voigt model
    (3.42), β → 0 the logarithmic polynomial.
    """

    id = "power-logarithm"
    title = "power law with logarithms, exact"
    equation = r"M = M_0 + (A_0 + A_1\ln s + A_2\ln^2 s)\,s^\beta,\quad s = i\omega"
    source = "(3.23) with real coefficients in s, docs/bushings.md"

    def __init__(self, order: int = 2) -> None:
        self.order = order
        self.coefficients = (
            Coefficient("M0", WEIGHT),
            *(Coefficient(f"A{k}", WEIGHT) for k in range(order + 1)),
            Coefficient("beta", "1", 0.01 if order else 1e-4, 1.0),
        )

    def modulus(self, omega: Array, parameters: Array) -> ComplexArray:
        """At s = iω."""
        return np.asarray(self.basis(omega, parameters[-1:]) @ parameters[:-1])

    def derivatives(self, omega: Array, parameters: Array) -> ComplexArray:
        """By M₀, A₀ …, β."""
        basis = self.basis(omega, parameters[-1:])
        log = np.log(omega) + 0.5j * pi
        slope = log * (basis[:, 1:] @ parameters[1:-1])
        return np.concatenate([basis, slope[:, None]], axis=1)

    def shapes(self, omega: Array) -> Iterable[Array]:
        """Exponents."""
        return EXPONENTS[:, None]

    def basis(self, omega: Array, shape: Array) -> ComplexArray:
        """1 and (log s)ᵏ s^β."""
        log = np.log(omega) + 0.5j * pi
        power = np.exp(shape[0] * log)
        logs = [power * log**k for k in range(self.order + 1)]
        return np.stack([np.ones(len(omega), dtype=np.complex128), *logs], axis=1)

    def admits(self, shape: Array) -> bool:
        """0 < β < 1; of order 1 and 2 not next to 0, where M₀ and the A cannot be told apart."""
        return bool(self.coefficients[-1].lower <= shape[0] <= 1.0)

    def assembled(self, weights: Array, shape: Array) -> Array:
        """M₀, A₀ …, β."""
        return np.append(weights, shape)


class FractionalKelvinVoigt(PowerLogarithm):
    """M = E₀ + E₁ (iω)^α, (3.42)."""

    id = "fractional-kelvin-voigt"
    title = "fractional Kelvin–Voigt"
    equation = r"M = E_0 + E_1\,(i\omega)^\alpha"
    source = f"R. L. Bagley, P. J. Torvik, J. Rheology 27 (1983) 201–210; {THESIS}, (3.42)"

    def __init__(self) -> None:
        super().__init__(order=0)
        names = (("E0", WEIGHT), ("E1", WEIGHT), ("alpha", "1"))
        self.coefficients = tuple(
            Coefficient(name, unit, c.lower, c.upper)
            for (name, unit), c in zip(names, self.coefficients, strict=True)
        )


class FractionalZener(ModulusModel):
    """M = E₀ (1 + k z/(1 + z)), z = (iωτ)^α: the four-parameter fractional model (3.43).

    Exactly causal, and passive for positive parameters.
    """

    id = "fractional-zener"
    title = "four-parameter fractional"
    equation = r"M = E_0\,(1 + k\,z/(1 + z)),\quad z = (i\omega\tau)^\alpha"
    source = f"T. Pritz, J. Sound and Vibration 195 (1996) 103–115; {THESIS}, (3.43)"
    coefficients = (
        Coefficient("E0", WEIGHT, 0.0),
        Coefficient("k", "1", 0.0),
        Coefficient("tau", "s", 1e-12, 1e6),
        Coefficient("alpha", "1", 1e-3, 1.0),
    )
    non_negative = True

    def modulus(self, omega: Array, parameters: Array) -> ComplexArray:
        """(3.43)."""
        e0, k, *shape = parameters
        return np.asarray(e0 * (1 + k * self._share(omega, shape[0], shape[1])))

    def derivatives(self, omega: Array, parameters: Array) -> ComplexArray:
        """By E₀, k, τ, α."""
        e0, k, tau, alpha = parameters
        share = self._share(omega, tau, alpha)
        by_log = e0 * k * share * (1 - share)  # ∂M/∂ log z
        log = np.log(omega * tau) + 0.5j * pi
        return np.stack([1 + k * share, e0 * share, by_log * alpha / tau, by_log * log], axis=1)

    def shapes(self, omega: Array) -> Iterable[Array]:
        """Relaxation times from far above the data to far below, with each exponent."""
        times = np.geomspace(1e-7 / omega.max(), 1e3 / omega.min(), 9)
        return [np.array([tau, alpha]) for tau in times for alpha in EXPONENTS[3::2]]

    def basis(self, omega: Array, shape: Array) -> ComplexArray:
        """1 and z/(1 + z)."""
        return np.stack([np.ones(len(omega)), self._share(omega, shape[0], shape[1])], axis=1)

    def admits(self, shape: Array) -> bool:
        """Times within what can be computed, 0 < α ≤ 1."""
        return bool(1e-12 <= shape[0] <= 1e6 and 1e-3 <= shape[1] <= 1.0)

    def assembled(self, weights: Array, shape: Array) -> Array:
        """E₀, k, τ, α."""
        return np.array([weights[0], weights[1] / max(weights[0], 1e-300), shape[0], shape[1]])

    @staticmethod
    def _share(omega: Array, tau: float, alpha: float) -> ComplexArray:
        z = (omega * tau) ** alpha * complex(cos(pi * alpha / 2), sin(pi * alpha / 2))
        return np.asarray(z / (1 + z))
