"""The filters between the motion and the two records, all known but one: the sensor's corner."""

import numpy as np
from numpy.typing import NDArray

from wheelhop.logger.correct import window_response
from wheelhop.logger.error import LoggerError
from wheelhop.logger.recording import CODE, Recording
from wheelhop.logger.settings import CONVERSION_S, parse_settings

Complex = NDArray[np.complex128]
Array = NDArray[np.float64]

INPUTS = 8


def one_pole(frequency_hz: Array, time_constant_s: float) -> Complex:
    """Low-pass 1 / (1 + i ω T), which a resistor and a capacitor make."""
    return np.asarray(1 / (1 + 2j * np.pi * frequency_hz * time_constant_s))


def high_pass(frequency_hz: Array, corner_hz: float) -> Complex:
    """First-order high-pass i f / (i f + f₀) of a charge amplifier; 1 for f₀ = 0."""
    return np.asarray(1j * frequency_hz / (1j * frequency_hz + corner_hz))


def averaging(recording: Recording, column: int, frequency_hz: Array) -> Array:
    """Gain of a recorder's averaging, about the instant that its rows are stamped with.

    For the logger's codes exactly as `window_response` has it, else sin(π f w) / (π f w) of a
    window of w seconds; 1 where it has been undone.
    """
    if recording.averaging_s == 0 or recording.channels[column].unit != CODE:
        return np.asarray(np.sinc(frequency_hz * recording.averaging_s))
    number, conversions = converted(recording, column)
    return window_response(frequency_hz, conversions, number).real


def converted(recording: Recording, column: int) -> tuple[int, int]:
    """Number of the input that a channel of codes comes from, and of its conversions in a sum.

    Raises LoggerError if the recording's notes lack the header's keys or contradict it.
    """
    settings = parse_settings(recording.notes, "calibration")
    numbers = {name: number for number, name in settings.inputs}
    name = recording.channels[column].name
    if name not in numbers:
        raise LoggerError(f"channel {name} is not among the log header's: {', '.join(numbers)}")
    return numbers[name], settings.conversions


def conversion_instants_s(number: int, conversions: int) -> Array:
    """(conversions,) when input A`number` is converted, about the mean instant of the scan.

    The order is 0 … 7, 7 … 0, so each round of 16 conversions has the input twice.
    """
    rounds = 2 * INPUTS * np.arange(conversions // 2)
    steps = np.sort(np.concatenate([rounds + number, rounds + 2 * INPUTS - 1 - number]))
    return np.asarray((steps - steps.mean()) * CONVERSION_S)
