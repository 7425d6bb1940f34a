"""What spectra tell: hum of the mains, and a sensor that shakes on its mount."""

from collections.abc import Collection, Iterator

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.health.finding import POSSIBLE, Finding
from wheelhop.calibration.health.motion import moves_in_phase
from wheelhop.calibration.sync.delay import stretches
from wheelhop.logger.recording import ACCELERATION, CODE, Recording

MAINS_HZ = (50.0, 60.0)
MAINS_SPREAD = 0.006  # the mains' own, and the logger's clock
HUM = 15.0  # amplitude of the line over its surroundings'
LONELY = 3.0  # and over every other line up to `REACH_HZ` below: a periodic track has many
REACH_HZ = 20.0
SLOW_HZ = 4.0  # strongest line below which multiples lie too densely to excuse a line
MULTIPLES = 12
FAINT = {ACCELERATION: 0.05, CODE: 0.1}  # less does no harm
SEGMENT_S = 2.56
MOUNT_HZ = 12.0  # lowest resonance of a mount looked for
MOUNT = 25.0  # its power over that of any of its like, and over the channel's usual ratio
MOUNT_SHARE = 0.02  # of the channel's power, in the peak

Array = NDArray[np.float64]


def spectrum_findings(recording: Recording, spoilt: Collection[str] = ()) -> Iterator[Finding]:
    """Hum and mounts, from the longest stretch without a gap; `spoilt` channels are no measure."""
    start, stop = max(stretches(~recording.missing), key=lambda s: s[1] - s[0], default=(0, 0))
    values = recording.values[start:stop]
    if len(values) < 2 * SEGMENT_S * recording.rate_hz:
        return
    span = (
        recording.start_s + start / recording.rate_hz,
        recording.start_s + stop / recording.rate_hz,
    )
    good = [i for i, channel in enumerate(recording.channels) if channel.name not in spoilt]
    yield from _hum(recording, values, good, span)
    if not moves_in_phase(recording):  # of a beam's points none is like another
        yield from _mounts(recording, values, good, span)


def folded(frequency_hz: float, rate_hz: float) -> float:
    """Where a frequency appears that the sampling rate cannot hold."""
    return abs(frequency_hz - rate_hz * round(frequency_hz / rate_hz))


def _hum(
    recording: Recording, values: Array, good: list[int], span: tuple[float, float]
) -> Iterator[Finding]:
    rate = recording.rate_hz
    windowed = (values - values.mean(axis=0)) * np.hanning(len(values))[:, None]
    amplitude = np.abs(np.fft.rfft(windowed, axis=0)) * 4 / len(values)
    grid = np.fft.rfftfreq(len(values), 1 / rate)
    largest = amplitude.max(axis=0) + np.finfo(float).tiny
    driven_hz = float(grid[np.argmax((amplitude / largest).sum(axis=1))])
    for mains in MAINS_HZ:
        at = folded(mains, rate)
        near = np.abs(grid - at) <= MAINS_SPREAD * mains + 2 * grid[1]
        around = (np.abs(grid - at) <= 4.0) & ~near
        below = (grid > at - REACH_HZ) & ~near
        if at < 5.0 or near.sum() == 0 or around.sum() < 8:
            continue
        for c in good:
            channel = recording.channels[c]
            line, floor = amplitude[near, c].max(), float(np.median(amplitude[around, c]))
            peak = float(grid[near][np.argmax(amplitude[near, c])])
            others = max(HUM * floor, LONELY * amplitude[below, c].max())
            if _harmonic(peak, driven_hz, grid[1], rate):
                continue
            if line > others and line > FAINT.get(channel.unit, 0.0):
                yield Finding(
                    "hum", (channel.name,),
                    f"a line of {line:.2g} {channel.unit} at {peak:.1f} Hz: mains of {mains:g} Hz",
                    POSSIBLE, line / others, *span,
                    "keep chargers away, twist or shield the wire, check the sensor's ground",
                )  # fmt: skip


def relative_power(values: Array, size: int) -> Array:
    """Relative power spectra (size // 2 + 1, channels): means over segments that overlap by half,
    windowed after Hann (P. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70)."""
    pieces = np.lib.stride_tricks.sliding_window_view(values, size, axis=0)[:: size // 2]
    pieces = (pieces - pieces.mean(axis=-1, keepdims=True)) * np.hanning(size + 1)[:-1]
    return np.asarray((np.abs(np.fft.rfft(pieces)) ** 2).mean(axis=0).T)


def _harmonic(line_hz: float, driven_hz: float, step_hz: float, rate_hz: float) -> bool:
    """Is a line a multiple of the strongest one, which is known to half a `step_hz`?

    No line is a multiple of itself, though sampling may fold one of its multiples onto it.
    """
    if driven_hz < SLOW_HZ or abs(driven_hz - line_hz) <= step_hz:
        return False
    return any(
        abs(folded(n * driven_hz, rate_hz) - line_hz) <= (1 + n / 2) * step_hz
        for n in range(2, MULTIPLES + 1)
    )


def _mounts(
    recording: Recording, values: Array, good: list[int], span: tuple[float, float]
) -> Iterator[Finding]:
    points = [channel.point or channel.name for channel in recording.channels]
    size = round(SEGMENT_S * recording.rate_hz)
    grid, power = np.fft.rfftfreq(size, 1.0 / recording.rate_hz), relative_power(values, size)
    high = (grid >= MOUNT_HZ) & (grid <= 0.45 * recording.rate_hz)
    for kind in "AB":
        group = [
            i for i, point in enumerate(points) if point in {f"{kind}{n}" for n in range(1, 5)}
        ]
        if len(group) < 3 or not set(group) <= set(good):  # a dead one is nobody's like
            continue
        for c in group:
            rest = np.max(power[:, [i for i in group if i != c]], axis=1)
            if not (rest.any() and power[:, c].any()):  # at rest to the last code
                continue
            ratio = power[:, c] / np.maximum(rest, 1e-12 * rest.max())
            usual = float(np.median(ratio[high]))
            peak = int(np.flatnonzero(high)[np.argmax((ratio * power[:, c])[high])])
            bell = power[max(peak - 2, 0) : peak + 3, c].sum() / power[1:, c].sum()
            expected = MOUNT * max(usual, 1.0)
            if ratio[peak] > expected and bell > MOUNT_SHARE:
                yield Finding(
                    "mount", (recording.channels[c].name,),
                    f"shakes {np.sqrt(ratio[peak]):.0f} times as much as any of its like at"
                    f" {grid[peak]:.0f} Hz", POSSIBLE, ratio[peak] / expected, *span,
                    "tighten the mount; if it is tight: hum, or a resonance of the vehicle",
                )  # fmt: skip
