"""Nonlinear laws of the struts as inputs of an identified body.

A force along a law of a strut's motion acts on the body that was identified, and either explains
runs no fit has seen or does not (nonlinear feedback as an input: D. Adams and R. Allemang, Mech.
Syst. Signal Process. 14 (2000) 637). The laws are a coarse net and name no effect: which one it is,
the diagnosis finds with the whole vehicle.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from wheelhop.identify.gram import projected, transient_basis
from wheelhop.identify.judge import judge
from wheelhop.identify.matrix import TransferMatrix
from wheelhop.identify.spectra import Measured, Spectra, through

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


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
    """One part as real rows, initial states projected out: regressors (N, m·order), laws
    (N, n, 2 laws), residual (N, n). `charge` makes up for the rows the initial states take."""

    phi: Array
    laws: Array
    rest: Array
    runs: int
    charge: float


def _rows(
    model: TransferMatrix, part: Spectra, rate_hz: float, sizes: tuple[Array, Array]
) -> _Rows:
    assert model.suspensions is not None
    s = 1j * part.omega
    h = model(s)
    basis = transient_basis(part.omega, model.sections, np.ones(len(part.omega)))
    factor = model.suspensions.factor(model.suspensions.value, s, model.inputs)
    fractions = model.sections.basis(s)
    phi = (part.inputs * factor)[:, :, :, None] * fractions[:, None, :]
    laws = force_responses(model, part, rate_hz, sizes)
    rest = part.outputs - through(h, part.inputs)
    runs, lines = part.inputs.shape[:2]
    outputs = part.outputs.shape[2]
    return _Rows(
        projected(phi.reshape(runs, lines, -1), basis),
        projected(laws.reshape(runs, lines, -1), basis).reshape(-1, outputs, laws.shape[-1]),
        projected(rest, basis),
        runs,
        len(basis) / (len(basis) - basis.shape[1]),
    )


def explained(
    model: TransferMatrix, best: TransferMatrix, measured: Measured, rate_hz: float
) -> tuple[str, Array]:
    """The kind of law that explains most of the runs held out, and what it leaves of each run's
    squared residual, over what the `best` linear model leaves.

    Law and numerators of `model` are fitted together to the fitted runs, its poles held; `best`
    need not be the same matrix.
    """
    motion = [strut_motion(part, rate_hz) for part in measured.fit]
    sizes = (_rms([m[0] for m in motion]), _rms([m[1] for m in motion]))
    fitted = [_rows(model, part, rate_hz, sizes) for part in measured.fit]
    held = [_rows(model, part, rate_hz, sizes) for part in measured.validate]
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
    plain = judge(best, measured.validate).residual.sum(axis=1)
    kind, least = "", np.full(len(plain), np.inf)
    for number, (name, _) in enumerate(FLAT):
        use = np.append(np.arange(free), free + 2 * number + np.arange(2))
        solved = _solve(normal[np.ix_(use, use)], right[use])
        left = _left(held, model, solved[:free], 2 * number, solved[free:])
        if left.sum() < least.sum():
            kind, least = name, left
    return kind, least / plain


def _rms(parts: Sequence[Array]) -> Array:
    """Of each strut (4,), over all runs."""
    return np.asarray(
        np.sqrt(np.mean(np.concatenate([p.reshape(-1, 4) for p in parts]) ** 2, axis=0))
    )


def _left(
    rows: Sequence[_Rows], model: TransferMatrix, numerators: Array, first: int, size: Array
) -> Array:
    """Squared residual of each run after numerators and a law are changed by so much, what the
    initial states absorb charged."""
    out = []
    for part in rows:
        rest = part.rest - part.laws[:, :, first : first + 2] @ size
        for i, at in enumerate(model.index):
            rest[:, i] -= part.phi @ numerators[at]
        out.append(part.charge * (rest**2).reshape(part.runs, -1).sum(axis=1))
    return np.concatenate(out)


def _solve(normal: Array, right: Array) -> Array:
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    scaled = normal * scale[:, None] * scale
    return np.asarray(scale * linalg.lstsq(scaled, scale * right, cond=1e-10)[0])
