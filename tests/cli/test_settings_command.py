"""`wheelhop settings`: from two settings of one car to words, JSON and a page."""

import json

import numpy as np
import pytest

import wheelhop as wh
from tests import truth
from tests.compare.other_car import RATE_HZ, Car, rough
from wheelhop.cli.main import main

HEAD = """\
format = 1
title = "one car"
vehicle = "vehicle.toml"
sample_rate_hz = 100.0
band_hz = [0.8, 30.0]

[channels]
imu = "body"
"""
RUN = """
[[run]]
id = "{0}"
file = "{0}.csv"
role = "fit"
speed_kmph = 20.0
track.kind = "unknown"
setting = "{0}"
"""


@pytest.fixture
def folder(tmp_path):
    rng = np.random.default_rng(8)
    car, ground = Car.drawn(rng), rough(rng, 320.0)
    for name, dampers in (("soft", 1.0), ("soft again", 1.0), ("hard", 2.5)):
        record = car.drive(ground, 5.5 * (1 + 0.02 * rng.normal()), 40.0, rng, dampers)
        table = np.column_stack([np.arange(len(record)) / RATE_HZ, record])
        np.savetxt(tmp_path / f"{name}.csv", table, "%.6g", ",", header="time_s,imu", comments="")
    text = HEAD + "".join(RUN.format(name) for name in ("soft", "soft again", "hard"))
    (tmp_path / "campaign.toml").write_text(text)
    vehicle = truth.campaign._vehicle_toml("car", truth.PRESETS["atv"].vehicle)
    (tmp_path / "vehicle.toml").write_text(vehicle)
    return tmp_path


def test_words_json_and_page(folder, capsys):
    page, plain = folder / "r.html", folder / "r.json"
    assert main(["settings", str(folder), "--json", str(plain), "--report", str(page)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "soft again against soft: no difference shown." in said
    assert "hard against soft: " in said and " dB " in said
    assert "It is no diagnosis" in said
    found = json.loads(plain.read_text())
    assert {d["setting"] for d in found["differences"] if d["differs"]} == {"hard"}
    assert "hard differs from soft" in page.read_text()


def test_python_says_the_same(folder):
    result = wh.compare_settings(folder, "hard")
    assert result.differences().groupby("setting")["differs"].any().to_dict() == {
        "soft": True,
        "soft again": True,
    }
    figure = wh.plot(result)
    assert [axes.get_xscale() for axes in figure.axes] == ["log", "log"]


def test_a_mistake_is_one_line(folder, capsys):
    assert main(["settings", str(folder), "--reference", "softer"]) == 2
    assert 'no setting "softer": choose from soft, soft again, hard' in capsys.readouterr().err


def test_old_campaigns_read_as_before(folder):
    text = folder / "campaign.toml"
    text.write_text("\n".join(s for s in text.read_text().split("\n") if "setting" not in s))
    assert {run.setting for run in wh.read(folder).runs} == {""}
