"""Vehicles side by side on the same runs: comfort, travel and tyre loads."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from wheelhop.files import write_picture
from wheelhop.predict.ride import Ride
from wheelhop.report.figures import SOFT, WIDTH
from wheelhop.report.modes import INKS
from wheelhop.report.svg import STYLE

PANELS: Mapping[str, Callable[[Ride], tuple[float, ...]]] = {
    "Weighted acceleration, m/s²": lambda ride: (ride.comfort_wk_rms_m_s2,),
    "Largest travel, mm": lambda ride: (
        1e3 * ride.travel_front_peak_m,
        1e3 * ride.travel_rear_peak_m,
    ),
    "Tyre load, rms / static": lambda ride: (
        ride.dynamic_load_front,
        ride.dynamic_load_rear,
    ),
}
"""What is drawn of a run; of two values the second, of the rear axle, is hollow."""
ROW_IN = 0.16


def rides_figure(runs: Sequence[str], rides: Mapping[str, Sequence[Ride]]) -> Figure:
    """A row for each run, in it a dot for each vehicle, by its name in `rides`."""
    with mpl.rc_context(STYLE):
        height = 1.2 + ROW_IN * len(runs) * max(len(rides), 2)
        figure = Figure(figsize=(WIDTH, height), layout="constrained")
        axes = figure.subplots(1, len(PANELS), sharey=True)
        away = np.linspace(-0.25, 0.25, len(rides)) if len(rides) > 1 else np.zeros(1)
        for axis, (title, values_of) in zip(axes, PANELS.items(), strict=True):
            for number, found in enumerate(rides.values()):
                ink = INKS[number % len(INKS)]
                y = np.arange(len(runs)) + away[number]
                values = np.array([values_of(ride) for ride in found])
                axis.plot(values[:, 0], y, "o", ms=4, color=ink)
                if values.shape[1] > 1:
                    axis.plot(values[:, 1], y, "o", ms=4, mfc="none", mec=ink)
            axis.set_title(title, fontsize=8)
            axis.set_xlim(0, 1.05 * axis.dataLim.x1)
            axis.tick_params(axis="y", length=0)
        for number, name in enumerate(rides):
            axes[0].plot([], [], "o", ms=4, color=INKS[number % len(INKS)], label=name)
        for end, fill in (("front", SOFT), ("rear", "none")):
            axes[0].plot([], [], "o", ms=4, mfc=fill, mec=SOFT, label=end)
        axes[0].set_yticks(range(len(runs)), runs)
        axes[0].set_ylim(len(runs) - 0.5, -0.5)
        figure.legend(
            *axes[0].get_legend_handles_labels(), loc="outside lower right", ncols=len(rides) + 2
        )
    return figure


def write_rides_figure(
    runs: Sequence[str], rides: Mapping[str, Sequence[Ride]], file: Path
) -> None:
    """Write it; raises InputError."""
    write_picture(file, rides_figure(runs, rides))
