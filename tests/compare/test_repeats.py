"""Noise from motion that is imposed again, and from the steps in which values come."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.component import rig
from tests.component.cases import CASES, DAMPER
from wheelhop.campaign import read_campaign
from wheelhop.compare import InBand, noise_floor
from wheelhop.compare.floor import QUIETEST, REPEATED, STEPS
from wheelhop.compare.quantisation import quantisation_rms, step_of
from wheelhop.compare.records import in_band
from wheelhop.compare.repeats import period_of, scatter
from wheelhop.simulate import Response

RATE_HZ, BAND_HZ = 512.0, (0.4, 60.0)
TIME_S = np.arange(8192) / RATE_HZ


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    folder = tmp_path_factory.mktemp("repeats") / "c"
    return read_campaign(rig.make_campaign(folder, "displacement", DAMPER, seed=1, noise=0.01))


def recorded(campaign, motions, sigma, *, law=lambda x, v: 2e4 * x + 400.0 * np.tanh(v / 0.01)):
    """The campaign with such motions, the force of a law along each, and white noise on it."""
    rng = np.random.default_rng(3)
    runs = []
    for i, x in enumerate(motions):
        time_s = TIME_S[: len(x)]
        force = law(x, np.gradient(x, time_s)) + rng.normal(0.0, sigma, len(x))
        shown = {"time_s": time_s, "displacement": x, "force": force, "record": force[:, None]}
        runs.append(replace(campaign.runs[0], id=f"run-{i}", **shown))
    return replace(
        campaign, sample_rate_hz=RATE_HZ, band_hz=BAND_HZ, noise_rms=None, runs=tuple(runs)
    )


def found(campaign):
    return scatter(campaign.runs, campaign.sample_rate_hz, campaign.band_hz)


def in_band_of(sigma):
    """Of white noise: the share of the frequencies in band."""
    return sigma * np.sqrt((BAND_HZ[1] - BAND_HZ[0]) / (RATE_HZ / 2))


def floor_of(campaign):
    unknown = [Response(r.id, np.zeros_like(r.record), None) for r in campaign.runs]
    return noise_floor(campaign, in_band(campaign, unknown))


@pytest.mark.parametrize("frequency_hz", [0.5, 1.37, 2.0])
def test_periods_of_a_sine_show_the_noise_under_friction(campaign, frequency_hz):
    """Friction fills the band with harmonics, so that no part of it is quiet. Of periods that are
    no whole number of samples a sixteenth of one is left, over which it jumps a little."""
    sine = 0.02 * np.sin(2 * np.pi * frequency_hz * TIME_S)
    noisy = recorded(campaign, [sine], sigma=3.0)
    assert found(noisy).noise_rms == pytest.approx(in_band_of(3.0), rel=0.15)
    assert found(noisy).uncertainty < 0.1
    floor = floor_of(noisy)
    assert (floor.basis, floor.source) == (REPEATED, "estimated")
    assert floor.pooled_rms == found(noisy).noise_rms


@pytest.mark.parametrize("later", [0, 3, 0.4])
def test_runs_that_impose_the_same_motion_show_the_noise(campaign, later):
    """Each a single cycle, cut a few samples, or a part of one, later."""
    rng = np.random.default_rng(5)
    frequency, phase = rng.uniform(0.3, 3.0, 9), rng.uniform(0.0, 6.0, 9)
    time_s = TIME_S[:3000]
    motions = [
        0.01 * np.sin(2 * np.pi * np.outer(time_s + shift / RATE_HZ, frequency) + phase).sum(axis=1)
        for shift in (0.0, later)
    ]
    noisy = recorded(campaign, motions, sigma=3.0, law=lambda x, v: 2e4 * x + 1e3 * v)
    assert found(noisy).noise_rms == pytest.approx(in_band_of(3.0), rel=0.12)
    assert found(noisy).runs == 2


def test_what_happened_once_is_not_the_noise_of_the_rest(campaign):
    sine = 0.02 * np.sin(2 * np.pi * TIME_S)
    noisy = recorded(campaign, [sine], sigma=3.0)
    (run,) = noisy.runs
    knocked = run.force + 400.0 * np.exp(-(((TIME_S - 4.3) / 0.02) ** 2))
    runs = (replace(run, force=knocked, record=knocked[:, None]),)
    assert found(replace(noisy, runs=runs)).noise_rms == pytest.approx(in_band_of(3.0), rel=0.15)


def test_motion_that_does_not_repeat_says_nothing(campaign):
    """Random motion; a sweep; one that repeats to a tenth; a force that repeats better than what
    moves it, as under a servo."""
    rng = np.random.default_rng(2)
    noise = np.cumsum(rng.normal(size=len(TIME_S)))
    sweep = np.sin(2 * np.pi * (0.3 + 0.1 * TIME_S) * TIME_S)
    sine = np.sin(2 * np.pi * TIME_S)
    worse = sine * (1.0 + 0.1 * np.sin(2 * np.pi * 0.083 * TIME_S))
    for motion in (noise, sweep, worse, sine + rng.normal(0.0, 0.01, len(TIME_S))):
        assert found(recorded(campaign, [0.02 * motion], sigma=0.01, law=lambda x, v: 2e4 * x)) is (
            None
        )


def test_the_quietest_of_few_runs_are_no_quieter_than_their_noise(campaign):
    """White noise of one channel in three runs that never repeat, and nothing else: of twelve parts
    the quietest alone is a quarter below it."""
    rng, ratios = np.random.default_rng(5), []
    for _ in range(8):
        still = recorded(campaign, [rng.normal(0.0, 0.01, 1280) for _ in range(3)], sigma=0.0)
        runs = [replace(run, record=rng.normal(0.0, 3.0, (1280, 1))) for run in still.runs]
        floor = floor_of(replace(still, runs=tuple(runs)))
        assert floor.basis == QUIETEST
        ratios.append(floor.noise_rms[0] / in_band_of(3.0))
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.05)


def test_a_vehicle_is_asked_for_no_repeats(bench):
    made, _ = bench.campaign([2.0, 2.0], lambda t, v: bench.noise(0.1), noise=None)
    assert found(made) is None
    assert floor_of(made).basis == QUIETEST


@given(st.floats(60.0, 900.0), st.floats(0.0, 6.0))
def test_a_period_is_found_to_a_hundredth_of_a_sample(period, phase):
    sample = np.arange(4096)
    wave = np.sin(2 * np.pi * sample / period + phase) + 0.4 * np.sin(6 * np.pi * sample / period)
    assert period_of(wave - wave.mean()) == pytest.approx(period, abs=0.02 + 1e-4 * period)


@pytest.mark.parametrize("step_m", [0.002, 1e-4, 1e-5])
@pytest.mark.parametrize("frequency_hz", [0.3, 3.0, 9.0])
@pytest.mark.parametrize("size_m", [0.005, 0.05])
def test_steps_of_the_values_are_noise(step_m, frequency_hz, size_m):
    """Against what rounding really does in band to a signal of two waves."""
    wave = np.sin(2 * np.pi * frequency_hz * TIME_S + 1.0)
    wave += 0.3 * np.sin(2 * np.pi * 1.37 * frequency_hz * TIME_S)
    true, band = size_m * wave, InBand(len(TIME_S), RATE_HZ, BAND_HZ)
    shown = step_m * np.round(true / step_m)
    made = np.sqrt(np.mean(band.signal(shown - true) ** 2))
    assert step_of(shown) == pytest.approx(step_m, rel=1e-6)
    assert 0.9 * made < quantisation_rms(shown, band) < 1.5 * made


@given(st.integers(0, 10_000), st.floats(1e-3, 1e3), st.floats(-1e3, 1e3))
def test_only_values_on_a_grid_have_a_step(seed, step, offset):
    rng = np.random.default_rng(seed)
    levels = rng.integers(-500, 500, 300)
    levels[:2] = 0, 1
    assert step_of(offset + step * levels) == pytest.approx(step, rel=1e-6)
    assert step_of(rng.normal(size=300)) == 0.0
    assert step_of(np.full(300, offset)) == 0.0


def test_no_floor_is_below_the_steps_of_a_display(campaign):
    """2 mm steps of a displacement under a force: between them nothing changes, and the quietest
    parts hold nothing."""
    wave = 0.02 * np.sin(2 * np.pi * 0.35 * TIME_S) + 0.01 * np.sin(2 * np.pi * 0.77 * TIME_S)
    shown = 0.002 * np.round(wave / 0.002)
    (run,) = recorded(campaign, [wave], sigma=1.0).runs
    run = replace(run, drive="force", displacement=shown, record=shown[:, None])
    stepped = replace(
        campaign,
        sample_rate_hz=RATE_HZ,
        band_hz=BAND_HZ,
        noise_rms=None,
        runs=(run,),
        drive="force",
    )
    floor = floor_of(stepped)
    assert floor.basis == STEPS
    assert 3e-4 < floor.pooled_rms < 0.002 / np.sqrt(12.0)
    assert floor.tolerance >= 0.15


def test_the_floor_of_a_rig_that_repeats_is_what_its_noise_is(campaign, tmp_path):
    """The rig that shares no code, whose sines are faded in."""
    component = CASES["dry-friction"].component("displacement")
    folder = rig.make_campaign(
        tmp_path / "c", "displacement", component, seed=1, noise=0.05, seconds=9.0
    )
    made = read_campaign(folder)
    stated = made.noise_rms
    floor = floor_of(replace(made, noise_rms=None))
    assert floor.pooled_rms == pytest.approx(stated, rel=0.15)
