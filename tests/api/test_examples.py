"""The examples for Python run, and say what their first lines promise."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.patience import PATIENCE_S

FOLDER = Path(__file__).parents[2] / "examples/python"
SAYS = {
    "add_an_effect": "dry-friction.front_N",
    "another_belief": "believed_softer",
    "diagnosis": "('dry-friction',)",
    "first_comparison": "worst: A",
    "own_recordings": "baseline",
    "read_logs": "missing: ",
    "residual_by_band": "over_floor",
    "simulate_a_drive": "iso8608-15kmph",
    "sweep_damping": "least error at 558 N s/m",
    "what_to_drive": "told from digressive-damper",
    "wheel_rate": "rear: wheel rate 6825",
}


def test_every_example_is_tried_and_on_the_page():
    assert {path.stem for path in FOLDER.glob("*.py")} == set(SAYS)
    page = (FOLDER.parents[1] / "docs/python.md").read_text(encoding="utf-8")
    assert all(f"examples/python/{name}.py" in page for name in SAYS)


@pytest.mark.parametrize("name", SAYS)
def test_an_example_runs(name, tmp_path):
    environment = {**os.environ, "TMPDIR": str(tmp_path), "MPLBACKEND": "agg"}
    done = subprocess.run(
        [sys.executable, "-W", "error::DeprecationWarning:__main__", FOLDER / f"{name}.py"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=environment,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 0, done.stderr
    assert SAYS[name] in done.stdout
    assert "Warning" not in done.stderr
