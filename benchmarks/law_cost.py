"""What a law costs, in seconds of the clock: python -m benchmarks.law_cost CAMPAIGN…

For each campaign: the first look at free laws of every place, the full fit of the one that promises
most, and the whole search of `wheelhop law`, named laws and formulas with it. Beside them the
screening of the library, which a diagnosis pays for in any case. The compiled code is loaded first.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TypeVar

from wheelhop.campaign import read_campaign
from wheelhop.diagnose import fit_baseline
from wheelhop.diagnose.screen.first_order import screen
from wheelhop.effects import load_effects
from wheelhop.law import find_law
from wheelhop.law.few_terms import fitted
from wheelhop.law.search import screened
from wheelhop.vehicle import read_nominal

T = TypeVar("T")


def timed(work: Callable[[], T]) -> tuple[T, float]:
    """What the work gives, and how long it took."""
    begin = time.perf_counter()
    return work(), time.perf_counter() - begin


def silent(text: str) -> None:
    """No word of progress."""


def main() -> None:
    """A line for each campaign."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("campaigns", nargs="+", type=Path)
    library = list(load_effects().values())
    print(f"{'campaign':28} {'runs':>4} {'library':>8} {'places':>7} {'free fit':>8} {'search':>7}")
    for folder in parser.parse_args().campaigns:
        campaign = read_campaign(folder)
        vehicle = read_nominal(campaign)
        baseline = fit_baseline(campaign, vehicle, progress=silent)
        workshop, base = baseline.workshop, baseline.rung
        screened(workshop, base, silent)
        _, of_library = timed(partial(screen, workshop, base.fit, library))
        (promises, *_), of_places = timed(partial(screened, workshop, base, silent))
        of_fit = 0.0
        if promises:
            best = promises[0].screened
            _, of_fit = timed(partial(fitted, workshop, base, best))
        _, of_search = timed(partial(find_law, campaign, vehicle, [], library, silent))
        print(
            f"{folder.name:28} {len(campaign.runs):4} {of_library:7.1f}s {of_places:6.1f}s"
            f" {of_fit:7.1f}s {of_search:6.1f}s",
            flush=True,
        )


if __name__ == "__main__":
    main()
