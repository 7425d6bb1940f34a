"""Quarter and half cars, and cars on a frame, through `wheelhop simulate`."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.vehicle.test_layout import QUARTER
from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.cli.main import main
from wheelhop.predict import Case, read_drives
from wheelhop.vehicle import read_nominal, read_vehicle

ROOT = Path(__file__).parents[2]
WORDS = ["--tracks", "washboard/low", "--speed", "9", "--seconds", "4"]


def test_a_quarter_car_makes_a_campaign_with_the_logger_s_channels_it_has(tmp_path):
    file = tmp_path / "quarter.toml"
    file.write_text(QUARTER)
    out = tmp_path / "made"
    assert main(["simulate", str(file), *WORDS, "--logger", "--out", str(out)]) == 0
    campaign = read_campaign(out)
    assert {channel.point for channel in campaign.channels} == {"A1", "B1"}
    assert len(read_nominal(campaign).values) == 7
    assert campaign.runs[0].record.std(axis=0).min() > 1.0


def test_a_vehicle_on_a_frame_takes_its_files_along(tmp_path):
    shutil.copy(ROOT / "examples/frame/baja.toml", tmp_path / "frame.toml")
    text = (ROOT / "examples/clean/vehicle.toml").read_text(encoding="utf-8")
    records = []
    for name, more in (("rigid", ""), ("bending", '\n[frame]\nfile = "frame.toml"\n')):
        file = tmp_path / f"{name}.toml"
        file.write_text(text + more, encoding="utf-8")
        out = tmp_path / name
        assert main(["simulate", str(file), *WORDS, "--noise", "0", "--out", str(out)]) == 0
        records.append(read_campaign(out).runs[0].record)
    bending = read_nominal(read_campaign(tmp_path / "bending"))
    assert bending["frame.1.frequency_hz"] == pytest.approx(27.0, rel=0.02)
    off = np.std(records[1] - records[0]) / np.std(records[0])
    assert 0.001 < off < 0.5


@pytest.mark.parametrize("effect", ["frame-twist", "cornering-roll", "wheel-imbalance"])
def test_an_effect_without_its_motion_is_a_line(effect, tmp_path, capsys):
    file = tmp_path / "quarter.toml"
    file.write_text(QUARTER)
    words = ["--with", effect, "--out", str(tmp_path / "made")]
    assert main(["simulate", str(file), *WORDS, *words]) == 2
    error = capsys.readouterr().err
    assert "does not apply to this vehicle" in error and error.count("\n") == 1
    assert not (tmp_path / "made").exists()


def test_a_vehicle_that_is_not_stable_is_a_line():
    vehicle = read_vehicle(ROOT / "examples/clean/vehicle.toml")
    pushed = vehicle.with_values({"suspension.front.stiffness_N_m": -5e4})
    with pytest.raises(CampaignError, match="the vehicle is not stable") as error:
        Case(pushed, (), read_drives(["washboard/low"], [9.0]))
    assert "\n" not in str(error.value)
