"""Every write, sync and rename of every command fails in turn: what is on the disk afterwards is
what was there before or what should be there after, never something between."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
# In fault_driver.py, too: convert-parquet, which writes in many small pieces and takes a minute;
# health and frame, which compute for long and write as rates does.
SCENARIOS = (
    *("campaign-new", "campaign-add", "convert-csv", "convert-uff"),
    *("convert-force", "import", "compare", "add", "recover", "calibrate", "decode"),
    *("rates", "thesis", "new", "road-csv", "road-crg", "simulate-campaign"),
)


@pytest.fixture(scope="module")
def shim(tmp_path_factory):
    if sys.platform != "linux" or shutil.which("gcc") is None:
        pytest.skip("faults are injected with LD_PRELOAD and gcc")
    library = tmp_path_factory.mktemp("shim") / "faults.so"
    subprocess.run(
        ["gcc", "-shared", "-fPIC", "-o", library, HERE / "faults.c", "-ldl"], check=True
    )
    return library


def drive(shim: Path, scenario: str, folder: Path) -> int:
    """How many failures the command has survived; raises with what went wrong at which one."""
    done = subprocess.run(
        [sys.executable, HERE / "fault_driver.py", scenario, folder],
        env=os.environ
        | {
            "LD_PRELOAD": str(shim),
            "FAULT_FOLDER": str(folder / "disk"),
            "PYTHONPATH": str(ROOT),
            "PYTHONDONTWRITEBYTECODE": "1",
            "OMP_NUM_THREADS": "1",
        },
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return int(done.stdout.split()[-1])


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_the_disk_fails_anywhere_and_files_are_of_before_or_of_after(scenario, shim, tmp_path):
    assert drive(shim, scenario, tmp_path.resolve()) >= 15
