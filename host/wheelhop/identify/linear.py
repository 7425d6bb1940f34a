"""Is what is missing between axle and body linear?

The best linear model from axles to body, of any order, is all that a linear mechanism can be,
whatever it holds: a seat, a mount, a bending frame. What it leaves beyond noise is not linear in
the axles' motion. Whether that is a law of the struts is asked directly: forces along a few
nonlinear laws of the struts' motion, as the linear model predicts it, act on the identified body,
and either they explain runs no fit has seen, or they do not (nonlinear feedback as an input:
D. Adams and R. Allemang, Mech. Syst. Signal Process. 14 (2000) 637).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from wheelhop.identify.gram import projected, transient_basis
from wheelhop.identify.identify import TransferMatrix
from wheelhop.identify.spectra import Measured, Spectra, through
from wheelhop.identify.structure import Structure

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

Answer = Literal["linear", "not linear", "cannot tell"]

ORDERS = (6, 8, 10)
STRUCTURES = (
    Structure("reciprocal"),
    Structure("reciprocal", left_right=False),
)


Law = Callable[[Array, Array], Array]


def _friction(sharp: float) -> Law:
    return lambda x, v: np.tanh(v / sharp)


def _bend(knee: float) -> Law:
    return lambda x, v: np.clip(v, -knee, knee)


def _stop(clearance: float) -> Law:
    return lambda x, v: np.minimum(x + clearance, 0.0)


def _gap(clearance: float) -> Law:
    return lambda x, v: x - np.clip(x, -clearance, clearance)


LAWS: dict[str, tuple[Law, ...]] = {
    "friction": tuple(map(_friction, (0.03, 0.1, 0.3))),
    "damper that bends": tuple(map(_bend, (0.5, 1.0, 2.0))),
    "rebound unlike compression": (lambda x, v: np.abs(v),),
    "cubic spring": (lambda x, v: x**3,),
    "spring harder one way": (lambda x, v: x**2,),
    "stop in compression": tuple(map(_stop, (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5))),
    "stops both ways": tuple(map(_gap, (0.5, 1.0, 1.5, 2.0, 2.5, 3.0))),
}
"""Forces from extension and its rate, each over its rms on the fitted runs, per kind of law."""

FLAT = [(name, law) for name, several in LAWS.items() for law in several]


def peakedness(model: TransferMatrix, runs: Sequence[Spectra]) -> float:
    """Mean over median of the residual's power, 1 for noise of any level, more where the residual
    gathers in lines; each output and run-length by itself, then averaged by power."""
    total = expected = 0.0
    for part in runs:
        response = model(1j * part.omega)
        growth = 1.0 + np.sum(np.abs(response) ** 2, axis=2)
        basis = transient_basis(part.omega, model.sections, np.ones(len(part.omega)))
        rest = part.outputs - through(response, part.inputs)
        rows = projected(rest, basis).reshape(len(part.runs), 2, len(part.omega), -1)
        power = np.sum(rows**2, axis=1) / growth
        level = np.median(power, axis=(0, 1)) / np.log(2.0)
        total += float((power.mean(axis=(0, 1)) * len(part.runs)).sum())
        expected += float((level * len(part.runs)).sum())
    return total / expected


def strut_motion(part: Spectra, rate_hz: float) -> tuple[Array, Array]:
    """Extension, m, and its rate, m/s, (r, samples, 4) of the struts in band, as measured."""
    s = 1j * part.omega
    relative = part.outputs - part.inputs
    return (
        _signal(relative / s[:, None] ** 2, part, rate_hz),
        _signal(relative / s[:, None], part, rate_hz),
    )


def _bins(part: Spectra, rate_hz: float) -> slice:
    step = 2 * np.pi * rate_hz / part.samples
    first = round(float(part.omega[0]) / step)
    return slice(first, first + len(part.omega))


def _signal(lines: ComplexArray, part: Spectra, rate_hz: float) -> Array:
    full = np.zeros((lines.shape[0], part.samples // 2 + 1, lines.shape[2]), complex)
    full[:, _bins(part, rate_hz)] = lines * np.sqrt(part.samples / 2)
    return np.asarray(np.fft.irfft(full, part.samples, axis=1))


def _lines(signal: Array, part: Spectra, rate_hz: float) -> ComplexArray:
    spectrum = np.fft.rfft(signal, axis=1)[:, _bins(part, rate_hz)]
    return np.asarray(spectrum * np.sqrt(2 / part.samples))


def force_responses(
    model: TransferMatrix, part: Spectra, rate_hz: float, sizes: tuple[Array, Array]
) -> ComplexArray:
    """Spectra (r, k, n, 2 laws) that forces of the laws leave in the outputs: of each law first the
    front struts', then the rear's."""
    x, v = strut_motion(part, rate_hz)
    s = 1j * part.omega
    assert model.suspensions is not None
    factor = model.suspensions.factor(model.suspensions.value, s, model.inputs)
    body = model(s) / factor[:, None, :] * (s**2)[:, None, None]
    out = []
    for _, law in FLAT:
        force = _lines(law(x / sizes[0], v / sizes[1]), part, rate_hz)
        moved = body[None] * force[:, :, None, :]
        out += [moved[..., :2].sum(axis=-1), moved[..., 2:].sum(axis=-1)]
    return np.stack(out, axis=-1)


@dataclass(frozen=True, eq=False)
class _Rows:
    """One part as weighted real rows, initial states projected out: regressors (N, m·order), laws
    (N, n, 2 laws), residual (N, n)."""

    phi: Array
    laws: Array
    rest: Array
    runs: int


def _rows(
    model: TransferMatrix, part: Spectra, rate_hz: float, sizes: tuple[Array, Array]
) -> _Rows:
    assert model.suspensions is not None
    s = 1j * part.omega
    h = model(s)
    weight = 1.0 / np.sqrt(1.0 + np.mean(np.sum(np.abs(h) ** 2, axis=2), axis=1))
    basis = transient_basis(part.omega, model.sections, weight)
    factor = model.suspensions.factor(model.suspensions.value, s, model.inputs)
    fractions = model.sections.basis(s) * weight[:, None]
    phi = (part.inputs * factor)[:, :, :, None] * fractions[:, None, :]
    laws = force_responses(model, part, rate_hz, sizes) * weight[:, None, None]
    rest = (part.outputs - through(h, part.inputs)) * weight[:, None]
    runs, lines = part.inputs.shape[:2]
    outputs = part.outputs.shape[2]
    return _Rows(
        projected(phi.reshape(runs, lines, -1), basis),
        projected(laws.reshape(runs, lines, -1), basis).reshape(-1, outputs, laws.shape[-1]),
        projected(rest, basis),
        runs,
    )


def gains(model: TransferMatrix, measured: Measured, rate_hz: float) -> tuple[Array, Array]:
    """What each law explains of the runs held out: (laws, runs) fall of the squared residual, and
    (runs,) the squared residual without a law, both over the noise power per coordinate.

    Law and numerators are fitted together to the fitted runs, the poles held.
    """
    motion = [strut_motion(part, rate_hz) for part in measured.fit]
    sizes = tuple(
        np.sqrt(np.mean(np.concatenate([m[q].reshape(-1, 4) for m in motion]) ** 2, axis=0))
        for q in (0, 1)
    )
    fitted = [_rows(model, part, rate_hz, (sizes[0], sizes[1])) for part in measured.fit]
    held = [_rows(model, part, rate_hz, (sizes[0], sizes[1])) for part in measured.validate]
    free, count = int(model.index.max()) + 1, 2 * len(FLAT)
    normal, right = np.zeros((free + count, free + count)), np.zeros(free + count)
    for rows in fitted:
        phi_phi = rows.phi.T @ rows.phi
        for i, at in enumerate(model.index):
            laws, rest = rows.laws[:, i], rows.rest[:, i]
            across = rows.phi.T @ laws
            np.add.at(normal, (at[:, None], at), phi_phi)
            np.add.at(normal[:, free:], at, across)
            normal[free:, free:] += laws.T @ laws
            np.add.at(right, at, rows.phi.T @ rest)
            right[free:] += laws.T @ rest
    normal[free:, :free] = normal[:free, free:].T
    noise = np.median(np.concatenate([r.rest**2 for r in fitted])) / 0.4549  # χ² of one: its median
    plain = _left(held, model, _solve(normal[:free, :free], right[:free]), None) / noise
    falls = []
    for number in range(len(FLAT)):
        columns = free + 2 * number + np.arange(2)
        use = np.append(np.arange(free), columns)
        solved = _solve(normal[np.ix_(use, use)], right[use])
        left = _left(held, model, solved[:free], (2 * number, solved[free:]))
        falls.append(plain - left / noise)
    return np.array(falls), plain


def _left(
    rows: Sequence[_Rows], model: TransferMatrix, numerators: Array, law: tuple[int, Array] | None
) -> Array:
    """Squared residual of each run after numerators and a law are changed by so much."""
    out = []
    for part in rows:
        rest = part.rest.copy()
        for i, at in enumerate(model.index):
            rest[:, i] -= part.phi @ numerators[at]
        if law is not None:
            first, size = law
            rest -= part.laws[:, :, first : first + 2] @ size
        out.append((rest**2).reshape(part.runs, -1).sum(axis=1))
    return np.concatenate(out)


def _solve(normal: Array, right: Array) -> Array:
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    scaled = normal * scale[:, None] * scale
    return np.asarray(scale * linalg.lstsq(scaled, scale * right, cond=1e-10)[0])
