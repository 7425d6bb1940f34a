"""From the voltages of sensors to the hidden effect, through a logger, as a user would do it."""

import json
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import wheelhop as wh
from wheelhop.campaign import read_campaign
from wheelhop.cli import demo_field as field
from wheelhop.cli.main import main
from wheelhop.hil_sim.day import read_day
from wheelhop.logger import read_log

ROOT = Path(__file__).parents[2]
TRUTH = tomllib.loads(
    (ROOT / "hil_sim/wheelhop/hil_sim/eight_drives/truth.toml").read_text(encoding="utf-8")
)
SUPPLY_V = 3.3
G_M_S2 = 9.80665


@pytest.fixture(scope="module", params=[pytest.param("double", marks=pytest.mark.slow), "firmware"])
def campaign(request, tmp_path_factory):
    """The folder of a campaign recorded by the double, or by the firmware on the board."""
    elf = field.find_firmware() if request.param == "firmware" else None
    if request.param == "firmware" and elf is None:
        pytest.skip("needs gcc-avr, arduino-core-avr and libsimavr-dev")
    folder = tmp_path_factory.mktemp(request.param) / "c"
    day = read_day()
    sessions = (field.TURNED, day.turning), (field.DRIVEN, day.driving)
    with ThreadPoolExecutor() as boards:  # one each
        recorded = [
            boards.submit(field.record, signals, folder / f"board-{i}", name, elf)
            for i, (name, signals) in enumerate(sessions)
        ]
    for done in (future.result() for future in recorded):
        log = read_log(done.file)
        assert done.lost == 0
        assert (log.written, log.missing, log.damage) == (done.due, 0, ())
        done.file.replace(folder / done.file.name)
    field.calibrate(folder)
    field.make_campaign(folder, day)
    return folder


def test_gains_and_offsets_are_found_within_their_uncertainty(campaign):
    """At k = 2, of 16 numbers two may well lie outside.

    1 g is 20 codes: between two levels that no noise dithers it is known to 2 % (k = 2), and
    nothing else in the budget comes near that.
    """
    constants = tomllib.loads((campaign / "calibration.toml").read_text())
    outside = 0
    for sensor, per_g, zero in zip(
        constants["sensor"],
        TRUTH["sensors"]["volts_per_g"],
        TRUTH["sensors"]["zero_g_volts"],
        strict=True,
    ):
        codes_per_v = 1024 / SUPPLY_V
        gain = G_M_S2 / (per_g * codes_per_v)
        offset = (zero + per_g) * codes_per_v - 0.5  # the converter rounds down
        found, expanded = sensor["gain_m_s2_per_code"], sensor["gain_m_s2_per_code_expanded"]
        assert expanded < 0.022 * gain
        outside += abs(found - gain) > expanded
        outside += abs(sensor["offset_code"] - offset) > sensor["offset_code_expanded"]
    assert outside <= 2


def test_the_campaign_holds_every_drive_and_knows_its_scales(campaign):
    read = read_campaign(campaign)
    assert [run.id for run in read.runs] == [drive.id for drive in read_day().drives]
    assert read.averaging_s == pytest.approx(0.01)
    assert all(0.001 < channel.scale_uncertainty < 0.02 for channel in read.channels)
    assert all(np.abs(run.record.mean(axis=0)).max() < 0.5 for run in read.runs)


def test_the_hidden_effect_explains_what_the_vehicle_does(campaign):
    found = wh.compare(campaign, "dry-friction")
    first, last = found.steps
    assert last.rung.error_validate < 0.25 * first.rung.error_validate
    hidden = TRUTH["effect"]["dry-friction"]
    for axle in ("front", "rear"):
        value, _ = last.parameters[f"dry-friction.{axle}_N"]
        assert value == pytest.approx(hidden[f"coulomb_{axle}_N"], rel=0.1)


@pytest.mark.slow  # a minute
def test_the_hidden_effect_is_found(campaign, tmp_path):
    assert main(["diagnose", str(campaign), "--json", str(tmp_path / "d.json")]) == 0
    found = json.loads((tmp_path / "d.json").read_text())
    assert found["verdict"] == TRUTH["effects"] == ["dry-friction"]
