"""Effects that need not seek what a channel shows: engine, wheels, and what driving does."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.simulate.setup import EFFECTS
from wheelhop.campaign.driven import Driven
from wheelhop.campaign.known import Known, Pushed
from wheelhop.effects import OwnValues, RunSetting

TIME = np.arange(1001) / 100.0
MIDDLE, SECONDS = 5.0, 10.0
IDLE, GAIN, TYPICAL = 60.0, 6.0, 100.0  # rad/s, rad/s², rad/s
ORDER = 2.0


def setting(**known):
    return RunSetting("run", 4.0, -2.0, 0.0, SECONDS, True, known=Known(**known))


def turned(at_s):
    """Angle of an engine that runs up, since mid-record."""
    return IDLE * (at_s - MIDDLE) + GAIN * (at_s**2 - MIDDLE**2) / 2


RUN_UP = Driven("rpm", TIME, IDLE + GAIN * TIME, TYPICAL)
THETA = {"freq_hz": ORDER * TYPICAL / (2 * pi), "cos_m_s2": 0.4, "sin_m_s2": -0.2}


def test_the_force_turns_with_the_engine_as_a_channel_shows_it():
    """Order times angle, whatever the mean speed of this run."""
    (force,) = EFFECTS["engine-vibration"].forces(THETA, setting(engine=RUN_UP), TIME, TIME, TIME)
    angle = ORDER * turned(TIME)
    np.testing.assert_allclose(force, 0.4 * np.cos(angle) - 0.2 * np.sin(angle), atol=1e-3)


def test_of_a_known_engine_nothing_but_the_force_is_free():
    effect, run = EFFECTS["engine-vibration"], setting(engine=RUN_UP)
    assert [p.name for p in effect.per_run(run)] == ["cos_m_s2", "sin_m_s2"]
    assert effect.run_starts(None, run, THETA) == ({},)
    summary = effect.summary([OwnValues(run, {**THETA, "body.mass_kg": 200.0})])
    assert summary == {
        "force_N": pytest.approx(200.0 * np.hypot(0.4, 0.2)),
        "order": pytest.approx(ORDER),
    }


class Residual:
    """What a force of an engine that runs up leaves of two channels, in noise."""

    settings = (setting(engine=RUN_UP),)

    def __init__(self, seed):
        rng = np.random.default_rng(seed)
        line = 0.4 * np.cos(ORDER * turned(TIME) + rng.uniform(0, 2 * pi))
        self.left = line[:, None] + rng.normal(size=(len(TIME), 2))

    def time_s(self, run_id):
        return TIME

    def measured(self, run_id):
        return self.left

    def modelled(self, run_id, changes):
        return np.zeros_like(self.left)


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1))
def test_a_line_that_runs_up_with_the_engine_is_found_in_noise(seed):
    """It sweeps from 19 to 38 Hz, and is one line over the angle."""
    start = EFFECTS["engine-vibration"].shape_starts(Residual(seed))[0]
    assert start["freq_hz"] == pytest.approx(THETA["freq_hz"], rel=3e-3)


def test_an_imbalance_turns_with_its_wheel_as_a_channel_shows_it():
    """A wheel that slips for a while gets round as often, but not then."""
    rate = 20.0 + 6.0 * np.sin(2 * pi * TIME / SECONDS)
    effect = EFFECTS["wheel-imbalance"].with_choice("rear_left")
    run = setting(wheels={2: Driven("wheel", TIME, rate, 20.0)})
    way = np.repeat(5.0 * TIME[:, None], 4, axis=1)
    theta = {"rear_m": 0.25, "rear_left_cos_m": 0.1}
    (force,) = effect.forces(theta, run, TIME, way, np.full_like(way, 5.0))
    about = 6.0 * SECONDS / (2 * pi) * (-1.0 - np.cos(2 * pi * TIME / SECONDS))
    angle = 20.0 * (TIME - MIDDLE) + about
    np.testing.assert_allclose(force, 0.1 * rate**2 * np.cos(angle), atol=0.03)


DRIVING = [("longitudinal-pitch", "x"), ("cornering-roll", "y")]


@pytest.mark.parametrize(("effect", "axis"), DRIVING)
def test_what_a_channel_shows_of_driving_moves_the_body(effect, axis):
    """Times a share that is free in every run; an offset of the sensor counts for nothing."""
    shown = 1.5 * np.sin(2 * pi * TIME / 4.0)
    run = setting(pushed={axis: Pushed(TIME, shown + 0.3)})
    share = EFFECTS[effect].per_run(run)[0]
    (force,) = EFFECTS[effect].forces({share.name: 0.8}, run, TIME, TIME, TIME)
    expected = 0.8 * (shown - shown.mean())
    np.testing.assert_allclose(force, expected, atol=1e-3)
    (still,) = EFFECTS[effect].forces({}, run, TIME, TIME, TIME)
    assert not still.any()
    rms = EFFECTS[effect].summary([OwnValues(run, {share.name: 0.8})])["rms_m_s2"]
    assert rms == pytest.approx(expected.std(), rel=0.01)


def test_what_is_added_to_a_measured_acceleration_is_as_small_as_its_noise():
    """But for what was before the record, of which nothing is known."""
    rng, shown = np.random.default_rng(5), 1.5 * np.sin(2 * pi * TIME / 4.0)
    run = setting(pushed={"x": Pushed(TIME, shown + rng.normal(0.0, 0.2, len(TIME)))})
    _, *added = EFFECTS["longitudinal-pitch"].per_run(run)
    before = [each.scale for each in added if each.span_s[0] < 0.0]
    inside = {each.scale for each in added if each.span_s[0] >= 0.0}
    assert 5 <= len(before) <= 9 and set(before) == {1.0}
    assert len(inside) == 1 and inside.pop() == pytest.approx(0.2, rel=0.1)


def test_of_a_measured_acceleration_what_driving_does_counts_not_the_bodys_shaking():
    driving, shaking = np.sin(2 * pi * TIME / 0.7), np.sin(2 * pi * 6.0 * TIME)
    inside = slice(50, -50)
    kept = Pushed(TIME, driving).at(TIME)[inside]
    assert np.std(kept - driving[inside]) < 0.015
    assert Pushed(TIME, shaking).at(TIME)[inside].std() < 0.1 * shaking.std()
