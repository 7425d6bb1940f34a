"""The picture of a comparison: response and delay over frequency, and what the fit leaves."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from wheelhop.calibration.shaker.response import one_pole
from wheelhop.calibration.shaker.result import (
    ALIKE,
    LEAST_COHERENCE,
    ChannelCalibration,
    Comparison,
)
from wheelhop.files import write_picture
from wheelhop.logger.recording import CODE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INKS = ("#0b66a8", "#c8540a", "#1b1f24", "#7a6aa8", "#3f8f6b", "#5b6470", "#a33b5e", "#8a6d1d")
"""Of the channels, in their order, over again if there are more."""


def draw(comparison: Comparison, path: Path) -> None:
    """Write the picture, its format by the suffix of `path`. Raises InputError."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 7.5), layout="constrained")
    axes: Any = figure.subplots(2, 2)
    (gain, rest), (phase, linear) = axes
    count = len(comparison.channels)
    for number, channel in enumerate(comparison.channels):
        colour = INKS[number % len(INKS)]
        aside = 1 + 0.1 / count * (number - (count - 1) / 2)  # bars must not hide each other
        _draw_gain(gain, channel, colour)
        _draw_phase(phase, channel, colour)
        _draw_rest(rest, channel, colour, aside)
        _draw_linear(linear, channel, colour, aside)
    for number, channel in enumerate(comparison.channels):
        _draw_unusable(gain, channel, INKS[number % len(INKS)])
    raw = comparison.channels[0].unit == CODE
    gain.set_ylabel("response, static = 1" if raw else "sensor over reference")
    phase.set_ylabel("phase behind the reference, °")
    for axis in (gain, phase, rest):
        axis.set_xlabel("frequency, Hz")
        axis.set_xscale("log")
        low, high = axis.get_xlim()
        ticks = [f for f in (0.5, 1, 2, 5, 10, 20, 50) if low < f < high]
        axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axis.minorticks_off()
    for axis in (rest, linear):
        axis.set_ylabel("off the fitted line, %")
        axis.set_ylim(*_limits(comparison))
        axis.axhline(0, color="0.6", lw=0.8)
    linear.set_xlabel("amplitude, m/s²")
    gain.set_title(
        "Response; band: expanded uncertainty of the gain, k = 2", fontsize=10, loc="left"
    )
    phase.set_title("Phase, clocks aligned", fontsize=10, loc="left")
    rest.set_title("Do the frequencies agree? Bars: k = 2", fontsize=10, loc="left")
    linear.set_title(
        "Does the amplitude matter, at one frequency? Bars: k = 2", fontsize=10, loc="left"
    )
    for axis in axes.flat:
        axis.grid(alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
    if not linear.collections:
        linear.text(
            0.5, 0.7, "one amplitude at each frequency", ha="center", transform=linear.transAxes
        )
        linear.set_xticks([])
    gain.legend(fontsize=8, ncols=2, frameon=False)
    write_picture(path, figure)


def _limits(comparison: Comparison) -> tuple[float, float]:
    """For what is off the line, so that weak points' bars do not flatten the rest; in %."""
    sure = np.concatenate([channel.expanded for channel in comparison.channels])
    off = np.concatenate([channel.deviation for channel in comparison.channels])
    counts = sure < 4 * np.median(sure)
    limit = 120 * float((np.abs(off) + sure)[counts].max())
    return -limit, limit


def _used(channel: ChannelCalibration) -> Any:
    return channel.points.coherence >= LEAST_COHERENCE


def _draw_gain(axis: Axes, channel: ChannelCalibration, colour: str) -> None:
    used, points = _used(channel), channel.points
    scale = abs(channel.gain.value) if channel.unit == CODE else 1.0
    size = np.abs(points.ratio) * scale
    grid = np.geomspace(points.frequency_hz[used].min(), points.frequency_hz[used].max(), 200)
    model = scale / abs(channel.gain.value) * np.abs(one_pole(grid, _constant(channel)))
    width = model * channel.gain.relative
    axis.fill_between(grid, model - width, model + width, color=colour, alpha=0.15, lw=0)
    axis.plot(grid, model, color=colour, lw=1)
    axis.errorbar(
        *(points.frequency_hz[used], size[used], size[used] * channel.expanded),
        fmt="o",
        ms=4,
        lw=1,
        color=colour,
        label=channel.name,
    )


def _draw_unusable(axis: Axes, channel: ChannelCalibration, colour: str) -> None:
    """Where they lie within what the usable ones have opened."""
    scale = abs(channel.gain.value) if channel.unit == CODE else 1.0
    bad = ~_used(channel)
    limits = axis.get_ylim()
    axis.plot(
        channel.points.frequency_hz[bad],
        scale * np.abs(channel.points.ratio[bad]),
        "x",
        color=colour,
        alpha=0.4,
    )
    axis.set_ylim(*limits)


def _draw_phase(axis: Axes, channel: ChannelCalibration, colour: str) -> None:
    used = _used(channel)
    frequency = channel.points.frequency_hz[used]
    grid = np.geomspace(frequency.min(), frequency.max(), 200)
    axis.plot(grid, np.degrees(np.angle(one_pole(grid, _constant(channel)))), color=colour, lw=1)
    model = np.angle(one_pole(frequency, _constant(channel)))
    axis.errorbar(
        *(frequency, np.degrees(model + channel.phase_rad), np.degrees(channel.expanded)),
        fmt="o",
        ms=4,
        color=colour,
    )


def _draw_rest(axis: Axes, channel: ChannelCalibration, colour: str, aside: float) -> None:
    frequency = channel.points.frequency_hz[_used(channel)]
    axis.errorbar(
        *(frequency * aside, 100 * channel.deviation, 100 * channel.expanded),
        fmt="o",
        ms=3,
        lw=0.8,
        color=colour,
    )


def _draw_linear(axis: Axes, channel: ChannelCalibration, colour: str, aside: float) -> None:
    """The frequency that was driven at most amplitudes."""
    used = _used(channel)
    frequency = channel.points.frequency_hz[used]
    alike = np.abs(frequency[:, None] / frequency - 1) < ALIKE
    chosen = alike[alike.sum(axis=0).argmax()]
    if chosen.sum() < 2:
        return
    axis.errorbar(
        channel.points.amplitude_m_s2[used][chosen] * aside,
        100 * channel.deviation[chosen],
        100 * channel.expanded[chosen],
        fmt="o",
        ms=3,
        lw=0.8,
        color=colour,
    )


def _constant(channel: ChannelCalibration) -> float:
    return 1 / (2 * np.pi * channel.corner_hz.value) if channel.corner_hz else 0.0
