"""Single runs: recordings exchanged, a speed or a track that is another one's, a run at rest."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import log
from pathlib import Path

import numpy as np

from wheelhop.campaign.change import Proposal
from wheelhop.gate.descriptions import FACTORS, UNLIKE, Description
from wheelhop.gate.drive import Drive, OnWaves, speeds_about
from wheelhop.gate.finding import Finding, needed
from wheelhop.gate.fixes import exchanged, heights, leave_out, of_speed, real, same_track
from wheelhop.gate.match import Match

AT_REST = 0.1
"""A run with less of the amplitude that its track causes, and none of its lines, is at rest."""
HEIGHT = {"centimetres": 10.0, "metres": 1000.0, "inches": 25.4}
"""What a number under amplitude_mm may have been in, and its millimetres."""
ALIKE = 0.15  # speeds closer than this are the same as far as hands hold them


@dataclass(frozen=True, eq=False)
class Runs:
    """The campaign's drives as described, all under one `description`."""

    drives: Sequence[Drive]
    description: Description
    found: Sequence[Match]

    @property
    def told(self) -> Sequence[Drive]:
        """The drives whose description puts more into the band than their noise."""
        return [d for d in self.drives if d.is_told(self.description.speed, self.gain)]

    def suspects(self) -> list[Drive]:
        """The told ones that are explained less than half as well as the runs in the middle: where
        an effect unknown to the nominal vehicle spoils all runs, no single one is to blame."""
        likely = {d.run.id: m.log_likelihood for d, m in zip(self.drives, self.found, strict=True)}
        told = self.told
        middle = float(np.median([likely[d.run.id] for d in told])) if told else 0.0
        return [d for d in told if likely[d.run.id] < middle / 2]

    @property
    def gain(self) -> float:
        """The logarithm of the gain that the runs have in common."""
        gains = [log(m.gain) for m in self.found if m.has_gain]
        return float(np.median(gains)) if gains else 0.0

    def likelihood(self, match: Match) -> float:
        """Of one run under some description, its gain being like the others'."""
        if not match.has_gain:
            return match.log_likelihood
        apart = min(abs(log(match.gain) - self.gain), 5 * UNLIKE)
        return match.log_likelihood - apart**2 / (2 * UNLIKE**2)

    def under(self, drive: Drive, speed_m_s: float) -> float:
        """Likelihood of a drive at about a speed."""
        speeds = speeds_about(self.description.speed * speed_m_s)
        return self.likelihood(
            drive.match(speeds, [self.description.places], self.description.rate)[0]
        )


def run_findings(runs: Runs, folder: Path, known: Collection[str] = ()) -> Iterator[Finding]:
    """The mistakes that single runs of the campaign in `folder` betray, at most one each, but for
    the ids already `known`."""
    as_stated = {d.run.id: runs.likelihood(m) for d, m in zip(runs.drives, runs.found, strict=True)}
    named = set(known)
    for finding, ids in (*_at_rest(runs), *_exchanged(runs, as_stated, folder)):
        if not named & set(ids):
            named |= set(ids)
            yield finding
    suspects = runs.suspects()
    for drive, found in zip(runs.drives, runs.found, strict=True):
        if drive.run.id in named:
            continue
        told = _misdescribed(runs, drive, as_stated[drive.run.id]) if drive in suspects else None
        told = told or _height(runs, drive, found)
        if told is not None:
            yield told


def _at_rest(runs: Runs) -> Iterator[tuple[Finding, tuple[str, ...]]]:
    for drive, found in zip(runs.drives, runs.found, strict=True):
        if not isinstance(drive, OnWaves) or found.has_gain:
            continue
        expected = np.exp(runs.gain) * np.sqrt(drive.predicted_power(runs.description.speed))
        held = float(np.sqrt(drive.spectra.power.sum()))
        if held < AT_REST * expected:
            run = drive.run
            yield (
                Finding(
                    "before",
                    "at-rest",
                    f"run {run.id}",
                    f"Run {run.id} holds {100 * held / expected:.1g} % of the motion that"
                    f" {run.track.kind} causes at {3.6 * run.speed_m_s:.3g} km/h, and no line of"
                    " it: the vehicle stood, or was not on the track.",
                    "Cut the stretch where it drove, or leave the run out.",
                    "certain",
                    fixes=(leave_out(run.id),),
                ),
                (run.id,),
            )


def _exchanged(
    runs: Runs, as_stated: Mapping[str, float], folder: Path
) -> Iterator[tuple[Finding, tuple[str, ...]]]:
    """Pairs of runs each of which explains the other's recording better than its own."""
    rises = []
    pairs = list(combinations(runs.suspects(), 2))
    for a, b in pairs:
        swapped = [_with_record(a, b), _with_record(b, a)]
        if None in swapped:
            continue
        rise = 2 * min(
            runs.under(now, now.run.speed_m_s) - as_stated[then.run.id]
            for now, then in zip(swapped, (b, a), strict=True)
            if now is not None
        )
        if rise > needed(len(runs.told) ** 2):
            rises.append((rise, a.run, b.run))
    for _, a_run, b_run in sorted(rises, key=lambda item: -item[0]):
        yield (
            Finding(
                "before",
                "runs-exchanged",
                f"runs {a_run.id} and {b_run.id}",
                f"The recording of {a_run.id} has the lines of {b_run.id}'s track and speed, and"
                " the other way round: the two are exchanged.",
                f"Exchange the files (or track and speed) of {a_run.id} and {b_run.id}.",
                fixes=(exchanged(a_run, b_run, folder),),
            ),
            (a_run.id, b_run.id),
        )


def _misdescribed(runs: Runs, drive: Drive, as_stated: float) -> Finding | None:
    """A run that some other speed, or another run's track, explains better than its own."""
    run = drive.run
    others = [o for o in runs.told if o is not drive]
    tried = len(runs.drives) * (len(others) + len(FACTORS))
    best, words = as_stated + needed(tried), ""
    fixes: tuple[Proposal, ...] = ()
    for factor in FACTORS:
        if abs(log(factor)) > log(1 + ALIKE):
            likely = runs.under(drive, factor * run.speed_m_s)
            if likely > best:
                best = likely
                words = (
                    f"a speed of about {3.6 * factor * run.speed_m_s:.2g} km/h, not"
                    f" {3.6 * run.speed_m_s:.3g}"
                )
                told = f"Write {3.6 * factor * run.speed_m_s:.2g} km/h for {run.id}"
                fixes = (of_speed([run], float(factor), told),)
    for other in others:
        moved = _with_record(other, drive)
        if moved is None or other.run.track == run.track:
            continue
        for speed in {run.speed_m_s, other.run.speed_m_s}:
            likely = runs.under(moved, speed)
            if likely > best:
                best, words = likely, f"the track of {other.run.id}, not its own"
                fixes = (same_track(run, other.run),)
    if not words:
        return None
    return Finding(
        "before",
        "track-or-speed",
        f"track and speed_kmph of run {run.id}",
        f"The lines of run {run.id} are those of {words}"
        f" (the likelihood rises by a factor of 10^{(best - as_stated) / log(10):.0f}).",
        f"Look at speed_kmph, track.pitch_mm and the file of {run.id}.",
        fixes=real(fixes),
    )


def _height(runs: Runs, drive: Drive, found: Match) -> Finding | None:
    """A track ten times, or a thousand times, as high as stated."""
    if not found.has_gain:
        return None
    gain = log(found.gain) - runs.gain
    height = min(
        (s * log(f) for f in HEIGHT.values() for s in (-1, 1)), key=lambda x: abs(gain - x)
    )
    rise = (gain**2 - (gain - height) ** 2) / (2 * UNLIKE**2)
    if rise <= needed(2 * len(HEIGHT) * len(runs.drives)):
        return None
    run = drive.run
    return Finding(
        "before",
        "heights",
        f"track.amplitude_mm of run {run.id}",
        f"Run {run.id} moves {np.exp(gain):.2g} times as much as the other runs foretell.",
        "Look at the height of its track: keys ending in _mm take millimetres.",
        fixes=(heights([run], float(np.exp(height)), run.id),),
    )


def _with_record(described: Drive, recorded: Drive) -> Drive | None:
    """The description of one run with the recording of another."""
    if not (isinstance(described, OnWaves) and isinstance(recorded, OnWaves)):
        return None
    spectra = replace(recorded.spectra, run=described.run)
    return replace(described, spectra=spectra)
