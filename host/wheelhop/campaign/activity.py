"""Where in a long recording the vehicle was driven, and where in each drive it drove steadily.

A driven vehicle follows the ground, and moves by millimetres; one at rest moves by micrometres,
however loud its engine idles. What tells them apart is therefore how far the points move:
acceleration above `WINDOW_S`⁻¹ Hz, integrated twice. A steady part is one whose spectrum, in
octaves, stays the same.
"""

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.special import polygamma

from wheelhop.campaign.segments import segments
from wheelhop.logger.recording import Recording

WINDOW_S = 1.0
OCTAVES = 5  # from 1 / WINDOW_S up
REST_S = 2.0  # a rest is quiet for at least so long
SHORTEST_S = 5.0  # a drive shorter than this is somebody getting in
FINEST = 2.0**24  # of a channel's largest value: no converter resolves less
CONTRAST = 3.0  # a drive moves at least so many times as far as the quietest rest

Array = NDArray[np.float64]
Span = tuple[int, int]


@dataclass(frozen=True)
class Stretch:
    """Rows `first` to before `last`, of them the steady part, `steady_first` to before
    `steady_last`, and the `rms` of what the channels did in that, in their unit; the mean of each
    channel is left out."""

    first: int
    last: int
    steady_first: int
    steady_last: int
    rms: float


def stretches(recording: Recording) -> tuple[Stretch, ...]:
    """Find the drives of a recording, in the order of time, each with its steady part.

    How far the points move in windows of `WINDOW_S`, half overlapping, is cut into pieces where it
    changes. Rest are the pieces in which it is less than `CONTRAST` times as far as in the quietest
    one; how much of the recording is rest does not matter. A rest is no shorter than `REST_S`, a
    drive no shorter than `SHORTEST_S`; a missing sample ends either, and so do channels that all
    stand still. Where no piece moves so much more than another there was no rest, or nothing else:
    what lies between gaps is given whole. The steady part of a drive is the longest piece in which
    the levels of its octaves do not change, or all of it where that is shorter than `SHORTEST_S`.

    Two assumptions: the vehicle stood still for `REST_S` somewhere if it drove over several tracks
    (else the gentlest may be taken for rest), and no drive moves it less than `CONTRAST` times as
    far as noise does when it is integrated twice.
    """
    size = max(round(WINDOW_S * recording.rate_hz), 8)
    hop = size // 2
    octaves, moved, bins = _levels(recording, size)
    scatter = polygamma(1, bins)  # variance of the log of a noise's power in so many bins
    shortest = max(round(REST_S * recording.rate_hz / hop), 4)  # windows of a rest
    fewest = SHORTEST_S * recording.rate_hz
    known = np.isfinite(moved)
    found = []
    for first, last in _driven(moved, shortest):
        before = bool(known[:first][-1:].any())
        behind = bool(known[last:][:1].any())
        first, last = _within(first, last, before, behind)
        begin, end = first * hop, (last + 1) * hop
        if last == len(moved):
            end = len(recording.values)
        if end - begin < fewest:
            continue
        pieces = segments(octaves[first:last], scatter, shortest)
        a, b = max(pieces, key=lambda piece: piece[1] - piece[0])
        a, b = _within(first + a, first + b, a > 0, first + b < last)
        rows = slice(a * hop, end if b == last else (b + 1) * hop)
        if rows.stop - rows.start < fewest:
            rows = slice(begin, end)
        rms = float(np.sqrt(recording.values[rows].var(axis=0).mean()))
        found.append(Stretch(begin, end, rows.start, rows.stop, rms))
    return tuple(found)


def _within(first: int, last: int, before: bool, behind: bool) -> Span:
    """Without the two windows at either end that may hold some of what is beside it."""
    return first + 2 * before, last - 2 * behind


def _driven(moved: Array, shortest: int) -> list[Span]:
    """Windows between rests and gaps."""
    known = np.isfinite(moved)
    scatter = polygamma(1, np.ones(1)) / 4  # of an amplitude, not a power
    pieces = [
        (first + a, first + b)
        for first, last in _spans(known)
        for a, b in segments(moved[first:last, None], scatter, shortest)
        if b - a >= shortest
    ]
    level = np.array([np.median(moved[a + 1 : b - 1]) for a, b in pieces])
    limit = level.min(initial=np.inf) + np.log(CONTRAST)
    still = level < limit
    if still.all():
        return _spans(known)
    busy = known.copy()
    for (a, b), rests in zip(pieces, still, strict=True):
        busy[a:b] = not rests
    # A piece between a rest and a drive may hold some of both: what is still at its end is rest.
    moving = [(a, np.flatnonzero(moved[a:b] >= limit)) for a, b in _spans(busy)]
    return [(a + int(at[0]), a + int(at[-1]) + 1) for a, at in moving if len(at)]


def _levels(recording: Recording, size: int) -> tuple[Array, Array, Array]:
    """Of windows of so many rows, half overlapping: log power in octaves (n, octaves), log of how
    far the points move (n,), each the mean over the channels; and the bins of the octaves.

    NaN with a gap in the window, or where no channel changes by more than rounding: what stands so
    still is no sensor at rest, but a recorder without one. What a channel's step hides counts
    as noise of a step's width (variance step²/12), so that a channel that stands still has a level.
    """
    hop = size // 2
    taper = np.hanning(size + 1)[:-1]
    edges = 2 ** np.arange(OCTAVES + 1)
    edges = edges[edges <= size // 2]
    bins = np.arange(1, edges[-1])
    count = max((len(recording.values) - size) // hop + 1, 0)
    octaves, far = np.zeros((count, len(edges) - 1)), np.zeros(count)
    changed, heard = np.zeros(count, dtype=bool), 0
    for column in recording.values.T if count else ():
        steps = np.diff(np.unique(column[np.isfinite(column)]))
        if not len(steps):
            continue
        windows = sliding_window_view(column, size)[::hop]
        spectra = np.fft.rfft((windows - windows.mean(axis=1, keepdims=True)) * taper, axis=1)
        power = np.abs(spectra[:, bins]) ** 2 / np.sum(taper**2) + steps.min() ** 2 / 12
        octaves += np.log(np.add.reduceat(power, edges[:-1] - 1, axis=1))
        far += np.log(np.sqrt(np.sum(power / bins**4, axis=1)))
        changed |= np.ptp(windows, axis=1) > np.nanmax(np.abs(column)) / FINEST
        heard += 1
    unknown = ~changed | ~np.isfinite(far)
    octaves[unknown], far[unknown] = np.nan, np.nan
    return octaves / max(heard, 1), far / max(heard, 1), np.diff(edges).astype(np.float64)


def _spans(busy: NDArray[np.bool_]) -> list[Span]:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], busy.astype(np.int8), [0]])))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
