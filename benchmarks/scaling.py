"""How a diagnosis grows with runs and with effects: python -m benchmarks.scaling [CAMPAIGN]

Every figure is processor seconds, the median of three, compiled code cached, one thread.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from wheelhop.campaign import Campaign, read_campaign
from wheelhop.diagnose import diagnose
from wheelhop.effects import Effect, load_effects
from wheelhop.vehicle import read_nominal

ROOT = Path(__file__).parents[1]
SHARES = (1 / 3, 2 / 3, 1.0)
REPEATS = 3


def main(arguments: Sequence[str]) -> None:
    """Print two tables."""
    campaign = read_campaign(Path(arguments[0] if arguments else ROOT / "examples/clean"))
    effects = load_effects()
    verdict = diagnose(campaign, read_nominal(campaign), effects).verdict  # compiles, too
    print(f"{campaign.folder.name} ({', '.join(verdict)}): processor seconds of a diagnosis")
    runs = [_some_runs(campaign, share) for share in SHARES]
    _table("runs", [len(c.runs) for c in runs], [_seconds(c, effects) for c in runs])
    some = [_some_effects(effects, share, verdict) for share in SHARES]
    _table("effects", [len(e) for e in some], [_seconds(campaign, e) for e in some])


def _some_runs(campaign: Campaign, share: float) -> Campaign:
    """The same share of the runs fitted and of those held out, evenly spread over the campaign."""
    kept = []
    for role in ("fit", "validate"):
        runs = [run for run in campaign.runs if run.role == role]
        places = np.linspace(0, len(runs) - 1, round(share * len(runs)))
        kept += [runs[round(place)] for place in places.tolist()]
    return replace(campaign, runs=tuple(kept))


def _some_effects(
    effects: Mapping[str, Effect], share: float, verdict: Sequence[str]
) -> dict[str, Effect]:
    """Those of the verdict, without which it would be another question, and others evenly spread
    over the library."""
    kept = [name for name in effects if name in verdict]
    others = [name for name in effects if name not in verdict]
    places = np.linspace(0, len(others) - 1, round(share * len(effects)) - len(kept))
    return {name: effects[name] for name in (*kept, *(others[round(p)] for p in places.tolist()))}


def _seconds(campaign: Campaign, effects: Mapping[str, Effect]) -> float:
    taken = []
    for _ in range(REPEATS):
        begin = time.process_time()
        diagnose(campaign, read_nominal(campaign), effects, jobs=1)
        taken.append(time.process_time() - begin)
    return statistics.median(taken)


def _table(what: str, counts: Sequence[int], seconds: Sequence[float]) -> None:
    """Seconds, and the power of the count with which they grow (1: in proportion)."""
    power = np.polyfit(np.log(counts), np.log(seconds), 1)[0]
    for count, time_s in zip(counts, seconds, strict=True):
        print(f"{count:4d} {what:8s} {time_s:7.2f} s {time_s / count:7.3f} s each")
    print(f"grows with the power {power:.2f} of the number of {what}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
