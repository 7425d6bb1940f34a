"""Blocks that contradict each other: a CRC of 16 bits lets one forgery in 65536 pass.

In every block first_scan = (scans in all data blocks before) + lost, so first_scan − lost counts
the scans that were written before it: exactly those of the blocks before, plus what the blocks
between that are not good have held, at most their capacity. `lost` and `late` only grow. Counts of
scans are modulo 2³²: one that falls by more than half a round has begun the next.
"""

import numpy as np
from numpy.typing import NDArray

from wheelhop.logger.block import DATA

PIECE = 1 << 16
ROUND = 1 << 32  # of scan numbers
JURY = 8  # blocks ahead that say which of two that contradict each other is false
BLOCK, WRITTEN, LOST, LATE, COUNT = range(5)  # columns below; WRITTEN is before the block


def agreeing(facts: NDArray[np.void], capacity: int) -> NDArray[np.bool_]:
    """Return which of the (n,) good blocks, in file order, agree with those around them.

    `capacity` is the most scans a block holds. The first one is measured by the start of the
    session, at which nothing was written and nothing lost.
    """
    count = facts["count"]
    is_data = facts["kind"] == DATA[0]
    sane: NDArray[np.bool_] = np.where(is_data, (count >= 1) & (count <= capacity), count == 0)
    kept = facts if sane.all() else facts[sane]
    follows = np.empty(len(kept), bool)
    before = np.zeros((1, 5), np.int64)
    for begin in range(0, len(kept), PIECE):  # a long log has millions of blocks
        line = np.concatenate([before, _rows(kept[begin : begin + PIECE])])
        follows[begin : begin + PIECE] = _follow(line[:-1], line[1:], capacity)
        before = line[-1:]
    if not follows.all():
        line = np.concatenate([np.zeros((1, 5), np.int64), _rows(kept)])
        sane[sane] = _outvote(line, follows, capacity)[1:]
    return sane


def unrolled(numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return counts of scans (n,), given modulo 2³² in file order, without the jumps back."""
    return numbers + ROUND * np.cumsum(np.diff(numbers, prepend=numbers[:1]) < 0)


def _nearest(difference: NDArray[np.int64]) -> NDArray[np.int64]:
    """Differences modulo 2³², the nearer way round."""
    return (difference + ROUND // 2) % ROUND - ROUND // 2


def _rows(facts: NDArray[np.void]) -> NDArray[np.int64]:
    written = facts["first_scan"] - facts["lost"]
    return np.column_stack(
        [facts["block"], written, facts["lost"], facts["late"], facts["count"]]
    ).astype(np.int64)


def _follow(
    before: NDArray[np.int64], after: NDArray[np.int64], capacity: int
) -> NDArray[np.bool_]:
    """Whether blocks can stand behind others."""
    room = np.maximum(after[..., BLOCK] - before[..., BLOCK] - 1, 0) * capacity
    more = _nearest(after[..., WRITTEN] - before[..., WRITTEN] - before[..., COUNT])
    more_lost = after[..., LOST] - before[..., LOST]
    grown = ((more_lost >= 0) | (_nearest(more_lost) >= 0)) & (
        after[..., LATE] >= before[..., LATE]
    )
    fits: NDArray[np.bool_] = grown & (more >= 0) & (more <= room)
    return fits


def _outvote(
    line: NDArray[np.int64], follows: NDArray[np.bool_], capacity: int
) -> NDArray[np.bool_]:
    """Walk along the line; where two contradict each other, drop one and go on with the other."""
    keep = np.ones(len(line), bool)
    before = np.arange(len(line)) - 1  # of each block, the one that it was found to follow
    breaks = np.append(np.flatnonzero(~follows) + 1, len(line))
    trusted, i = 0, 1
    while i < len(line):
        if trusted == i - 1 and follows[trusted]:
            i = int(breaks[np.searchsorted(breaks, i)])
            trusted = i - 1
            continue
        if _follow(line[trusted], line[i], capacity):
            before[i] = trusted
            trusted = i
        elif trusted > 0 and _is_better(line, i, trusted, before[trusted], capacity):
            keep[trusted] = False
            trusted = int(before[trusted])
            continue
        else:
            keep[i] = False
        i += 1
    return keep


def _is_better(line: NDArray[np.int64], i: int, trusted: int, before: int, capacity: int) -> bool:
    """Whether block i is right rather than the trusted one; both together cannot be."""
    if not _follow(line[before], line[i], capacity):
        return False
    jury = line[i + 1 : i + 1 + JURY]
    ours, theirs = (int(_follow(line[k], jury, capacity).sum()) for k in (i, trusted))
    # Undecided: the smaller loss is the smaller claim.
    return (ours, -int(line[i, LOST])) > (theirs, -int(line[trusted, LOST]))
