"""Pictures of transfer matrices and of parameter studies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import BODY_POINTS, Channel
from wheelhop.files import write_picture
from wheelhop.identify.frf import Frf
from wheelhop.identify.matrix import TransferMatrix
from wheelhop.identify.spectra import Measured
from wheelhop.identify.structure import VERTICAL, input_name
from wheelhop.identify.study import Variant
from wheelhop.simulate import Model, frequency_response

Array = NDArray[np.floating[Any]]
ComplexArray = NDArray[np.complex128]

IDENTIFIED, NOMINAL = "C0", "C1"
TICKS = (0.5, 1, 2, 5, 10, 20, 50)


def physical_matrix(
    channels: Sequence[Channel], physical: Model, model: TransferMatrix, frequency_hz: Array
) -> ComplexArray:
    """H of a physical model at the places of an identified one (f, n, m), NaN for axles that move
    fore and aft, which it has not. Its force laws, which are not linear, are left out."""
    wanted = {BODY_POINTS[corner]: row for row, corner in enumerate(model.outputs)}
    places = sorted((c for c in channels if c.point in wanted), key=lambda c: wanted[c.point])
    system = physical.system(places, "axles")
    omega = 2 * np.pi * frequency_hz[:, None, None]
    response = frequency_response(system, frequency_hz) / -(omega**2)
    found = np.full((*response.shape[:2], len(model.inputs)), np.nan, complex)
    for j, corner in enumerate(model.inputs):
        if corner < VERTICAL:
            found[:, :, j] = response[:, :, corner]
    return found


def draw_matrix(
    model: TransferMatrix, nominal: ComplexArray, frequency_hz: Array, path: Path
) -> None:
    """Magnitudes of all elements with their bands (twice the standard error), beside the nominal
    model's. The format is by the suffix of `path`; raises InputError."""
    from matplotlib.figure import Figure

    s = 2j * np.pi * frequency_hz
    h, error = np.abs(model(s)), model.standard_error(s)
    rows, columns = h.shape[1:]
    figure = Figure(figsize=(2.6 * columns + 0.6, 2.1 * rows + 0.6), layout="constrained")
    axes: Any = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for i in range(rows):
        for j in range(columns):
            axis = axes[i, j]
            low, high = h[:, i, j] - 2 * error[:, i, j], h[:, i, j] + 2 * error[:, i, j]
            axis.fill_between(
                frequency_hz, np.maximum(low, 1e-6), high, color=IDENTIFIED, alpha=0.25, lw=0
            )
            axis.plot(frequency_hz, h[:, i, j], color=IDENTIFIED, lw=1.5, label="identified")
            axis.plot(
                *(frequency_hz, np.abs(nominal[:, i, j])),
                **{"color": NOMINAL, "lw": 1.2, "ls": "--", "label": "vehicle.toml"},
            )
            title = f"{input_name(model.inputs[j])} → {BODY_POINTS[model.outputs[i]]}"
            axis.set_title(title, fontsize=9)
            axis.set_ylim(0.002, 3 * max(1.0, float(h.max()) / 2))
            _frequency_axis(axis, frequency_hz, i == rows - 1)
            axis.set_yscale("log")
    for i in range(rows):
        axes[i, 0].set_ylabel("|H|")
    axes[0, 0].legend(fontsize=7, loc="lower left")
    write_picture(path, figure, dpi=130)


def draw_frf(found: Frf, measured: Measured, lines: NDArray[np.bool_], path: Path) -> None:
    """Magnitudes of an estimate with twice its standard error, and below them the multiple
    coherence of each output, at these lines (k,); raises InputError."""
    from matplotlib.figure import Figure

    frequency = found.omega[lines] / (2 * np.pi)
    h, error = np.abs(found.matrix[lines]), found.standard_error[lines]
    rows, columns = h.shape[1:]
    figure = Figure(figsize=(2.6 * columns + 3.2, 2.1 * rows + 0.6), layout="constrained")
    axes: Any = figure.subplots(rows, columns + 1, sharex=True, squeeze=False)
    for i in range(rows):
        output = BODY_POINTS[measured.outputs[i]]
        for j in range(columns):
            axis = axes[i, j]
            low, high = h[:, i, j] - 2 * error[:, i, j], h[:, i, j] + 2 * error[:, i, j]
            axis.fill_between(
                frequency, np.maximum(low, 1e-6), high, color=IDENTIFIED, alpha=0.25, lw=0
            )
            axis.plot(frequency, h[:, i, j], color=IDENTIFIED, lw=1.2)
            axis.set_title(f"{input_name(measured.inputs[j])} → {output}", fontsize=9)
            _frequency_axis(axis, frequency, i == rows - 1)
            axis.set_yscale("log")
            axis.set_ylim(0.002, 3 * max(1.0, float(h.max()) / 2))
        last = axes[i, columns]
        last.plot(frequency, found.coherence[lines, i], color="0.3", lw=1.2)
        last.set_title(f"coherence of {output}", fontsize=9)
        last.set_ylim(0.0, 1.02)
        _frequency_axis(last, frequency, i == rows - 1)
        axes[i, 0].set_ylabel("|H|")
    write_picture(path, figure, dpi=130)


def draw_study(
    variants: Sequence[Variant], varied: str, path: Path, *, words: Mapping[str, str] | None = None
) -> None:
    """Magnitude, phase and step response of each variant (thesis figures 2.15-2.20)."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4.2), layout="constrained")
    axes: Any = figure.subplots(1, 3)
    frequency = np.geomspace(0.2, 50, 400)
    time_s = np.arange(0, 2.0, 0.004)
    for number, variant in enumerate(variants):
        response = variant.system(2j * np.pi * frequency)[:, 0, 0]
        style = {"color": f"C{number}", "lw": 1.4, "label": f"× {variant.factor:g}"}
        axes[0].plot(frequency, np.abs(response), **style)
        axes[1].plot(frequency, np.degrees(np.unwrap(np.angle(response))), **style)
        axes[2].plot(time_s, variant.step(time_s), **style)
    axes[0].set_yscale("log")
    axes[0].set_ylabel("body over ground")
    axes[1].set_ylabel("phase, °")
    axes[2].set_ylabel("body, m, for a step of 1 m")
    axes[2].set_xlabel("time, s")
    axes[2].grid(alpha=0.3)
    for axis in axes[:2]:
        _frequency_axis(axis, frequency, True)
    axes[0].legend(title=varied.replace("-", " "), fontsize=8)
    for axis in axes:
        axis.spines[["top", "right"]].set_visible(False)
    write_picture(path, figure, dpi=130)


def _frequency_axis(axis: Any, frequency_hz: Array, labelled: bool) -> None:
    axis.set_xscale("log")
    axis.set_xlim(frequency_hz[0], frequency_hz[-1])
    ticks = [f for f in TICKS if frequency_hz[0] <= f <= frequency_hz[-1]]
    axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.minorticks_off()
    axis.grid(alpha=0.3)
    if labelled:
        axis.set_xlabel("frequency, Hz")
