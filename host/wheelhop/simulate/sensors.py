"""What the instrument makes of true accelerations: its faults act on the integration's own steps,
run-up included, before samples are taken."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from wheelhop.campaign import Campaign, Channel
from wheelhop.campaign.low_pass import LowPass, responses
from wheelhop.effects import Effect, Ringing
from wheelhop.effects.transfer import transferred
from wheelhop.simulate.model import Values

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

UNDONE = 0.1
"""A filter is undone where it leaves this share of a sine and more; what it took beyond is gone."""


def sensed(
    acceleration: Array,
    rate_hz: float,
    before: int,
    faults: Iterable[tuple[Effect, Values]],
    channels: Sequence[Channel],
) -> Array:
    """Readings (n, c), in the channels' units, of what truly is (n, c), so many of them before the
    record, through effects with their numbers, in their order."""
    since_s = (np.arange(len(acceleration)) - before) / rate_hz
    for effect, theta in faults:
        acceleration = effect.sense(theta, acceleration, channels, rate_hz)
        if isinstance(effect, Ringing):
            lingering = effect.lingering(theta, since_s, channels)
            acceleration = acceleration if lingering is None else acceleration + lingering
    return acceleration


def as_recorded(readings: Array, rate_hz: float, campaign: Campaign, values: Values) -> Array:
    """Readings (n, c) as they come out of the recorder's filters and of the calibration."""
    if any(filters := campaign.filters):
        readings = transferred(readings, rate_hz, partial(_response, filters))
    return miscalibrated(readings, rate_hz, campaign.channels, values)


def as_read(record: Array, rate_hz: float, campaign: Campaign, values: Values) -> Array:
    """What the sensors read, of what came out (n, c): the opposite of `as_recorded`."""
    readings = recalibrated(record, rate_hz, campaign.channels, values)
    if not any(filters := campaign.filters):
        return readings

    def inverse(frequency_hz: Array) -> ComplexArray:
        gain = _response(filters, frequency_hz)
        return np.asarray(gain.conj() / np.maximum(np.abs(gain) ** 2, UNDONE**2))

    return transferred(readings, rate_hz, inverse)


def miscalibrated(
    readings: Array, rate_hz: float, channels: Sequence[Channel], values: Values
) -> Array:
    """Readings (n, c) as they come out where gains and corners are not what the calibration says:
    "channel.B1.gain" and "channel.B1.corner" are by how much more they really are, relative."""
    if not any(f"{c.key}.gain" in values for c in channels):
        return readings
    gain, corner = _errors(channels, values)
    spectrum = fft.rfft(readings, axis=0) * _undone_wrongly(
        len(readings), rate_hz, channels, corner
    )
    return np.asarray(fft.irfft(spectrum, len(readings), axis=0) * (1.0 + gain))


def recalibrated(
    readings: Array, rate_hz: float, channels: Sequence[Channel], values: Values
) -> Array:
    """Readings (n, c) set right: the opposite of `miscalibrated`."""
    if not any(f"{c.key}.gain" in values for c in channels):
        return readings
    gain, corner = _errors(channels, values)
    spectrum = fft.rfft(readings, axis=0) / _undone_wrongly(
        len(readings), rate_hz, channels, corner
    )
    return np.asarray(fft.irfft(spectrum, len(readings), axis=0) / (1.0 + gain))


def _response(filters: tuple[LowPass | None, ...], frequency_hz: Array) -> ComplexArray:
    """Gains (f, c) of the channels' filters at the frequencies of a transform; the last few are
    kept. What all have in common stands there once (f, 1)."""
    shared = filters[:1] if len(set(filters)) == 1 else filters
    return _on_grid(shared, len(frequency_hz), float(frequency_hz[-1]))


@lru_cache(maxsize=32)
def _on_grid(filters: tuple[LowPass | None, ...], count: int, highest_hz: float) -> ComplexArray:
    return responses(filters, np.linspace(0.0, highest_hz, count))


def _errors(channels: Sequence[Channel], values: Values) -> tuple[Array, Array]:
    gain, corner = (
        np.array([values.get(f"{c.key}.{what}", 0.0) for c in channels])
        for what in ("gain", "corner")
    )
    return gain, corner


def _undone_wrongly(
    count: int, rate_hz: float, channels: Sequence[Channel], corner: Array
) -> ComplexArray:
    """Response (f, c) of low-passes of first order, undone as if their corners were as stated."""
    stated = np.array([c.corner_hz or np.inf for c in channels])
    frequency = fft.rfftfreq(count, 1.0 / rate_hz)[:, None]
    return np.asarray((1 + 1j * frequency / stated) / (1 + 1j * frequency / stated / (1 + corner)))
