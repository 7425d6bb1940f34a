"""Calibration by turning over: what it finds, and what it notices."""

import datetime as dt
from dataclasses import replace

import numpy as np
import pytest

from wheelhop.calibration.conditions import Conditions
from wheelhop.calibration.error import CalibrationError
from wheelhop.calibration.flip import find_rests, flip_calibration
from wheelhop.hil_sim.rig import Sensor, random_sensor
from wheelhop.hil_sim.rig_flip import flip_log

CONDITIONS = Conditions("flip", dt.date(2026, 1, 1), dt.date(2027, 1, 1))
PAIR = (Sensor("B1", rest_code=530.3), Sensor("A1", rest_code=520.8))


def flip(sensors=PAIR, orientations=(1, -1, 1, -1, 1), seed=0, **options):
    log = flip_log(sensors, np.random.default_rng(seed), orientations, **options)
    return flip_calibration(log, CONDITIONS)


def test_a_supply_that_changed_is_found():
    log = flip_log(PAIR, np.random.default_rng(0), (1, -1, 1, -1, 1))
    steady = flip_calibration(log, CONDITIONS)
    notes = {**log.notes, "supply_mv": "3300", "low_supply_mv": "3000"}
    found = flip_calibration(replace(log, notes=notes), CONDITIONS)
    sentence = "the sensors' supply fell from 3300 to 3000 mV (-9 %) in between"
    assert found.findings == (sentence, *steady.findings)


def test_gain_and_offset_are_within_their_uncertainty():
    inside = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        sensors = [random_sensor(rng, name) for name in ("B1", "B2", "A1")]
        gravity = 9.80665 * (1 + rng.uniform(-0.0027, 0.0027))
        kelvin = rng.uniform(-10, 10)
        found = flip(sensors, seed=seed, rest_s=15.0, gravity_m_s2=gravity)
        for sensor, channel in zip(sensors, found.channels, strict=True):
            offset = sensor.rest_code - 0.5 + kelvin * sensor.rest_drift_code
            inside.append(
                [
                    abs(channel.gain.value - sensor.gain_at(kelvin)) <= channel.gain.expanded,
                    abs(channel.offset.value - offset) <= channel.offset.expanded,
                ]
            )
            assert channel.gain.relative < 0.03
    assert (np.mean(inside, axis=0) >= 0.95).all()


def test_five_rests_in_six_minutes_are_seen_with_their_orientation():
    found = flip()
    assert found.orientations == (1, -1, 1, -1, 1)
    assert found.rests[-1].end_s < 360
    assert all(rest.end_s - rest.start_s > 55 for rest in found.rests)
    assert found.findings == ()
    assert found.constants().of("B1").corner_hz is None


def test_a_sensor_on_its_head_is_noticed_and_gets_a_negative_gain():
    found = flip(orientations=[(1, -1), (-1, 1), (1, -1), (-1, 1)])
    assert found.channels[1].gain.value == pytest.approx(-PAIR[1].gain_m_s2_per_code, rel=0.02)
    assert any(line.startswith("A1: the first rest") for line in found.findings)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"orientations": (1,)}, "1 rests of 8 s or more"),
        ({"orientations": (1, -1, 1), "rest_s": 5.0}, "leave all sensors alone"),
        ({"orientations": [(1, 1), (-1, 1), (1, 1)]}, "A1: swings by .* was this sensor turned"),
        ({"orientations": [(1, 1), (-1, 1), (1, -1)]}, "at no time were all sensors upside down"),
        ({"gravity_m_s2": 25.0}, "B1: swings by"),
    ],
)
def test_what_was_not_done_right_is_said(options, words):
    with pytest.raises(CalibrationError, match=words):
        flip(**options)


def test_sensors_turned_one_after_the_other_with_pauses_are_waited_for():
    found = flip(orientations=[(1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1), (-1, -1)])
    assert found.orientations == (1, -1, 1, -1)


def test_once_each_way_is_enough_but_said():
    assert any("only once" in line for line in flip(orientations=(1, -1)).findings)


def test_a_driving_car_is_no_rest():
    log = flip_log(PAIR, np.random.default_rng(0))
    moved = log.values + 3 * np.random.default_rng(1).standard_normal(log.values.shape)
    assert find_rests(log.after("driven", values=moved)) == []
