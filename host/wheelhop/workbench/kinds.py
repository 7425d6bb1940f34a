"""What Compare draws of its rows: a chart of either kind, with the words above it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.files.words import significant, squared
from wheelhop.workbench.charts import (
    AFTER,
    BEFORE,
    FLOOR,
    MEASURED,
    MORE,
    MOST,
    WHOLE,
    Line,
    Options,
    Panel,
    Window,
    chart,
)
from wheelhop.workbench.compared import (
    COHERENCE,
    DISTANCE,
    HISTOGRAM,
    OVERLAY,
    RESPONSE,
    SPECTROGRAM,
    SPECTRUM,
    TIME,
    XY,
)
from wheelhop.workbench.curves import Curve, Row, within
from wheelhop.workbench.spectra import Array, Spectra, power_density, spectra
from wheelhop.workbench.spectrogram import spectrogram

OF_RUNS = (AFTER, BEFORE, *MORE, MEASURED)
"""Colours of runs laid over one another; after these they come again, dashed."""
PEN, PATH_PEN, MODEL_PEN = 4.0, 2.5, 1.4
"""Pixels: what was measured is thick and grey, a model lies over it."""
ROW_PX, SMALL_PX = 300, 170
"""Height of a panel among few, and among many."""
FOOT_PX, CAPTION_PX, HEAD_PX = 42, 20, 30
"""Below a panel, for what stands along its x axis, and for a caption; above all, for the names."""
BINS = 41
"""Of a histogram, an odd number, so that one of them lies about rest."""
WAVES = 2
"""Segments of a coherence hold so many waves of the slowest frequency in band, which a Hann window
just tells from a constant."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A chart, its height, and whether all its panels have one x axis."""

    options: Options
    height_px: int
    joined: bool


@dataclass(frozen=True)
class Look:
    """What a picture is made for: from when to when, s, where the cursors stand, and the band."""

    window: Window
    cursors: Window | None
    band_hz: tuple[float, float]


def picture(kind: str, rows: Sequence[Row], look: Look) -> Picture:
    """The rows as a chart of this kind."""
    if kind == SPECTROGRAM:
        return _spectrogram(rows, look)
    panels = PANELS[kind](rows, look)
    joined = kind != XY
    every = ROW_PX if len(panels) <= 2 else SMALL_PX
    foot = FOOT_PX + (CAPTION_PX if any(panel.caption for panel in panels) else 0)
    total = HEAD_PX + len(panels) * (every + foot)
    window = look.window if kind == TIME else WHOLE
    zoom = range(len(panels)) if joined else ()
    options = chart(panels, [every] * len(panels), list(zoom), window, 100 * foot / total)
    if kind == TIME:
        outside = {"colorAlpha": 1.0}  # while it is dragged, nothing fades
        options["brush"] = {"xAxisIndex": "all", "toolbox": [], "outOfBrush": outside}
        # where cursors stand a drag sets them anew, and moves nothing
        options["dataZoom"][0]["moveOnMouseMove"] = look.cursors is None
    if kind == XY:
        del options["dataZoom"]
        options["tooltip"] = {"show": False}
    return Picture(options, total, joined)


def _spectrogram(rows: Sequence[Row], look: Look) -> Picture:
    every = ROW_PX if len(rows) <= 2 else SMALL_PX
    foot = FOOT_PX + CAPTION_PX
    total = HEAD_PX + len(rows) * (every + foot)
    share = [100 * every / total] * len(rows)
    return Picture(spectrogram(rows, look.band_hz, share, 100 * foot / total), total, False)


def _over_time(rows: Sequence[Row], look: Look) -> list[Panel]:
    """Every row against time; below a single one what each model leaves of it."""
    end = max((row.length_s for row in rows), default=1.0)
    panels, several = [], len({row.run for row in rows}) > 1
    for i, row in enumerate(rows):
        begins = several and (i == 0 or rows[i - 1].run != row.run)
        time = np.arange(len(row.curves[0].signal)) / row.rate_hz
        lines = [_line(curve, time, curve.signal) for curve in row.curves]
        about = Panel(
            *("time, s", f"{row.channel}, {row.unit}", lines),
            marks=look.cursors or (),
            title=_title(row, rows),
            caption=row.run if begins else "",
            units=("s", row.unit),
            ends=(0.0, end),
        )
        panels.append(about)
        if len(rows) == 1 and len(row.curves) > 1:
            measured, *models = row.curves
            left = [_line(curve, time, measured.signal - curve.signal) for curve in models]
            name = f"residual, {row.unit}"
            panels.append(
                replace(about, y_name=name, lines=left, band=2 * row.noise, title="residual")
            )
    return [replace(panel, x_name="") for panel in panels[:-1]] + panels[-1:]


def _laid_over(rows: Sequence[Row], look: Look) -> list[Panel]:
    """Runs over one another against time."""
    return _runs_over(rows, "time, s", "s", _time_of)


def _over_distance(rows: Sequence[Row], look: Look) -> list[Panel]:
    """Runs over one another against the place of the front axle: what a track does lies together,
    whatever the speed."""
    if any(row.place_m is None for row in rows):
        return _laid_over(rows, look)
    return _runs_over(rows, "place of the front axle, m", "m", lambda row: row.place_m)


def _time_of(row: Row) -> Array:
    return np.arange(len(row.curves[0].signal)) / row.rate_hz


def _runs_over(
    rows: Sequence[Row], x_name: str, x_unit: str, x_of: Callable[[Row], Array | None]
) -> list[Panel]:
    """A panel for every channel: of one run what was measured and modelled, of several what was
    measured in each."""
    panels = []
    for channel, group in _by_channel(rows).items():
        lines = []
        for i, row in enumerate(group):
            x = np.asarray(x_of(row))
            if len(group) == 1:
                lines += [_line(curve, x, curve.signal) for curve in row.curves]
            else:
                colour = OF_RUNS[i % len(OF_RUNS)]
                dashed = i >= len(OF_RUNS)
                signal = row.curves[0].signal
                lines.append(Line(row.run, x, signal, colour, MODEL_PEN, dashed=dashed))
        unit = group[0].unit
        panels.append(
            Panel(*(x_name, f"{channel}, {unit}", lines), title=channel, units=(x_unit, unit))
        )
    return [replace(panel, x_name="") for panel in panels[:-1]] + panels[-1:]


def _spectra(rows: Sequence[Row], look: Look) -> list[Panel]:
    """Power densities in band, of every channel; of several runs the mean of theirs."""
    low, high = look.band_hz
    panels = []
    for channel, group in _by_channel(rows).items():
        lines = []
        for name, curves in _by_name(group).items():
            frequency, power = power_density([c.signal for c in curves], group[0].rate_hz)
            kept = (frequency >= low) & (frequency <= high) & (power > 0)
            lines.append(_line(replace(curves[0], name=name), frequency[kept], power[kept]))
        noise, unit = group[0].noise, f"{squared(group[0].unit)}/Hz"
        if noise > 0:
            level = np.full(2, noise**2 / (high - low))
            lines.append(Line("noise floor", [low, high], level, FLOOR, dashed=True))
        panels.append(
            Panel(
                *("frequency, Hz", f"{channel}, {unit}", lines),
                log=True,
                title=channel,
                units=("Hz", unit),
            )
        )
    return panels


def _responses(rows: Sequence[Row], look: Look) -> list[Panel]:
    """The first channel over every other one: the size of H1."""
    panels = []
    for over, group in _pairs(rows).items():
        unit = f"{group[0][0].unit}/{group[0][1].unit}" if _differ(group) else "1"
        found = _paired(group, look, _coherent_gain)
        name = f"{group[0][0].channel} / {over}" + (f", {unit}" if unit != "1" else "")
        panels.append(
            Panel(
                *("frequency, Hz", name, found),
                log=True,
                title=f"{group[0][0].channel} / {over}",
                units=("Hz", unit if unit != "1" else ""),
            )
        )
    return panels


def _coherent_gain(both: Spectra) -> Array:
    """The gain, where it is not one by chance."""
    return np.where(both.coherence > both.by_chance, both.gain, np.nan)


def _coherences(rows: Sequence[Row], look: Look) -> list[Panel]:
    """Share of the first channel's power that goes with another one, and what would by chance."""
    panels = []
    for over, group in _pairs(rows).items():
        chance = _paired(group, look, lambda both: np.full(len(both.input), both.by_chance))[0]
        level = replace(chance, name="by chance", colour=FLOOR, width=1.0, dashed=True)
        panels.append(
            Panel(
                *("frequency, Hz", f"{group[0][0].channel} with {over}"),
                [*_paired(group, look, lambda both: both.coherence), level],
                title=f"{group[0][0].channel} with {over}",
                units=("Hz", ""),
                y_ends=(0.0, 1.0),
            )
        )
    return panels


def _over_each_other(rows: Sequence[Row], look: Look) -> list[Panel]:
    """The first channel over every other one, run by run, in the window."""
    panels = []
    for over, group in _pairs(rows).items():
        for y, x in group:
            part = within(y, look.window)
            most = slice(part.start, part.stop, max(1, (part.stop - part.start) // (4 * MOST)))
            lines = [
                _path(of_y, of_x.signal[most], of_y.signal[most])
                for of_y, of_x in zip(y.curves, x.curves, strict=True)
            ]
            caption = y.run if len(group) > 1 else ""
            names = f"{over}, {x.unit}", f"{y.channel}, {y.unit}"
            panels.append(Panel(*names, lines, caption=caption, units=(x.unit, y.unit)))
    return panels


def _histograms(rows: Sequence[Row], look: Look) -> list[Panel]:
    """How much of the time a channel has which value, in all runs."""
    panels = []
    for channel, group in _by_channel(rows).items():
        every = {
            name: np.concatenate([c.signal for c in curves])
            for name, curves in _by_name(group).items()
        }
        end = max(float(np.abs(values).max()) for values in every.values()) or 1.0
        edges = np.linspace(-end, end, BINS + 1)
        lines = []
        for curve in group[0].curves:
            count, _ = np.histogram(every[curve.name], edges)
            share = 100 * np.repeat(count, 2) / len(every[curve.name])
            lines.append(_path(curve, np.repeat(edges, 2)[1:-1], share))
        unit = group[0].unit
        panels.append(
            Panel(
                *(f"{channel}, {unit}", "share of time, %", lines),
                title=channel,
                units=(unit, "%"),
            )
        )
    return panels


PANELS: dict[str, Callable[[Sequence[Row], Look], list[Panel]]] = {
    TIME: _over_time,
    OVERLAY: _laid_over,
    DISTANCE: _over_distance,
    SPECTRUM: _spectra,
    RESPONSE: _responses,
    COHERENCE: _coherences,
    XY: _over_each_other,
    HISTOGRAM: _histograms,
}


def _line(curve: Curve, x: NDArray[np.float64], y: NDArray[np.float64]) -> Line:
    width = PEN if curve.colour == MEASURED else MODEL_PEN
    return Line(curve.name, x, y, curve.colour, width, dashed=curve.colour in MORE)


def _path(curve: Curve, x: NDArray[np.float64], y: NDArray[np.float64]) -> Line:
    width = PATH_PEN if curve.colour == MEASURED else MODEL_PEN
    return replace(_line(curve, x, y), width=width, path=True)


def _title(row: Row, rows: Sequence[Row]) -> str:
    """What tells a row from the others."""
    runs, channels = {each.run for each in rows}, {each.channel for each in rows}
    names = [row.channel] if len(channels) > 1 or len(runs) == 1 else []
    return ", ".join([*names, *([row.run] if len(runs) > 1 else [])])


def _by_channel(rows: Sequence[Row]) -> dict[str, list[Row]]:
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row.channel, []).append(row)
    return found


def _by_name(rows: Sequence[Row]) -> dict[str, list[Curve]]:
    """The curves of one name in all rows: what was measured, and each model."""
    found: dict[str, list[Curve]] = {}
    for row in rows:
        for curve in row.curves:
            found.setdefault(curve.name, []).append(curve)
    return found


def _pairs(rows: Sequence[Row]) -> dict[str, list[tuple[Row, Row]]]:
    """The first channel with every other one, run by run."""
    first, *others = _by_channel(rows) or [""]
    found: dict[str, list[tuple[Row, Row]]] = {}
    of_run = {row.run: row for row in rows if row.channel == first}
    for row in rows:
        if row.channel in others and row.run in of_run:
            found.setdefault(row.channel, []).append((of_run[row.run], row))
    return found


def _differ(group: Sequence[tuple[Row, Row]]) -> bool:
    y, x = group[0]
    return y.unit != x.unit


def _paired(
    group: Sequence[tuple[Row, Row]], look: Look, value: Callable[[Spectra], Array]
) -> list[Line]:
    """A line for what was measured and for each model, in band, over all runs."""
    (low, high), rate_hz = look.band_hz, group[0][0].rate_hz
    lines = []
    for i, curve in enumerate(group[0][0].curves):
        outputs = [y.curves[i].signal for y, _ in group]
        inputs = [x.curves[i].signal for _, x in group]
        both = spectra(inputs, outputs, rate_hz, round(WAVES * rate_hz / low))
        kept = (both.frequency_hz >= low) & (both.frequency_hz <= high)
        kept &= np.isfinite(both.coherence)
        lines.append(_line(curve, both.frequency_hz[kept], value(both)[kept]))
    return lines


def words(rows: Sequence[Row]) -> str:
    """The line above the chart, of a single row."""
    if len(rows) != 1:
        return ""
    (row,) = rows
    rms = " · ".join(f"{c.name} {significant(_rms(c.signal))}" for c in row.curves)
    return f"rms of the run, {row.unit}: {rms}"


def readings(rows: Sequence[Row], cursors: Window) -> list[list[str]]:
    """What stands at two cursors, their difference, and rms between, of every curve."""
    found = []
    for row in rows:
        part = within(row, cursors)
        for curve in row.curves:
            ends = [_at(curve.signal, row.rate_hz, end) for end in cursors]
            between = curve.signal[part] if part.stop > part.start else np.full(1, np.nan)
            numbers = (*ends, ends[1] - ends[0], _rms(between), float(np.ptp(between)))
            name = f"{row.channel}, {row.run}"
            found.append([name, curve.name, *map(significant, numbers), row.unit])
    return found


def _at(signal: Array, rate_hz: float, time_s: float) -> float:
    return float(np.interp(time_s * rate_hz, np.arange(len(signal)), signal))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
