"""Undo what the logger's window, the sensor's filter and the clock have done to a recording.

Window and filter are undone in band: the inverse response holds up to `BAND` of the Nyquist
frequency and fades to 1 at it, since what lies there is half alias anyway. The filter has
2·`TAPS` + 1 taps and is applied to each run without gaps on its own, so a gap stays a gap. Runs are
continued by odd reflection: within some ten samples of their ends the result is as good as that
guess.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from wheelhop.logger.error import LoggerError
from wheelhop.logger.recording import Recording
from wheelhop.logger.settings import CONVERSION_S, number, parse_settings

BAND = 0.8
TAPS = 64
GRID = 4096  # frequencies over one turn at which a filter is laid out
SENSOR_HZ = 50.0  # of the ADXL326 with 0.1 µF at its output

SENSOR_STEP = "sensors' low-pass of first order"

Response = Callable[[NDArray[np.float64]], NDArray[np.complex128]]
"""Frequencies in Hz → what is left of a sine."""


def window_response(
    frequency_hz: NDArray[np.float64], conversions: int, input_number: int
) -> NDArray[np.complex128]:
    """Return (n,) what a sum of `conversions` conversions makes of a sine, about its mean instant.

    Input k is converted at the places k and 15 − k of each of the P = conversions/2 passes of 16:
    H(f) = cos(2πf·d) · sin(P·πf·16T) / (P·sin(πf·16T)), d = (15 − 2k)/2 · T, T = 156.25 µs,
    the mean of cos(2πfτ) over its instants τ (`firmware/SPEC.md`, "Scans").
    """
    passes = conversions // 2
    off = (15 - 2 * input_number) / 2 * CONVERSION_S
    centres = (np.arange(passes) - (passes - 1) / 2) * 16 * CONVERSION_S
    turns = 2 * np.pi * np.asarray(frequency_hz)
    mean: NDArray[np.float64] = np.cos(turns[:, None] * centres).mean(axis=1)
    return (np.cos(turns * off) * mean).astype(np.complex128)


def together_response(
    frequency_hz: NDArray[np.float64], conversions: int, step_s: float
) -> NDArray[np.complex128]:
    """Return (n,) what a sum of `conversions` conversions at equal steps makes of a sine.

    H(f) = sin(n·πfT) / (n·sin(πfT)), Dirichlet's kernel, about the mean instant.
    """
    turns = np.pi * np.asarray(frequency_hz)
    at = np.arange(conversions) - (conversions - 1) / 2
    mean: NDArray[np.float64] = np.cos(2 * turns[:, None] * at * step_s).mean(axis=1)
    return mean.astype(np.complex128)


def sensor_response(frequency_hz: NDArray[np.float64], corner_hz: float) -> NDArray[np.complex128]:
    """Return (n,) the response of a filter of first order, 1/(1 + jf/f₀)."""
    return np.asarray(1 / (1 + 1j * np.asarray(frequency_hz) / corner_hz))


def correct_window(recording: Recording) -> Recording:
    """Undo the averaging over a scan, for each input exactly. Raises LoggerError if it is undone,
    or if the recording does not say how it was averaged.
    """
    if not recording.averaging_s:
        raise LoggerError("these samples are no averages, or no longer: nothing to undo")
    settings = parse_settings(recording.notes, "recording")
    responses: list[Response] = [
        partial(together_response, conversions=settings.conversions, step_s=settings.step_s)
        if settings.together
        else partial(window_response, conversions=settings.conversions, input_number=k)
        for k, _ in settings.inputs
    ]
    values = _undo(recording, responses)
    band = BAND * recording.rate_hz / 2
    step = f"averaging over {recording.averaging_s * 1e3:g} ms undone up to {band:g} Hz"
    return recording.after(step, values=values, averaging_s=0.0)


def correct_sensor(
    recording: Recording, corner_hz: float | Sequence[float | None] = SENSOR_HZ
) -> Recording:
    """Undo the sensors' own low-pass of first order, by default that of 0.1 µF at an ADXL326.

    `corner_hz` is one for all channels or one for each; a channel with None stays as it is. Raises
    LoggerError if it is undone already.
    """
    if any(step.startswith(SENSOR_STEP) for step in recording.history):
        raise LoggerError("the sensors' low-pass is undone already: once is enough")
    corners: list[float | None]
    if isinstance(corner_hz, int | float):
        corners = [corner_hz] * len(recording.channels)
    else:
        corners = list(corner_hz)
    responses = [
        partial(sensor_response, corner_hz=corner) if corner else None for corner in corners
    ]
    if not any(responses):
        return recording
    values = _undo(recording, responses)
    band = BAND * recording.rate_hz / 2
    known = [f"{corner:g}" if corner else "unknown" for corner in corners]
    which = known[0] if len(set(known)) == 1 else ", ".join(known)
    step = f"{SENSOR_STEP} at {which} Hz undone up to {band:g} Hz"
    return recording.after(step, values=values)


def correct_clock(recording: Recording) -> Recording:
    """Put samples at true time, by the clock error the logger has noted: t·(1 + ppm·10⁻⁶).

    The note moves into the history. Raises LoggerError if there is none: the clock was never
    measured, or is corrected already.
    """
    if not recording.notes.get("clock_ppm"):
        raise LoggerError("no clock error is noted: never measured, or corrected already")
    ppm = number(recording.notes, "clock_ppm")
    stretch = 1 + ppm * 1e-6
    return recording.after(
        f"clock error of {ppm:g} ppm corrected",
        rate_hz=recording.rate_hz / stretch,
        start_s=recording.start_s * stretch,
        averaging_s=recording.averaging_s * stretch,
        notes=_at_true_time(recording.notes, stretch),
    )


def _at_true_time(notes: Mapping[str, str], stretch: float) -> dict[str, str]:
    """The notes without the clock's error, their marks at true time, too."""
    kept = {key: value for key, value in notes.items() if key != "clock_ppm"}
    if "marks_s" in kept:
        marks = kept["marks_s"].split()
        kept["marks_s"] = " ".join(f"{float(at_s) * stretch:.1f}" for at_s in marks)
    return kept


def _undo(recording: Recording, responses: Sequence[Response | None]) -> NDArray[np.float64]:
    values = recording.values.copy()
    whole = runs(~recording.missing)
    for column, response in enumerate(responses):
        if response is None:
            continue
        taps = inverse_taps(response, recording.rate_hz)
        for begin, end in whole:
            values[begin:end, column] = filtered(values[begin:end, column], taps)
    return values


def runs(there: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return begin and end of each stretch without a gap."""
    edges = np.flatnonzero(np.diff(there, prepend=False, append=False))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def inverse_taps(response: Response, rate_hz: float) -> NDArray[np.float64]:
    """Return the (2·TAPS + 1,) taps of 1/H in band, fading to 1 towards the Nyquist frequency."""
    frequency = np.linspace(0, rate_hz / 2, GRID // 2 + 1)
    edge, top = BAND * rate_hz / 2, rate_hz / 2
    fade = np.clip((frequency - edge) / (top - edge), 0, 1)
    weight = np.cos(np.pi / 2 * fade) ** 2
    # With H = 1 where the weight is 0, a zero of H up there does no harm.
    inverse = 1 + weight * (1 / np.where(weight > 0, response(frequency), 1) - 1)
    impulse = np.roll(np.fft.irfft(inverse, GRID), TAPS)[: 2 * TAPS + 1]
    taps: NDArray[np.float64] = impulse * np.kaiser(2 * TAPS + 1, 4.0)
    taps /= taps.sum()
    return taps


def filtered(values: NDArray[np.float64], taps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (n,) or (n, channels) values behind a filter, both ends continued by reflection."""
    from scipy.signal import oaconvolve  # takes long to import

    if len(values) == 1:
        return values
    margin = [(TAPS, TAPS), (0, 0)][: values.ndim]
    padded = np.pad(values, margin, mode="reflect", reflect_type="odd")
    column = taps.reshape(-1, *[1] * (values.ndim - 1))
    result: NDArray[np.float64] = oaconvolve(padded, column, mode="valid", axes=0)
    return result
