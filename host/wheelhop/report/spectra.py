"""Runs on a road known by its spectrum: measured and expected power density (thesis 4.52)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

from wheelhop.files import write_picture
from wheelhop.predict.road_spectra import RoadRun
from wheelhop.report.figures import AFTER, MEASURED, log_axis
from wheelhop.report.svg import STYLE

PANEL_IN = (1.6, 1.5)


def draw_spectra(runs: Sequence[RoadRun], path: Path) -> None:
    """A row for each run, a panel for each channel: the record's power in thirds of an octave on
    the expected one, about it the 95 % of chance. Raises InputError."""
    count = max(len(one.channels) for one in runs)
    size = (PANEL_IN[0] * count + 0.8, PANEL_IN[1] * len(runs) + 0.9)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=size, layout="constrained")
        grid = figure.subplots(len(runs), count, sharex=True, sharey=True, squeeze=False)
        top = 3 * max(float(one.measured_density.max()) for one in runs)
        least = min(float(one.predicted_density.min()) for one in runs) / 3
        for line, one in zip(grid, runs, strict=True):
            hertz, expected, (low, high) = one.middle_hz, one.predicted_density, one.chance
            for i, axes in enumerate(line[: len(one.channels)]):
                within = (expected[:, i] * low, expected[:, i] * high)
                axes.fill_between(hertz, *within, color=AFTER, alpha=0.18, lw=0, label="95 %")
                axes.plot(hertz, expected[:, i], color=AFTER, label="expected of the road")
                shown = one.measured_density[:, i]
                axes.plot(hertz, shown, ".-", color=MEASURED, ms=3, label="measured")
                axes.set_title(one.channels[i].name)
                log_axis(axes, least, top)
                log_axis(axes, float(hertz[0]), float(hertz[-1]), "x")
            line[0].set_ylabel(f"{one.run.id}\nunit²/Hz", fontsize=6)
        for axes in grid[-1]:
            axes.set_xlabel("Hz")
        figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside upper left", ncols=3)
    write_picture(path, figure, dpi=130)
