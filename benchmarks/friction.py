"""Friction of another form: python -m benchmarks.friction [--draws N] [--seed N] [--all] [--jobs N]

Every draw hides force tanh(v / creep) at one end of the ATV: 40 to 120 N, 2 to 20 mm/s, recorded at
100 to 1000 Hz, 6 runs (`tests/truth/other_laws.py`, MuJoCo). The verdict is right if it calls that
friction, or the critic gives both names; a damper alone is wrong. The rivals are the suspension's
effects, all of which act where a strut moves; `--all` asks the whole library. Whether what lies
between axle and body is linear is not asked: the verdict does not depend on it.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from tests.truth import PRESETS
from tests.truth.campaign import write_campaign
from tests.truth.other_laws import TanhFriction
from wheelhop.campaign import read_campaign
from wheelhop.diagnose.baseline import fit_baseline
from wheelhop.diagnose.search.ladder import climb
from wheelhop.diagnose.verdict.critic import criticism
from wheelhop.effects import Effect, beliefs, load_effects
from wheelhop.gate import gate
from wheelhop.vehicle import read_vehicle

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

NAME = "dry-friction"
LEFT_OUT = ("chassis-twist-medium-fast", "one-sided-washboard-high")
"""Of the eight runs of a short campaign: what is left has two to judge by."""


@dataclass(frozen=True)
class Draw:
    """What is hidden, and how it is recorded."""

    force_N: float
    creep_m_s: float
    rate_hz: float
    end: str
    seed: int

    @staticmethod
    def of(seed: int) -> Draw:
        """Sizes even in their logarithm."""
        rng = np.random.default_rng(seed)
        force, creep, rate = (
            float(np.exp(rng.uniform(np.log(low), np.log(high))))
            for low, high in ((40.0, 120.0), (0.002, 0.02), (100.0, 1000.0))
        )
        return Draw(force, creep, round(rate), str(rng.choice(["front", "rear"])), seed)

    def write(self, folder: Path) -> Path:
        """The campaign."""
        front_N, rear_N = (self.force_N * (self.end == end) for end in ("front", "rear"))
        hidden = TanhFriction(front_N, rear_N, self.creep_m_s)
        return write_campaign(
            folder,
            PRESETS["atv"],
            [hidden],
            seed=self.seed,
            short=True,
            rate_hz=self.rate_hz,
            without=LEFT_OUT,
        )


def quiet(text: str) -> None:
    """No progress is shown."""


def ask(library: Mapping[str, Effect], seed: int) -> tuple[bool, str]:
    """Whether friction is among the names of what a draw hides, and a line about it."""
    draw = Draw.of(seed)
    with tempfile.TemporaryDirectory() as work:
        campaign = read_campaign(draw.write(Path(work)))
        vehicle, began = read_vehicle(campaign.vehicle_file), time.process_time()
        campaign = gate(campaign, vehicle).campaign
        base = fit_baseline(campaign, vehicle, jobs=1, progress=quiet)
        asked = {**library, **beliefs(campaign, vehicle)}
        found = climb(base, asked, max_effects=4, progress=quiet)
    either = [f.about.split() for f in criticism(found) if f.kind == "either"]
    right = NAME in {*found.verdict, *(name for names in either for name in names)}
    return right, (
        f"{seed:4d} {draw.end:5s} {draw.force_N:5.0f} N {1e3 * draw.creep_m_s:5.1f} mm/s"
        f" {draw.rate_hz:5.0f} Hz  {'right' if right else 'WRONG'}"
        f"  {', '.join(found.verdict)} ({100 * found.confidence:.0f} %),"
        f" {found.ladder[-1].over_floor:.2f} x floor,"
        f" {time.process_time() - began:.0f} s"
    )


def main() -> None:
    """Print a line for each draw, and how many were right."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.friction")
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1, help="of the first draw")
    parser.add_argument("--all", action="store_true", help="ask the whole library")
    parser.add_argument("--jobs", type=int, default=1, help="draws at the same time")
    given = parser.parse_args()
    library = load_effects()
    if not given.all:
        library = {k: e for k, e in library.items() if e.place == "suspension"}
    right = 0
    with ProcessPoolExecutor(given.jobs) as pool:
        seeds = range(given.seed, given.seed + given.draws)
        for done, (found, line) in enumerate(pool.map(partial(ask, library), seeds), start=1):
            right += found
            print(f"{line}  [{right} of {done}]", flush=True)


if __name__ == "__main__":
    main()
