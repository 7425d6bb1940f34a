"""What the sensors put out: ADC codes at eight inputs as functions of time."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

CHANNELS = 8
SELF_TEST = 43.0
"""Codes by which an ADXL326's self-test shifts its Z output: 105 mV at 3 V of supply (data sheet),
and as the cube of the supply; 140 mV of 3.3 V, which are code 1024."""
CODES = 1024  # of a 10-bit converter; its reference voltage is code 1024


@dataclass(frozen=True)
class Signals:
    """A table of ADC codes, straight lines between its rows.

    `codes` has the shape (rows, 8) and is not rounded: the converter gives the next lower integer,
    limited to 0 … 1023. Row i holds at i / `rate_hz` seconds of board time. Before the first and
    after the last row the inputs stand still, unless `repeat`: then the first row follows
    1 / `rate_hz` after the last.
    """

    codes: NDArray[np.float64]
    rate_hz: float = 1.0
    repeat: bool = False

    def __post_init__(self) -> None:
        if self.codes.ndim != 2 or self.codes.shape[1] != CHANNELS or len(self.codes) == 0:
            raise ValueError(f"signals: shape {self.codes.shape}, expected (rows, {CHANNELS})")
        if not (np.isfinite(self.codes).all() and self.rate_hz > 0):
            raise ValueError("signals: codes must be finite and the rate positive")


def constant(codes: ArrayLike) -> Signals:
    """Inputs at rest: one code for all, or one for each of the eight."""
    return Signals(_per_channel(codes)[None, :])


def ramp(start: ArrayLike, per_second: ArrayLike, seconds: float = 60.0) -> Signals:
    """Codes that grow at a constant rate for `seconds` and then stand still."""
    first = _per_channel(start)
    return Signals(
        np.stack([first, first + seconds * _per_channel(per_second)]), rate_hz=1 / seconds
    )


def sines(
    frequency_hz: ArrayLike,
    amplitude: ArrayLike = 200.0,
    mean: ArrayLike = 512.0,
    phase_rad: ArrayLike = 0.0,
    *,
    seconds: float = 10.0,
    rate_hz: float = 6400.0,
) -> Signals:
    """`mean` + `amplitude` sin(2π `frequency_hz` t + `phase_rad`), each for all inputs or for each.

    The straight lines between the rows are off by at most amplitude·(π f / rate)²/2.
    """
    time_s = np.arange(round(seconds * rate_hz) + 1)[:, None] / rate_hz
    angle = 2 * np.pi * _per_channel(frequency_hz) * time_s + _per_channel(phase_rad)
    return Signals(_per_channel(mean) + _per_channel(amplitude) * np.sin(angle), rate_hz)


def from_array(codes: ArrayLike, rate_hz: float, *, repeat: bool = False) -> Signals:
    """Rows of eight codes, `rate_hz` of them in a second."""
    return Signals(np.array(codes, dtype=np.float64), rate_hz, repeat)


def from_volts(
    volts: ArrayLike,
    rate_hz: float,
    *,
    reference_volts: float = 3.3,
    repeat: bool = False,
) -> Signals:
    """Rows of eight voltages, against the voltage at the AREF pin."""
    codes = np.array(volts, dtype=np.float64) / reference_volts * CODES
    return Signals(codes, rate_hz, repeat)


def _per_channel(values: ArrayLike) -> NDArray[np.float64]:
    """One value for all channels, or one for each, as an array of shape (8,)."""
    try:
        return np.broadcast_to(np.asarray(values, dtype=np.float64), (CHANNELS,))
    except ValueError:
        raise ValueError(f"signals: give one value or {CHANNELS}, not {values!r}") from None
