"""What one channel tells by itself, or beside the others' size: clipped, stuck, dead, drifting."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.health.finding import CERTAIN, LIKELY, POSSIBLE, Finding
from wheelhop.calibration.sync.delay import stretches
from wheelhop.files.units import STANDARD_GRAVITY_M_S2
from wheelhop.logger.recording import ACCELERATION, CODE, Recording

TOP_BIN = 0.005  # of the range: what is this near to the extreme is at the extreme
PILE = 3.0  # samples at the extreme over those in the nine bins before it; a sine has 0.46
FEWEST_CLIPPED = 8
RAILS = (0.5, 1022.5)  # codes beyond which the converter is at its end
STUCK_S = 1.0
MOVES = 10.0  # others must move by as many steps before standing still is odd
DEAD = 0.5  # rms over the others' median, below which a white channel is dead if they are not
SILENT = 0.01  # and below which any channel is
WHITE = 4.0  # standard errors within which autocorrelation is none
LAGS = 10
FEWEST_ROWS = 20
DRIFT_STRAIGHT = 0.25  # of a drift, that its middle may lie off the straight line
DRIFT_SHORTEST_S = 8.0
DRIFT_SURE = 5.0  # standard deviations that slow motion would have to make it
SLOW_HZ = 1.0
DRIFT = {ACCELERATION: 1.0, CODE: 2.0}
LEVEL_CODES = (250.0, 774.0)  # 0.8 and 2.5 V of 3.3: no ADXL326 at rest is outside
GRAVITY_TOLERANCE = 2.5
BEYOND = "drive slower, mount the sensor softer, or take one of a larger range"
END = {"m": "the sensor is at its end: give it more stroke, or leave the channel out"}
"""What to do about a range that was exceeded, by the channel's unit."""

Array = NDArray[np.float64]


def channel_findings(recording: Recording) -> Iterator[Finding]:
    """What is wrong with single channels."""
    present = recording.values[~recording.missing]
    if len(present) < FEWEST_ROWS:
        return
    alike = replace(recording, values=recording.values / _usual(recording, present))
    even = alike.values[~recording.missing]
    rms, levels = even.std(axis=0), np.median(present, axis=0)
    for c, channel in enumerate(recording.channels):
        column = present[:, c]
        others = float(np.median(np.delete(rms, c))) if len(rms) > 1 else 0.0
        still = _stuck(alike, c, others, recording) or _dead(alike, c, even, others)
        if still:
            yield still
            continue
        yield from _clipping(recording, c, column)
        yield from _level(recording, c, levels)
        if channel.unit in DRIFT:
            yield from _drift(recording, c)


def _usual(recording: Recording, present: Array) -> Array:
    """What channels are divided by (c,) to be held against each other: nothing where all are in
    one unit, else the median rms of those in the same."""
    units = np.array([channel.unit for channel in recording.channels])
    if len(set(units)) == 1:
        return np.ones(len(units))
    usual = {unit: float(np.median(present[:, units == unit].std(axis=0))) for unit in set(units)}
    return np.array([usual[unit] or 1.0 for unit in units])


def quantum(column: Array) -> float:
    """The smallest step between values of a channel; 0 if it has only one."""
    steps = np.diff(np.unique(column))
    return float(steps.min(initial=np.inf)) if len(steps) else 0.0


def _when(recording: Recording, start: int, stop: int) -> tuple[float, float]:
    rate = recording.rate_hz
    return recording.start_s + start / rate, recording.start_s + stop / rate


def _stuck(alike: Recording, c: int, others: float, recording: Recording) -> Finding | None:
    values = alike.values
    same = np.append(np.diff(values[:, c]) == 0.0, False)
    runs = [(a, b + 1) for a, b in stretches(same) if (b + 1 - a) / recording.rate_hz >= STUCK_S]
    if not runs:
        return None
    step = quantum(values[~alike.missing, c])
    # At rest, less than one step of the converter, standing still is what a good channel does.
    moving = [
        (a, b)
        for a, b in runs
        if len(recording.channels) > 1
        and np.median(np.delete(values[a:b].std(axis=0), c)) > max(MOVES * step, 0.1 * others)
    ]
    if not moving:
        return None
    first, last = moving[0][0], moving[-1][1]
    seconds = sum(b - a for a, b in moving) / recording.rate_hz
    level = recording.values[first, c]
    return Finding(
        "stuck", (recording.channels[c].name,),
        f"reads {level:.6g} without change for {seconds:.3g} s while others move",
        CERTAIN, seconds / STUCK_S, *_when(recording, first, last),
        "check plug, wire and solder of this sensor; wheelhop logger selftest tells if it is dead",
    )  # fmt: skip


def _dead(recording: Recording, c: int, present: Array, others: float) -> Finding | None:
    column = present[:, c]
    ratio = float(column.std() / others) if others > 0 else 1.0
    if ratio > DEAD or others < quantum(column):
        return None
    alive = np.mean([not _white(other) for other in np.delete(present, c, axis=1).T]) > 0.5
    if ratio > SILENT and not (alive and _white(column)):
        return None
    return Finding(
        "dead", (recording.channels[c].name,),
        f"only noise, {100 * ratio:.2g} % of what the others read", LIKELY, DEAD / max(ratio, 1e-6),
        *_when(recording, 0, len(recording.values)),
        "wheelhop logger selftest tells dead from still; check plug, wire and supply",
    )  # fmt: skip


def _white(column: Array) -> bool:
    centred = column - column.mean()
    power = float(centred @ centred)
    if power == 0.0:
        return True
    lags = [float(centred[k:] @ centred[:-k]) / power for k in range(1, LAGS + 1)]
    return bool(np.abs(lags).max() < WHITE / np.sqrt(len(column)))


def _clipping(recording: Recording, c: int, column: Array) -> Iterator[Finding]:
    channel = recording.channels[c]
    span = float(np.ptp(column))
    width = max(quantum(column), TOP_BIN * span)
    for side, end in (("top", column.max()), ("bottom", column.min())):
        depth = np.abs(column - end)
        at_end, near = int(np.sum(depth <= width)), int(np.sum(depth <= 10 * width))
        at_rail = channel.unit == CODE and (end > RAILS[1] if side == "top" else end < RAILS[0])
        piled = at_end >= FEWEST_CLIPPED and at_end > PILE * (near - at_end) and 10 * width < span
        if not (at_rail or (piled and _crests_differ(column, depth <= width, width))):
            continue
        rows = np.flatnonzero(np.abs(recording.values[:, c] - end) <= width)
        level = "the converter's end" if at_rail else f"{end:.4g} {channel.unit}"
        yield Finding(
            "clipping", (channel.name,),
            f"{at_end} samples at the {side}, {level}: the range was exceeded", CERTAIN if at_rail
            else LIKELY, at_end / FEWEST_CLIPPED, *_when(recording, rows[0], rows[-1] + 1),
            END.get(channel.unit, BEYOND),
        )  # fmt: skip


def _crests_differ(column: Array, at_end: NDArray[np.bool_], width: float) -> bool:
    """Whether what leads to the end and away from it differs more than the end does.

    Samples in step with a periodic motion meet each crest at the same place: they are as alike
    there as if they were cut off, but so are their neighbours. A limit makes crests of different
    size alike. Of the neighbours the mean counts, which a crest met a little earlier or later
    leaves as it was.
    """
    i = np.flatnonzero(at_end[1:-1]) + 1
    return bool(len(i)) and float(np.std(column[i - 1] + column[i + 1])) / 2 > width


def _level(recording: Recording, c: int, levels: Array) -> Iterator[Finding]:
    channel, level = recording.channels[c], float(levels[c])
    whole = _when(recording, 0, len(recording.values))
    if channel.unit == CODE and not LEVEL_CODES[0] < level < LEVEL_CODES[1]:
        yield Finding(
            "level", (channel.name,), f"rests at code {level:.0f}, where no sensor does", LIKELY,
            abs(level - 512) / 262, *whole,
            "the input floats or a wire is broken: check plug, supply and ground",
        )  # fmt: skip
    if channel.unit == ACCELERATION:
        felt = np.array([other.unit == ACCELERATION for other in recording.channels])
        up = felt & (np.abs(levels - STANDARD_GRAVITY_M_S2) < GRAVITY_TOLERANCE)
        down = felt & (np.abs(levels + STANDARD_GRAVITY_M_S2) < GRAVITY_TOLERANCE)
        # Only a recording that holds gravity tells; the few are wrong, not the many.
        if down[c] and up.sum() >= 2 * down.sum():
            yield Finding(
                "polarity", (channel.name,), f"reads {level:.1f} m/s² at rest, the others +9.8",
                CERTAIN, abs(level) / STANDARD_GRAVITY_M_S2, *whole,
                "the sensor is upside down: turn it, or change the sign of its gain",
            )  # fmt: skip


def _drift(recording: Recording, c: int) -> Iterator[Finding]:
    """Means over the first, middle and last half, weighted so that vibration leaves little."""
    channel = recording.channels[c]
    first, stop = max(stretches(~recording.missing), key=lambda s: s[1] - s[0])
    values, rows = recording.values[first:stop, c], stop - first
    if rows < DRIFT_SHORTEST_S * recording.rate_hz:
        return
    half = rows // 2
    window, means = np.hanning(half + 2)[1:-1], []
    for start in (0, (rows - half) // 2, rows - half):
        means.append(float(window @ values[start : start + half] / window.sum()))
    drift = 2 * (means[2] - means[0])
    bent = 2 * abs(means[1] - (means[0] + means[2]) / 2)
    chance = (
        2 * np.sqrt(2 * _slow_power(values, recording.rate_hz) * window @ window) / window.sum()
    )
    surely = abs(drift) > max(DRIFT[channel.unit], DRIFT_SURE * chance)
    if surely and bent < DRIFT_STRAIGHT * abs(drift):
        yield Finding(
            "drift", (channel.name,), f"its mean moves by {drift:+.2g} {channel.unit}", POSSIBLE,
            abs(drift) / DRIFT[channel.unit], *_when(recording, first, stop),
            "let the logger warm up, check supply and mount; take the mean out piecewise",
        )  # fmt: skip


def _slow_power(values: Array, rate_hz: float) -> float:
    """Variance of white noise as strong as a channel's slow motion, a straight line taken out."""
    time = np.linspace(-1.0, 1.0, len(values))
    window = np.hanning(len(values))
    rest = (values - values.mean() - time * (time @ values) / (time @ time)) * window
    slow = np.abs(np.fft.rfft(rest)[2 : max(4, round(SLOW_HZ * len(values) / rate_hz))]) ** 2
    return float(np.median(slow) / np.log(2) / (window @ window))
