"""The figures: the ladder, measured against modelled, and where the residual lies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter
from numpy.typing import NDArray
from scipy import signal

from wheelhop.compare import Breakdown, Locking, Slice
from wheelhop.diagnose import Step
from wheelhop.files.words import significant, squared
from wheelhop.logger import Recording
from wheelhop.report.cases import Case
from wheelhop.report.svg import COLOURS, STYLE, Drawing, literal

Array = NDArray[np.float64]

INK, SOFT, RULE = COLOURS["ink"], COLOURS["soft"], COLOURS["rule"]
MEASURED, BEFORE, AFTER, FLOOR = (COLOURS[k] for k in ("measured", "before", "after", "floor"))
DASHED: dict[str, Any] = {"color": FLOOR, "linestyle": (0, (4, 3)), "linewidth": 1.0}
WIDTH = 8.0  # inches, the page's text width


def ladder_figure(steps: Sequence[Step]) -> Drawing:
    """Error on fitted and on held-out runs, rung by rung, down to the noise floor."""
    with mpl.rc_context(STYLE):
        height = 2.9 if len(steps) > 1 else 1.9
        figure = Drawing(figsize=(WIDTH, height), layout="constrained")
        draw_ladder(figure.add_subplot(), steps)
    return figure


def draw_ladder(axes: Axes, steps: Sequence[Step]) -> None:
    """Draw `ladder_figure` into given axes."""
    several = len(steps) > 1
    floor = 100 * steps[-1].floor
    errors = [100 * step.rung.error for step in steps]
    fitted = [100 * step.rung.error_fit for step in steps]
    x = range(len(steps))
    held_out = steps[0].rung.validation is not None
    if held_out:
        axes.plot(x, fitted, "o", ms=6, mfc="none", mec=SOFT, label="runs fitted", zorder=3)
    label = "runs held out" if held_out else "runs fitted"
    axes.plot(x, errors, "-", color=MEASURED, linewidth=2.0)
    axes.plot(x, errors, "o", ms=6, color=INK, label=label, zorder=4)
    for i, error in enumerate(errors):
        place: dict[str, Any] = {"xytext": (9, 5), "textcoords": "offset points"}
        axes.annotate(f"{significant(error, 2)} %", (i, error), **place)
    values = [value for value in (*errors, *fitted, floor) if value > 0]
    log_axis(axes, min(values) / 1.7, max(values) * (1.6 if several else 2.6))
    _draw_floor(axes, floor)
    axes.set_ylabel("error E, %")
    before = [None, *steps[:-1]]
    axes.set_xticks(x, [_rung_name(a, b) for a, b in zip(before, steps, strict=True)])
    axes.tick_params(axis="x", length=0, colors=INK)
    axes.grid(axis="x", visible=False)
    axes.set_xlim(-0.4, max(len(steps) - 1, 1) + 0.6)
    axes.legend(loc="upper right", ncols=2, borderaxespad=0.0)


def _draw_floor(axes: Axes, floor: float) -> None:
    """A dashed line with its name, under its right end."""
    axes.axhline(floor, **DASHED)
    axes.annotate(
        f"noise floor {significant(floor, 2)} %",
        (1.0, floor),
        xycoords=("axes fraction", "data"),
        xytext=(0, -4),
        textcoords="offset points",
        color=SOFT,
        ha="right",
        va="top",
    )


def _rung_name(before: Step | None, step: Step) -> str:
    if before is None:
        return "baseline"
    lines = [f"+ {name}" for name in step.added if name not in before.added]
    lines += [f"− {name}" for name in before.added if name not in step.added]
    return "\n".join(lines)


def case_figure(case: Case, added: str) -> Drawing:
    """One channel of one run: against time, what is left of it, and its spectrum. `added` names
    the effects of the last model; without any, the baseline is drawn alone."""
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 3.2), layout="constrained")
        grid = figure.add_gridspec(2, 2, width_ratios=(1.75, 1), height_ratios=(2.1, 1))
        upper = figure.add_subplot(grid[0, 0])
        lower = figure.add_subplot(grid[1, 0], sharex=upper)
        draw_signal(upper, case, added)
        draw_residual(lower, case, added)
        upper.tick_params(axis="x", labelbottom=False, length=0)
        upper.set_xlabel("")
        lower.yaxis.set_major_locator(MaxNLocator(3))
        draw_spectrum(figure.add_subplot(grid[:, 1]), case, added)
        figure.align_ylabels([upper, lower])
        handles, labels = upper.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=3)
    return figure


def draw_signal(axes: Axes, case: Case, added: str) -> None:
    """Measured and modelled against time, of the stretch that is shown."""
    part = case.shown
    time = case.time_s[part]
    axes.plot(time, case.measured[part], color=MEASURED, linewidth=2.4, label="measured")
    axes.plot(time, case.before[part], color=BEFORE, label="baseline")
    if added:
        axes.plot(time, case.after[part], color=AFTER, label=f"with {added}")
    axes.set_ylabel(f"{case.quantity}, {case.unit}")
    _along_time(axes, time)


def draw_residual(axes: Axes, case: Case, added: str) -> None:
    """Measured minus modelled of the same stretch, and twice the noise on either side of 0."""
    part = case.shown
    time = case.time_s[part]
    axes.plot(time, (case.measured - case.before)[part], color=BEFORE, label="baseline")
    if added:
        after = (case.measured - case.after)[part]
        axes.plot(time, after, color=AFTER, label=f"with {added}")
    band = 2 * case.noise_rms
    axes.axhspan(-band, band, color=RULE, linewidth=0, label="noise, ± 2 σ")
    axes.set_ylabel(f"residual, {case.unit}")
    _along_time(axes, time)


def _along_time(axes: Axes, time: Array) -> None:
    axes.set_xlabel("time, s")
    axes.set_xlim(time[0], time[-1])
    axes.yaxis.set_major_locator(MaxNLocator(5))


def draw_spectrum(axes: Axes, case: Case, added: str) -> None:
    """Power spectral densities of measurement and models, and that of the noise."""
    lines = [(case.measured, MEASURED, 2.4, "measured"), (case.before, BEFORE, 1.1, "baseline")]
    if added:
        lines.append((case.after, AFTER, 1.1, f"with {added}"))
    lowest = np.inf
    for values, colour, width, label in lines:
        frequency, power = _spectrum(values, case.rate_hz)
        axes.plot(frequency, power, color=colour, linewidth=width, label=label)
        lowest = min(lowest, float(power[1:].min()))
    bandwidth = _bandwidth(case)
    if case.noise_rms > 0:
        level = case.noise_rms**2 / bandwidth[1]
        axes.axhline(level, **DASHED, label="noise")
        lowest = 0.2 * level
    top = float(_spectrum(case.measured, case.rate_hz)[1].max())
    axes.set_xscale("log")
    axes.set_xlim(*bandwidth[0])
    axes.xaxis.set_major_locator(LogLocator(base=10, subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_yscale("log")
    axes.set_ylim(lowest, 3 * top)
    axes.set_xlabel("frequency, Hz")
    axes.set_ylabel(f"power density, {squared(case.unit)}/Hz")


ONE_PANEL = {"signal": draw_signal, "residual": draw_residual, "psd": draw_spectrum}
"""What shows one channel of one run in one panel."""


def panel_figure(case: Case, kind: str, added: str) -> Drawing:
    """One channel of one run in one panel of a kind of `ONE_PANEL`."""
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 3.0), layout="constrained")
        axes = figure.add_subplot()
        draw_panel(axes, case, kind, added)
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.0)
    return figure


def draw_panel(axes: Axes, case: Case, kind: str, added: str) -> None:
    """Draw one panel of a case into given axes, with its legend and a title that says which run."""
    ONE_PANEL[kind](axes, case, added)
    axes.set_title(literal(f"{case.channel} in {case.run_id}"))
    axes.legend(loc="best")


def _spectrum(values: Array, rate_hz: float) -> tuple[Array, Array]:
    """Welch's estimate over a third of the run, Hann window."""
    frequency, power = signal.welch(values, rate_hz, nperseg=max(8, len(values) // 3))
    return frequency[1:], power[1:]


def _bandwidth(case: Case) -> tuple[tuple[float, float], float]:
    """Frequencies that hold the in-band signal, and their extent, Hz."""
    power = np.abs(np.fft.rfft(case.measured)) ** 2
    frequency = np.fft.rfftfreq(len(case.measured), 1 / case.rate_hz)
    inside = frequency[power > 1e-18 * power.max()]
    return (float(inside[0]), float(inside[-1])), float(inside[-1] - inside[0])


def recording_figure(recording: Recording, columns: Sequence[int] = ()) -> Drawing:
    """Every channel, or those in some columns, against time, one above the other, those of one unit
    on one scale."""
    with mpl.rc_context(STYLE):
        columns = columns or range(len(recording.channels))
        count = len(columns)
        figure = Drawing(figsize=(WIDTH, 0.5 + 0.85 * count), layout="constrained")
        panels = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
        units = [recording.channels[column].unit for column in columns]
        for axes, unit, column in zip(panels, units, columns, strict=True):
            draw_recorded(axes, recording, column)
            axes.yaxis.set_major_locator(MaxNLocator(3))
            axes.sharey(panels[units.index(unit)])
        panels[-1].set_xlabel("time, s")
    return figure


def draw_recorded(axes: Axes, recording: Recording, column: int) -> None:
    """One channel against time."""
    channel = recording.channels[column]
    axes.plot(recording.time_s, recording.values[:, column], color=AFTER, linewidth=0.8)
    axes.set_ylabel(literal(f"{channel.name}, {channel.unit}" if channel.unit else channel.name))
    axes.margins(x=0.0)


def where_figure(before: Breakdown, after: Breakdown | None) -> Drawing:
    """Residual over floor by frequency band and by motion, and what it is locked to."""
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 2.75), layout="constrained")
        draw = [_draw_bands, _draw_motions, _draw_locking]
        if not before.motion:  # the channels determine none
            draw.remove(_draw_motions)
        panels = figure.subplots(1, len(draw), width_ratios=(1.35, 1, 1)[: len(draw)])
        for drawn, axes in zip(draw, panels, strict=True):
            drawn(axes, before, after)
    return figure


def _draw_bands(axes: Axes, before: Breakdown, after: Breakdown | None) -> None:
    axes.set_title("by third-octave band")
    for where, colour in ((before, BEFORE), (after, AFTER)):
        if where is not None:
            frequency = [float(part.name) for part in where.band]
            ratio = [part.ratio for part in where.band]
            axes.plot(frequency, ratio, "o-", ms=3.2, color=colour)
    axes.axhline(1, **DASHED)
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(base=10, subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("frequency, Hz")
    axes.set_ylabel("residual / noise floor")
    log_axis(axes, *_ratio_range([*before.band, *(after.band if after else ())]))


def _draw_motions(axes: Axes, before: Breakdown, after: Breakdown | None) -> None:
    axes.set_title("by motion")
    names = [part.name for part in before.motion]
    y = np.arange(len(names))[::-1]
    start = np.array([part.ratio for part in before.motion])
    end = start if after is None else np.array([part.ratio for part in after.motion])
    axes.hlines(y, np.minimum(start, end), np.maximum(start, end), color=RULE, linewidth=2.5)
    axes.plot(start, y, "o", ms=4.5, color=BEFORE)
    if after is not None:
        axes.plot(end, y, "o", ms=4.5, color=AFTER)
    axes.axvline(1, **DASHED)
    axes.set_yticks(y, names)
    axes.tick_params(axis="y", length=0, colors=INK)
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("residual / noise floor")
    log_axis(axes, *_ratio_range([*before.motion, *(after.motion if after else ())]), "x")


def _draw_locking(axes: Axes, before: Breakdown, after: Breakdown | None) -> None:
    axes.set_title("locked to")
    locked = (("the drive", AFTER), *LOCKED[1:]) if before.on_rig else LOCKED
    bars = [("baseline", before)] if after is None else [("before", before), ("after", after)]
    for i, (_, where) in enumerate(bars):
        bottom = 0.0
        for share, (_, colour) in zip(_locking_shares(where.locking), locked, strict=True):
            axes.bar(i, 100 * share, 0.62, bottom=bottom, color=colour, linewidth=0)
            bottom += 100 * share
    axes.set_xticks(range(len(bars)), [name for name, _ in bars])
    axes.set_xlim(-0.6, max(len(bars) - 1, 1) + 1.6)
    axes.tick_params(axis="x", length=0, colors=INK)
    axes.grid(axis="x", visible=False)
    axes.set_ylim(0, 100)
    axes.set_ylabel("share of the residual, %")
    x = max(len(bars) - 1, 0) + 0.5
    for k, (name, colour) in enumerate(locked):
        axes.add_patch(Rectangle((x, 8 + 14 * k), 0.14, 7, color=colour, linewidth=0))
        axes.text(x + 0.22, 11.5 + 14 * k, name, va="center")


LOCKED = (
    ("the road", AFTER),
    ("time", BEFORE),
    ("neither", COLOURS["share-neither"]),
    ("noise", COLOURS["share-noise"]),
)


def _locking_shares(locking: Locking) -> tuple[float, float, float, float]:
    """Road, time, neither, and the noise, which is locked to nothing."""
    noise = min(locking.noise, locking.neither)
    return locking.road, locking.time, locking.neither - noise, noise


def _ratio_range(parts: Sequence[Slice]) -> tuple[float, float]:
    ratios = np.array([part.ratio for part in parts])
    ratios = ratios[np.isfinite(ratios) & (ratios > 0)]
    if not len(ratios):
        return 0.7, 10.0
    return min(0.7, float(ratios.min()) / 1.2), max(2.6, float(ratios.max()) * 1.3)


def log_axis(axes: Axes, low: float, high: float, which: str = "y") -> None:
    """A logarithmic axis with plain numbers: 0.5, 1, 2, 5, 10, …"""
    axis = axes.yaxis if which == "y" else axes.xaxis
    (axes.set_yscale if which == "y" else axes.set_xscale)("log")
    (axes.set_ylim if which == "y" else axes.set_xlim)(low, high)
    steps = (1,) if high / low > 300 else (1, 2, 5)
    axis.set_major_locator(LogLocator(base=10, subs=steps))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())
