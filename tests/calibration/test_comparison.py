"""Comparison with a reference, on simulated rigs whose truth is known."""

import datetime as dt
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from wheelhop.calibration.conditions import Conditions
from wheelhop.calibration.error import CalibrationError
from wheelhop.calibration.shaker.comparison import compare_with_reference
from wheelhop.hil_sim.rig import STEPPED, SWEPT, Rig, Sensor, Shaking, random_rig

CONDITIONS = Conditions("cal", dt.date(2026, 1, 1), dt.date(2027, 1, 1), reference_expanded=0.003)
RIGS = 80
SHORT = Shaking(tuple((f, a, 5.0) for f, a, _ in STEPPED), pause_s=0.8)


def gain_at_10_hz(sensor, kelvin=0.0):
    return sensor.gain_at(kelvin) * np.hypot(1, 10 / sensor.corner_hz)


def delay_at_10_hz(sensor):
    return np.arctan(10 / sensor.corner_hz) / (20 * np.pi) + sensor.delay_s


def calibrate(rig, seed=0, conditions=CONDITIONS):
    rng = np.random.default_rng(seed)
    return compare_with_reference(rig.reference(rng), rig.log(rng), conditions)


@cache
def many():
    """(2 · RIGS, …) error and expanded uncertainty of everything; a use at another temperature."""
    rows = []
    for seed in range(RIGS):
        rng = np.random.default_rng(seed)
        rig = replace(random_rig(rng, shaking=SHORT), reference_rate_hz=500.0)
        found = calibrate(rig, seed)
        kelvin = rng.uniform(-10, 10)
        for sensor, channel in zip(rig.sensors, found.channels, strict=True):
            truth = (
                (sensor.gain_at(kelvin), channel.gain),
                (gain_at_10_hz(sensor, kelvin), channel.sensitivity),
                (sensor.rest_code - 0.5 + kelvin * sensor.rest_drift_code, channel.offset),
                (delay_at_10_hz(sensor), channel.delay_s),
                (sensor.corner_hz, channel.corner_hz),
                (rig.clock_offset_s, found.offset_s),
                (rig.clock_ppm, found.drift_ppm),
            )
            rows.append([(v.value - t, v.expanded, abs(v.value)) for t, v in truth])
    return np.array(rows).transpose(1, 2, 0)


@pytest.mark.slow
def test_gains_are_within_their_uncertainty_as_often_as_it_says():
    static, dynamic, *_ = many()
    for error, expanded, _ in (static, dynamic):
        assert (np.abs(error) <= expanded).mean() >= 0.95
        # Nor is the uncertainty a wall to hide behind: the median error of a normal one is 0.34 U.
        assert np.median(np.abs(error) / expanded) > 0.2


def test_the_uncertainty_at_10_hz_is_half_a_per_cent_at_most():
    _, expanded, value = many()[1]
    assert (expanded / value).max() <= 0.005


def test_offset_corner_delay_and_clocks_are_found():
    _, _, offset, delay, corner, clock, drift = many()
    assert np.abs(delay[0]).max() < 50e-6
    assert np.abs(clock[0]).max() < 0.2e-3
    assert np.abs(drift[0]).max() < 5.0
    for error, expanded, _ in (offset, delay, corner, clock, drift):
        assert (np.abs(error) <= expanded).mean() >= 0.9


def test_a_sweep_gives_the_same_with_less_certainty():
    rig = random_rig(np.random.default_rng(5), 3, SWEPT)
    found = calibrate(rig, 5)
    assert not found.stepped
    for sensor, channel in zip(rig.sensors, found.channels, strict=True):
        assert abs(channel.gain.value - sensor.gain_m_s2_per_code) < channel.gain.expanded
        assert channel.sensitivity.relative < 0.005
        assert channel.corner_hz.value == pytest.approx(sensor.corner_hz, rel=0.03)
        assert channel.usable_hz[1] > 30
    assert found.drift_ppm.value == pytest.approx(rig.clock_ppm, abs=5)
    assert found.offset_s.value == pytest.approx(rig.clock_offset_s, abs=0.2e-3)


PLAIN = Rig((Sensor("B1"), Sensor("B2", delay_s=400e-6)), SHORT, clock_ppm=800.0)


@pytest.mark.parametrize("conversions", [2, 4])
def test_faster_scans_give_the_same(conversions):
    """Fewer conversions in a sum: another averaging, which is taken out exactly."""
    sensor = Sensor("B1", gain_m_s2_per_code=0.52, corner_hz=46.0)
    rig = Rig((sensor,), SHORT, -0.4, 1500.0, conversions=conversions)
    (channel,) = calibrate(rig).channels
    assert abs(channel.gain.value - 0.52) < channel.gain.expanded
    assert channel.sensitivity.relative < 0.005
    assert channel.corner_hz.value == pytest.approx(46.0, rel=0.01)


def test_a_channel_that_is_late_is_seen_against_the_others():
    late, early = (c.delay_s.value for c in reversed(calibrate(PLAIN).channels))
    assert late - early == pytest.approx(400e-6, abs=20e-6)


def test_what_is_wrong_is_said():
    reversed_one = Sensor("B1", gain_m_s2_per_code=-0.5)
    bent = Sensor("B2", cubic=2e-6)
    found = calibrate(replace(PLAIN, sensors=(reversed_one, bent)))
    assert found.channels[0].gain.value == pytest.approx(-0.5, rel=0.005)
    assert any("B1: reversed" in line for line in found.findings)
    assert any(line.startswith("B2: the gain changes with amplitude") for line in found.findings)
    assert not any(line.startswith("B1: the gain") for line in found.findings)


def test_nothing_is_said_of_a_rig_that_is_right():
    assert calibrate(PLAIN).findings == ()


def test_a_high_pass_of_the_reference_is_suspected_and_taken_out_once_stated():
    rig = replace(PLAIN, reference_high_pass_hz=0.6)
    suspicious = calibrate(rig)
    assert any("high-pass at 0.6" in line for line in suspicious.findings)
    assert any("contradict" in line for line in suspicious.findings)
    told = calibrate(rig, conditions=replace(CONDITIONS, high_pass_hz=0.6))
    assert told.findings == ()
    assert told.channels[0].gain.value == pytest.approx(Sensor("").gain_m_s2_per_code, rel=0.005)


def test_a_sensor_that_is_not_on_the_table_is_named():
    rig = replace(PLAIN, sensors=(Sensor("B1"), Sensor("B2", gain_m_s2_per_code=1e6)))
    with pytest.raises(CalibrationError, match="B2"):
        calibrate(rig)


def test_recordings_of_different_sessions_are_refused():
    rng = np.random.default_rng(0)
    other = replace(PLAIN, shaking=Shaking(((33.0, 5.0, 20.0), (3.0, 5.0, 4.0), (21.0, 5.0, 9.0))))
    with pytest.raises(CalibrationError, match="no common motion"):
        compare_with_reference(other.reference(rng), PLAIN.log(rng), CONDITIONS)


def test_lost_scans_are_left_out_and_cost_little():
    rng = np.random.default_rng(0)
    reference, log = PLAIN.reference(rng), PLAIN.log(rng)
    values = log.values.copy()
    values[500:507] = values[3000:3100] = values[4001] = np.nan
    found = compare_with_reference(reference, replace(log, values=values), CONDITIONS)
    assert found.channels[0].gain.value == pytest.approx(Sensor("").gain_m_s2_per_code, rel=0.003)
    assert found.drift_ppm.value == pytest.approx(800, abs=2)


def test_round_frequencies_do_not_mislead_the_clocks():
    """All repeat after 0.2 s; only where the steps begin tells one period from the next."""
    steps = tuple((f, 12.0, 5.0) for f in (5.0, 10.0, 20.0, 40.0, 15.0))
    rig = Rig((Sensor("B1", gain_m_s2_per_code=-0.5),), Shaking(steps), -0.77, -3000.0)
    found = calibrate(rig)
    assert found.offset_s.value == pytest.approx(-0.77, abs=0.2e-3)
    assert found.channels[0].gain.value == pytest.approx(-0.5, rel=0.005)


def test_frequencies_too_close_to_show_the_filter_leave_the_static_gain_open():
    steps = tuple((f, 20.0, 5.0) for f in (9.1, 9.7, 10.3, 9.7))
    found = calibrate(replace(PLAIN, shaking=Shaking(steps)))
    for sensor, channel in zip(PLAIN.sensors, found.channels, strict=True):
        assert channel.sensitivity.relative < 0.006
        assert channel.gain.relative > 1.5 * channel.sensitivity.relative
        assert abs(channel.gain.value - sensor.gain_m_s2_per_code) < channel.gain.expanded
        assert channel.corner_hz is None or channel.corner_hz.relative > 0.1


def test_rounding_of_weak_motion_errs_alike_at_all_frequencies_and_the_budget_knows():
    """Four codes at every step: what the level between two codes does, it does everywhere, so the
    worst level is no accident. Errors follow an arcsine, whose end is near twice the deviation."""
    steps = tuple((f, 2.0, 5.0) for f in (5.3, 9.7, 15.1, 21.7, 9.7))
    for level in np.linspace(0, 1, 12, endpoint=False):
        quiet = Sensor("B1", rest_code=531 + level, noise_code=0.05)
        found = calibrate(Rig((quiet,), Shaking(steps), -0.3, 700.0))
        value = found.channels[0].sensitivity
        assert abs(value.value - gain_at_10_hz(quiet)) < 1.25 * value.expanded
        assert any("rounding makes the gain uncertain" in line for line in found.findings)


def test_a_sensor_driven_into_its_end_is_refused():
    steps = tuple((f, 400.0, 5.0) for f in (5.3, 9.7, 15.1))
    with pytest.raises(CalibrationError, match="B1: its codes reach the end"):
        calibrate(replace(PLAIN, shaking=Shaking(steps)))


def test_sines_that_match_a_period_too_early_are_locked_anew():
    """Five tones of 5 s, and clocks apart by as much as once sent the rough offset 0.36 s away."""
    tones = tuple((f, min(15.0, 0.012 * (2 * np.pi * f) ** 2), 5.0) for f in (9.7, 3.7, 21.7, 43.3))
    sensors = tuple(Sensor(f"B{k}", 0.48 + 0.01 * k, 531.3 + k) for k in range(1, 5))
    shaking = Shaking((*tones, (15.3, 15.0, 5.0)))
    for offset_s in np.linspace(-0.1, 0.1, 17):
        found = calibrate(Rig(sensors, shaking, clock_offset_s=float(offset_s)), 1)
        assert found.offset_s.value == pytest.approx(offset_s, abs=0.2e-3)


@pytest.mark.parametrize("seed", range(1000, 1004))
def test_sweeps_against_a_reference_of_few_samples_a_second(seed):
    """Steps between its samples would look like a slower sensor, and that like a delay."""
    rng = np.random.default_rng(seed)
    rig = replace(random_rig(rng, shaking=SWEPT), reference_rate_hz=500.0)
    found = calibrate(rig, seed)
    for sensor, channel in zip(rig.sensors, found.channels, strict=True):
        assert abs(channel.delay_s.value - delay_at_10_hz(sensor)) < 50e-6
        assert abs(channel.gain.value - sensor.gain_m_s2_per_code) < 1.5 * channel.gain.expanded
    assert abs(found.offset_s.value - rig.clock_offset_s) < 0.2e-3
    assert abs(found.drift_ppm.value - rig.clock_ppm) < 5.0


def test_a_sensor_on_its_head_can_be_swept():
    found = calibrate(Rig((Sensor("B1", -0.5),), SWEPT, -0.5, 2500.0))
    assert found.channels[0].gain.value == pytest.approx(-0.5, rel=0.005)
    assert found.drift_ppm.value == pytest.approx(2500, abs=5)


def test_one_frequency_is_not_enough():
    with pytest.raises(CalibrationError, match="at 1 frequencies only"):
        calibrate(replace(PLAIN, shaking=Shaking(tuple((9.7, a, 5.0) for a in (5, 10, 15)))))


def test_the_budget_adds_up():
    for channel in calibrate(PLAIN).channels:
        total = 2 * np.sqrt(sum(part**2 for _, part in channel.budget))
        assert channel.sensitivity.relative == pytest.approx(total)
        assert dict(channel.budget)["reference"] == pytest.approx(0.0015)
