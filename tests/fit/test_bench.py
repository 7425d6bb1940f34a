"""The bench: work for all runs in parallel threads."""

import subprocess
import sys
from pathlib import Path

CLEAN = Path(__file__).parents[2] / "examples/clean"
NESTED = """
import sys
from wheelhop.campaign import read_campaign
from wheelhop.fit import Workshop, initial_model
from wheelhop.vehicle import read_nominal

campaign = read_campaign(sys.argv[1], skip=set(sys.argv[2:]))
workshop = Workshop(campaign, initial_model(campaign, read_nominal(campaign)), jobs=2)
print(workshop.each(lambda i: sum(workshop.each(lambda j: i * j, [1, 2, 3])), [1, 2, 3]))
"""


def test_work_that_asks_for_work_does_not_wait_for_itself():
    """Both threads at once need a third: none is free until they are done."""
    skipped = sorted(path.stem for path in (CLEAN / "runs").glob("*.csv"))[2:]
    command = [sys.executable, "-c", NESTED, str(CLEAN), *skipped]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.stdout == "[6, 12, 18]\n", done.stderr
