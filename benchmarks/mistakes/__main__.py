"""Are the mistakes people make found and named? python -m benchmarks.mistakes [FOLDER …]

Plants each kind of mistake into `--base` good campaigns of the independent simulator
(`tests/truth`, vehicles of all its presets, a third of the campaigns with an effect hidden in the
physics) and asks the gate alone; then asks it about `--good` good campaigns, and about those in
FOLDER … . Seeds follow on `--seed`. Prints a line for each kind, with what was said where it was
missed, each finding in a good campaign, and the processor time of 18 runs.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.blind.vehicles import rougher, varied
from benchmarks.mistakes.planted import MISTAKES, Asked
from tests.diagnose.cases import CASES
from tests.truth import PRESETS
from tests.truth.campaign import write_campaign
from tests.truth.effects import make_effects
from wheelhop.campaign import read_campaign
from wheelhop.gate import gate
from wheelhop.vehicle import read_nominal

HIDDEN = [name for name in CASES if name != "clean" and not name.startswith("sensor-")]


def good(folder: Path, seed: int) -> Asked:
    """A good campaign: any vehicle, every third with an effect that is no fault of a sensor."""
    rng = np.random.default_rng(seed)
    name = list(PRESETS)[seed % len(PRESETS)]
    preset = rougher(varied(name, rng), float(rng.uniform(0.8, 1.2)))
    hidden = CASES[HIDDEN[seed // 3 % len(HIDDEN)]].hidden if name == "atv" else {}
    where = folder / str(seed)
    write_campaign(
        where,
        preset,
        make_effects(hidden),
        seed=seed,
        short=bool(seed % 4),
        noise_rms=float(rng.uniform(0.05, 0.25)),
        draft=True,
    )
    return asked(where)


def asked(folder: Path) -> Asked:
    """A campaign on disk and its vehicle."""
    campaign = read_campaign(folder)
    return campaign, read_nominal(campaign)


def plant(bases: list[Asked], seed: int) -> Iterator[tuple[str, int, list[str]]]:
    """Each mistake: in how many of the campaigns it was named, and what was said where not."""
    for name, (kinds, mistake) in MISTAKES.items():
        named, said = 0, []
        for number_, (campaign, vehicle) in enumerate(bases):
            rng = np.random.default_rng([seed, number_])
            found = gate(*mistake(campaign, vehicle, rng)).findings
            if any(finding.kind in kinds.split() for finding in found):
                named += 1
            else:
                said.append(", ".join(f.kind for f in found) or "nothing")
        yield name, named, said


def main() -> int:
    """Print what was found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--base", type=int, default=5, help="campaigns to plant each mistake in")
    parser.add_argument("--good", type=int, default=200, help="good campaigns to ask about")
    parser.add_argument("--seed", type=int, default=0, help="of the first campaign")
    parser.add_argument("folders", nargs="*", type=Path, help="good campaigns on disk, too")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as work:
        seeds = range(arguments.seed, arguments.seed + arguments.base + arguments.good)
        bases = [good(Path(work), s) for s in seeds[: arguments.base]]
        total = 0
        for name, named, said in plant(bases, arguments.seed):
            total += named
            print(f"{name:28s} {named:3d} of {len(bases)}  {'; '.join(said)}", flush=True)
        tried = len(MISTAKES) * len(bases)
        print(
            f"{len(MISTAKES)} kinds, named {total} of {tried}: {100 * total / max(tried, 1):.1f} %"
        )
        false, times, count = 0, [], 0
        campaigns = [(partial(good, Path(work), s), f"seed {s}") for s in seeds[arguments.base :]]
        campaigns += [(partial(asked, f), str(f)) for f in arguments.folders]
        for make, label in campaigns:
            campaign, vehicle = make()
            begin = time.process_time()
            findings = gate(campaign, vehicle).findings
            if len(campaign.runs) == 18:
                times.append(time.process_time() - begin)
            count += 1
            if findings:
                false += 1
                print(
                    f"  {label}: {'; '.join(f'{f.about}: {f.text}' for f in findings)}", flush=True
                )
        print(f"good campaigns: {false} of {count} with a finding")
        if times:
            print(
                f"18 runs: {statistics.median(times):.2f} s, at most {max(times):.2f} s,"
                " of processor time"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
