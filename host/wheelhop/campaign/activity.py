"""Where in a long recording the vehicle was driven: stretches between two rests."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.logger.recording import Recording

WINDOW_S = 0.5
REST_S = 2.0  # a rest is quiet for at least so long
SHORTEST_S = 5.0  # a drive shorter than this is somebody getting in
CONTRAST = 3.0  # a drive shakes at least so much more than a rest


@dataclass(frozen=True)
class Stretch:
    """Rows `first` to before `last`, and the `rms` of what the channels did there, in their unit;
    the mean of each channel is left out."""

    first: int
    last: int
    rms: float


def stretches(recording: Recording) -> tuple[Stretch, ...]:
    """Find the drives of a recording, in the order of time.

    The level of each `WINDOW_S` is compared with the geometric mean of a quiet and a loud one (5th
    and 75th percentile). Missing samples end a stretch, and one window at either end is left out:
    it may be half a rest. Where loud is not `CONTRAST` times quiet there was no rest, and the
    stretches are what lies between gaps.
    """
    level = _level(recording)
    known = level[np.isfinite(level)]
    if not len(known):
        return ()
    quiet, loud = np.percentile(known, [5, 75])
    busy = np.isfinite(level)
    if loud > CONTRAST * quiet:
        busy &= level > max(np.sqrt(quiet * loud), loud / 20)
        busy = _without_short(busy, False, REST_S, np.isfinite(level))
    window = _window(recording)
    found = []
    for first, last in _pieces(busy):
        rows = slice((first + 1) * window, (last - 1) * window)
        if (rows.stop - rows.start) / recording.rate_hz >= SHORTEST_S:
            rms = float(np.sqrt(recording.values[rows].var(axis=0).mean()))
            found.append(Stretch(rows.start, rows.stop, rms))
    return tuple(found)


def _window(recording: Recording) -> int:
    return max(round(WINDOW_S * recording.rate_hz), 2)


def _level(recording: Recording) -> NDArray[np.float64]:
    """Deviation of each whole window from its mean, over all channels; NaN with a gap in it."""
    window = _window(recording)
    count = len(recording.values) // window
    cut = recording.values[: count * window].reshape(count, window, -1)
    return np.asarray(np.sqrt(cut.var(axis=1).mean(axis=1)))


def _pieces(busy: NDArray[np.bool_]) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], busy.astype(np.int8), [0]])))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _without_short(
    busy: NDArray[np.bool_], state: bool, seconds: float, allowed: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Turn pieces of `state` that are shorter than so many seconds, and wholly `allowed`."""
    mended = busy.copy()
    for first, last in _pieces(busy == state):
        inside = first > 0 and last < len(busy)
        if inside and (last - first) * WINDOW_S < seconds and allowed[first:last].all():
            mended[first:last] = not state
    return mended
