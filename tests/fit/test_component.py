"""A component's numbers: what is free of them, and where their fit begins, on records made up."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import Channel, ComponentCampaign, RigRun, TrackSpec
from wheelhop.effects import RunSetting
from wheelhop.fit import begin_component, run_parameters, vehicle_parameters
from wheelhop.simulate import Model
from wheelhop.vehicle import Vehicle

RATE_HZ, N = 400.0, 1600
TIME = 3.0 + np.arange(N) / RATE_HZ  # no record has to begin at zero
TRUE = {"stiffness_N_m": 2.0e4, "damping_N_s_m": 150.0, "mass_kg": 5.0}
OFF = {"stiffness_N_m": 1.4e4, "damping_N_s_m": 210.0, "mass_kg": 6.5}
SIGMAS = {"stiffness_N_m": 4e3, "damping_N_s_m": 45.0, "mass_kg": 0.9}
SETTING = RunSetting("run", 0.0, 3.0, 3.0, 7.0, on_road=False, on_rig=True)


def run_of(seed, drive, true=TRUE, size_m=1e-3):
    """Sines on the record's own lines, so that displacement and force belong to each other to the
    last digit."""
    rng, lines = np.random.default_rng(seed), np.arange(8, 100, 4)
    omega = 2 * np.pi * lines * RATE_HZ / N
    wave = np.exp(1j * np.outer(TIME, omega)) * np.exp(2j * np.pi * rng.random(len(lines)))
    wave *= size_m / (1.0 + (omega / 60.0) ** 2)
    k, c, m = (true[term] for term in ("stiffness_N_m", "damping_N_s_m", "mass_kg"))
    displacement = wave.real.sum(axis=1)
    velocity = (1j * omega * wave).real.sum(axis=1)
    force = ((k + 1j * omega * c - omega**2 * m) * wave).real.sum(axis=1)
    record = (displacement if drive == "force" else force)[:, None]
    given = ("run", Path("run.csv"), "fit", 0.0, TrackSpec("unknown", {}), TIME, record)
    return RigRun(*given, drive, displacement, force, velocity)


def campaign_of(*runs, drive="force", sigmas=SIGMAS):
    return ComponentCampaign(
        folder=Path(),
        title="made up",
        vehicle_file=Path("component.toml"),
        sample_rate_hz=RATE_HZ,
        band_hz=(1.0, 30.0),
        averaging_s=0.0,
        noise_rms=None,
        channels=(Channel("output", "rig"),),
        runs=runs,
        drive=drive,
        nominal=OFF,
        uncertainty=sigmas,
    )


def free_of(campaign, sigmas=SIGMAS):
    values = {f"component.{key}": value for key, value in OFF.items()}
    stated = {f"component.{key}": value for key, value in sigmas.items()}
    return vehicle_parameters(campaign, Vehicle("component", values, stated))


def begun(campaign, sigmas=SIGMAS):
    model = Model({f"component.{key}": value for key, value in OFF.items()})
    found = begin_component(campaign, model, free_of(campaign, sigmas)).values
    return {key: found[f"component.{key}"] for key in OFF}


def test_under_a_force_there_is_a_mass_to_move():
    """At least a fiftieth of what is stated; anything else may turn out to be an effect alone."""
    free = {f.name.removeprefix("component."): f for f in free_of(campaign_of(run_of(1, "force")))}
    assert free.keys() == OFF.keys()
    for key, one in free.items():
        assert (one.mean, one.sigma, one.scale) == (OFF[key], SIGMAS[key], SIGMAS[key])
        assert one.upper == np.inf
    assert free["mass_kg"].lower == pytest.approx(OFF["mass_kg"] / 50.0)
    assert free["stiffness_N_m"].lower == free["damping_N_s_m"].lower == 0.0


def test_under_a_displacement_even_the_mass_may_vanish():
    """What is known exactly is not free."""
    sigmas = SIGMAS | {"damping_N_s_m": 0.0}
    free = free_of(campaign_of(run_of(1, "displacement"), drive="displacement"), sigmas)
    assert {f.name: f.lower for f in free} == {
        "component.stiffness_N_m": 0.0,
        "component.mass_kg": 0.0,
    }


def test_a_run_under_a_force_begins_somewhere_and_somehow_fast():
    """At its first sample, as far away and as fast as it moves on the whole."""
    run = run_of(2, "force")
    place, speed, offset = run_parameters(run, SETTING, Model({}))
    assert (place.name, speed.name, offset.name) == ("initial_m", "initial_m_s", "offset_N")
    assert (place.mean, speed.mean, offset.mean) == (run.displacement[0], 0.0, 0.0)
    assert offset.sigma == offset.scale == pytest.approx(np.sqrt(np.mean(run.force**2)))
    assert place.sigma == place.scale == pytest.approx(run.displacement.std())
    assert speed.sigma == speed.scale == pytest.approx(run.velocity.std(), rel=0.01)
    imposed = run_of(2, "displacement")
    assert run_parameters(imposed, SETTING, Model({})) == []


@pytest.mark.parametrize("drive", ["force", "displacement"])
def test_a_linear_component_is_found_to_the_last_digits(drive):
    """m ẍ + c ẋ + k x = F, two runs of unlike size, from numbers a third off."""
    runs = (run_of(3, drive), run_of(4, drive, size_m=1e-4))
    found = begun(campaign_of(*runs, drive=drive))
    assert found == pytest.approx(TRUE, rel=1e-3)


@pytest.mark.parametrize("sure", OFF)
def test_what_is_known_exactly_stays(sure):
    """And the rest is told as if it were so: of stiffness and mass the resonance is kept."""
    found = begun(campaign_of(run_of(5, "force")), SIGMAS | {sure: 0.0})
    assert found[sure] == OFF[sure]
    true = run_of(5, "force", TRUE | {sure: OFF[sure]})
    sigmas = SIGMAS | {sure: 0.0}
    assert begun(campaign_of(true), sigmas) == pytest.approx(TRUE | {sure: OFF[sure]}, rel=1e-3)


def test_nothing_is_sought_where_everything_is_known():
    assert begun(campaign_of(run_of(6, "force")), dict.fromkeys(SIGMAS, 0.0)) == OFF


@pytest.mark.parametrize("drive", ["force", "displacement"])
def test_a_stiffness_never_begins_below_nothing(drive):
    """A spring that pushes is an effect; the start stays at the bound."""
    negative = TRUE | {"stiffness_N_m": -3e3}
    found = begun(campaign_of(run_of(7, drive, negative), drive=drive))
    assert found["stiffness_N_m"] == pytest.approx(0.0, abs=1.0)


def test_decays_without_a_force_keep_the_mass():
    """There are only ratios: a stiffness per mass, a damping per mass."""
    free = RigRun(
        *("run", Path("run.csv"), "fit", 0.0, TrackSpec("unknown", {}), TIME),
        *(np.zeros((N, 1)), "force", *decay()),
    )
    found = begun(campaign_of(free))
    assert found["mass_kg"] == OFF["mass_kg"]
    ratio = OFF["mass_kg"] / TRUE["mass_kg"]
    assert found["stiffness_N_m"] == pytest.approx(ratio * TRUE["stiffness_N_m"], rel=0.02)


def decay():
    """Displacement, force and velocity of a free decay."""
    k, c, m = (TRUE[term] for term in ("stiffness_N_m", "damping_N_s_m", "mass_kg"))
    pole = (-c + 1j * np.sqrt(4 * k * m - c**2)) / (2 * m)
    x = 1e-3 * np.exp(pole * (TIME - TIME[0]))
    return x.real, np.zeros(N), (pole * x).real


def test_the_nominal_numbers_stay_where_none_come_nearer():
    """A record to which they belong exactly."""
    found = begun(campaign_of(run_of(8, "force", OFF)))
    assert found == pytest.approx(OFF, rel=1e-3)


def noisy(drive, share):
    """A run whose measured quantity has white noise of a share of it; lines, and what is found."""
    clean = run_of(9, drive)
    noise = share * clean.record.std() * np.random.default_rng(9).normal(size=N)
    x, force = clean.displacement, clean.force
    x, force = (x + noise, force) if drive == "force" else (x, force + noise)
    run = RigRun(
        *("run", Path("run.csv"), "fit", 0.0, clean.track, TIME, clean.record + noise[:, None]),
        *(drive, x, force, clean.velocity if drive == "displacement" else None),
    )
    lines = slice(4, 121)  # 1 to 30 Hz
    spectra = (np.fft.rfft(signal)[lines] for signal in (x, force))
    omega = 2 * np.pi * np.arange(4, 121) * RATE_HZ / N
    return begun(campaign_of(run, drive=drive)), omega, *spectra


def dynamic(values, omega):
    """Force per displacement."""
    k, c, m = (values[term] for term in ("stiffness_N_m", "damping_N_s_m", "mass_kg"))
    return k + 1j * omega * c - omega**2 * m


def test_under_a_force_it_is_the_displacement_that_has_to_agree():
    """Numbers a little to either side leave more of it."""
    found, omega, x, force = noisy("force", 0.03)
    assert found == pytest.approx(TRUE, rel=0.1)

    def left(values):
        return np.sum(np.abs(x - force / dynamic(values, omega)) ** 2)

    for key, value in found.items():
        for factor in (0.95, 1.05):
            assert left({**found, key: factor * value}) > left(found)


def test_under_a_displacement_it_is_the_force_that_has_to_agree():
    """Ordinary least squares, which nothing beats."""
    found, omega, x, force = noisy("displacement", 0.3)
    columns = np.stack([x, 1j * omega * x, -(omega**2) * x], axis=1)
    both = (np.concatenate([part.real, part.imag]) for part in (columns, force))
    best = np.linalg.lstsq(*both, rcond=None)[0]
    assert list(found.values()) == pytest.approx(best, rel=1e-2)


@pytest.mark.parametrize("drive", ["force", "displacement"])
def test_numbers_begin_within_their_bounds(drive):
    """Whatever a record says: a mass that is less than may be is as little as may be."""
    campaign = campaign_of(run_of(10, drive, TRUE | {"mass_kg": 0.5}), drive=drive)
    model = Model({f"component.{key}": value for key, value in OFF.items()})
    narrow = {
        "component.mass_kg": (1.25, np.inf),
        "component.damping_N_s_m": (0.0, 70.0),
    }
    free = [
        replace(f, lower=narrow[f.name][0], upper=narrow[f.name][1]) if f.name in narrow else f
        for f in free_of(campaign)
    ]
    found = begin_component(campaign, model, free).values
    assert found["component.mass_kg"] == pytest.approx(1.25)
    assert found["component.damping_N_s_m"] == pytest.approx(70.0)
