"""A speed that a channel shows: the way it makes, and a run that is found again by it."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import (
    ATV,
    CHANNELS,
    campaign_of,
    model_of,
    relative,
    simulated,
)
from tests.truth.effect import Effect
from wheelhop.campaign import TrackSpec
from wheelhop.campaign.driven import Driven
from wheelhop.effects.base import RunSetting
from wheelhop.effects.speed_fluctuation import SpeedFluctuation
from wheelhop.fit import find_start
from wheelhop.fit.parameters import run_parameters, speed_uncertainty
from wheelhop.simulate import RunSimulator

TIME = np.arange(1024) / 100.0
FIRST, GAIN = 3.0, 0.3  # m/s, m/s²: to twice the speed


@dataclass
class Hurrying(Effect):
    """The vehicle gains speed from time 0 on."""

    id = "hurrying"

    def steer(self, drive):
        drive.path += (0.5 * GAIN * np.maximum(drive.time, 0.0) ** 2)[:, None]


def recorded_speed(noise=0.0, **stated):
    rng = np.random.default_rng(1)
    speed = FIRST + GAIN * TIME + noise * rng.normal(size=len(TIME))
    return Driven("gps", TIME, speed, FIRST, **stated)


def hurried(track, start_m, **more):
    """A campaign of one run that gains speed, its noise that of its sensors."""
    run = truth.Run(track, FIRST, start_m, TIME)
    shown = truth.simulate_run(ATV, run, [Hurrying()])[1]
    shown = shown + np.random.default_rng(2).normal(0.0, 0.1, shown.shape)
    return driven_campaign(run, shown, **more)


def driven_campaign(run, record, noise=0.05, **more):
    campaign = campaign_of({"run": run}, {"run": record})
    driven = recorded_speed(noise, **{"uncertainty": 0.01, **more})
    (of_it,) = campaign.runs
    of_it = replace(of_it, driven=driven, speed_m_s=driven.mean_m_s)
    return replace(campaign, runs=(of_it,))


def test_a_speed_that_grows_with_time_makes_half_its_square_of_way():
    """And beyond the record's ends the same way back."""
    found, end = recorded_speed(), float(TIME[-1])
    mean = FIRST + GAIN * end / 2
    assert found.mean_m_s == pytest.approx(mean)
    time = np.array([0.0, 2.5, end])
    way = FIRST * time + GAIN * time**2 / 2
    np.testing.assert_allclose(found.gone(time) * mean, way, atol=1e-4)
    np.testing.assert_allclose(found.faster(time) * mean, FIRST + GAIN * time, rtol=1e-9)
    np.testing.assert_allclose(found.gone(-time), -found.gone(time), atol=1e-12)
    np.testing.assert_allclose(found.gone(end + time), 2 * end - found.gone(end - time), atol=1e-9)
    np.testing.assert_allclose(found.gone(-2.2 * end), -2 * end - found.gone(0.2 * end), atol=1e-9)


def test_the_model_drives_as_the_channel_shows():
    track = truth.Track("sine-sweep", {"amplitude_mm": 12.0, "pitch_start_mm": 2500.0,
                                       "pitch_end_mm": 400.0, "length_mm": 60000.0})  # fmt: skip
    run = truth.Run(track, FIRST, 2.0, TIME)
    shown = truth.simulate_run(ATV, run, [Hurrying()])[1]
    campaign = driven_campaign(run, shown, noise=0.0)
    model = model_of(ATV, {"run": replace(run, speed_m_s=campaign.runs[0].speed_m_s)})
    late = slice(200, None)
    found = simulated(campaign, model)["run"]
    assert relative(found[late], shown[late]) < 0.01
    blind = replace(campaign, runs=(replace(campaign.runs[0], driven=None),))
    assert relative(simulated(blind, model)["run"][late], shown[late]) > 0.5


PLACES = {
    "washboard": ({"amplitude_mm": 15.0, "pitch_mm": 1500.0}, 2.3),
    "half-sine-bump": ({"amplitude_mm": 60.0, "length_mm": 500.0, "side": "both"}, -30.0),
}


@pytest.mark.parametrize("kind", PLACES)
def test_a_run_that_gains_speed_is_placed(kind):
    """A washboard modulo its pitch, a bump where it was met: a speed that is a little more begins a
    little further away."""
    keys, start_m = PLACES[kind]
    track = truth.Track(kind, keys)
    campaign = hurried(track, start_m)
    model = model_of(ATV, {})
    system = model.system(CHANNELS, "road")
    (run,) = campaign.runs
    found = find_start(campaign, run, model, system)
    met = TIME[np.argmin(np.abs(start_m + FIRST * TIME + GAIN * TIME**2 / 2))]
    apart = found["start_m"] + found["speed_m_s"] * float(run.driven.gone(met))
    if kind == "washboard":
        apart -= start_m + FIRST * met + GAIN * met**2 / 2
        apart -= track.metres("pitch") * np.rint(apart / track.metres("pitch"))
    assert apart == pytest.approx(0.0, abs=0.1)
    assert found["speed_m_s"] == pytest.approx(FIRST + GAIN * TIME[-1] / 2, rel=0.01)


def test_a_start_that_is_stated_says_which_of_the_waves_it_is():
    """The phase is the record's."""
    keys, start_m = PLACES["washboard"]
    campaign = hurried(truth.Track("washboard", keys), start_m + 4 * 1.5)
    model = model_of(ATV, {})
    (run,) = campaign.runs
    stated = replace(run, start_m=(start_m + 4 * 1.5 + 0.5, 0.6))
    found = find_start(campaign, stated, model, model.system(CHANNELS, "road"))
    assert found["start_m"] == pytest.approx(start_m + 4 * 1.5, abs=0.15)


def test_a_start_that_is_known_to_centimetres_is_kept_where_the_record_says_another():
    run = truth.Run(truth.Track("flat"), 4.0, 0.0, TIME)
    campaign = campaign_of({"run": run}, {"run": np.zeros((len(TIME), 8))})
    sine = {"amplitude_m": 0.02, "pitch_start_m": 1.0, "pitch_end_m": 1.0, "length_m": 30.0}
    (of_it,) = campaign.runs
    of_it = replace(of_it, track=TrackSpec("sine-sweep", sine))
    campaign = replace(campaign, runs=(of_it,))
    there = {"run": {"speed_m_s": 4.0, "start_m": -20.0}}
    model = replace(model_of(ATV, {}), runs=there)
    record = simulated(campaign, model)["run"]
    for start, expected in ((None, -20.0), ((-24.0, 1.0), -20.0), ((-24.0, 0.02), -24.0)):
        stated = replace(of_it, record=record, start_m=start)
        found = find_start(campaign, stated, model_of(ATV, {}), model.system(CHANNELS, "road"))
        assert found["start_m"] == pytest.approx(expected, abs=0.3)


def test_what_is_stated_is_believed_in_the_fit():
    track = truth.Track("washboard", PLACES["washboard"][0])
    run = truth.Run(track, FIRST, 0.0, TIME)
    campaign = driven_campaign(run, np.zeros((len(TIME), 8)))
    (of_it,) = campaign.runs
    of_it = replace(of_it, start_m=(7.0, 0.5))
    setting = RunSimulator(replace(campaign, runs=(of_it,)), of_it, 1.0).setting
    speed, start = run_parameters(of_it, setting, model_of(ATV, {}))
    assert (speed.mean, speed.sigma) == (of_it.speed_m_s, 0.01 * of_it.speed_m_s)
    assert (start.mean, start.sigma) == (7.0, 0.5)
    assert speed_uncertainty(replace(of_it, driven=None)) == 0.06


@pytest.mark.parametrize(("noise", "wander"), [(0.02, 0.02), (0.0, 0.04 * 4.0), (0.9, 0.04 * 4.0)])
def test_of_a_speed_that_is_recorded_its_noise_is_left_to_fluctuate(noise, wander):
    """And no more than of one that a hand held: 4 %, which over 5 s is a way of 5 s / 2π of it."""
    setting = RunSetting("run", 4.0, -4.0, 0.0, 10.0, True, driven=recorded_speed(noise_rms=noise))
    (scale,) = {p.scale for p in SpeedFluctuation().per_run(setting)}
    assert scale == pytest.approx(wander * 5.0 / (2 * np.pi))
