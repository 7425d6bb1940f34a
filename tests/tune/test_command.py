"""`wheelhop tune` and `wh.tune`: one result as a table, a page and JSON; mistakes are one line."""

import json
import shutil

import pytest

import wheelhop as wh
from tests.tune.cars import FILE
from wheelhop.cli.main import main

SHORT = ("--tracks", "herringbone/low", "--speed", "12", "--settings", "40", "--seconds", "3")


@pytest.fixture
def vehicle(tmp_path):
    return str(shutil.copy(FILE, tmp_path / "vehicle.toml"))


def test_what_is_printed_is_on_the_page_and_in_the_file(vehicle, tmp_path, capsys):
    page, file = tmp_path / "tuned.html", tmp_path / "tuned.json"
    words = ["--vary", "front.damping=±50%", "rear.stiffness=+-20%", "--objective", "comfort,roll"]
    outputs = ["--report", str(page), "--json", str(file)]
    assert main(["tune", vehicle, *SHORT, *words, *outputs]) == 0
    told = json.loads(file.read_text())
    shown = capsys.readouterr().out
    assert [o["name"] for o in told["objectives"]] == ["comfort", "roll"]
    for sentence in told["sentences"]:
        assert sentence.split(":")[0][:40] in shown.replace("\n", " ").replace("  ", " ")
    text = page.read_text(encoding="utf-8")
    assert text.count("<svg") == 3 and "Before and after" in text
    first = told["front"][0]
    assert set(first["values"]) == {"front.damping", "rear.stiffness"}
    assert len(told["front"]) == len({tuple(one["objectives"]) for one in told["front"]})
    again = wh.tune(
        vehicle, ["front.damping=±50%", "rear.stiffness=±20%"], "herringbone/low", 12.0,
        ["comfort", "roll"], settings=40, seconds=3.0, progress=False,
    )  # fmt: skip
    assert again.front[0].values == first["values"], "the same seed, the same setting"
    table = again.to_dataframe()
    assert table.index[0] == "now" and table.loc[1, "comfort"] == first["objectives"][0]


def test_the_work_is_what_the_page_of_tuning_says(vehicle):
    """The present setting, 7 places of the variable, 64 of its damper, 40 of the search, 24 cars
    for the present setting and up to 9 of the front, and both once more run by run; the search
    rides nothing twice that it begins with."""
    found = wh.tune(
        vehicle, "front.damping=±50%", "herringbone/low", 12.0, settings=40, seconds=3.0
    )
    assert len(found.front) == 9
    assert 0 <= 1 + 7 + 64 + 40 + 24 * (1 + 9) + 2 - found.count <= 1


WRONG = {
    ("--vary", "front.dampng=±50%"): "did you mean",
    ("--vary", "front.damping=±50%", "--objective", "speed"): "--objective speed",
    ("--vary", "front.damping=±50%", "--settings", "3"): "3 settings",
    ("--vary", "front.damping=±50%", "--seed", "-1"): "--seed -1",
    ("--vary", "front.damping=±50%", "--tracks", "moon"): "moon",
}


@pytest.mark.parametrize("words", WRONG, ids=" ".join)
def test_a_mistake_is_one_line(vehicle, words, capsys):
    assert main(["tune", vehicle, *SHORT, *words]) == 2
    line = capsys.readouterr().err.strip().splitlines()[-1]
    assert WRONG[words] in line


def test_a_vehicle_without_tracks_says_what_is_missing(vehicle, capsys):
    assert main(["tune", vehicle, "--vary", "front.damping=±50%"]) == 2
    assert "--tracks" in capsys.readouterr().err
