"""Recordings against each other: copies, one signal twice, noise stated that is not there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from math import expm1, log

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, ComponentCampaign, RigRun, Run
from wheelhop.campaign.channels import noise_key
from wheelhop.campaign.types import BODY_POINTS
from wheelhop.compare import weighed
from wheelhop.compare.quantisation import step_of
from wheelhop.gate.finding import Finding, needed
from wheelhop.gate.fixes import leave_out, without
from wheelhop.gate.spectra import QUARTERS, Spectra

Array = NDArray[np.float64]

LEAST_S = 0.5
"""Two recordings that share so long a stretch, sample by sample, are cut from one."""
WINDOW = 16  # samples in a row
SAME_PHASES = 0.5
"""Half of all phases alike, over the whole spectrum: noise, which never repeats, is most of it."""
DIGITS = 3e-5
"""Share of its range by which rounding to five digits changes a recording; the noise of sensors is
more."""
ROUNDED = 0.25
"""Share of what changes from sample to sample to which samples are rounded: of two recordings with
noise of their own, sixteen in a row never agree to that."""
ALIKE = 0.02  # sizes of two copies, whatever was rounded or taken out of the mean
SAME_SIGNAL = 1e-4  # of the power, left of the difference of two columns
QUIET_SHARE = 0.1  # of all lines of all spectra are quietest
NOISE = 1.5  # by which an estimate of the noise from a record may be off
UNIT = 5.0  # and by which stated noise is in another unit
FLAT_BODY = 1 / 8
"""Share of warp in what the body points do: of four unrelated signals a quarter, of a rigid body
none; frames that twist stay far below half of the former."""


@dataclass(frozen=True)
class Copy:
    """Two runs whose recordings are the same over so many seconds."""

    runs: tuple[Run, Run]
    seconds: float


def find_copies(campaign: Campaign) -> Iterator[Copy]:
    """Recordings that are the same, or overlap, each pair once: linear in the number of runs."""
    named: set[tuple[str, str]] = set()
    for copy in (*_shared_windows(campaign), *_same_phases(campaign)):
        first, second = sorted(run.id for run in copy.runs)
        if (first, second) not in named:
            named.add((first, second))
            yield copy


def copy_findings(copies: Iterable[Copy]) -> Iterator[Finding]:
    """What is to be said of them."""
    for copy in copies:
        a, b = copy.runs
        leak = " a held-out run that was fitted tests nothing," if a.role != b.role else ""
        yield Finding(
            "before",
            "copy",
            f"runs {a.id} and {b.id}",
            f"The recordings of {a.id} and {b.id} are the same over {copy.seconds:.1f} s,{leak}"
            " noise included.",
            "Leave one of them out, or cut them so that they do not overlap.",
            "certain",
            fixes=tuple(leave_out(run.id) for run in (a, b)),
        )


def _samples(run: Run) -> Array:
    """All that a recording holds (n, columns): of a rig what it imposed, too."""
    if isinstance(run, RigRun):
        return np.stack([run.displacement, run.force], axis=1)
    return run.record


def _sound(campaign: Campaign) -> list[int]:
    """The runs that show noise. Where the values come in steps that are coarser than what changes
    from sample to sample, a machine that repeats a motion repeats them to the last digit."""
    found = []
    for k, run in enumerate(campaign.runs):
        samples = _samples(run)
        steps = [step_of(values) for values in samples.T]
        if np.any(_change(samples) > steps):
            found.append(k)
    return found


def _rounding(campaign: Campaign) -> Array:
    """To what the columns of recordings are rounded before they are compared: 0.01 of their unit,
    or about as finely, or a share of what changes from sample to sample, if that is less."""
    own = ROUNDED * np.median([_change(_samples(run)) for run in campaign.runs], axis=0)
    if isinstance(campaign, ComponentCampaign):
        return np.asarray(np.maximum(own, 1e-300))
    return np.asarray(np.minimum(0.01 * weighed(campaign).noise_scale, np.maximum(own, 1e-300)))


def _change(samples: Array) -> Array:
    """By how much the columns (n, columns) change from sample to sample, motion apart: the median
    of their second differences."""
    return np.asarray(np.median(np.abs(np.diff(samples, 2, axis=0)), axis=0))


def _shared_windows(campaign: Campaign) -> Iterator[Copy]:
    """Pairs that share windows of samples (`_rounding`) one after the other, which noise forbids.
    What a run shows twice by itself is no noise."""
    unit = _rounding(campaign)
    seen: dict[int, tuple[int, int]] = {}
    shared: dict[tuple[int, int, int], list[int]] = {}
    for k in _sound(campaign):
        scaled = _samples(campaign.runs[k]) / unit
        rounded = np.clip(np.rint(scaled), -(2.0**62), 2.0**62).astype(np.int64)
        moved = np.append(0, np.cumsum(np.any(np.diff(rounded, axis=0) != 0, axis=1)))
        restless = np.flatnonzero(moved[WINDOW:] - moved[:-WINDOW] > WINDOW / 2)
        marks, first, times = np.unique(
            _marks(rounded)[restless], return_index=True, return_counts=True
        )
        once = zip(restless[first].tolist(), marks.tolist(), times.tolist(), strict=True)
        for i, mark, count in once:
            other, j = seen.setdefault(mark, (k, i)) if count == 1 else (k, i)
            if other != k:
                shared.setdefault((other, k, i - j), []).append(j)
    longest: dict[tuple[int, int], int] = {}
    for (a, b, later), at in shared.items():
        stretch = slice(min(at), max(at) + WINDOW)
        one = _samples(campaign.runs[a])[stretch]
        other_one = _samples(campaign.runs[b])[stretch.start + later : stretch.stop + later]
        if _same_digits(one, other_one):
            longest[a, b] = max(longest.get((a, b), 0), len(at) + WINDOW)
    for (a, b), count in longest.items():
        seconds = count / campaign.sample_rate_hz
        if seconds > LEAST_S:
            yield Copy((campaign.runs[a], campaign.runs[b]), seconds)


def _marks(rows: NDArray[np.int64]) -> NDArray[np.uint64]:
    """A number for the window that begins at each row: the same for the same window, and of two
    others the same once in 2⁶⁴ (a sum of products modulo 2⁶⁴, by odd numbers drawn once)."""
    drawn = np.random.default_rng(0).integers(2**64, size=(WINDOW, rows.shape[1]), dtype=np.uint64)
    of_rows = rows.view(np.uint64) @ (drawn.T | np.uint64(1))
    count = max(len(rows) - WINDOW + 1, 0)
    return np.asarray(sum(of_rows[k : k + count, k] for k in range(WINDOW)))


def _same_phases(campaign: Campaign) -> Iterator[Copy]:
    """Neighbours in size whose phases agree at all frequencies but for one shift in time, and whose
    samples then do to the last digits."""
    scale = _rounding(campaign)
    runs = [campaign.runs[k] for k in _sound(campaign)]
    size = np.array([_samples(run).std(axis=0) / scale for run in runs])
    for i, j in pairwise(np.argsort(size.sum(axis=1)) if runs else ()):
        if np.all(np.abs(size[i] - size[j]) <= ALIKE * size[j]):
            a, b = _samples(runs[i]), _samples(runs[j])
            n = min(len(a), len(b))
            # Without a window, what leaks from one strong line has one phase everywhere.
            window = np.hanning(n)[:, None]
            cross = np.fft.rfft(window * a[:n], axis=0)
            cross *= np.fft.rfft(window * b[:n], axis=0).conj()
            cross /= np.maximum(np.abs(cross), 1e-300)
            alike = np.fft.irfft(cross, n, axis=0).mean(axis=1)
            ahead = int(np.argmax(alike))
            ahead -= n * (ahead > n // 2)
            one = a[max(ahead, 0) : n + min(ahead, 0)]
            other = b[max(-ahead, 0) : n + min(-ahead, 0)]
            if alike.max() > SAME_PHASES and _same_digits(one, other):
                yield Copy((runs[i], runs[j]), n / campaign.sample_rate_hz)


def _same_digits(a: Array, b: Array) -> bool:
    """Whether two stretches (n, columns) are the same but for gains, means and the last digits, be
    they steps of the values or the digits kept of them."""
    for one, other in zip(a.T, b.T, strict=True):
        basis = np.stack([one, np.ones_like(one)], axis=1)
        left = other - basis @ np.linalg.lstsq(basis, other, rcond=None)[0]
        digit = max(step_of(one), step_of(other), DIGITS * float(np.ptp(other)))
        if np.std(left) > digit:
            return False
    return True


def same_signal_findings(campaign: Campaign) -> Iterator[Finding]:
    """Two channels that hold one signal: a wire on two inputs, a column copied. On a track that
    moves both alike two sensors differ by their noise alone: at the frequencies where next to
    nothing moves, by all they hold."""
    lines = [np.fft.rfft(_windowed(run.record), axis=0) for run in campaign.runs]
    for i, j in combinations(range(len(campaign.channels)), 2):
        if campaign.channels[i].quantity != campaign.channels[j].quantity:
            continue
        apart = np.concatenate([np.abs(x[:, i] - x[:, j]) ** 2 for x in lines])
        power = np.concatenate([np.abs(x[:, i]) ** 2 + np.abs(x[:, j]) ** 2 for x in lines])
        quiet = power <= np.quantile(power, QUIET_SHARE)
        share = apart.sum() / max(power.sum(), 1e-300)
        alike = power.sum() > 0 and share < SAME_SIGNAL
        if alike and apart[quiet].sum() <= power[quiet].sum() / 2:
            a, b = campaign.channels[i].name, campaign.channels[j].name
            yield Finding(
                "before",
                "same-signal",
                f"channels {a} and {b}",
                f"{a} and {b} hold the same signal: {100 * share:.1g} % of their power differs,"
                " less than two sensors' noise.",
                f"Look at the wiring and at the export of {a} and {b}.",
                "certain",
            )


def _windowed(record: Array) -> Array:
    return np.asarray(np.hanning(len(record))[:, None] * (record - record.mean(axis=0)))


def noise_findings(campaign: Campaign, spectra: Sequence[Spectra]) -> Iterator[Finding]:
    """The stated noise of every quantity against the quietest quarter of band and runs. It is too
    little only where something rests: a road that nobody described may shake all of the band."""
    described = any(s.run.track.kind != "unknown" for s in spectra)
    for quantity in campaign.quantities if spectra else ():
        of_it = [i for i, c in enumerate(campaign.channels) if c.quantity == quantity]
        first = campaign.channels[of_it[0]]
        stated = campaign.noise_rms if quantity == campaign.leading.quantity else first.noise_rms
        if stated is None:
            continue
        quietest = min(spectra, key=lambda s: s.quietest(of_it))
        rms = float(np.sqrt(quietest.quietest(of_it))) * first.noise_scale
        ratio = stated / max(rms, 1e-300)
        tried = QUARTERS * len(spectra)
        is_too_much = ratio > NOISE and not _by_chance(ratio, quietest.amplitudes(of_it), tried)
        if not is_too_much and (ratio > 1 / UNIT or not described):
            continue
        key = noise_key(first.unit)
        what = "more" if ratio > 1 else "less"
        yield Finding(
            "before",
            "noise",
            key,
            f"{key} = {stated:.3g} is {what} than the recordings hold where they are"
            f" quietest: {rms:.2g} {first.unit} in run {quietest.run.id}.",
            f"State the noise in band in {first.unit}, as a recording at rest shows it, or leave"
            " the key out.",
            "certain" if ratio > 1 else "likely",
            fixes=(without(key),),
        )


def _by_chance(ratio: float, amplitudes: float, tried: int) -> bool:
    """Whether the least median power of so many amplitudes, `tried` times, may be that of noise
    which is `ratio` times as large: by H. Chernoff's bound of the chance that half of them lie
    below it (Annals of Mathematical Statistics 23 (1952) 493)."""
    below = max(-expm1(-log(2.0) / ratio / ratio), 1e-300)
    return -0.5 * amplitudes * log(4.0 * below * (1.0 - below)) < needed(tried)


def rigid_findings(campaign: Campaign, spectra: Sequence[Spectra]) -> Iterator[Finding]:
    """Whether B1 … B4 can belong to one rigid body: B1 − B2 − B3 + B4 = 0, whatever moves it."""
    points = [channel.point for channel in campaign.channels]
    if not spectra or any(points.count(point) != 1 for point in BODY_POINTS):
        return
    body = [points.index(point) for point in BODY_POINTS]
    of_body = sum(s.lines[:, body][:, :, body].sum(axis=0) for s in spectra)
    warp = np.array([1.0, -1.0, -1.0, 1.0]) / 2
    share = float((warp @ of_body @ warp).real / max(np.trace(of_body).real, 1e-300))
    if share > FLAT_BODY:
        names = ", ".join(campaign.channels[i].name for i in body)
        yield Finding(
            "before",
            "not-rigid",
            f"channels {names}",
            f"{names} cannot sit on one rigid body: B1 − B2 − B3 + B4, which is zero on it, holds"
            f" {100 * share:.0f} % of their motion (four unrelated signals: 25 %).",
            "Look at the four sensors' places, signs and gains before a spring is blamed; only a"
            " frame that twists at its resonance does as much.",
        )
