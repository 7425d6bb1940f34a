"""Held-out runs that the fitted ones foresee badly: a wheel that leaves the ground only there."""

from types import SimpleNamespace

import pytest

from benchmarks.blind.vehicles import rougher
from tests import truth
from tests.diagnose.cases import LIBRARY, baseline_of, diagnosed
from wheelhop.diagnose import caveats
from wheelhop.diagnose.confirm.validate import Incumbent
from wheelhop.diagnose.score import above_noise, all_noise, excess, material
from wheelhop.diagnose.search.ladder import fit_with

CAR = truth.PRESETS["passenger-car"]
LIFTING = {
    "tyre-lift-off": {},
    "digressive-damper": {"knee_m_s": 0.25, "slope_ratio": 0.8},
}
UNSTEADY = {
    "dry-friction": {"coulomb_front_N": 75.0, "coulomb_rear_N": 55.0},
    "speed-fluctuation": {"fraction": 1.5e-4, "period_min_s": 1.8, "period_max_s": 6.4},
}


def campaign(folder, hidden, *, seed, severity=1.0):
    effects = truth.make_effects(hidden)
    return truth.write_campaign(
        folder, rougher(CAR, severity), effects, seed=seed, short=True, noise_rms=0.15, draft=True
    )


def fitted(folder, names):
    """The baseline, and the vehicle fitted with these effects."""
    base = baseline_of(folder)
    return base, fit_with(base, [LIBRARY[name] for name in names], lambda text: None)[-1]


@pytest.fixture(scope="module")
def lifting(tmp_path_factory):
    return campaign(tmp_path_factory.mktemp("lifting"), LIFTING, seed=1994, severity=1.2)


@pytest.fixture(scope="module")
def explained(lifting):
    """Both effects in the model, neither searched for."""
    return fitted(lifting, LIFTING)


def test_a_prediction_is_no_better_than_its_numbers(explained):
    """The fitted runs know the static loads too little to say when a wheel lands; within their
    uncertainty nothing is left that two simulators' disagreement on a lifting wheel does not
    explain. What is reported as foreseen stays so."""
    base, rung = explained
    workshop = base.workshop
    assert all_noise(rung.fit, workshop.noise)
    foreseen = above_noise(rung.validation, workshop.noise)
    assert foreseen > 1.5 * material(rung)
    assert excess(rung, workshop.noise) < 0.5 * material(rung)
    assert rung.error_validate > 1.02 * rung.error_judging
    # The shared numbers went no farther than the fitted runs allow: χ² of some forty.
    assert rung.fit.posterior.distance(rung.update.model.values) < 80.0


def test_a_rung_is_held_against_others_on_equal_terms(explained):
    """Where a rival's numbers may move on the runs held out, so may those of the rung it is to
    replace: what the vehicle could do by itself speaks for no effect."""
    base, rival = explained
    incumbent = Incumbent(base.workshop, base.rung)
    assert incumbent.against(base.rung) is base.rung
    moved = incumbent.against(rival)
    assert moved.fit is base.rung.fit
    assert moved.error_validate == base.rung.error_validate
    assert moved.error_judging < base.rung.error_judging


def test_a_user_reads_why_held_out_runs_stay_above_the_floor():
    floor = SimpleNamespace(error_validate=0.24, expected_validate=0.24, tolerance=0.05)
    step = SimpleNamespace(
        rung=SimpleNamespace(update=object(), error_validate=0.36),
        comparison=SimpleNamespace(floor=floor),
        above_floor=False,
        over_floor=1.01,
    )
    (line,) = caveats(step)
    assert "foreseen to 1.50 times the floor" in line
    assert "comes to 1.01 times" in line
    near = SimpleNamespace(update=object(), error_validate=0.25)
    for other in ({"above_floor": True}, {"rung": near}, {"rung": SimpleNamespace(update=None)}):
        assert caveats(SimpleNamespace(**{**vars(step), **other})) == []


@pytest.mark.slow
def test_no_flexible_effect_makes_up_for_uncertain_numbers(lifting):
    """A braking moment that is free at every instant would, and be a third effect of the two."""
    few = (*LIFTING, "longitudinal-pitch", "cornering-roll")
    diagnosis = diagnosed(lifting, {name: LIBRARY[name] for name in few})
    assert set(diagnosis.verdict) == set(LIFTING)


def test_a_second_effect_in_the_held_out_runs_is_not_made_up_for(tmp_path):
    """A driver who is unsteady in them: no number of the vehicle can make up for that."""
    base, rung = fitted(campaign(tmp_path, UNSTEADY, seed=51), ["dry-friction"])
    workshop = base.workshop
    assert all_noise(rung.fit, workshop.noise)
    assert rung.update is not None
    assert excess(rung, workshop.noise) > 0.8 * above_noise(rung.validation, workshop.noise)


def test_the_baseline_foresees_or_fails(tmp_path):
    """A faint effect that only held-out runs show must not vanish in the vehicle's numbers."""
    folder = campaign(tmp_path, {"speed-fluctuation": UNSTEADY["speed-fluctuation"]}, seed=51)
    base, rung = fitted(folder, [])
    assert all_noise(rung.fit, base.workshop.noise)
    assert excess(rung, base.workshop.noise) > material(rung)
    assert rung.update is None
