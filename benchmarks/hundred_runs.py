"""What a diagnosis of 100 runs takes beside one of 18: python -m benchmarks.hundred_runs [N …]

The independent simulator drives one machine, friction hidden in it, over the proving ground at 18
speeds, and then again, now a little slower, now a little faster, until there are as many runs. Each
diagnosis is a process of its own, one thread, compiled code cached: processor seconds, peak memory.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import count, islice
from pathlib import Path

import numpy as np

from benchmarks.timing import measure
from tests import truth
from wheelhop.campaign import Campaign, Run, read_campaign

FRICTION = {"dry-friction": {"coulomb_front_N": 75.0, "coulomb_rear_N": 55.0}}
SEED = 2601
NOISE_M_S2 = 0.13
CHANGE = 0.02
LIMIT = 6.0
"""A hundred runs should take no more than so many times what eighteen take."""

BEFORE = """
from benchmarks.hundred_runs import driven
from wheelhop.diagnose import diagnose
from wheelhop.effects import load_effects
from wheelhop.vehicle import read_nominal
campaign = driven({folder!r}, {wanted})
vehicle, effects = read_nominal(campaign), load_effects()
"""
TIMED = "assert diagnose(campaign, vehicle, effects, jobs=1).verdict == ('dry-friction',)"


def driven(folder: str, wanted: int) -> Campaign:
    """The campaign in a folder, driven until there are as many runs as wanted."""
    campaign = read_campaign(Path(folder))
    known = truth.read_truth(folder)

    def runs() -> Iterator[Run]:
        yield from campaign.runs
        for lap in count(1):
            faster = 1.0 + CHANGE * (-1) ** lap * lap
            for i, run in enumerate(campaign.runs):
                seed = 1000 * lap + i
                speed = known.runs[run.id].speed_m_s * faster
                # Somewhere else, and well beyond where the track begins.
                start = known.runs[run.id].start_m + 1.7 * lap
                drive = replace(known.runs[run.id], speed_m_s=speed, start_m=start, seed=seed)
                record = truth.simulate_run(known.vehicle, drive, known.effects)[1]
                noise = NOISE_M_S2 * np.random.default_rng(seed).normal(size=record.shape)
                stated = run.speed_m_s * faster
                yield replace(run, id=f"{run.id}-{lap}", speed_m_s=stated, record=record + noise)

    return replace(campaign, runs=tuple(islice(runs(), wanted)))


def main(arguments: Sequence[str]) -> None:
    """A line for every number of runs, and by how many times the last takes longer."""
    counts = [int(word) for word in arguments] or [18, 100]
    with tempfile.TemporaryDirectory() as folder:
        truth.make_campaign(folder, seed=SEED, effects=FRICTION)
        measure(BEFORE.format(folder=folder, wanted=counts[0]), TIMED)  # compiles
        taken = []
        for wanted in counts:
            _, processor_s, memory_mb = measure(BEFORE.format(folder=folder, wanted=wanted), TIMED)
            taken.append(processor_s)
            print(f"{wanted:4d} runs: {processor_s:7.1f} s, {memory_mb:6.0f} MB", flush=True)
    print(f"{taken[-1] / taken[0]:.1f} times as long; {LIMIT:g} are allowed")


if __name__ == "__main__":
    main(sys.argv[1:])
