"""`wheelhop simulate`: by words alone, and one line for every mistake."""

import errno
import json
import os
from pathlib import Path

import pytest

from wheelhop.campaign import read_campaign
from wheelhop.cli.main import main
from wheelhop.diagnose import climb, fit_baseline
from wheelhop.effects import load_effects
from wheelhop.vehicle import read_nominal

VEHICLE = Path(__file__).parents[2] / "examples/clean/vehicle.toml"
SHORT = ["--seconds", "4"]


def test_a_clean_campaign_comes_down_to_its_noise(tmp_path, capsys):
    folder, result = tmp_path / "c", tmp_path / "compare.json"
    tracks = ["washboard/low", "herringbone/medium"]
    assert main(["simulate", str(VEHICLE), "--tracks", *tracks, "--out", str(folder)]) == 0
    assert "4 runs" in capsys.readouterr().out
    assert main(["compare", str(folder), "--json", str(result)]) == 0
    found = json.loads(result.read_text())
    assert found["error_validate"] < 1.05 * found["floor"]["error_validate"]


MISTAKES = {
    "speed 0": (["--speed", "0"], "--speed 0: must be above 0"),
    "no such track": (["--tracks", "washbord/low"], "did you mean 'washboard/low'"),
    "no such key": (["--tracks", "washboard/low:pitch=3"], "pitch"),
    "no speed": (["--tracks", "flat"], "say how fast"),
    "no shape": (["--tracks", "unknown"], "has no shape"),
    "no effect": (["--with", "dry-frictoin"], "did you mean 'dry-friction'"),
    "no parameter": (["--with", "dry-friction:fornt_N=3"], "did you mean 'front_N'"),
    "out of bounds": (["--with", "dry-friction:front_N=-3"], "must be within 0"),
    "no form": (["--with", "dry-friction:form=sticky"], "elastic, creeping"),
    "no number": (["--with", "dry-friction:front_N=much"], "is not a number"),
    "twice": (["--with", "dry-friction", "dry-friction"], "given twice"),
    "noise": (["--noise", "-1"], "--noise -1"),
    "not a number of seconds": (["--seconds", "nan"], "--seconds nan"),
    "too stiff": (["--with", "anti-roll-bar:front_N_m=1e9"], "runs away"),
    "more mass than there is": (["--with", "driver-seat:mass_kg=2000"], "must be within"),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_a_mistake_is_one_line_and_leaves_nothing(case, tmp_path, capsys):
    words, complaint = MISTAKES[case]
    out = ["--out", str(tmp_path / "c")]
    if "--tracks" not in words:
        words = ["--tracks", "washboard/low", *words]
    assert main(["simulate", str(VEHICLE), *words, *out]) == 2
    error = capsys.readouterr().err
    assert complaint in error and error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_negative_mass_is_one_line(tmp_path, capsys):
    file = tmp_path / "vehicle.toml"
    file.write_text(VEHICLE.read_text().replace("mass_kg = 2", "mass_kg = -2", 1))
    assert main(["simulate", str(file), "--tracks", "washboard/low"]) == 2
    error = capsys.readouterr().err
    assert "mass_kg" in error and error.count("\n") == 1


def test_a_survey_with_a_hole_is_one_line(tmp_path, capsys):
    road = tmp_path / "road.csv"
    road.write_text("x_m,left_m,right_m\n0,0,0\n1,nan,0\n2,0,0\n")
    words = ["--tracks", f"profile:file={road}", "--speed", "10", "--out", str(tmp_path / "c")]
    assert main(["simulate", str(VEHICLE), *words]) == 2
    error = capsys.readouterr().err
    assert "line 3" in error and error.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["road.csv"]


PUSH = """
from wheelhop.effects import Amplitude, Effect
from wheelhop.vehicle import CORNERS, suspension

class Push(Effect):
    id, place, title, equation, source = "push", "suspension", "pushes", "f = -k x", "a test"

    def parameters_for(self, vehicle, channels):
        return (Amplitude("k_N_m", "N/m", "negative stiffness", 2e4),)

    def modify(self, theta, vehicle, parts):
        for corner in CORNERS:
            parts.add_spring(suspension(vehicle, corner), -theta["k_N_m"])
"""


def test_a_disk_that_is_full_is_told_of_the_log_to_be_written(tmp_path, monkeypatch, capsys):
    def full(*block):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("wheelhop.hil_sim.double.card.Card.append", full)
    log = tmp_path / "r.hop"
    words = ["--tracks", "washboard/low", "--speed", "8", "--seconds", "2", "--out", str(log)]
    assert main(["simulate", str(VEHICLE), *words]) == 2
    said = capsys.readouterr().err
    assert f"wheelhop: {log}: cannot be written" in said.splitlines()[-1]
    assert not list(tmp_path.iterdir())


def test_a_vehicle_that_falls_over_is_one_line(tmp_path, capsys):
    own = tmp_path / "push.py"
    own.write_text(PUSH)
    words = ["--library", str(own), "--with", "push", "--tracks", "washboard/low"]
    assert main(["simulate", str(VEHICLE), *words]) == 2
    error = capsys.readouterr().err
    assert "not stable" in error and error.count("\n") == 1


def test_a_hidden_effect_is_named(tmp_path):
    folder = tmp_path / "c"
    words = ["--tracks", "washboard/low", "herringbone/low", "--with", "dry-friction", *SHORT]
    assert main(["simulate", str(VEHICLE), *words, "--out", str(folder)]) == 0
    campaign = read_campaign(folder)
    base = fit_baseline(campaign, read_nominal(campaign), progress=str)
    few = ("dry-friction", "digressive-damper", "driver-seat", "speed-fluctuation")
    diagnosis = climb(
        base, {name: load_effects()[name] for name in few}, max_effects=1, progress=str
    )
    assert diagnosis.verdict == ("dry-friction",)
