"""Late triggers: samples that do not lie at equal steps, brought to equal steps."""

import math
from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from wheelhop.logger.correct import TAPS, Response, filtered, inverse_taps, runs


def at_equal_steps(values: NDArray[np.float64], shift: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return what rows 0, 1, 2, … would have been of samples that were taken at i + `shift`[i].

    `values` (n, channels); `shift` (n,), in steps, begins with 0 and never falls. A fraction of a
    step is a delay: a filter in band, as in `correct`. A gap stays a gap, and where half a step or
    more is skipped at once there is one; such rows are NaN.
    """
    rows = math.floor(len(values) - 1 + shift[-1]) + 1
    moved = np.full((rows, values.shape[1]), np.nan)
    for run in runs(np.asarray(~np.isnan(values).any(axis=1))):
        for begin, first, stop in _pieces(shift, *run):
            whole = round(shift[begin])
            response: Response = partial(_ahead, steps=shift[begin] - whole)
            taps = inverse_taps(response, 1.0)
            # Neighbours beyond the piece are out of place by no more than the next shift.
            low, high = max(first - whole - TAPS, run[0]), min(stop - whole + TAPS, run[1])
            delayed = filtered(values[low:high], taps)
            moved[first:stop] = delayed[first - whole - low : stop - whole - low]
    return moved


def _pieces(shift: NDArray[np.float64], begin: int, end: int) -> Iterator[tuple[int, int, int]]:
    """Of a run, stretches of one shift: where they begin, first row and the row behind the last."""
    begins = [begin, *(np.flatnonzero(np.diff(shift[begin:end])) + begin + 1).tolist()]
    for k, at in enumerate(begins):
        first, last = math.ceil(at + shift[at]), end - 1
        if k + 1 < len(begins):
            last = begins[k + 1] - 1
            if shift[last + 1] - shift[at] < 0.5:
                yield at, first, math.ceil(last + 1 + shift[last + 1])
                continue
        yield at, first, math.floor(last + shift[at]) + 1


def _ahead(frequency: NDArray[np.float64], steps: float) -> NDArray[np.complex128]:
    """A signal that is `steps` ahead; what undoes it is a delay."""
    return np.asarray(np.exp(2j * np.pi * frequency * steps))
