"""Two recorders, two clocks: where the logger's time lies on the reference's.

    t_reference = (1 + drift) · t_logger + offset

Found roughly here, from what both have recorded of the same motion; `chain.py` then estimates it
together with the gains, from the phases.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from wheelhop.calibration.error import CalibrationError
from wheelhop.logger.recording import Recording

Array = NDArray[np.float64]

FRAME_S, HOP_S = 1.0, 0.1
PIECE_S = 4.0
LARGEST_DRIFT = 0.006  # a ceramic resonator is within 0.5 %


@dataclass(frozen=True)
class Clock:
    """`offset_s` and `drift` as defined above."""

    offset_s: float
    drift: float = 0.0

    def on_reference(self, logger_s: Array) -> Array:
        """The logger's times on the reference's clock."""
        return np.asarray((1 + self.drift) * logger_s + self.offset_s)

    def on_logger(self, reference_s: Array) -> Array:
        """The reference's times on the logger's clock."""
        return np.asarray((reference_s - self.offset_s) / (1 + self.drift))


def window_mean(time_s: Array, values: Array, centres_s: Array, width_s: float) -> Array:
    """Means of (n,) uniform samples over windows of `width_s` about `centres_s`; 0 outside them."""
    from scipy.interpolate import CubicSpline  # takes long to import

    # Steps instead of a spline would take sinc(f/rate) off a reference sampled at a few hundred Hz.
    integral = CubicSpline(time_s, np.nan_to_num(values - np.nanmean(values))).antiderivative()
    ends = (np.clip(centres_s + side * width_s / 2, *time_s[[0, -1]]) for side in (1, -1))
    upper, lower = (integral(end) for end in ends)
    return np.asarray((upper - lower) / width_s)


def rough_clock(reference: Recording, log: Recording, column: int) -> Clock:
    """Offset to about 0.3 s, whatever the drift: where the two spectrograms match best.

    Raises CalibrationError if they never do.
    """
    rate = log.rate_hz
    start, end = reference.time_s[[0, -1]]
    times = np.arange(start, end, 1 / rate)
    theirs = _frames(window_mean(reference.time_s, reference.values[:, 0], times, 1 / rate), rate)
    values = log.values[:, column]
    ours = _frames(np.nan_to_num(values - np.nanmean(values)), rate)
    match = signal.fftconvolve(theirs, ours[:, ::-1], axes=1).sum(axis=0)
    best = int(np.argmax(match))
    share = match[best] / np.sqrt((theirs**2).sum() * (ours**2).sum())
    if not share > 0.2:
        raise CalibrationError(
            f"channel {log.channels[column].name}: the two recordings show no common motion: are"
            " they of the same session, and is this sensor on the table?"
        )
    hop = max(1, round(HOP_S * rate)) / rate
    return Clock(float(start - log.start_s + (best - ours.shape[1] + 1) * hop))


def whole_clock(reference: Recording, log: Recording, column: int, clock: Clock) -> Clock:
    """The offset from all of both recordings, once the drift is known.

    Steady sines match again a period later, but then their beginnings and ends do not.
    """
    reach_s = 1.0
    size = len(log.values) - 2 * int(np.ceil(reach_s * log.rate_hz))
    _, lags, _ = _lags(reference, log, column, clock, reach_s, size, either_sign=True)
    return Clock(clock.offset_s + (float(lags[0]) if len(lags) else 0.0), clock.drift)


def swept_clock(reference: Recording, log: Recording, column: int, clock: Clock) -> Clock:
    """Offset and drift from lags of pieces of the recording, for motion that is never steady.

    The pieces are seconds long, and their lags are fitted by a straight line that few wrong ones
    cannot turn (Theil-Sen). Tried with both polarities of the sensor; the better match counts.
    """
    turned = replace(log, values=-log.values)
    tried = [_one_sided_clock(reference, one, column, clock) for one in (log, turned)]
    return max(tried, key=lambda found: found[0])[1]


def _one_sided_clock(
    reference: Recording, log: Recording, column: int, clock: Clock
) -> tuple[float, Clock]:
    """The match, its median correlation over the pieces, and the clock."""
    reach, match = 1.0, 0.0
    size = round(PIECE_S * log.rate_hz)
    for _ in range(4):
        centres, lags, weights = _lags(reference, log, column, clock, reach, size)
        good = weights > 0.7 if (weights > 0.7).sum() >= 4 else weights > 0.3
        if good.sum() < 4:
            raise CalibrationError(
                f"channel {log.channels[column].name}: too little common motion to compare the"
                " clocks by: hold each of three or more frequencies for 6 s, or sweep slowly"
            )
        slope, middle = _line(lags[good], centres[good])
        slope = float(np.clip(slope, -LARGEST_DRIFT, LARGEST_DRIFT))
        clock = Clock(clock.offset_s + middle, clock.drift + slope)
        reach, match = max(0.05, reach / 4), float(np.median(weights))
    return match, clock


def _line(lags: Array, centres: Array) -> tuple[float, float]:
    from scipy.stats import theilslopes

    slope, middle, _, _ = theilslopes(lags, centres)
    return float(slope), float(middle)


def _lags(
    reference: Recording,
    log: Recording,
    column: int,
    clock: Clock,
    reach_s: float,
    size: int,
    either_sign: bool = False,
) -> tuple[Array, Array, Array]:
    """Centre (logger's time), lag and correlation of each piece of `size` rows.

    With `either_sign` a sensor on its head is matched, too.
    """
    time_s, rate = log.time_s, log.rate_hz
    theirs = window_mean(
        reference.time_s, reference.values[:, 0], clock.on_reference(time_s), 1 / rate
    )
    values = log.values[:, column]
    ours = np.nan_to_num(values - np.nanmean(values))
    edge = int(np.ceil(reach_s * rate))
    found = []
    for first in range(edge, len(ours) - size - edge + 1, size):
        piece = signal.detrend(ours[first : first + size]) * np.hanning(size)
        around = signal.detrend(theirs[first - edge : first + size + edge])
        match = signal.correlate(around, piece, mode="valid")
        energy = signal.correlate(around**2, np.hanning(size) ** 2, mode="valid")
        score = match / np.sqrt(np.maximum(energy * (piece @ piece), 1e-30))
        best = int(np.argmax(np.abs(score) if either_sign else score))
        if 0 < best < len(score) - 1:
            left, top, right = score[best - 1 : best + 2]
            part = (left - right) / (2 * (left - 2 * top + right))
            lag = (best + part - edge) / rate
            found.append((time_s[first + size // 2], lag, top))
    return tuple(np.array(found).reshape(-1, 3).T)  # type: ignore[return-value]


def _frames(values: Array, rate_hz: float) -> Array:
    """Spectrogram (frequencies, frames), its square root, each line without its mean."""
    size, hop = round(FRAME_S * rate_hz), max(1, round(HOP_S * rate_hz))
    padded = np.pad(values, (0, max(0, size - len(values))))
    frames = np.lib.stride_tricks.sliding_window_view(padded, size)[::hop]
    level = np.sqrt(np.abs(np.fft.rfft(frames * np.hanning(size), axis=1))).T
    return np.asarray(level - level.mean(axis=1, keepdims=True))
