"""Every write, sync and rename of every command fails in turn: what is on the disk afterwards is
what was there before or what should be there after, never something between."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
# In fault_driver.py, too: convert-parquet, which writes in many small pieces and takes a minute;
# health and frame, which compute for long and write as rates does.
SCENARIOS = (
    *("campaign-new", "campaign-add", "convert-csv", "import", "add", "recover"),
    *("decode", "new", "road-csv"),
)
ALIKE = (
    *("convert-uff", "convert-force", "calibrate", "rates", "road-crg", "simulate-campaign"),
    *("thesis", "compare"),
)
"""They write by the same means as some of those above."""


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


@pytest.fixture
def disk(tmp_path):
    """In memory where that can be had: the disk that fails is the shim's, a real one only slow."""
    memory = Path("/dev/shm")
    within = memory if os.access(memory, os.W_OK) else tmp_path
    with tempfile.TemporaryDirectory(dir=within) as folder:
        yield Path(folder).resolve()


@pytest.mark.parametrize(
    "scenario", [*SCENARIOS, *(pytest.param(name, marks=pytest.mark.slow) for name in ALIKE)]
)
def test_the_disk_fails_anywhere_and_files_are_of_before_or_of_after(scenario, shim, disk):
    assert drive(shim, scenario, disk) >= 15
