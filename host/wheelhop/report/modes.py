"""Vehicles side by side: their modes, and what they make of a road's waves."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from wheelhop.files import write_picture
from wheelhop.predict.modal import Modes, Transmissibility
from wheelhop.predict.modal_words import by_place
from wheelhop.report.figures import INK, SOFT, WIDTH
from wheelhop.report.svg import COLOURS, STYLE

INKS = (COLOURS["after"], COLOURS["before"], INK, "#7a6aa8", "#3f8f6b", SOFT)
"""Of vehicles, in their order, over again if there are more."""
REAR = (0, (4, 2))
TICKS_HZ = (0.3, 1, 3, 10, 30)


def modes_figure(found: Sequence[tuple[Modes, Transmissibility]]) -> Figure:
    """Transmissibility to the driver, travel and tyre load per height of the ground, and the modes
    by frequency and damping ratio, each named by what moves most; one colour for each vehicle."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 5.6), layout="constrained")
        (driver, travel), (load, points) = figure.subplots(2, 2)
        taken: list[tuple[str, float, float]] = []
        for number, (modes, passed) in enumerate(found):
            ink = INKS[number % len(INKS)]
            hertz = passed.frequency_hz
            driver.plot(hertz, np.abs(passed.driver), color=ink, label=modes.name)
            for axes, curves in ((travel, passed.travel), (load, passed.tyre_load)):
                for end, curve in curves.items():  # 1/m and % per cm are the same
                    style = "-" if end == "front" else REAR
                    axes.plot(hertz, np.abs(curve), color=ink, linestyle=style)
            _draw_modes(points, modes, ink, taken)
        driver.set_title("Driver's acceleration over the ground's")
        travel.set_title("Travel of the struts per height of the ground")
        load.set_title("Tyre load per cm of ground, % of static")
        points.set_title("Modes: damping ratio, and what moves most")
        for axes in (travel, load):
            axes.plot([], [], "-", color=SOFT, label="front")
            if any(len(passed.travel) > 1 for _, passed in found):
                axes.plot([], [], linestyle=REAR, color=SOFT, label="rear")
            axes.legend(frameon=False)
        driver.legend(frameon=False)
        for axes in (driver, travel, load, points):
            axes.set_xscale("log")
            axes.set_xticks(TICKS_HZ, [f"{tick:g}" for tick in TICKS_HZ])
            axes.xaxis.set_minor_formatter(NullFormatter())
            axes.set_xlabel("Hz")
            axes.set_ylim(0, 1.08 * axes.dataLim.y1)
            axes.set_xlim(TICKS_HZ[0], TICKS_HZ[-1])
    return figure


def write_modes_figure(found: Sequence[tuple[Modes, Transmissibility]], file: Path) -> None:
    """Write it; raises InputError."""
    write_picture(file, modes_figure(found))


def _draw_modes(axes: Axes, modes: Modes, ink: str, taken: list[tuple[str, float, float]]) -> None:
    """Points with names, unless the same name stands there already (`taken`)."""
    axes.plot(modes.frequency_hz, modes.damping_ratio, "o", ms=4.5, color=ink)
    for k, (x, y) in enumerate(zip(modes.frequency_hz, modes.damping_ratio, strict=True)):
        shares = by_place(modes, k)
        name = max(shares, key=lambda place: shares[place])
        near = [n for n, other, z in taken if abs(np.log(x / other)) < 0.25 and abs(y - z) < 0.05]
        if TICKS_HZ[0] <= x <= TICKS_HZ[-1] and name not in near:
            taken.append((name, x, y))
            place = (-5, -3, "right") if near else (0, 5, "center")
            axes.annotate(
                name, (x, y), xytext=place[:2], textcoords="offset points", fontsize=6.5,
                color=ink, ha=place[2],
            )  # fmt: skip
