"""How well `--budget` tells seconds: the work a diagnosis counts beside what a processor needs.

    python -m benchmarks.work [CAMPAIGN ...]

Work is counted so that no verdict depends on how busy a computer is (docs/theory.md, section 10).
The last column is what this computer needs for a second of it; the question whether axle to body is
linear, asked after the search, is not part of the budget, and counts as time alone.
"""

import sys
import time
from pathlib import Path

import wheelhop as wh

EXAMPLES = Path(__file__).parents[1] / "examples"


def main() -> None:
    """Print a line for each campaign."""
    names = sys.argv[1:] or [str(f.parent) for f in sorted(EXAMPLES.glob("*/campaign.toml"))]
    print(f"{'campaign':44} {'work, s':>8} {'CPU, s':>8} {'ratio':>6}")
    for name in names:
        began = time.process_time()
        found = wh.diagnose(name, budget_s=None)
        spent = time.process_time() - began
        work = found.steps[-1].rung.fit.runs[0].bench.work.seconds
        print(f"{Path(name).name[:44]:44} {work:8.1f} {spent:8.1f} {spent / work:6.2f}", flush=True)


if __name__ == "__main__":
    main()
