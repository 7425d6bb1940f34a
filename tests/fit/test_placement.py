"""Speed and start of a run are found from its record, on every kind of track."""

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import ATV, CHANNELS, campaign_of, model_of, simulated
from wheelhop.campaign import TrackSpec
from wheelhop.fit import Workshop, find_start, seek_again
from wheelhop.fit.placement import _likelihood

TIME = np.arange(1024) / 100.0
NOMINAL = 4.0
ACTUAL = {"speed_m_s": 3.83, "start_m": 36.87}
BUMP = {"speed_m_s": 3.83, "start_m": -8.4}  # the bump comes after two seconds

PERIODIC = {
    "washboard": {"amplitude_mm": 15.0, "pitch_mm": 400.0},
    "one-sided-washboard": {"amplitude_mm": 25.0, "pitch_mm": 600.0},
    "herringbone": {"amplitude_mm": 20.0, "pitch_mm": 800.0, "angle_deg": 20.0},
    "chassis-twist": {"amplitude_mm": 150.0, "pitch_mm": 2000.0, "lateral_offset_mm": 100.0},
}
ONCE = {
    "half-sine-bump": {"amplitude_mm": 60.0, "length_mm": 500.0, "side": "both"},
    "half-sine-bump left": {"amplitude_mm": 60.0, "length_mm": 500.0, "side": "left"},
    "step-bump": {"height_mm": 30.0, "width_mm": 400.0, "side": "both"},
    "sine-sweep": {
        "amplitude_mm": 12.0,
        "pitch_start_mm": 2500.0,
        "pitch_end_mm": 400.0,
        "length_mm": 30000.0,
    },
}


def believed(seed):
    """The vehicle as its owner believes it to be: every number some 10 % off."""
    rng = np.random.default_rng(seed)
    return {k: v * (1 + 0.1 * float(np.clip(rng.normal(), -2, 2))) if "geometry" not in k else v
            for k, v in ATV.items()}  # fmt: skip


def noisy(acceleration, seed):
    return acceleration + np.random.default_rng(seed).normal(0.05, 0.1, acceleration.shape)


def found_in(run, recorded, seed):
    campaign = campaign_of({"run": run}, {"run": recorded}, nominal_m_s={"run": NOMINAL})
    model = model_of(believed(seed), {})
    return find_start(campaign, campaign.runs[0], model, model.system(CHANNELS, "road"))


@pytest.mark.parametrize(("kind", "seed"), list(zip(PERIODIC, (1, 2, 1, 2), strict=True)))
def test_on_a_periodic_track(kind, seed):
    """To 1 % of the speed and a tenth of the wavelength, modulo the wavelength."""
    track = truth.Track(kind, PERIODIC[kind])
    run = truth.Run(track, ACTUAL["speed_m_s"], ACTUAL["start_m"], TIME)
    found = found_in(run, noisy(truth.simulate_run(ATV, run)[1], seed), seed)
    pitch = track.metres("pitch")
    assert found["speed_m_s"] == pytest.approx(ACTUAL["speed_m_s"], rel=0.01)
    apart = (found["start_m"] - ACTUAL["start_m"]) / pitch
    assert abs(apart - round(apart)) < 0.1


@pytest.mark.parametrize(("kind", "seed"), list(zip(ONCE, (1, 2, 1, 2), strict=True)))
def test_on_a_track_that_ends(kind, seed):
    track = truth.Track(kind.split()[0], ONCE[kind])
    run = truth.Run(track, BUMP["speed_m_s"], BUMP["start_m"], TIME)
    found = found_in(run, noisy(truth.simulate_run(ATV, run)[1], seed), seed)
    assert found["speed_m_s"] == pytest.approx(BUMP["speed_m_s"], rel=0.01)
    assert found["start_m"] == pytest.approx(BUMP["start_m"], abs=0.05)


@pytest.mark.parametrize("seed", [1])
def test_on_a_random_road(seed):
    """A class B road: there is no wavelength, only the one place where the record fits."""
    flat = {"run": truth.Run(truth.Track("flat"), ACTUAL["speed_m_s"], ACTUAL["start_m"], TIME)}
    campaign = campaign_of(flat)
    road = TrackSpec("iso8608", {"unevenness_m3": 4e-6, "waviness": 2.0, "seed": float(seed)})
    on_road = type(campaign.runs[0])(**{**vars(campaign.runs[0]), "track": road})
    campaign = type(campaign)(**{**vars(campaign), "runs": (on_road,)})
    recorded = noisy(simulated(campaign, model_of(ATV, flat))["run"], seed)
    measured = type(on_road)(**{**vars(on_road), "record": recorded, "speed_m_s": NOMINAL})
    campaign = type(campaign)(**{**vars(campaign), "runs": (measured,)})
    model = model_of(believed(seed), {})
    found = find_start(campaign, measured, model, model.system(CHANNELS, "road"))
    assert found["speed_m_s"] == pytest.approx(ACTUAL["speed_m_s"], rel=0.01)
    assert found["start_m"] == pytest.approx(ACTUAL["start_m"], abs=0.1)


def test_a_standing_vehicle_has_no_start():
    run = truth.Run(truth.Track("flat"), 1.0, 0.0, TIME)
    campaign = campaign_of({"run": run}, nominal_m_s={"run": 0.0})
    model = model_of(ATV, {})
    assert find_start(campaign, campaign.runs[0], model, model.system(CHANNELS, "road")) == {}


SWAPPED = {"effect": "sensor-polarity", "theta": {"wrong": 1.0}, "choice": "A1/B4"}


def lost(track, actual, stated, fault=None):
    """A run's bench, the model that is true but for where and how fast it drove, and what is sought
    for either: first the true one."""
    runs = {"run": truth.Run(track, actual["speed_m_s"], actual["start_m"], TIME)}
    true = model_of(ATV, runs, **(fault or {}))
    clean = simulated(campaign_of(runs), true)
    campaign = campaign_of(runs, clean, nominal_m_s={"run": stated["speed_m_s"]}, noise_rms=0.1)
    workshop = Workshop(campaign, true, jobs=1)
    (bench,) = workshop.benches.values()
    return [
        seek_again(campaign, bench, model, workshop.systems(model))
        for model in (true, true.with_run("run", stated))
    ]


@pytest.mark.parametrize("astray", [0.25, 0.5])
@pytest.mark.parametrize(
    ("kind", "speed_m_s", "stated_m_s"),
    [("washboard", 3.83, 3.83), ("chassis-twist", 1.2, 1.2), ("chassis-twist", 1.2, 1.27)],
)
def test_a_run_that_is_lost_is_placed_by_the_whole_model(
    kind, speed_m_s, stated_m_s, astray, monkeypatch
):
    """Somewhere on its waves; of long ones the speed is sought, too. One that stands where it
    should is left alone. Nothing is found by the linear model."""
    monkeypatch.setattr("wheelhop.fit.placement.find_start", lambda *given: {})
    track = truth.Track(kind, PERIODIC[kind])
    pitch, actual = track.metres("pitch"), {"speed_m_s": speed_m_s, "start_m": 36.87}
    stated = {"speed_m_s": stated_m_s, "start_m": 36.87 + astray * pitch}
    nothing, found = lost(track, actual, stated)
    assert nothing == {}
    apart = (found["start_m"] - 36.87) / pitch
    assert abs(apart - round(apart)) < 0.1
    assert found["speed_m_s"] == pytest.approx(speed_m_s, rel=0.015)


@pytest.mark.parametrize("fault", [{}, SWAPPED], ids=["good sensors", "swapped sensors"])
def test_faults_of_sensors_are_taken_out_before_a_bump_is_sought(fault):
    track = truth.Track("half-sine-bump", ONCE["half-sine-bump left"])
    nothing, found = lost(track, BUMP, {"speed_m_s": 3.83, "start_m": -5.0}, fault)
    assert nothing == {}
    assert found["start_m"] == pytest.approx(BUMP["start_m"], abs=0.05)


def test_of_a_run_whose_start_is_not_free_none_is_sought():
    runs = {"run": truth.Run(truth.Track("flat"), 1.0, 0.0, TIME)}
    model = model_of(ATV, {}).with_run("run", {})
    workshop = Workshop(campaign_of(runs), model, jobs=1)
    (bench,) = workshop.benches.values()
    assert seek_again(workshop.campaign, bench, model, workshop.systems(model)) == {}


@pytest.mark.parametrize(("half_seconds", "whole_is_likelier"), [(5.0, False), (8.0, True)])
def test_a_place_that_explains_all_has_to_do_so_for_a_while_against_a_better_gain(
    half_seconds, whole_is_likelier
):
    """One explains the whole record, but shows half as much again; the other leaves 4 % of it,
    and is as large as the vehicle is believed to make it."""
    gain, share = np.array([0.7, 1.0]), np.array([1.0, 0.96])
    energy = share / gain**2
    whole, sized = _likelihood(gain * energy, energy, 1.0, half_seconds)
    assert (whole > sized) == whole_is_likelier
