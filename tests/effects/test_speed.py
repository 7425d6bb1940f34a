"""Effects on the way of the wheels: distances, rates, and a wander found in a record."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.simulate.setup import ATV, CHANNELS, EFFECTS
from wheelhop.effects import OwnValues, RunSetting

SETTING = RunSetting("run", 4.0, -4.0, 0.0, 10.3, True)
STANDING = RunSetting("standing", 0.0, -4.0, 0.0, 10.3, True)
AXLES = RunSetting("axles", 4.0, 0.0, 0.0, 10.3, False)
TIME = np.linspace(-4.0, 10.3, 2861)
RECORD = TIME >= 0.0


def drawn(effect, seed, scale=1.0):
    """What the effect leaves free in a run, at random; its shape as screening begins."""
    rng = np.random.default_rng(seed)
    shapes = {p.name: p.start for p in effect.parameters_for(ATV, CHANNELS)}
    return shapes | {p.name: scale * p.scale * rng.normal() for p in effect.per_run(SETTING)}


@pytest.mark.parametrize("name", ["speed-fluctuation", "left-right-drift"])
@pytest.mark.parametrize("setting", [STANDING, AXLES], ids=["standing", "measured axles"])
def test_speed_is_nothing_where_the_track_does_not_pass(name, setting):
    assert not EFFECTS[name].per_run(setting)


@settings(max_examples=20)
@given(st.sampled_from(["speed-fluctuation", "left-right-drift"]), st.integers(0, 10**6))
def test_rate_is_the_derivative_of_the_distance(name, seed):
    effect = EFFECTS[name]
    theta = drawn(effect, seed)
    distance, rate = effect.travel(theta, SETTING, TIME, 4.0 * TIME, 4.0)
    assert distance.shape == rate.shape == (len(TIME), 4)
    # The history begins at some time with a jump of the rate; its integral knows of no jump.
    step = TIME[1] - TIME[0]
    gained = np.cumsum(rate[:-1] + rate[1:], axis=0) * step / 2
    np.testing.assert_allclose(
        distance[1:] - distance[0], gained, atol=1.5 * step * np.abs(rate).max()
    )
    assert np.abs(gained).max() > 10 * step * np.abs(rate).max()


@given(st.integers(0, 10**6))
def test_speed_fluctuation_moves_all_wheels_alike(seed):
    effect = EFFECTS["speed-fluctuation"]
    distance, _ = effect.travel(drawn(effect, seed), SETTING, TIME, 4.0 * TIME, 4.0)
    np.testing.assert_array_equal(distance, np.repeat(distance[:, :1], 4, axis=1))
    assert effect.travel({}, SETTING, TIME, 4.0 * TIME, 4.0) is None


@pytest.mark.parametrize("period", [2.5, 4.0, 6.0])
def test_speed_fluctuation_follows_a_wander_to_a_thousandth(period):
    """Least squares of the spline to v f T/2π sin(2πt/T): what is left is below 0.2 % of it."""
    effect = EFFECTS["speed-fluctuation"]
    names = [p.name for p in effect.per_run(SETTING)]
    columns = np.column_stack(
        [effect.travel({n: 1.0}, SETTING, TIME, 4.0 * TIME, 4.0)[0][RECORD, 0] for n in names]
    )
    gain = np.sin(2 * np.pi * TIME[RECORD] / period)
    left = gain - columns @ np.linalg.lstsq(columns, gain, rcond=None)[0]
    assert np.sqrt(np.mean(left**2)) < 2e-3 * np.sqrt(np.mean(gain**2))


def test_speed_fluctuation_summary_is_the_wander_over_the_speed():
    effect = EFFECTS["speed-fluctuation"]
    theta = drawn(effect, 5)
    _, rate = effect.travel(theta, SETTING, TIME, 4.0 * TIME, 4.0)
    wander = rate[RECORD, 0] - rate[RECORD, 0].mean()
    summary = effect.summary([OwnValues(SETTING, theta)])
    assert summary["rms_fraction"] == pytest.approx(np.std(wander) / 4.0, rel=0.02)
    assert summary["peak_fraction"] == pytest.approx(np.abs(wander).max() / 4.0, rel=0.02)


class Washboard:
    """A left and a right axle over a sine of wavelength 0.6 m; the model drives at constant speed,
    the record is ahead of it by `gain` (of either side)."""

    channels = tuple(c for c in CHANNELS if c.name in ("A1", "A2"))

    def __init__(self, gain, noise, right=None):
        self.time = np.arange(1024) / 100.0
        rng = np.random.default_rng(3)
        ahead = [gain(self.time), (right or gain)(self.time)]
        self._record = self._wave(4.0 * self.time[:, None] + np.column_stack(ahead))
        self._record += noise * rng.normal(size=self._record.shape)

    def _wave(self, x):
        left, right = np.broadcast_to(x, (len(x), 2)).T
        return np.column_stack(
            [np.sin(2 * np.pi * left / 0.6), 0.5 * np.cos(2 * np.pi * (right - 0.1) / 0.6)]
        )

    def time_s(self, run_id):
        return self.time

    def measured(self, run_id):
        return self._record

    def modelled(self, run_id, changes):
        return self._wave(4.0 * self.time[:, None] + changes.get("start_m", 0.0))

    def all_modelled(self, run_id, trials):
        return [self.modelled(run_id, changes) for changes in trials]

    def placed(self, run_id, channels):
        return {}


@pytest.mark.parametrize(("fraction", "period"), [(0.04, 4.0), (0.03, 2.5), (0.05, 6.0)])
def test_speed_fluctuation_begins_near_the_wander_of_a_record(fraction, period):
    """Within a tenth of the wavelength, also where the phase turns by more than a radian."""
    size = 4.0 * fraction * period / (2 * np.pi)

    def gain(t):
        return size * np.sin(2 * np.pi * t / period + 0.7)

    effect, probe = EFFECTS["speed-fluctuation"], Washboard(gain, 0.05)
    theta = effect.run_starts(probe, SETTING, {})[0]
    found, _ = effect.travel(theta, SETTING, probe.time, 4.0 * probe.time, 4.0)
    inside = (probe.time > 0.5) & (probe.time < 9.5)
    error = (found[:, 0] - gain(probe.time))[inside]
    assert np.sqrt(np.mean(error**2)) < 0.06


def test_left_right_drift_begins_near_the_lead_of_the_left_side():
    """A serpentine, the sides half a wavelength apart at its turns, on top of a wandering speed."""

    def wander(t):
        return 0.06 * np.sin(2 * np.pi * t / 5.0 + 0.4)

    def lead(t):
        return 0.3 * np.sin(2 * np.pi * t / 6.0)

    probe = Washboard(lambda t: wander(t) + lead(t) / 2, 0.05, lambda t: wander(t) - lead(t) / 2)
    effect = EFFECTS["left-right-drift"]
    for form in effect.choices(probe.channels):
        drift = effect.with_choice(form)
        theta = drift.run_starts(probe, SETTING, {})[0]
        found, _ = drift.travel(theta, SETTING, probe.time, 4.0 * probe.time, 4.0)
        inside = (probe.time > 0.5) & (probe.time < 9.5)
        error = (found[:, 0] - found[:, 1] - lead(probe.time))[inside]
        assert np.sqrt(np.mean(error**2)) < 0.06


@pytest.mark.parametrize("name", ["speed-fluctuation", "left-right-drift"])
def test_the_fast_form_follows_a_driver_who_brakes_and_swerves(name):
    """A history of 0.9 s period, which the slow form cannot follow."""
    gain, left = np.sin(2 * np.pi * TIME[RECORD] / 0.9), {}
    for form in ("slow", "fast"):
        effect = EFFECTS[name].with_choice(form)
        names = [p.name for p in effect.per_run(SETTING)]
        ways = [effect.travel({n: 1.0}, SETTING, TIME, 4.0 * TIME, 4.0)[0] for n in names]
        columns = np.column_stack([way[RECORD, 0] for way in ways])
        rest = gain - columns @ np.linalg.lstsq(columns, gain, rcond=None)[0]
        left[form] = np.sqrt(np.mean(rest**2) / np.mean(gain**2))
    assert left["fast"] < 5e-3
    assert left["slow"] > 0.05


@given(st.integers(0, 10**6))
def test_left_right_drift_leaves_the_mean_of_the_sides(seed):
    """Front and rear of a side alike; the run's own speed and start are those of the middle."""
    effect = EFFECTS["left-right-drift"]
    theta = drawn(effect, seed)
    distance, _ = effect.travel(theta, SETTING, TIME, 4.0 * TIME, 4.0)
    np.testing.assert_array_equal(distance[:, :2], distance[:, 2:])
    np.testing.assert_allclose(distance[:, 0] + distance[:, 1], 0.0, atol=1e-12)
    lead = distance[:, 0] - distance[:, 1]
    gained = abs(lead[-1] - lead[RECORD][0]) / (4.0 * 10.3)
    assert effect.summary([OwnValues(SETTING, theta)])["relative_rate"] == pytest.approx(gained)


@pytest.mark.parametrize("wander", [0.0, 0.03])
def test_left_right_drift_follows_a_steady_and_a_slowly_wandering_lead(wander):
    """1 % of the way and a sine of 8 s period: a hundredth of a wavelength is left at most."""
    effect = EFFECTS["left-right-drift"]
    theta = {p.name: p.start for p in effect.parameters_for(ATV, CHANNELS)}
    names = [p.name for p in effect.per_run(SETTING)]
    columns = []
    for name in names:
        distance, _ = effect.travel(theta | {name: 1.0}, SETTING, TIME, 4.0 * TIME, 4.0)
        columns.append((distance[:, 0] - distance[:, 1])[RECORD])
    time = TIME[RECORD]
    lead = 0.01 * 4.0 * time + wander * np.sin(2 * np.pi * time / 8.0 + 1.0)
    basis = np.column_stack(columns)
    left = lead - basis @ np.linalg.lstsq(basis, lead, rcond=None)[0]
    assert np.abs(left).max() < 0.004
