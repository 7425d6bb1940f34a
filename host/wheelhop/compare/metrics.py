"""The field's figures of agreement, one channel of one run at a time, in band."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from wheelhop.compare.rating import Rating, iso18571
from wheelhop.compare.records import Record
from wheelhop.compare.thirds import third_octave_of, third_octaves
from wheelhop.compare.windows import hann

Array = NDArray[np.float64]

ZERO_PADDING = 8  # a peak's parabola is fitted to a spectrum this much finer than the record's


@dataclass(frozen=True)
class Peak:
    """The largest peak of an amplitude spectrum (Hann window).

    ``height`` is the zero-to-peak amplitude, in the channel's unit, of the sine that would cause
    it and ``width_hz`` its width at half power. A steady sine is not narrower than the window,
    1.44 over the record's duration.
    """

    frequency_hz: float
    height: float
    width_hz: float


@dataclass(frozen=True)
class ChannelFigures:
    """How one channel of one run compares with the model.

    ``error`` is E, the root of Σr²/Σy²; ``nrmse`` the rms residual over the range
    (maximum - minimum) of the measurement; ``coherence`` the magnitude-squared coherence of
    measurement and model (Welch, eight half-overlapping Hann segments or so), averaged over
    the band with the measured power spectrum as weight: the fraction of the measured power
    that is linear in the model's signal. ``psd_ratio`` maps each third-octave to the model's
    power over the measured; ``floor`` is the E the noise alone would leave.
    """

    run_id: str
    channel: str
    error: float
    floor: float
    nrmse: float
    coherence: float
    measured_peak: Peak
    model_peak: Peak
    psd_ratio: dict[str, float]
    rating: Rating


def channel_figures(
    records: Sequence[Record], channels: Sequence[str], noise_rms: Array
) -> tuple[ChannelFigures, ...]:
    """Figures of every predicted channel of every record, in that order.

    ``noise_rms`` (n_channels,) is the noise of each channel in band, as the records hold it.
    """
    out = []
    signals = [(r.signal(r.measured), r.signal(r.model)) for r in records]
    for record, (measured, model), rating in zip(records, signals, _ratings(signals), strict=True):
        n, rate = record.band.n, record.band.rate_hz
        coherence = _coherence(measured, model, record)
        noise = record.noise_scale * np.sqrt(np.sum(record.noise_power(noise_rms**2), axis=0) / n)
        for c in np.flatnonzero(record.predicted):
            y = measured[:, c]
            energy = float(np.sum(y**2))
            rms = float(np.sqrt(np.mean((y - model[:, c]) ** 2)))
            out.append(
                ChannelFigures(
                    record.run.id,
                    channels[int(c)],
                    error=_ratio(rms, np.sqrt(energy / n)),
                    floor=_ratio(noise[c], np.sqrt(energy / n)),
                    nrmse=_ratio(rms, np.ptp(y)),
                    coherence=float(coherence[c]),
                    measured_peak=spectral_peak(y, rate),
                    model_peak=spectral_peak(model[:, c], rate),
                    psd_ratio=psd_ratio(record, int(c)),
                    rating=rating[c],
                )
            )
    return tuple(out)


def spectral_peak(x: Array, rate_hz: float) -> Peak:
    """Largest peak of a band-passed signal ``x`` (n,), interpolated.

    Frequency and height come from the parabola through the logarithms of the three values
    around the maximum of the zero-padded spectrum, the half-power points from straight lines.
    """
    window = hann(len(x))
    size = fft.next_fast_len(ZERO_PADDING * len(x), real=True)
    amplitude = np.abs(fft.rfft(x * window, size)) * 2.0 / window.sum()
    top = int(np.argmax(amplitude))
    if amplitude[top] <= 0.0 or not 0 < top < len(amplitude) - 1:
        return Peak(float("nan"), float("nan"), float("nan"))
    a, b, c = np.log(np.maximum(amplitude[top - 1 : top + 2], 1e-300))
    offset = 0.5 * (a - c) / (a - 2.0 * b + c)
    height = float(np.exp(b - 0.25 * (a - c) * offset))
    power, half, step = amplitude**2, 0.5 * height**2, rate_hz / size

    def crossing(direction: int) -> float:
        side = power[top::direction]
        below = np.flatnonzero(side < half)
        if not len(below):
            return float("nan")
        k = int(below[0])
        return float(k - 1 + (side[k - 1] - half) / (side[k - 1] - side[k]))

    width = (crossing(1) + crossing(-1)) * step
    return Peak((top + float(offset)) * step, height, width)


def psd_ratio(record: Record, channel: int) -> dict[str, float]:
    """Model's power over the measured power in each third-octave; NaN where none is measured."""
    frequency = record.band.frequency_hz
    number = np.tile(third_octave_of(frequency), 2)
    bands = third_octaves((float(frequency[0]), float(frequency[-1])))
    measured, model = record.measured[:, channel] ** 2, record.model[:, channel] ** 2
    return {
        band.name: _ratio(model[number == band.x].sum(), measured[number == band.x].sum())
        for band in bands
        if (number == band.x).any()
    }


def _coherence(measured: Array, model: Array, record: Record) -> Array:
    """Power-weighted mean coherence of each column (n_channels,)."""
    from scipy.signal import csd, welch  # takes long to import

    segment = max(8, 2 * record.band.n // 9)  # eight segments that overlap by half
    low, high = record.band.frequency_hz[[0, -1]]
    settings = {"fs": record.band.rate_hz, "nperseg": segment, "axis": 0}
    frequency, power = welch(measured, **settings)
    other = welch(model, **settings)[1]
    cross = np.abs(csd(measured, model, **settings)[1]) ** 2
    inside = (frequency >= low) & (frequency <= high)
    with np.errstate(divide="ignore", invalid="ignore"):
        linear = np.nan_to_num(cross / other)  # γ² times the measured power
        return np.asarray(linear[inside].sum(axis=0) / power[inside].sum(axis=0))


def _ratings(signals: Sequence[tuple[Array, Array]]) -> list[list[Rating]]:
    """ISO/TS 18571 rating of every channel; records of one length are rated together, faster."""
    out: list[list[Rating]] = [[]] * len(signals)
    for n in {len(measured) for measured, _ in signals}:
        group = [i for i, (measured, _) in enumerate(signals) if len(measured) == n]
        rated = iso18571(*(np.hstack([signals[i][side] for i in group]) for side in (0, 1)))
        width = len(rated) // len(group)
        for k, i in enumerate(group):
            out[i] = rated[k * width : (k + 1) * width]
    return out


def _ratio(a: float, b: float) -> float:
    return float(a / b) if b > 0.0 else float("nan")
