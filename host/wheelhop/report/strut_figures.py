"""What damper people look at: histograms of velocity and travel, and the loops of every strut."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from wheelhop.files.words import significant
from wheelhop.law.places import CORNER_NAMES
from wheelhop.report.figures import AFTER, BEFORE, MEASURED, RULE, WIDTH
from wheelhop.report.loops import FINER
from wheelhop.report.page import table
from wheelhop.report.stretch import farthest
from wheelhop.report.strut_motion import (
    BASELINE,
    LOW_SPEED_M_S,
    StrutHistory,
    StrutRun,
    shares,
)
from wheelhop.report.svg import STYLE, Drawing, literal
from wheelhop.simulate import Model
from wheelhop.vehicle import struts

Array = NDArray[np.float64]
Histories = Mapping[int, Sequence[StrutHistory]]

BINS = 41
"""Of a histogram, an odd number, so that one of them lies about rest."""

SHOWN = 0.999
"""So much of the time lies within the axis of a histogram; the rest joins its last bins."""


def histograms_figure(histories: Histories) -> Drawing:
    """A row for each strut: how much of the time it has which velocity, and which travel."""
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 1.55 * len(histories) + 0.7), layout="constrained")
        panels = figure.subplots(len(histories), 2, sharex="col", squeeze=False)
        for column, what in enumerate(("velocity", "travel")):
            edges = _edges([1e3 * getattr(h, what) for each in histories.values() for h in each])
            for panel, each in zip(panels[:, column], histories.values(), strict=True):
                for history in each:
                    _draw_histogram(panel, history, 1e3 * getattr(history, what), edges)
        for row, corner in zip(panels, histories, strict=True):
            row[0].set_title(CORNER_NAMES[corner], loc="left")
            row[0].set_ylabel("share of time, %")
            low = 1e3 * LOW_SPEED_M_S
            row[0].axvspan(-low, low, color=RULE, linewidth=0, zorder=0)
        panels[-1, 0].set_xlabel("velocity, mm/s: bump below 0, rebound above")
        panels[-1, 1].set_xlabel("travel, mm: bump below 0, rebound above")
        _name_lines(figure, panels[0, 0])
    return figure


def _edges(every: Sequence[Array]) -> Array:
    """Ends of the bins (BINS + 1,), alike on both sides of 0."""
    end = max(float(np.quantile(np.abs(values), SHOWN)) for values in every)
    return np.linspace(-end, end, BINS + 1) if end > 0.0 else np.linspace(-1.0, 1.0, BINS + 1)


def _draw_histogram(panel: Axes, history: StrutHistory, values: Array, edges: Array) -> None:
    count, _ = np.histogram(np.clip(values, edges[0], edges[-1]), edges)
    colour, _ = _pen(history)
    panel.stairs(
        100 * count / len(values),
        edges,
        label=history.name,
        fill=colour == MEASURED,
        color=colour,
        linewidth=1.1,
    )
    panel.yaxis.set_major_locator(MaxNLocator(4))


def strut_loops_figure(histories: Histories, model: Model) -> Drawing:
    """A row for each strut, of the run in which it travels farthest: the force in it over travel,
    and the force without the spring of `model`, the last one, over velocity."""
    springs = (strut.stiffness_N_m for strut in struts(model.values))
    stiffness = dict(zip(histories, springs, strict=True))
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 2.1 * len(histories) + 0.4), layout="constrained")
        panels = figure.subplots(len(histories), 2, squeeze=False)
        for row, (corner, each) in zip(panels, histories.items(), strict=True):
            run_id = farthest_run(each[0])
            part = farthest(_finer(each[0].runs[run_id].travel), FINER * each[0].rate_hz)
            for history in each:
                _draw_loops(row, history, history.runs[run_id], stiffness[corner], part)
            row[0].set_title(literal(f"{CORNER_NAMES[corner]}, {run_id}"), loc="left")
            row[0].set_ylabel("force, N")
            row[1].set_ylabel("without spring, N")
        panels[-1, 0].set_xlabel("travel, mm: bump below 0, rebound above")
        panels[-1, 1].set_xlabel("velocity, mm/s: bump below 0, rebound above")
        _name_lines(figure, panels[0, 0])
    return figure


def farthest_run(history: StrutHistory) -> str:
    """The run with the largest travel, from end to end."""
    return max(history.runs, key=lambda run: float(np.ptp(history.runs[run].travel)))


def _draw_loops(
    row: NDArray[np.object_], history: StrutHistory, run: StrutRun, stiffness: float, part: slice
) -> None:
    if run.force is None:
        return
    colour, width = _pen(history)
    x, v, force = (_finer(y)[part] for y in (run.travel, run.velocity, run.force))
    for panel, along, shown in ((row[0], x, force), (row[1], v, force - stiffness * x)):
        panel.plot(1e3 * along, shown, color=colour, linewidth=width, label=history.name)
        panel.yaxis.set_major_locator(MaxNLocator(5))


def _finer(y: Array) -> Array:
    """With points between the samples of a signal in band."""
    samples = np.arange(len(y))
    between = np.linspace(0, len(y) - 1, FINER * (len(y) - 1) + 1)
    return np.asarray(CubicSpline(samples, y)(between))


def _pen(history: StrutHistory) -> tuple[str, float]:
    """Colour and width of a line."""
    if history.is_measured:
        return MEASURED, 2.4
    return (BEFORE if history.name == BASELINE else AFTER), 1.1


def _name_lines(figure: Drawing, panel: Axes) -> None:
    handles, labels = panel.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper left", ncols=3)


def any_measured(histories: Histories) -> bool:
    """Whether the travel of any strut was measured."""
    return any(history.is_measured for each in histories.values() for history in each)


def shares_table(histories: Histories) -> str:
    """Every strut's shares of the time, its velocity and its travel, as HTML."""
    with_noise = any_measured(histories)
    rows = []
    for corner, each in histories.items():
        for i, history in enumerate(each):
            noise = significant(1e3 * history.velocity_noise) if history.is_measured else ""
            rows.append(
                (
                    f'<span class="whole">{CORNER_NAMES[corner]}</span>' if i == 0 else "",
                    f'<span class="whole">{history.name}</span>',
                    *(f"{100 * part:.0f} %" for part in vars(shares(history.velocity)).values()),
                    significant(1e3 * float(np.sqrt(np.mean(history.velocity**2)))),
                    *([noise] if with_noise else []),
                    _from_to(1e3 * history.travel),
                )
            )
    headings = ["strut", "", "bump, high", "bump, low", "rebound, low", "rebound, high"]
    headings += ["velocity rms, mm/s", *(["of it noise"] if with_noise else []), "travel, mm"]
    return table(headings, rows, "ll" + "r" * (len(headings) - 2))


def _from_to(values: Array) -> str:
    low, high = (f"{float(end):.3g}".replace("-", "−") for end in (values.min(), values.max()))
    return f"{low} … {high}"
