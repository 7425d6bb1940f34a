"""`wheelhop sync-check` and `wheelhop health` from file to exit status."""

import json
import subprocess
import sys
from argparse import Namespace
from dataclasses import replace

import numpy as np
import pytest

from tests.calibration.test_beam import GOOD
from tests.calibration.test_sync_planted import ruler
from wheelhop.cli import health, sync_check
from wheelhop.files import InputError
from wheelhop.formats import read, write
from wheelhop.hil_sim.beam_rig import BeamRig

PAIR = ruler((0.152, 0.6096), (15.0, 34.0))


@pytest.fixture
def files(tmp_path):
    """A beam file, and sessions of its two sensors in step and sampled in turn."""
    beam = tmp_path / "beam.toml"
    beam.write_text(GOOD, encoding="utf-8")
    for order in ("palindrome", "plain"):
        write(BeamRig(PAIR, (0.5, 0.5)).record(20.0, order), tmp_path / f"{order}.csv")
    return tmp_path


def arguments(files, order, **more):
    defaults = {"limit_ms": 0.1, "figure": None, "json": None, "correct": None}
    given = {"recording": files / f"{order}.csv", "beam": files / "beam.toml"}
    return Namespace(**defaults | given | more)


def examined(*recordings, **more):
    defaults = {"recordings": list(recordings), "figure": None, "json": None, "checklist": False}
    return Namespace(**defaults | more)


def test_sync_check_passes_what_is_in_step(files, capsys):
    assert sync_check.run(arguments(files, "palindrome", json=files / "out.json")) == 0
    assert "in step" in capsys.readouterr().out
    result = json.loads((files / "out.json").read_text(encoding="utf-8"))
    assert result["passed"] and [c["verdict"] for c in result["channels"]] == ["pass", "pass"]


def test_sync_check_fails_what_is_not_and_mends_it(files, capsys):
    mended = files / "mended.csv"
    correct = (files / "plain.csv", mended)
    assert sync_check.run(arguments(files, "plain", correct=correct)) == 1
    assert "fail" in capsys.readouterr().out
    assert "moved in time" in read(mended).history[-1]
    assert sync_check.run(arguments(files, "mended")) == 0


def test_sync_check_does_not_overwrite_its_input(files):
    same = (files / "plain.csv", files / "plain.csv")
    with pytest.raises(InputError, match="is there already"):
        sync_check.run(arguments(files, "plain", correct=same))


@pytest.mark.parametrize("name", ["sync.xyz", "nowhere/sync.png"])
def test_a_figure_that_cannot_be_written_is_one_line(files, name):
    with pytest.raises(InputError, match="sync"):
        sync_check.run(arguments(files, "plain", figure=files / name))
    with pytest.raises(InputError, match="sync"):
        health.run(examined(files / "plain.csv", figure=files / name))


def test_what_is_refused_names_the_files(files):
    text = (files / "beam.toml").read_text(encoding="utf-8").replace("[15.0, 34.0]", "[22.0]")
    (files / "beam.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"plain.csv on .*beam.toml: 22 Hz is within 10%"):
        sync_check.run(arguments(files, "plain"))


def test_figures_are_written(files):
    sync_check.run(arguments(files, "plain", figure=files / "sync.png"))
    health.run(examined(files / "plain.csv", figure=files / "health.png"))
    assert all((files / name).stat().st_size > 10_000 for name in ("sync.png", "health.png"))


def test_health_tells_good_from_bad(files, capsys):
    good = files / "palindrome.csv"
    recording = read(good)
    values = recording.values.copy()
    values[500:900, 1] = values[500, 1]
    bad = files / "bad.csv"
    write(replace(recording, values=values), bad)
    assert health.run(examined(good, bad, json=files / "health.json")) == 1
    out = capsys.readouterr().out
    assert "palindrome.csv: nothing found" in out and "without change for 4 s" in out
    result = json.loads((files / "health.json").read_text(encoding="utf-8"))
    assert result[str(good)]["healthy"] and not result[str(bad)]["healthy"]
    assert result[str(bad)]["findings"][0]["channels"] == ["A1"]
    assert np.isfinite(result[str(bad)]["findings"][0]["strength"])
    assert health.run(examined(good)) == 0


def test_these_modules_do_not_load_the_plotting():
    modules = "wheelhop.calibration.sync, wheelhop.calibration.health, wheelhop.hil_sim.beam_rig"
    code = f"import sys, {modules}; print('matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout == "False\n", done.stderr
