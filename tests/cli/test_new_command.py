"""`wheelhop new`: by options, by answers, and what `check` says of it."""

import io
import re
import shutil
from pathlib import Path

import pytest

from wheelhop.cli.main import main
from wheelhop.cli.parser_new import QUESTIONS
from wheelhop.vehicle import read_vehicle

ROOT = Path(__file__).parents[2]
NEEDED = ["--front-kg", "130", "--rear-kg", "160", "--wheelbase-m", "1.42"]


def test_what_is_missing_is_said_in_one_go(tmp_path, capsys):
    assert main(["new", str(tmp_path / "car"), "--front-kg", "130"]) == 2
    line = capsys.readouterr().err
    assert line.count("\n") == 1
    assert all(option in line for option in ("--rear-kg KG", "--wheelbase-m M", "--track-width-m"))
    assert not (tmp_path / "car").exists()


def test_answers_and_options_are_the_same(tmp_path, capsys, monkeypatch):
    words = [*NEEDED, "--track-width-m", "1.18", "--rear-ride-hz", "1.6", "--driver-kg", "80"]
    assert main(["new", str(tmp_path / "a" / "car"), *words]) == 0
    answers = {"front_kg": "heavy\n\n130", "rear_kg": "160", "wheelbase_m": "1,42"}
    answers |= {"track_width_m": "118\n1.18", "rear_ride_hz": "1.6", "driver_kg": "80"}
    skipped = ("front_motion_ratio", "rear_motion_ratio")  # nobody asks without a spring
    asked = [answers.get(q.name, "") for q in QUESTIONS if q.name not in skipped]
    terminal = io.StringIO("\n".join(asked) + "\n")
    terminal.isatty = lambda: True
    monkeypatch.setattr("sys.stdin", terminal)
    capsys.readouterr()
    assert main(["new", str(tmp_path / "b" / "car")]) == 0
    said = capsys.readouterr().out
    assert "'heavy' is not a number" in said and "this one is needed" in said
    assert "118 m: vehicles have 0.2 to 5" in said
    texts = [(tmp_path / name / "car/vehicle.toml").read_text() for name in "ab"]
    assert texts[0] == texts[1]
    assert main(["new", str(tmp_path / "b" / "car")]) == 2
    assert "is there already" in capsys.readouterr().err


def test_check_names_the_guesses_until_their_marks_are_gone(tmp_path, capsys):
    folder = tmp_path / "clean"
    shutil.copytree(ROOT / "examples/clean", folder)
    (folder / "vehicle.toml").unlink()
    assert main(["new", str(folder), *NEEDED, "--track-width-m", "1.18"]) == 0
    capsys.readouterr()
    file = folder / "vehicle.toml"
    for measured in ("", "pitch_inertia_kg_m2"):
        if measured:
            text = re.sub(rf"({measured} = \S+)  # estimated.*", r"\1", file.read_text())
            file.write_text(text)
        assert main(["check", str(folder)]) == 0
        (line,) = [x for x in capsys.readouterr().out.splitlines() if "only estimated" in x]
        assert "body.roll_inertia_kg_m2" in line and "wheelbase" not in line
        assert ("body.pitch_inertia_kg_m2" in line) is (not measured)


def test_the_page_has_every_number_and_what_is_estimated_as_it_is_done(tmp_path):
    page = (ROOT / "docs/vehicle-file.md").read_text()
    rows = set(re.findall(r"^\| `([^|]*?) \|", page, re.M))
    named = {w.strip("` ") for row in rows for w in row.split(",")}
    numbers = read_vehicle(ROOT / "examples/clean/vehicle.toml").values
    for key in numbers:
        general = re.sub(r"\.(front|rear)\.", ".*.", key)
        assert general in named or key.split(".")[-1] in named, key


@pytest.mark.parametrize("word", ["nan", "-3", "1e9", ""])
def test_a_number_no_vehicle_has_is_refused(word, tmp_path, capsys):
    with pytest.raises(SystemExit) as end:
        main(["new", str(tmp_path / "car"), "--front-kg", word])
    assert end.value.code == 2 and "--front-kg" in capsys.readouterr().err
