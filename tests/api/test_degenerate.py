"""Campaigns nobody would record: a line that says what is wrong, or results to look at."""

import re
import shutil
import warnings

import numpy as np
import pytest

import wheelhop as wh
from benchmarks.fuzz_campaigns import CHANGES, make_pattern
from wheelhop.cli.main import main


@pytest.fixture(scope="module")
def pattern(tmp_path_factory):
    return make_pattern(tmp_path_factory.mktemp("fuzz") / "pattern")


@pytest.fixture
def folder(pattern, tmp_path):
    return shutil.copytree(pattern, tmp_path / "c")


CASES = [("rest", 5), ("copy", 2), ("spike", 3), ("band", 4)]


@pytest.mark.parametrize(("name", "seed"), CASES)
def test_every_table_of_a_degenerate_comparison(folder, name, seed):
    {change.__name__: change for change in CHANGES}[name](folder, np.random.default_rng(seed))
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        result = wh.compare(folder)
        tables = [result.ladder(), result.parameters(), result.agreement()]
        tables += [result.residuals("band"), result.residuals("run")]
        shown = result._repr_html_() + result.comparison._repr_html_()
        wh.plot(result, "where")
    assert all(len(table) for table in tables) and shown.count("<table") >= 2
    channels = {c.name for c in result.campaign.channels}
    assert set(result.residuals("run").index.get_level_values("channel")) == channels


def kill_b1(folder):
    for file in (folder / "runs").glob("*.csv"):
        head, *rows = file.read_text().splitlines()
        column = head.split(",").index("B1")
        cells = [row.split(",") for row in rows]
        file.write_text(
            "\n".join([head, *(",".join([*c[:column], "0", *c[column + 1 :]]) for c in cells)])
        )


def test_a_figure_of_a_diagnosis_is_of_the_channel_it_names(folder):
    """The gate leaves out a sensor that rests; those behind it keep their names."""
    kill_b1(folder)
    found = wh.diagnose(folder, effects={}, max_effects=0)
    assert [c.name for c in found.campaign.channels] == list(found.comparison.channels)
    assert "B1" not in found.comparison.channels


@pytest.mark.slow
def test_what_is_stored_is_what_was_compared_without_the_dead_sensor(folder, capsys):
    kill_b1(folder)
    compared = wh.compare(folder, "sensor-gain")
    added = wh.add(folder, "sensor-gain")
    assert added.parameters().equals(compared.parameters())
    assert [f.about for f in added.findings] == [f.about for f in compared.findings] != []
    assert main(["add", str(folder), "sensor-gain"]) == 0
    assert "left out: the channel B1" in " ".join(capsys.readouterr().out.split())


def test_a_law_is_looked_for_without_the_dead_sensor(folder, monkeypatch):
    kill_b1(folder)

    def look(campaign, *given):
        assert "B1" not in [channel.name for channel in campaign.channels]
        raise wh.CampaignError("looked")

    monkeypatch.setattr("wheelhop.cli.law.find_law", look)
    assert main(["law", str(folder)]) == 2


def test_sensors_are_not_called_sound_where_one_was_left_out(folder, capsys):
    kill_b1(folder)
    assert main(["compare", str(folder)]) == 0
    assert "nothing found wrong" not in capsys.readouterr().out


def all_zero(folder):
    for file in (folder / "runs").glob("*.csv"):
        head, *rows = file.read_text().splitlines()
        zeros = [row.partition(",")[0] + ",0" * head.count(",") for row in rows]
        file.write_text("\n".join([head, *zeros]) + "\n")


def no_frequency_in_band(folder):
    file = folder / "campaign.toml"
    file.write_text(re.sub(r"band_hz = .*", "band_hz = [30.1, 30.2]", file.read_text()))


@pytest.mark.parametrize("change", [all_zero, no_frequency_in_band])
@pytest.mark.parametrize("command", ["check", "compare", "diagnose"])
def test_what_cannot_be_compared_is_one_line(folder, change, command, capsys):
    change(folder)
    assert main([command, str(folder)]) == 2
    said = capsys.readouterr()
    assert said.out == "" and said.err.count("\n") == 1
    assert str(folder) in said.err and "Traceback" not in said.err
    with pytest.raises(wh.CampaignError, match=r"nothing to compare|tell nothing"):
        wh.compare(folder)
