"""What the instrument makes of true accelerations: its faults act on the integration's own steps,
run-up included, before samples are taken."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from wheelhop.campaign import Channel
from wheelhop.effects import Effect
from wheelhop.simulate.model import Values

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


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
        lingering = effect.lingering(theta, since_s, channels)
        if lingering is not None:
            acceleration = acceleration + lingering
    return acceleration


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
