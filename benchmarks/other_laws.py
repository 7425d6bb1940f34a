"""Are machines called by the names of their textbook laws? python -m benchmarks.other_laws [NAME …]

Hides each machine of `tests/diagnose/machines.py` in a campaign of 8 runs of the ATV
(`tests/truth`, MuJoCo), diagnoses it with the effects of the same place, and prints the verdict,
its confidence, and the error on held-out runs over that of an oracle, which knows all but the
noise.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from tests.diagnose.cases import diagnosed, oracle_of
from tests.diagnose.machines import FURTHER, MACHINES, rivals
from tests.truth import PRESETS, make_effect
from tests.truth.campaign import write_campaign


def main() -> None:
    """Print a line for each machine."""
    machines = MACHINES | FURTHER
    parser = argparse.ArgumentParser(prog="python -m benchmarks.other_laws")
    parser.add_argument("--seed", type=int, default=101)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(machines))
    given = parser.parse_args()
    for name in given.names or machines:
        hidden = [make_effect(name, machines[name])]
        with tempfile.TemporaryDirectory() as work:
            write_campaign(Path(work), PRESETS["atv"], hidden, seed=given.seed, short=True)
            found = diagnosed(Path(work), rivals(name))
            error = found.ladder[-1].rung.error_validate / oracle_of(Path(work) / "truth.toml")
        print(
            f"{name:22s} {', '.join(found.verdict)}, {100 * found.confidence:.0f} %,"
            f" {error:.2f} x oracle",
            flush=True,
        )


if __name__ == "__main__":
    main()
