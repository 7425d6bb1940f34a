"""Pictures of transfer matrices, of frequency responses and of parameter studies."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from wheelhop.campaign import BODY_POINTS
from wheelhop.files import made_folder, write_picture
from wheelhop.identify.frf import Frf
from wheelhop.identify.matrix import TransferMatrix
from wheelhop.identify.spectra import Measured
from wheelhop.identify.structure import input_name
from wheelhop.identify.study import Variant, study
from wheelhop.identify.thesis_cars import CHAPTER_2, racing_car, stiffened
from wheelhop.report.modes import INKS
from wheelhop.report.svg import COLOURS, STYLE

Array = NDArray[np.floating[Any]]
ComplexArray = NDArray[np.complex128]

IDENTIFIED, NOMINAL = COLOURS["after"], COLOURS["before"]
TICKS = (0.5, 1, 2, 5, 10, 20, 50)
BAND = "twice its standard error"


def draw_matrix(
    model: TransferMatrix, nominal: ComplexArray, frequency_hz: Array, path: Path
) -> None:
    """Magnitudes of all elements with their bands (twice the standard error), beside the nominal
    model's. The format is by the suffix of `path`; raises InputError."""
    s = 2j * np.pi * frequency_hz
    h, error = np.abs(model(s)), model.standard_error(s)
    rows, columns = h.shape[1:]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(2.6 * columns + 0.6, 2.1 * rows + 0.9), layout="constrained")
        axes: Any = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for (i, j), axis in np.ndenumerate(axes):
            _magnitude(axis, frequency_hz, h[:, i, j], error[:, i, j], "identified")
            axis.set_ylim(0.002, 3 * max(1.0, float(h.max()) / 2))
            axis.plot(
                frequency_hz,
                np.abs(nominal[:, i, j]),
                color=NOMINAL,
                linestyle="--",
                label="vehicle.toml",
            )
            axis.set_title(f"{input_name(model.inputs[j])} → {BODY_POINTS[model.outputs[i]]}")
            _frequency_axis(axis, frequency_hz, i == rows - 1)
        for i in range(rows):
            axes[i, 0].set_ylabel("|H|")
        _legend(figure, axes[0, 0])
        write_picture(path, figure, dpi=130)


def draw_frf(found: Frf, measured: Measured, lines: NDArray[np.bool_], path: Path) -> None:
    """Magnitudes of an estimate with twice its standard error, and beside them the multiple
    coherence of each output, at these lines (k,); raises InputError."""
    frequency = found.omega[lines] / (2 * np.pi)
    h, error = np.abs(found.matrix[lines]), found.standard_error[lines]
    rows, columns = h.shape[1:]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(2.6 * columns + 3.2, 2.1 * rows + 0.9), layout="constrained")
        axes: Any = figure.subplots(rows, columns + 1, sharex=True, squeeze=False)
        for i in range(rows):
            output = BODY_POINTS[measured.outputs[i]]
            for j in range(columns):
                axis = axes[i, j]
                _magnitude(axis, frequency, h[:, i, j], error[:, i, j], "estimated")
                axis.set_ylim(0.002, 3 * max(1.0, float(h.max()) / 2))
                axis.set_title(f"{input_name(measured.inputs[j])} → {output}")
                _frequency_axis(axis, frequency, i == rows - 1)
            last = axes[i, columns]
            last.plot(frequency, found.coherence[lines, i], color=COLOURS["ink"])
            last.set_title(f"coherence of {output}")
            last.set_ylim(0.0, 1.02)
            _frequency_axis(last, frequency, i == rows - 1)
            axes[i, 0].set_ylabel("|H|")
        _legend(figure, axes[0, 0])
        write_picture(path, figure, dpi=130)


def draw_study(variants: Sequence[Variant], varied: str, path: Path) -> None:
    """Magnitude, phase and step response of each variant (thesis figures 2.15-2.20)."""
    frequency = np.geomspace(0.2, 50, 400)
    time_s = np.arange(0, 2.0, 0.004)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10, 4.2), layout="constrained")
        axes: Any = figure.subplots(1, 3)
        for number, variant in enumerate(variants):
            response = variant.system(2j * np.pi * frequency)[:, 0, 0]
            style = {"color": INKS[number % len(INKS)], "label": f"× {variant.factor:g}"}
            axes[0].plot(frequency, np.abs(response), **style)
            axes[1].plot(frequency, np.degrees(np.unwrap(np.angle(response))), **style)
            axes[2].plot(time_s, variant.step(time_s), **style)
        axes[0].set_yscale("log")
        axes[0].set_title("Body over ground")
        axes[1].set_title("Phase, °")
        axes[2].set_title("Body after a step of 1 m, m")
        axes[2].set_xlabel("time, s")
        for axis in axes[:2]:
            _frequency_axis(axis, frequency, True)
        axes[0].legend(title=varied.replace("-", " "), loc="lower left")
        write_picture(path, figure, dpi=130)


def draw_thesis(folder: Path) -> list[Path]:
    """Draw figures 2.15 to 2.17, 2.20 and 5.24 of the thesis anew into a folder, which is made if
    need be: 2.18 is a sketch, 2.19 a photo. Raises InputError."""
    drawn = []
    with made_folder(folder):
        for number, (varied, factors) in CHAPTER_2.items():
            drawn.append(folder / f"figure-{number}.png")
            draw_study(study(racing_car(), varied, factors), varied, drawn[-1])
        for end, variants in stiffened().items():
            drawn.append(folder / f"figure-5.24-{end}.png")
            draw_study(variants, f"stiffness, {end} left", drawn[-1])
    return drawn


def _magnitude(axis: Axes, hertz: Array, size: Array, error: Array, name: str) -> None:
    """One element over frequency, with its band."""
    low, high = np.maximum(size - 2 * error, 1e-6), size + 2 * error
    axis.fill_between(hertz, low, high, color=IDENTIFIED, alpha=0.25, lw=0, label=BAND)
    axis.plot(hertz, size, color=IDENTIFIED, label=name)
    axis.set_yscale("log")


def _legend(figure: Figure, axis: Axes) -> None:
    """One for all panels, above them."""
    handles, labels = axis.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper left", ncols=len(labels))


def _frequency_axis(axis: Axes, frequency_hz: Array, labelled: bool) -> None:
    axis.set_xscale("log")
    axis.set_xlim(frequency_hz[0], frequency_hz[-1])
    ticks = [f for f in TICKS if frequency_hz[0] <= f <= frequency_hz[-1]]
    axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.minorticks_off()
    if labelled:
        axis.set_xlabel("frequency, Hz")
