"""Moving channels in time by a fraction of a sample: the cure for channels sampled in turn."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.error import CalibrationError
from wheelhop.logger.recording import Recording

HALF = 24
"""Rows on either side that make one; this close to a gap the result is less exact."""
KAISER = 8.0

Array = NDArray[np.float64]


def align(recording: Recording, skew_s: Mapping[str, float]) -> Recording:
    """Return the recording as if all channels had been sampled at its rows' instants.

    `skew_s` says by name how much later than that a channel was sampled; others stay as they are.
    A band-limited interpolation (windowed sinc) up to about 0.9 of half the rate; gaps stay gaps,
    and no sample is made of rows across one. Raises CalibrationError for a channel that is not
    there, or a skew of more than `HALF` / 2 rows.
    """
    names = [channel.name for channel in recording.channels]
    for name, skew in skew_s.items():
        if name not in names:
            raise CalibrationError(f"there is no channel {name}, only {', '.join(names)}")
        if not abs(skew) * recording.rate_hz <= HALF / 2:
            raise CalibrationError(
                f"channel {name} is {skew:g} s off: more than {HALF / 2:g} samples are no skew,"
                " look for another reason"
            )
    values = recording.values.copy()
    moved = {name: skew for name, skew in skew_s.items() if skew != 0.0}
    for start, stop in stretches(~recording.missing):
        for name, skew in moved.items():
            column = names.index(name)
            values[start:stop, column] = delayed(
                recording.values[start:stop, column], skew * recording.rate_hz
            )
    steps = ", ".join(f"{name} by {skew * 1e3:+.4f} ms" for name, skew in moved.items())
    return (
        recording.after(f"channels moved in time: {steps}", values=values) if moved else recording
    )


def delayed(samples: Array, by: float) -> Array:
    """`samples` (n,) later by `by` samples, a fraction as a rule; its ends are point-mirrored.

    Windowed sinc: T. Laakso et al., Splitting the unit delay, IEEE Signal Processing Magazine
    13(1), 1996.
    """
    reach = min(HALF, len(samples) - 1)
    if reach < 1:
        return samples.copy()
    offset = np.arange(-HALF, HALF + 1) - by
    kernel = np.sinc(offset) * np.i0(
        KAISER * np.sqrt(np.clip(1 - (offset / (HALF + 1)) ** 2, 0.0, 1.0))
    )
    padded = np.pad(samples, reach, mode="reflect", reflect_type="odd")
    padded = np.pad(padded, HALF - reach, mode="edge")
    return np.convolve(padded, kernel / kernel.sum(), mode="valid")


def stretches(present: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Start and stop of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], present, [False]])))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]
