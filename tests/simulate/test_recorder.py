"""What the recorder's filter makes of a run, against a digital filter at ten times the rate."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import optimize, signal

from tests import truth
from tests.simulate.setup import ATV, CHANNELS, TIME, campaign_of, model_of, relative, simulated
from wheelhop.campaign.low_pass import LowPass
from wheelhop.effects import beliefs, load_effects
from wheelhop.effects.beliefs import FILTER_ORDERS, RecorderFilter
from wheelhop.simulate import RunSimulator
from wheelhop.simulate.sensors import as_read, as_recorded
from wheelhop.vehicle import Vehicle

TRACK = truth.Track("washboard", {"amplitude_mm": 15.0, "pitch_mm": 400.0})
RUN = {"run": truth.Run(TRACK, 5.0, 20.0, TIME, averaging_s=0.0)}
ORDER, CORNER_HZ = 4, 40.0
FILTERED = replace(campaign_of(RUN), low_pass=LowPass("butterworth", ORDER, CORNER_HZ))


def filtered_finely(campaign, model, times=20):
    """The same run sampled so many times as often, through scipy's digital filter, thinned out."""
    fine = replace(campaign.runs[0], time_s=np.arange(len(TIME) * times) / (100.0 * times))
    finely = replace(campaign, sample_rate_hz=100.0 * times, runs=(fine,), low_pass=None)
    record = simulated(finely, model)["run"]
    sections = signal.butter(ORDER, CORNER_HZ, fs=100.0 * times, output="sos")
    return signal.sosfilt(sections, record, axis=0)[::times][: len(TIME)]


@pytest.mark.parametrize("effect", ["", "dry-friction"])
def test_a_filter_acts_before_samples_are_taken(effect):
    theta = {"front_N": 60.0, "rear_N": 60.0, "presliding_N_m": 2e5} if effect else None
    model = model_of(ATV, RUN, effect, theta)
    found, expected = simulated(FILTERED, model)["run"], filtered_finely(FILTERED, model)
    later = slice(50, None)  # the digital filter begins at rest
    assert relative(found[later], expected[later]) < 3e-3
    assert relative(simulated(campaign_of(RUN), model)["run"][later], expected[later]) > 0.3


def test_a_channel_of_its_own_filter_is_filtered_alone():
    model, campaign = model_of(ATV, RUN), campaign_of(RUN)
    own = replace(campaign.channels[0], low_pass=FILTERED.low_pass)
    alone = replace(campaign, channels=(own, *campaign.channels[1:]))
    found = simulated(alone, model)["run"]
    np.testing.assert_allclose(found[:, 0], simulated(FILTERED, model)["run"][:, 0], atol=1e-9)
    np.testing.assert_allclose(found[:, 1:], simulated(campaign, model)["run"][:, 1:], atol=1e-3)
    but = replace(FILTERED, channels=(replace(own, low_pass=LowPass("none")), *alone.channels[1:]))
    found = simulated(but, model)["run"]
    np.testing.assert_allclose(found[:, 0], simulated(campaign, model)["run"][:, 0], atol=1e-3)
    back = as_read(as_recorded(found, 200.0, alone, ATV), 200.0, alone, ATV)
    np.testing.assert_allclose(back[100:-100, 1:], found[100:-100, 1:], atol=1e-9)


def test_what_the_recorder_did_is_undone():
    """Up to half the corner, and but for the ends, where nobody knows how it went on."""
    rng, rate_hz = np.random.default_rng(4), 200.0
    sections = signal.butter(6, 20.0, fs=rate_hz, output="sos")
    readings = signal.sosfiltfilt(sections, rng.normal(size=(2000, len(CHANNELS))), axis=0)
    there = as_recorded(readings, rate_hz, FILTERED, ATV)
    back = as_read(there, rate_hz, FILTERED, ATV)
    inside = slice(100, -100)
    assert np.abs(there - readings)[inside].max() > 0.5 * readings.std()
    np.testing.assert_allclose(back[inside], readings[inside], atol=5e-3 * readings.std())


@pytest.mark.parametrize(("gain", "restored"), [(0.15, 1.0), (0.07, 0.49)])
def test_what_the_filter_has_taken_is_not_made_up(gain, restored):
    """A tenth of a sine is enough to undo the filter; of what it left less of, noise would grow."""
    frequency, rate_hz = CORNER_HZ * (gain**-2 - 1.0) ** (0.5 / ORDER), 1000.0
    sine = np.sin(2 * np.pi * frequency * np.arange(4000) / rate_hz)
    readings = np.repeat(sine[:, None], len(CHANNELS), axis=1)
    back = as_read(as_recorded(readings, rate_hz, FILTERED, ATV), rate_hz, FILTERED, ATV)
    assert back[1000:3000].std() / sine.std() == pytest.approx(restored, abs=0.02)


@pytest.mark.parametrize("order", [1, 2, 4, 5, 6, 8, 10])
def test_a_filter_of_any_order_is_followed_by_one_that_is_tried(order):
    highest_hz = 30.0
    frequency = np.linspace(0.5, highest_hz, 100)
    true = LowPass("butterworth", order, 1.5 * highest_hz).response(frequency)

    def left(numbers, tried):
        corner, delay = abs(numbers[0]), 1e-3 * numbers[1]
        found = LowPass("butterworth", tried, corner, delay_s=delay).response(frequency)
        return np.mean(np.abs(found - true) ** 2)

    begun = [(tried, factor) for tried in FILTER_ORDERS for factor in (0.7, 1.0, 1.4)]
    ends = [
        optimize.minimize(left, [1.5 * highest_hz * factor, 0.0], (tried,), "Nelder-Mead").fun
        for tried, factor in begun
    ]
    assert np.sqrt(min(ends)) < 0.004


def test_measured_axles_drive_the_body_as_they_moved():
    """Axles and body are recorded through one filter: with the filter stated, the axles' motion
    and so the body's is that of a recorder without."""
    model = model_of(ATV, RUN)
    there, seen = (simulated(c, model)["run"] for c in (campaign_of(RUN), FILTERED))
    moved = {}
    for campaign, record in ((campaign_of(RUN), there), (FILTERED, seen)):
        run = replace(campaign.runs[0], record=record, track=truth_unknown(campaign))
        simulator = RunSimulator(replace(campaign, runs=(run,)), run, 0.0)
        own = replace(model, runs={})
        moved[campaign.low_pass is None] = simulator.record(
            own, own.system(campaign.channels, "axles")
        )
    body = [i for i, c in enumerate(CHANNELS) if not c.is_axle]
    inside = slice(100, -100)
    assert relative(moved[False][inside][:, body], seen[inside][:, body]) < 0.05
    assert relative(moved[True][inside][:, body], seen[inside][:, body]) > 0.3


def truth_unknown(campaign):
    return replace(campaign.runs[0].track, kind="unknown", values={})


def test_the_belief_is_the_filter():
    """What the hypothesis makes of a record is what the same filter makes of it when stated; none
    at 0 s; it is offered where neither filter nor means are stated."""
    effect = RecorderFilter(30.0, ORDER)
    model = replace(
        model_of(ATV, RUN),
        effects=(effect,),
        values={**ATV, f"{effect.id}.time_s": 1.0 / (2 * np.pi * CORNER_HZ)},
    )
    found = simulated(campaign_of(RUN), model)["run"]
    np.testing.assert_allclose(found, simulated(FILTERED, model_of(ATV, RUN))["run"], atol=1e-9)
    none = model.with_values({f"{effect.id}.time_s": 0.0})
    np.testing.assert_allclose(
        simulated(campaign_of(RUN), none)["run"],
        simulated(campaign_of(RUN), model_of(ATV, RUN))["run"],
        atol=1e-6,
    )
    assert "order = 4, corner_hz = 40" in effect.remedy(model.theta(effect))
    vehicle = Vehicle("atv", ATV, {})
    averaged = {"run": replace(RUN["run"], averaging_s=0.0066)}
    offered = [
        effect.id in beliefs(campaign, vehicle)
        for campaign in (campaign_of(RUN), FILTERED, campaign_of(averaged))
    ]
    assert offered == [True, False, False]
    assert effect.id not in load_effects()
