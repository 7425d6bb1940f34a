"""Swept sines: the response from cross-spectra, and how much of it to believe.

Bendat and Piersol, Random Data, 4th ed.: H₁ = S_rl / S_rr, coherence γ² = |S_rl|² / (S_rr S_ll),
relative standard uncertainty √((1 − γ²) / (2 γ² n)) of magnitude and phase over n averages.
"""

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.error import CalibrationError
from wheelhop.calibration.shaker.align import Clock, window_mean
from wheelhop.calibration.shaker.points import Points
from wheelhop.calibration.shaker.response import averaging
from wheelhop.logger.recording import Recording

Array = NDArray[np.float64]

SEGMENT_S = 12.0
BANDS_PER_OCTAVE = 6
LOWEST_HZ, HIGHEST_HZ = 0.2, 55.0
FEWEST_LINES = 3
NO_ROUNDING = np.zeros(1, dtype=complex)


def swept_points(reference: Recording, log: Recording, column: int, clock: Clock) -> Points:
    """The response of one channel in bands of a sixth of an octave (wider at low frequencies).

    Averages run over the lines of a band and over segments of 12 s that overlap by half; how many
    of them count is told by how the power is spread over them. Bands above those through which the
    sweep went are left out: what is there are harmonics and hum.
    """
    rate, time_s = log.rate_hz, log.time_s
    aligned = clock.on_reference(time_s)
    covered = (aligned > reference.time_s[0]) & (aligned < reference.time_s[-1])
    theirs = window_mean(reference.time_s, reference.values[:, 0], aligned, 1 / rate)
    values = log.values[:, column]
    middle, both = _segments(time_s, covered, theirs, values - np.nanmean(values), rate)
    size = round(SEGMENT_S * rate)
    frequency = np.arange(size // 2 + 1) * rate / size
    r, el = both  # (segments, lines)
    power, cross, ours = np.abs(r) ** 2, np.conj(r) * el, np.abs(el) ** 2
    strength = 4 * power.sum(axis=1) / (0.375 * size**2)  # 2 × mean square, Hann
    rows = []
    for lines in _swept(frequency, power, min(HIGHEST_HZ, 0.48 * rate)):
        p, total = power[:, lines], float(power[:, lines].sum())
        ratio = complex(cross[:, lines].sum() / total)
        coherence = float(np.abs(ratio) ** 2 * total / ours[:, lines].sum())
        averages = max(1.0, total**2 / float((p**2).sum()) / 3)  # overlap, and Hann's width
        centre = float((p * frequency[lines]).sum() / total)
        scale = 2 / (size * 0.375 * rate)  # Hann, one-sided density
        leftover = float((ours[:, lines].mean() * (1 - coherence)) * scale)
        rows.append(
            (
                *(centre / (1 + clock.drift), float((p.sum(axis=1) * middle).sum() / total)),
                *(float(np.sqrt(p.sum(axis=1) @ strength / total)), ratio),
                float(np.sqrt(max(1 - coherence, 1e-9) / (2 * max(coherence, 1e-9) * averages))),
                # Rounding is noise here, since frequency and phase never rest.
                *(NO_ROUNDING, float(np.nanmean(values)), float(np.sqrt(leftover * rate / 2))),
                *(coherence, 0.0),
            )
        )
    points = Points.of(rows)
    on_logger = points.frequency_hz * (1 + clock.drift)
    window = averaging(log, column, on_logger)
    # The reference was averaged as well, over one period of the logger's rate by its own clock.
    return points.corrected(window / np.sinc(on_logger / rate))


def _swept(frequency: Array, power: Array, highest_hz: float) -> list[slice]:
    """The bands up to the highest that, where it is strongest, has the largest velocity of all."""
    bands = _bands(frequency, highest_hz)
    velocity = np.where(frequency < LOWEST_HZ, 0, power / np.maximum(frequency, LOWEST_HZ) ** 2)
    top = -1
    for number, lines in enumerate(bands):
        moment = int(power[:, lines].sum(axis=1).argmax())
        dominant = frequency[velocity[moment].argmax()]
        if frequency[lines][0] / 1.1 <= dominant <= frequency[lines][-1] * 1.1:
            top = number
    return bands[: top + 1]


def _bands(frequency: Array, highest_hz: float) -> list[slice]:
    """The lines of each band."""
    edges = LOWEST_HZ * 2 ** (np.arange(1, 60) / BANDS_PER_OCTAVE)
    first, bands = int(np.searchsorted(frequency, LOWEST_HZ)), []
    for edge in edges[edges < highest_hz * 2 ** (1 / BANDS_PER_OCTAVE)]:
        last = int(np.searchsorted(frequency, edge))
        if last - first >= FEWEST_LINES:
            bands.append(slice(first, last))
            first = last
    return bands


def _segments(
    time_s: Array, covered: NDArray[np.bool_], theirs: Array, ours: Array, rate_hz: float
) -> tuple[Array, NDArray[np.complex128]]:
    """Middle times (segments,) and spectra (2, segments, lines) of the segments without gaps."""
    size = round(SEGMENT_S * rate_hz)
    window = np.hanning(size)
    middles, spectra = [], []
    for first in range(0, len(ours) - size + 1, size // 2):
        part = slice(first, first + size)
        if covered[part].all() and not np.isnan(ours[part]).any():
            middles.append(time_s[part].mean())
            pair = np.stack([theirs[part], ours[part]])
            pair -= pair.mean(axis=1, keepdims=True)
            spectra.append(np.fft.rfft(pair * window, axis=1))
    if not spectra:
        raise CalibrationError(
            f"the recordings have no {SEGMENT_S:g} s in common without a gap: sweep two minutes"
        )
    return np.array(middles), np.array(spectra).transpose(1, 0, 2)


def usable_band_hz(points: Points, least: float) -> tuple[float, float]:
    """The widest range of frequencies, in octaves, whose coherence is nowhere below `least`.

    Its ends lie midway to the next band that is worse, if there is one. (NaN, NaN): there is none.
    """
    order = np.argsort(points.frequency_hz)
    frequency, good = points.frequency_hz[order], points.coherence[order] >= least
    best, widest = (float("nan"), float("nan")), -1.0
    for first in range(len(good)):
        last = first
        while last < len(good) and good[last]:
            last += 1
        if last == first:
            continue
        low = np.sqrt(frequency[first] * frequency[first - 1]) if first else frequency[0]
        high = frequency[last - 1]
        high = np.sqrt(high * frequency[last]) if last < len(good) else high
        if np.log2(high / low) > widest:
            widest, best = float(np.log2(high / low)), (float(low), float(high))
    return best
