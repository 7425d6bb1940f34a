"""One drive used twice: recordings, or stretches of them, that two runs of a campaign share.

Two drives over one track differ in their noise and in their speed, sample by sample; two copies of
one drive do not, whatever became of their names, gains, offsets and last digits. So what is
compared is the second difference of the samples, in which noise is strongest, and gain and offset
do not matter. The signs of a short stretch of it, all channels together, are a fingerprint. Of
every second the smallest is kept ("winnowing", Schleimer, Wilkerson and Aiken, SIGMOD 2003), so
that two runs that share some seconds share a fingerprint, and the work grows with the samples, not
with pairs of runs.
"""

import hashlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign.types import Campaign, CampaignError, RigRun, Run

BITS = 64  # of a fingerprint
BLOCK_S = 1.0
ALIKE = 0.99  # least r² of the second differences; no driver repeats himself so well
MOST_PLACES = 8  # of which it is tried whether a run is the same as others from there on


@dataclass(frozen=True)
class Duplicate:
    """A stretch of `seconds` that run `second` has from `second_s` on, and `first` from `first_s`
    on, each counted from the run's beginning. `whole`: it is all of both; `exact`: to the last bit;
    `leaks`: one of them is fitted and the other judges."""

    first: str
    second: str
    first_s: float
    second_s: float
    seconds: float
    whole: bool
    exact: bool
    leaks: bool

    def __str__(self) -> str:
        how = "the same samples" if self.exact else "nearly the same samples"
        line = f'run "{self.second}" holds {how} as run "{self.first}"'
        if not self.whole:
            line += (
                f" for {self.seconds:.1f} s, from {self.second_s:.1f} s on there and from "
                f"{self.first_s:.1f} s on here"
            )
        return line + (": one is fitted, the other judges the fit" if self.leaks else "")


def find_duplicates(campaign: Campaign) -> list[Duplicate]:
    """What any run shares with an earlier one for 3.5 s or more, in the order of the runs.

    A run is compared with the first one of each role that has the same fingerprint: of three copies
    the third is named beside the first. Signals that repeat exactly, as those of a simulation
    without noise do, have no fingerprints; then only recordings that are the same as a whole are
    found. A machine that repeats a drive to 1 % of what changes from sample to sample is named,
    too: a rig, or a simulation with little noise.
    """
    runs = campaign.runs
    roles = dict.fromkeys(run.role for run in runs)
    records = [_signals(run) for run in runs]
    block = max(round(BLOCK_S * campaign.sample_rate_hz), 2)
    prints: dict[tuple[int, str], tuple[int, int]] = {}
    wholes: dict[tuple[bytes, str], int] = {}
    found: list[Duplicate] = []
    for number, run in enumerate(runs):
        digest = _digest(run)
        same = {wholes[digest, role]: 0 for role in roles if (digest, role) in wholes}
        votes: Counter[tuple[int, int]] = Counter()
        for key, place in _fingerprints(records[number], block):
            for role in roles:
                if (key, role) in prints:
                    other, there = prints[key, role]
                    votes[other, there - place] += 1
            prints.setdefault((key, run.role), (number, place))
        places = [*same.items(), *(pair for pair, _ in votes.most_common(MOST_PLACES))]
        seen: set[int] = set()
        for other, shift in places:
            if other in seen:
                continue
            stretch = _shared(records[other], records[number], shift, block)
            if other in same:
                stretch = (0, len(records[number]))
            if stretch is not None:
                seen.add(other)
                found.append(_duplicate(campaign, other, number, shift, stretch))
        wholes.setdefault((digest, run.role), number)
    return found


def refuse_leaks(campaign: Campaign) -> None:
    """Raise CampaignError if a run that is to judge holds the very samples of one to be fitted."""
    fitted = {_digest(run): run.id for run in campaign.fit_runs if len(run.time_s)}
    for run in campaign.validate_runs:
        twin = fitted.get(_digest(run))
        if twin is not None:
            raise CampaignError(
                f'{run.file}: run "{run.id}" (validate) holds the samples of run "{twin}" (fit): '
                "what was fitted cannot judge the fit; leave one out, or record another run"
            )


def _signals(run: Run) -> NDArray[np.float64]:
    """(n, c) all that was measured in a run."""
    if isinstance(run, RigRun):
        return np.column_stack([run.displacement, run.force])
    return run.record


def _digest(run: Run) -> bytes:
    values = np.ascontiguousarray(_signals(run)) + 0.0  # -0.0 is 0.0
    return hashlib.sha256(repr(values.shape).encode() + values.tobytes()).digest()


def _fingerprints(values: NDArray[np.float64], block: int) -> Iterator[tuple[int, int]]:
    """Fingerprints and where they begin; one that occurs twice in the run says nothing."""
    signs = (np.diff(values[:, :BITS], n=2, axis=0) > 0).astype(np.uint64)
    n, c = signs.shape
    length = -(-BITS // c)
    if n < length:
        return
    words = (signs << np.arange(c, dtype=np.uint64)).sum(axis=1, dtype=np.uint64)
    keys = np.zeros(n - length + 1, np.uint64)
    for k in range(length):  # what is shifted out at the top has been mixed in before
        keys = (keys ^ words[k : n - length + 1 + k]) * np.uint64(0x9E3779B97F4A7C15)
        keys ^= keys >> np.uint64(29)
    _, first, count = np.unique(keys, return_index=True, return_counts=True)
    order = np.full(len(keys), np.inf)
    single = first[count == 1]
    order[single] = (keys[single] >> np.uint64(16)).astype(np.float64)
    kept = np.flatnonzero((order == _least_around(order, block)) & np.isfinite(order))
    yield from zip(keys[kept].tolist(), kept.tolist(), strict=True)


def _least_around(values: NDArray[np.float64], width: int) -> NDArray[np.float64]:
    """The least of the `width` values around each, in a time that does not grow with the width:
    a window is the end of one block and the beginning of the next (van Herk, Pattern Recognit.
    Lett. 13 (1992) 517)."""
    n = len(values)
    padded = np.full(-(-(n + width - 1) // width) * width, np.inf)
    padded[width // 2 : width // 2 + n] = values
    blocks = padded.reshape(-1, width)
    begin = np.minimum.accumulate(blocks, axis=1).ravel()
    end = np.minimum.accumulate(blocks[:, ::-1], axis=1)[:, ::-1].ravel()
    return np.minimum(end[:n], begin[width - 1 : width - 1 + n])


def _shared(
    first: NDArray[np.float64], second: NDArray[np.float64], shift: int, block: int
) -> tuple[int, int] | None:
    """The longest stretch (from, to) of `second`, in whole blocks, that `first` has `shift` rows
    later; None if there is none."""
    low, high = max(0, -shift), min(len(second), len(first) - shift)
    if high - low < block:
        return None
    x = np.diff(first[low + shift : high + shift], n=2, axis=0)
    y = np.diff(second[low:high], n=2, axis=0)
    starts = np.arange(0, max(len(x) - block + 1, 1), block)
    xx, yy, xy = (np.add.reduceat(product, starts, axis=0) for product in (x * x, y * y, x * y))
    moving = (xx > 0) & (yy > 0)
    alike = np.divide(xy**2, xx * yy, out=np.zeros_like(xy), where=moving)
    alike[~moving & (xx == yy)] = np.nan  # a channel at rest in both says nothing
    told = np.isfinite(alike).any(axis=1)
    good = told.copy()
    good[told] = np.nanmedian(alike[told], axis=1) >= ALIKE
    edges = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(np.int8), [0]])))
    if not len(edges):
        return None
    longest = int(np.argmax(edges[1::2] - edges[::2]))
    begin, end = edges[2 * longest], edges[2 * longest + 1]
    stop = high if end == len(starts) else low + int(starts[end])
    return low + int(starts[begin]), stop


def _duplicate(
    campaign: Campaign, first: int, second: int, shift: int, stretch: tuple[int, int]
) -> Duplicate:
    a, b = campaign.runs[first], campaign.runs[second]
    begin, stop = stretch
    rate = campaign.sample_rate_hz
    theirs, ours = _signals(a)[begin + shift : stop + shift], _signals(b)[begin:stop]
    return Duplicate(
        first=a.id,
        second=b.id,
        first_s=(begin + shift) / rate,
        second_s=begin / rate,
        seconds=(stop - begin) / rate,
        whole=len(ours) == len(_signals(a)) == len(_signals(b)),
        exact=bool(np.array_equal(theirs, ours)),
        leaks=a.role != b.role,
    )
