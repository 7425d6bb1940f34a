"""Where the fit of a component begins, on a rig that shares no code."""

import pytest

from tests.component import rig
from tests.component.test_diagnose import OSCILLATOR
from wheelhop.campaign import read_campaign
from wheelhop.fit import begin_component, initial_model, vehicle_parameters
from wheelhop.vehicle import read_nominal

KEYS = ("mass_kg", "stiffness_N_m", "damping_N_s_m")


def started(folder):
    campaign = read_campaign(folder)
    nominal = read_nominal(campaign)
    model = initial_model(campaign, nominal)
    free = vehicle_parameters(campaign, nominal)
    return nominal.values, begin_component(campaign, model, free).values


def test_a_resonance_beside_the_nominal_one_is_found_at_once(tmp_path):
    """Mass and stiffness a third off, so that the nominal resonance lies elsewhere."""
    off = {"mass_kg": 1.3, "stiffness_N_m": 0.7, "damping_N_s_m": 1.3}
    nominal = "\n".join(f"{k} = {f * getattr(OSCILLATOR, k):.6g}" for k, f in off.items())
    folder = rig.make_campaign(
        tmp_path / "c", "force", OSCILLATOR, seed=4, noise=0.01, nominal=nominal
    )
    _, found = started(folder)
    for key in KEYS:
        assert found[f"component.{key}"] == pytest.approx(getattr(OSCILLATOR, key), rel=0.1)
    ratio = found["component.stiffness_N_m"] / found["component.mass_kg"]
    assert ratio == pytest.approx(OSCILLATOR.stiffness_N_m / OSCILLATOR.mass_kg, rel=0.02)


def test_free_decays_leave_the_mass_where_it_was_believed(tmp_path):
    """Without a force there are ratios alone: stiffness over mass is found."""
    folder = rig.make_campaign(
        tmp_path / "c", "force", OSCILLATOR, seed=4, noise=0.002, only="decay"
    )
    nominal, found = started(folder)
    assert found["component.mass_kg"] == nominal["component.mass_kg"]
    true = OSCILLATOR.stiffness_N_m / OSCILLATOR.mass_kg
    ratio = found["component.stiffness_N_m"] / found["component.mass_kg"]
    assert ratio == pytest.approx(true, rel=0.05)
