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

from wheelhop.identify.gram import projected, transient_basis
from wheelhop.identify.identify import TransferMatrix
from wheelhop.identify.spectra import Spectra, through
from wheelhop.identify.structure import Structure

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

Answer = Literal["linear", "not linear", "cannot tell"]

ORDERS = (6, 8, 10)
STRUCTURES = (
    Structure("reciprocal"),
    Structure("reciprocal", left_right=False),
)


def _friction(x: Array, v: Array, size: Array, speed: Array) -> Array:
    return np.tanh(v / (0.1 * speed))


def _digressive(x: Array, v: Array, size: Array, speed: Array) -> Array:
    return np.clip(v, -speed, speed) / speed


def _one_sided(x: Array, v: Array, size: Array, speed: Array) -> Array:
    return np.abs(v) / speed


def _cubic(x: Array, v: Array, size: Array, speed: Array) -> Array:
    return (x / size) ** 3


def _square(x: Array, v: Array, size: Array, speed: Array) -> Array:
    return (x / size) ** 2


def _stop(x: Array, v: Array, size: Array, speed: Array) -> Array:
    return np.minimum(x + 2 * size, 0.0) / size


LAWS: dict[str, Callable[[Array, Array, Array, Array], Array]] = {
    "friction": _friction,
    "bend at a speed": _digressive,
    "rebound unlike compression": _one_sided,
    "cubic": _cubic,
    "square": _square,
    "stop in compression": _stop,
}
"""Forces from extension x and its rate v, given the rms of both over the fitted runs."""


@dataclass(frozen=True, eq=False)
class Forces:
    """What the laws' forces do to the outputs, as weighted rows of one part."""


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


def strut_motion(model: TransferMatrix, part: Spectra, rate_hz: float) -> tuple[Array, Array]:
    """Extension, m, and its rate, m/s, (r, samples, 4) of the struts in band, the body's motion as
    the model predicts it: measured, its noise would drive the laws."""
    s = 1j * part.omega
    body = through(model(s), part.inputs)
    relative = body - part.inputs
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


def responses(
    model: TransferMatrix, part: Spectra, rate_hz: float, sizes: tuple[Array, Array]
) -> dict[str, ComplexArray]:
    """Spectra (r, k, n, 2) that a force of each law leaves in the outputs: front struts, rear."""
    x, v = strut_motion(model, part, rate_hz)
    s = 1j * part.omega
    assert model.suspensions is not None
    factor = model.suspensions.factor(model.suspensions.value, s, model.inputs)
    body = model(s) / factor[:, None, :] * (s**2)[:, None, None]
    out = {}
    for name, law in LAWS.items():
        force = _lines(law(x, v, *sizes), part, rate_hz)
        moved = body[None] * force[:, :, None, :]
        out[name] = np.stack([moved[..., :2].sum(-1), moved[..., 2:].sum(-1)], axis=-1)
    return out
