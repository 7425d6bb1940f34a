"""The synchronicity check on the thesis's ruler: closed ends, known skews, and refusals."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.calibration.test_sync_planted import ruler
from wheelhop.calibration.error import CalibrationError
from wheelhop.calibration.sync.check import check_synchronicity
from wheelhop.calibration.sync.delay import align
from wheelhop.hil_sim.beam_rig import CODES_PER_M_S2, REST, BeamRig

EIGHT = tuple(np.linspace(0.25, 1.0, 8) * 0.6096)
TWO_TONES = ruler(EIGHT, (15.0, 34.0), loss_factor=0.008)
STEP_S = 156.25e-6


def recorded(session=TWO_TONES, order="palindrome", **settings):
    return BeamRig(session, (0.5,) * len(session.frequencies_hz), **settings).record(20.0, order)


def skews(check):
    return np.array([channel.skew_s for channel in check.channels])


def test_palindrome_shows_no_skew():
    check = check_synchronicity(recorded(), TWO_TONES)
    assert check.passed and check.ramp_s == 0.0
    assert np.abs(skews(check)).max() < 30e-6


def test_plain_order_shows_its_ramp_and_is_mended():
    recording = recorded(order="plain")
    check = check_synchronicity(recording, TWO_TONES)
    expanded = np.array([channel.expanded_s for channel in check.channels])
    assert np.all(np.abs(skews(check) - STEP_S * np.arange(8)) <= expanded + 5e-6)
    assert check.ramp_s == pytest.approx(STEP_S, rel=0.03)
    assert [c.verdict for c in check.channels][::7] == ["fail", "fail"] and not check.passed
    mended = align(recording, check.skews_s)
    again = check_synchronicity(mended, TWO_TONES)
    assert again.passed and np.abs(skews(again)).max() < 5e-6
    assert "moved in time" in mended.history[-1]


def test_verdict_does_not_depend_on_the_assumed_damping():
    recording = recorded(order="plain", clock_ppm=2000.0)
    found = [
        skews(check_synchronicity(recording, replace(TWO_TONES, loss_factor=assumed)))
        for assumed in (0.0, 0.004, 0.008, 0.016)
    ]
    assert np.ptp(found, axis=0).max() < 10e-6


def test_the_beam_tells_its_own_damping():
    check = check_synchronicity(recorded(), replace(TWO_TONES, loss_factor=0.003))
    assert check.loss_factor == pytest.approx(0.008, abs=check.loss_expanded + 1e-4)
    assert check.loss_expanded < 0.002


def test_one_tone_is_honest_about_damping():
    session = ruler(EIGHT[2:6], (15.0,), loss_factor=0.002)
    truth = replace(session, loss_factor=0.009)
    check = check_synchronicity(recorded(truth), replace(session, loss_factor=0.005))
    told = [c for c in check.channels if not np.isnan(c.skew_s)]
    assert all(abs(c.skew_s) <= c.expanded_s for c in told)
    assert any("one frequency" in remark for remark in check.remarks)


@pytest.mark.parametrize("mode", [1, 2, 3])
def test_near_a_resonance_the_tool_refuses_and_says_why(mode):
    natural = TWO_TONES.beam.natural_frequencies_hz(60.0)[mode]
    near = ruler(EIGHT, (1.04 * natural,))
    with pytest.raises(CalibrationError, match=rf"natural frequency {natural:.2f}"):
        check_synchronicity(recorded(near), near)


def test_a_refused_frequency_leaves_the_others():
    natural = TWO_TONES.beam.natural_frequencies_hz(60.0)
    session = ruler(EIGHT, (15.0, 0.97 * natural[2], 34.0))
    check = check_synchronicity(recorded(session), session)
    assert [f for f, _ in check.refused] == [session.frequencies_hz[1]]
    assert len(check.frequencies_hz) == 2 and check.passed


def test_what_hangs_at_the_drive_does_not_change_the_verdict():
    heavy = replace(TWO_TONES, beam=TWO_TONES.beam.carrying(0.6096, 0.06))
    check = check_synchronicity(recorded(heavy, order="plain"), TWO_TONES)
    assert check.ramp_s == pytest.approx(STEP_S, rel=0.03)


def test_the_lost_rows_do_not_matter():
    recording = recorded()
    values = recording.values.copy()
    values[300:340] = values[1000:1020] = np.nan
    assert check_synchronicity(replace(recording, values=values), TWO_TONES).passed


def test_two_dwells_one_after_the_other_are_as_good_as_both_at_once():
    low, high = (
        recorded(replace(TWO_TONES, frequencies_hz=(f,)), order="plain")
        for f in TWO_TONES.frequencies_hz
    )
    low = replace(low, values=np.vstack([low.values, high.values]))
    assert check_synchronicity(low, TWO_TONES).ramp_s == pytest.approx(STEP_S, rel=0.03)


def test_two_sensors_pass_or_fail_together():
    pair = ruler((EIGHT[1], EIGHT[6]), (15.0, 34.0))
    good = check_synchronicity(recorded(pair), pair)
    bad = check_synchronicity(recorded(pair, late_s={"A1": 1e-3}), pair)
    assert [c.verdict for c in good.channels] == ["pass", "pass"]
    assert [c.verdict for c in bad.channels] == ["fail", "fail"]
    assert bad.channels[1].skew_s == pytest.approx(-1e-3, abs=0.05e-3)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"frequencies_hz": (15.0, 49.0)}, "cannot be seen"),
        ({"frequencies_hz": (11.0,)}, "no steady vibration"),
        ({"channels": ("A0", "A1", "A2", "A3", "A4", "A5", "A6", "X")}, "no such channel"),
    ],
)
def test_what_cannot_be_evaluated_is_one_line(change, said):
    with pytest.raises(CalibrationError, match=said):
        check_synchronicity(recorded(), replace(TWO_TONES, **change))


def test_a_short_recording_is_refused():
    recording = recorded()
    with pytest.raises(CalibrationError, match="too short"):
        check_synchronicity(replace(recording, values=recording.values[:150]), TWO_TONES)


def test_a_slow_filter_looks_like_an_early_sampling():
    corners = {name: 50.0 for name in TWO_TONES.channels} | {"A3": 42.5}
    check = check_synchronicity(recorded(corner_hz=corners), TWO_TONES)
    late = [np.arctan(np.array([15.0, 34.0]) / c) / (2 * np.pi * np.array([15.0, 34.0]))
            for c in (50.0, 42.5)]  # fmt: skip
    difference = late[1] - late[0]
    skew = check.channels[3].skew_s
    assert -difference.max() - 40e-6 < skew < -difference.min() + 40e-6
    assert np.abs(np.delete(skews(check), 3)).max() < 60e-6


def test_a_shaker_that_distorts_does_not_disturb():
    dirty = replace(TWO_TONES, frequencies_hz=(15.0, 30.0, 34.0, 45.0))
    recording = BeamRig(dirty, (0.5, 0.03, 0.5, 0.02)).record(20.0, "plain")
    assert check_synchronicity(recording, TWO_TONES).ramp_s == pytest.approx(STEP_S, rel=0.04)


@settings(max_examples=40, deadline=None)
@given(
    arrays(
        np.float64,
        st.tuples(st.sampled_from([0, 9, 300, 700]), st.just(8)),
        elements=st.sampled_from([0.0, 1.0, 500.0, 1e9, float("nan")]),
    )
)
def test_no_recording_is_too_odd_to_refuse(values):
    try:
        check_synchronicity(replace(recorded_once(), values=values), TWO_TONES)
    except CalibrationError as error:
        assert "\n" not in str(error)


@cache
def recorded_once():
    return recorded()


def test_a_known_force_makes_the_comparison_absolute():
    """Figure C.4: the ruler moves as much as 0.5 N move it, and half as much as 1 N."""
    codes = recorded()
    calibrated = replace(
        codes,
        values=(codes.values - REST) / CODES_PER_M_S2,
        channels=tuple(replace(channel, unit="m/s²") for channel in codes.channels),
    )
    right = check_synchronicity(calibrated, replace(TWO_TONES, force_N=0.5))
    assert right.level == pytest.approx((1.0, 1.0), rel=0.01)
    for channel in right.channels:
        assert channel.measured == pytest.approx(channel.expected, rel=0.03, abs=0.3)
    wrong = check_synchronicity(calibrated, replace(TWO_TONES, force_N=1.0))
    assert wrong.level == pytest.approx((0.5, 0.5), rel=0.01) and wrong.passed
    # By hand: ω² F over the bare ruler's receptance, without sensors, averaged over 10 ms.
    bare = ruler((0.6096,), (15.0,), sensor_kg=0.0)
    assert abs(bare.shape(np.array([15.0]), 0.0).item()) == pytest.approx(89.8, abs=0.1)
    assert not check_synchronicity(codes, TWO_TONES).level
    in_codes = check_synchronicity(codes, replace(TWO_TONES, force_N=0.5))
    assert not in_codes.level and any("decode it" in remark for remark in in_codes.remarks)
