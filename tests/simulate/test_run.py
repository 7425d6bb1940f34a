"""One run: time domain against the frequency domain, and measured axles that drive the body."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests import truth
from tests.simulate.setup import (
    ATV,
    CHANNELS,
    TIME,
    campaign_of,
    linear_response,
    model_of,
    relative,
    simulated,
)
from wheelhop.campaign import CampaignError, Channel, TrackSpec
from wheelhop.effects import Effect
from wheelhop.fit import Workshop, fit
from wheelhop.simulate import RunSimulator
from wheelhop.track import make_track, wheel_envelope
from wheelhop.vehicle import CORNERS

HERRINGBONE = truth.Track("herringbone", {"amplitude_mm": 20.0, "pitch_mm": 800.0})
WASHBOARD = truth.Track("washboard", {"amplitude_mm": 15.0, "pitch_mm": 400.0})
STEEP = truth.Track("washboard", {"amplitude_mm": 40.0, "pitch_mm": 600.0})


@pytest.mark.parametrize(
    "track", [HERRINGBONE, WASHBOARD, STEEP], ids=["smooth", "with kinks", "with sharp kinks"]
)
def test_steady_state_is_that_of_the_fourier_series(track):
    """Over one wavelength the road repeats: its envelope's discrete Fourier transform times the
    frequency response is the steady state. Averaging is multiplication by sinc."""
    pitch, samples, window = track.metres("pitch"), 4000, 0.0066
    run = truth.Run(track, pitch / 0.16, 20.0, TIME, averaging_s=window)  # 16 samples per wave
    campaign = campaign_of({"run": run})
    model = model_of(ATV, {"run": run})
    found = simulated(campaign, model, run_up_s=6.0)["run"]

    spec = make_track(campaign.runs[0].track)
    x = run.start_m + run.speed_m_s * 0.16 * np.arange(samples) / samples
    height = np.empty((samples, 4))
    for i in CORNERS:
        behind = 0.0 if i < 2 else ATV["geometry.wheelbase_m"]
        side = ATV["geometry.track_width_m"] / 2 * (1 if i % 2 == 0 else -1)
        envelope = wheel_envelope(spec, side, 0.279, (x - behind).min(), (x - behind).max())
        height[:, i] = envelope.height(x - behind)
    exact = linear_response(model.system(CHANNELS, "road"), height, 0.16 / samples)
    spectrum = np.fft.rfft(exact, axis=0)
    spectrum *= np.sinc(np.fft.rfftfreq(samples, 0.16 / samples) * window)[:, None]
    wave = np.fft.irfft(spectrum, samples, axis=0)[:: samples // 16]
    expected = np.tile(wave, (len(TIME) // 16, 1))
    assert relative(found, expected) < 1e-3


def test_a_longer_run_up_changes_nothing():
    run = {"run": truth.Run(WASHBOARD, 2.5, 20.0, TIME)}
    campaign, model = campaign_of(run), model_of(ATV, run)
    short, long = (simulated(campaign, model, run_up_s=s)["run"] for s in (4.0, 8.0))
    assert relative(short, long) < 1e-4


@settings(max_examples=10)
@given(st.floats(1.0, 6.0), st.floats(10.0, 50.0), st.integers(1, 20))
def test_starting_later_is_starting_further_on(speed, start, later):
    """Shifting the start by the way of some samples shifts the record by these samples."""
    here = {"run": truth.Run(HERRINGBONE, speed, start, TIME[:200])}
    there = {"run": truth.Run(HERRINGBONE, speed, start + speed * later / 100.0, TIME[:200])}
    one, other = (
        simulated(campaign_of(r), model_of(ATV, r), run_up_s=6.0)["run"] for r in (here, there)
    )
    size = np.abs(one).max()
    np.testing.assert_allclose(other[:-later], one[later:], atol=1e-4 * size)


def test_a_loose_sensor_rings_from_before_the_record():
    """A second after the record began its mount has not forgotten what came before; a record that
    begins only then shows the same."""
    early, later = TIME[:300], TIME[100:300]
    theta = {"loose": 1.0, "freq_hz": 24.0, "zeta": 0.01}
    found = []
    for time in (early, later):
        run = {"run": truth.Run(HERRINGBONE, 6.0, 30.0, time)}
        model = model_of(ATV, run, "sensor-mount", theta, choice="B2")
        found.append(simulated(campaign_of(run), model, run_up_s=6.0)["run"])
    size = np.abs(found[1]).max()
    np.testing.assert_allclose(found[1], found[0][100:], atol=2e-4 * size)


def test_models_simulated_together_do_what_each_does_alone():
    """Vehicles, starts, a law, a history of force and a sensor's fault, in one go."""
    run = {"run": truth.Run(WASHBOARD, 4.0, 30.0, TIME)}
    campaign, model = campaign_of(run), model_of(ATV, run)
    history = {"coefficient_3_m_s2": 1.0, "coefficient_4_m_s2": -2.0}
    friction = {"front_N": 60.0, "rear_N": 40.0, "presliding_N_m": 5e5}
    models = [
        model,
        *(model.with_values({"body.mass_kg": 200.0 + 10.0 * i}) for i in range(9)),
        *(model.with_run("run", {"start_m": 30.0 + 0.1 * i}) for i in range(3)),
        model_of(ATV, run, "dry-friction", friction),
        model_of(ATV, run, "cornering-roll", own=history),
        model_of(ATV, run, "cornering-roll", own={k: 2.0 * v for k, v in history.items()}),
        model_of(ATV, run, "sensor-gain", {"error": 0.1}, choice="B2"),
        model_of(ATV, run, "sensor-gain", {"error": 0.2}, choice="B2"),
    ]
    trials = [(m, m.system(CHANNELS, "road")) for m in models]
    together = RunSimulator(campaign, campaign.runs[0], 4.0).records(trials)
    for trial, found in zip(trials, together, strict=True):
        alone = RunSimulator(campaign, campaign.runs[0], 4.0).record(*trial)
        assert relative(found, alone) < 1e-6


def test_hundreds_of_places_need_the_memory_of_some():
    """Where a run may have begun is tried at hundreds of places at once, each of which moves the
    wheels another way."""
    run = {"run": truth.Run(WASHBOARD, 4.0, 30.0, TIME)}
    campaign, model = campaign_of(run), model_of(ATV, run)
    system = model.system(CHANNELS, "road")
    peaks = []
    for count in (1, 40, 280):  # what the first imports and compiles does not count
        places = [model.with_run("run", {"start_m": 30.0 + 0.01 * i}) for i in range(count)]
        simulator = RunSimulator(campaign, campaign.runs[0], 4.0)
        tracemalloc.start()
        try:
            records = simulator.records([(place, system) for place in places])
            kept, peak = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
        assert len(records) == count
        peaks.append(peak - kept)
    assert peaks[2] < 2.0 * peaks[1]


def test_any_channels_in_any_order():
    run = {"run": truth.Run(HERRINGBONE, 4.0, 30.0, TIME)}
    model = model_of(ATV, run)
    full = simulated(campaign_of(run), model)["run"]
    chosen = (
        Channel("rear", "A4"),
        Channel("dash", "body-xy", 0.3, 0.1),
        Channel("left", "B1"),
    )
    found = simulated(campaign_of(run, channels=chosen), model)["run"]
    np.testing.assert_allclose(found[:, [0, 2]], full[:, [7, 0]], rtol=1e-9, atol=1e-9)
    # A rigid body: the dash lies on the plane through the corners.
    ahead, width = ATV["geometry.cg_to_front_axle_m"], ATV["geometry.track_width_m"]
    along = (full[:, 0] - full[:, 2]) / ATV["geometry.wheelbase_m"]
    across = (full[:, 0] - full[:, 1]) / width
    expected = full[:, 0] + along * (0.3 - ahead) + across * (0.1 - width / 2)
    np.testing.assert_allclose(found[:, 1], expected, atol=1e-9)


@pytest.mark.parametrize(
    ("track", "reached"), [(HERRINGBONE, 0.002), (WASHBOARD, 0.04)], ids=["smooth", "with kinks"]
)
def test_measured_axles_move_the_body_as_the_road_did(track, reached):
    """Axle accelerations of MuJoCo's car, twice integrated and imposed, give its body channels.

    Where the wheel rests on two points the axle is jerked; what lies beyond half the sample rate
    is folded into the band, and 3 % is as well as measured axles know the road. The run says so:
    what is left is about as large as each datum's doubt, not as the sensors' noise.
    """
    run = truth.Run(track, 3.9, 33.0, np.arange(1024) / 100.0)
    _, recorded = truth.simulate_run(ATV, run)
    campaign = campaign_of({"run": run}, {"run": recorded}, noise_rms=0.02)
    unknown = type(campaign.runs[0])(
        **{**vars(campaign.runs[0]), "track": TrackSpec("unknown", {})}
    )
    campaign = type(campaign)(**{**vars(campaign), "runs": (unknown,)})
    model = model_of(ATV, {})
    workshop = Workshop(campaign, model, jobs=1)
    # How the body moved when the record began is all that is free.
    fitted = fit(workshop, model, (), workshop.of_role("fit"))
    (response,) = workshop.responses(fitted.model)
    assert response.position_m is None
    assert np.isnan(response.record[:, 4:]).all()
    assert relative(response.record[:, :4], recorded[:, :4]) < reached
    (bench,), (run_fit,) = workshop.benches.values(), fitted.runs
    left = np.sqrt(np.mean(run_fit.residual**2)) / workshop.noise
    assert left < 1.5
    if track is WASHBOARD:
        assert left > 0.3
        assert np.sqrt(np.mean(bench.undoubted(run_fit.residual) ** 2)) > 5.0 * workshop.noise


def test_measured_axles_move_as_they_did_whatever_the_vehicle():
    """The motion that drives the body follows from the axles' records and scales alone, and is made
    once for all vehicles that are tried."""
    run = truth.Run(WASHBOARD, 3.9, 33.0, TIME)
    record = np.random.default_rng(5).normal(size=(len(TIME), len(CHANNELS)))
    campaign = campaign_of({"run": run}, {"run": record})
    unknown = replace(campaign.runs[0], track=TrackSpec("unknown", {}))
    simulator = RunSimulator(campaign, unknown, 4.0)
    model = model_of(ATV, {})
    system = model.system(CHANNELS, "axles")
    motion = simulator.prescribed(model, system)
    other = {"geometry.wheelbase_m": 1.1, "wheel.front.radius_m": 0.2, "channel.B1.gain": 0.03}
    assert simulator.prescribed(model.with_values(other), system).height is motion.height
    larger = simulator.prescribed(model.with_values({"channel.A2.gain": 0.25}), system)
    np.testing.assert_allclose(larger.height, motion.height / [1.0, 1.25, 1.0, 1.0], atol=1e-12)


class Careless(Effect):
    """Moves the clock that all effects are given."""

    id, title, place = "careless", "careless", "track"

    def travel(self, theta, run, time_s, position_m, speed_m_s):
        time_s += 1.0


def test_an_effect_cannot_move_the_instants_that_others_are_given():
    run = {"run": truth.Run(WASHBOARD, 2.5, 20.0, TIME)}
    model = model_of(ATV, run)
    careless = replace(model, effects=(Careless(),))
    with pytest.raises(ValueError, match="read-only"):
        simulated(campaign_of(run), careless)


STEP = truth.Track("step-bump", {"height_mm": 100.0, "width_mm": 1000.0})


@pytest.mark.parametrize(
    ("key", "far_off"), [("wheel.rear.radius_m", 0.006), ("start_m", 1e10), ("speed_m_s", 1e12)]
)
def test_a_model_that_cannot_roll_is_nowhere(key, far_off):
    """A fit on its way may ask for a wheel lower than the step, or for a start beyond where places
    a micrometre apart are told apart: that costs infinitely much and ends nothing."""
    campaign, model = campaign_of({"run": truth.Run(STEP, 3.0, 20.0, TIME)}), model_of(ATV, {})
    simulator = RunSimulator(campaign, campaign.runs[0], 4.0)
    system = model.system(CHANNELS, "road")
    for start_m in (0.0, -5e8):
        there = model.with_run("run", {"start_m": start_m})
        assert np.isfinite(simulator.record(there, system)).all()
    if key in model.values:
        other = model.with_values({key: far_off})
    else:
        other = model.with_run("run", {key: far_off})
    assert np.isnan(simulator.record(other, system)).all()


def test_a_step_as_high_as_the_nominal_wheel_is_refused():
    wall = truth.Track("step-bump", {"height_mm": 350.0, "width_mm": 1000.0})
    campaign, model = campaign_of({"wall": truth.Run(wall, 3.0, 20.0, TIME)}), model_of(ATV, {})
    simulator = RunSimulator(campaign, campaign.runs[0], 4.0)
    with pytest.raises(CampaignError, match=r'campaign.toml: run "wall": a step of 0.35 m is too'):
        simulator.record(model, model.system(CHANNELS, "road"))
