"""`wheelhop calibrate` from files to constants, and its mistakes in one line."""

import datetime as dt
from argparse import Namespace
from dataclasses import replace

import numpy as np
import pytest

from wheelhop.calibration import CalibrationError, read_constants
from wheelhop.calibration.session import read_session
from wheelhop.cli.calibrate import run
from wheelhop.formats import write
from wheelhop.hil_sim.rig import STEPPED, Rig, Sensor, Shaking
from wheelhop.hil_sim.rig_flip import flip_log
from wheelhop.logger.recording import Channel

SENSORS = (Sensor("B1", gain_m_s2_per_code=0.51), Sensor("B2", gain_m_s2_per_code=0.49))
RIG = Rig(SENSORS, Shaking(tuple((f, a, 5.0) for f, a, _ in STEPPED[:8])), -0.4, 900.0)
SESSION = """format = 1
id = "cal-2026-11"
date = 2026-11-20
temperature_C = 23.0

[reference]
file = "reference.csv"
sensor = "B&K 4382 no. 1234567"
certificate = "CDK-0815"
expanded_percent = 0.5
charge_pC_per_m_s2 = 3.16
amplifier_mV_per_pC = 10.0

[logger]
file = "log.csv"

[sensors]
B1 = "326-0017"
B2 = "326-0018"
"""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recorded")
    rng = np.random.default_rng(0)
    reference = RIG.reference(rng)
    volts = replace(reference, values=0.0316 * reference.values, channels=(Channel("ai0", "V"),))
    write(volts, folder / "reference.csv")
    write(RIG.log(rng), folder / "log.csv")
    return folder


@pytest.fixture
def session(recorded, tmp_path):
    for file in recorded.iterdir():
        (tmp_path / file.name).symlink_to(file)
    path = tmp_path / "session.toml"
    path.write_text(SESSION)
    return path


def calibrate(session, flip=False):
    out = session.parent / "calibration.toml" if session else None
    return run(Namespace(session=session, flip=flip, out=out, figure=None))


def test_volts_and_codes_become_constants_a_table_and_a_picture(session, capsys):
    assert calibrate(session) == 0
    constants = read_constants(session.parent / "calibration.toml")
    assert (constants.id, constants.device) == ("cal-2026-11", 3)
    for sensor, found in zip(SENSORS, constants.sensors, strict=True):
        assert abs(found.gain.value - sensor.gain_m_s2_per_code) < found.gain.expanded
    found = constants.of("B1")
    assert (found.serial, found.certificate) == ("326-0017", "CDK-0815")
    assert (found.date, found.valid_until) == (dt.date(2026, 11, 20), dt.date(2027, 11, 20))
    assert (session.parent / "calibration.png").read_bytes()[:4] == b"\x89PNG"
    out = capsys.readouterr().out
    for words in ("stepped sine", "drift", "326-0017", "quantisation", "31.10", "calibration.toml"):
        assert words in out


def test_one_sensor_after_the_other_ends_in_one_file(session):
    calibrate(session)
    session.write_text(SESSION.replace('B1 = "326-0017"\n', "").replace("0018", "0099"))
    calibrate(session)
    constants = read_constants(session.parent / "calibration.toml")
    assert [s.serial for s in constants.sensors] == ["326-0017", "326-0099"]


def test_turning_over_needs_the_log_alone(tmp_path, capsys):
    log = flip_log(SENSORS, np.random.default_rng(1), rest_s=20.0)
    write(log, tmp_path / "flip.csv")
    assert calibrate(tmp_path / "flip.csv", flip=True) == 0
    found = read_constants(tmp_path / "calibration.toml").of("B2")
    assert abs(found.gain.value - 0.49) < found.gain.expanded
    assert "does not tell frequency response" in capsys.readouterr().out
    assert (tmp_path / "calibration.png").exists()


@pytest.mark.parametrize(
    ("out", "figure", "words"),
    [
        ("no/calibration.toml", None, "there is no folder"),
        ("calibration.toml", "picture.doc", "a picture is .png"),
        ("log.csv", "picture.png", "not valid TOML"),
    ],
)
def test_an_output_that_cannot_be_written_is_told_before_the_work(session, out, figure, words):
    folder = session.parent
    figure = folder / figure if figure else None
    with pytest.raises(CalibrationError, match=words):
        run(Namespace(session=session, flip=False, out=folder / out, figure=figure))


def test_without_a_log_it_says_how_to_turn_them_over(capsys):
    assert calibrate(None, flip=True) == 0
    assert "upside down" in capsys.readouterr().out
    with pytest.raises(CalibrationError, match="say which session"):
        calibrate(None)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("expanded_percent", "expanded", "did you mean 'expanded_percent'"),
        ("charge_pC_per_m_s2 = 3.16\n", "", "'charge_pC_per_m_s2' is missing"),
        ('"reference.csv"', '"none.csv"', "none.csv"),
        ('B2 = "', 'B7 = "', "no channel B7 in the log, it has B1, B2"),
        ("date = 2026-11-20\n", "", "'date' is missing: give a day"),
        ('id = "cal-2026-11"', 'id = "calibration-of-november"', "at most 15"),
        ('[reference]\nfile = "reference.csv"', "[reference]", "'file' is missing"),
        ("amplifier_mV_per_pC = 10.0", "amplifier_mV_per_pC = 0", "greater than 0"),
        ("[sensors]", '[rig]\naxis = "down"\n[sensors]', "must be"),
    ],
)
def test_a_mistake_in_the_session_is_one_line(session, old, new, words):
    assert old in SESSION
    session.write_text(SESSION.replace(old, new, 1))
    with pytest.raises(ValueError, match=words) as error:
        read_session(session)
    assert "\n" not in str(error.value)


def test_a_session_without_a_reference_says_what_to_give(session):
    start, end = SESSION.index("[reference]"), SESSION.index("[logger]")
    session.write_text(SESSION[:start] + SESSION[end:])
    with pytest.raises(CalibrationError, match="no \\[reference\\]"):
        calibrate(session)
