"""Vehicles side by side: their modes, and what they make of a road's waves."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter
from matplotlib.transforms import Bbox

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
        for number, (modes, passed) in enumerate(found):
            ink = INKS[number % len(INKS)]
            hertz = passed.frequency_hz
            driver.plot(hertz, np.abs(passed.driver), color=ink, label=modes.name)
            for axes, curves in ((travel, passed.travel), (load, passed.tyre_load)):
                for end, curve in curves.items():  # 1/m and % per cm are the same
                    style = "-" if end == "front" else REAR
                    axes.plot(hertz, np.abs(curve), color=ink, linestyle=style)
        driver.set_title("Driver's acceleration over the ground's")
        travel.set_title("Travel of the struts per height of the ground")
        load.set_title("Tyre load per cm of ground, % of static")
        points.set_title("Modes: damping ratio, and what moves most")
        for axes in (travel, load):
            axes.plot([], [], "-", color=SOFT, label="front")
            if any(len(passed.travel) > 1 for _, passed in found):
                axes.plot([], [], linestyle=REAR, color=SOFT, label="rear")
            axes.legend(frameon=False)
        for modes, _ in found:
            points.update_datalim(np.column_stack([modes.frequency_hz, modes.damping_ratio]))
        figure.legend(*driver.get_legend_handles_labels(), loc="outside upper left", ncols=3)
        for axes in (driver, travel, load, points):
            axes.set_xscale("log")
            axes.set_xticks(TICKS_HZ, [f"{tick:g}" for tick in TICKS_HZ])
            axes.xaxis.set_minor_formatter(NullFormatter())
            axes.set_xlabel("Hz")
            axes.set_ylim(0, 1.08 * axes.dataLim.y1)
            axes.set_xlim(TICKS_HZ[0], TICKS_HZ[-1])
        _draw_modes(figure, points, [modes for modes, _ in found])
    return figure


def write_modes_figure(found: Sequence[tuple[Modes, Transmissibility]], file: Path) -> None:
    """Write it; raises InputError."""
    write_picture(file, modes_figure(found))


def _draw_modes(figure: Figure, axes: Axes, found: Sequence[Modes]) -> None:
    """Points in their vehicle's colour, each with the name of what moves most; once where several
    vehicles have a mode alike."""
    points = []
    for number, modes in enumerate(found):
        ink = INKS[number % len(INKS)]
        axes.plot(modes.frequency_hz, modes.damping_ratio, "o", ms=4.5, color=ink)
        for k, at in enumerate(zip(modes.frequency_hz, modes.damping_ratio, strict=True)):
            shares = by_place(modes, k)
            if TICKS_HZ[0] <= at[0] <= TICKS_HZ[-1]:
                points.append((max(shares, key=lambda place: shares[place]), at, ink))
    figure.draw_without_rendering()  # now it is known where everything stands
    pixels = axes.transData.transform([at for _, at, _ in points])
    dot = 0.035 * figure.dpi
    taken = [Bbox.from_extents(x - dot, y - dot, x + dot, y + dot) for x, y in pixels]
    alike: list[tuple[str, float, float]] = []
    for name, at, ink in points:
        near = [z for n, x, z in alike if n == name and abs(np.log(at[0] / x)) < 0.25]
        if all(abs(at[1] - z) >= 0.05 for z in near):
            alike.append((name, *at))
            taken.append(_named(axes, name, at, ink, taken))


PLACES = (
    *((0, 7, "center"), (6, 0, "left"), (-6, 0, "right"), (0, -7, "center")),
    *((5, 6, "left"), (-5, 6, "right"), (5, -6, "left"), (-5, -6, "right")),
    *((12, 12, "left"), (-12, -12, "right")),
)
"""Where a name may stand about its point, pt, best first."""


def _named(axes: Axes, name: str, at: tuple[float, float], ink: str, taken: Sequence[Bbox]) -> Bbox:
    """A name beside its point, where it overlaps least of what is there; the place it takes."""
    text = axes.annotate(
        name, at, (0, 0), textcoords="offset points", fontsize=6.5, color=ink, va="center"
    )
    places = []
    for x, y, side in PLACES:
        text.set(position=(x, y), horizontalalignment=side)
        box = text.get_window_extent()
        places.append((sum(box.overlaps(other) for other in taken), x, y, side, box))
    _, x, y, side, box = min(places, key=lambda place: place[0])
    text.set(position=(x, y), horizontalalignment=side)
    return box
