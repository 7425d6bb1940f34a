"""How long 18 runs take, effect by effect: python -m benchmarks.each_effect [NAME …]

Every campaign hides one effect at clear strength (`tests/diagnose/cases.py`, or what is named of
them) and is made by MuJoCo, one thread, in a process of its own; so is each diagnosis, on all
processors, import included and compiled code cached. What a machine is worth drops out of the
ratio: processor seconds of the diagnosis, which simulates the campaign many times, over those of
making it once.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.timing import DIAGNOSE, measure
from tests.diagnose.cases import CASES as TESTED
from tests.diagnose.cases import Case

CASES = {**TESTED, "backlash": Case({"backlash": {"gap_m": 0.001}})}
"""MuJoCo takes minutes for backlash: too long for the tests."""

MAKE = "from tests.truth import make_campaign"
MADE = "make_campaign({folder!r}, seed={seed}, effects={hidden!r})"


def main(names: Sequence[str]) -> int:
    """Print a line for each."""
    if unknown := [name for name in names if name not in CASES]:
        print(f"{', '.join(unknown)}: no such case; there are {', '.join(CASES)}", file=sys.stderr)
        return 2
    print(f"{os.cpu_count()} processors, {time.strftime('%Y-%m-%d %H:%M')}")
    columns = "made, s", "wall, s", "processor, s", "peak, MB", "diagnosed / made"
    print(f"{'':24s}" + " ".join(f"{column:>16s}" for column in columns))
    with tempfile.TemporaryDirectory() as work:
        warm = False
        for name in names or CASES:
            case, folder = CASES[name], str(Path(work) / name.replace(" ", "-"))
            made = MADE.format(folder=folder, seed=case.seed, hidden=dict(case.hidden))
            _, making, _ = measure(MAKE, made)
            diagnose = DIAGNOSE.format(folder=folder)
            if not warm:
                measure("", diagnose)  # fills the cache of compiled code
                warm = True
            wall, processor, memory = measure("", diagnose)
            figures = making, wall, processor, memory, processor / making
            print(f"{name:24s}" + " ".join(f"{figure:16.2f}" for figure in figures), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
