"""Machines of other laws than the library's: what it calls by the same name still wins."""

import pytest

from tests.diagnose.cases import LIBRARY, diagnosed, oracle_of
from tests.diagnose.machines import FURTHER, MACHINES, rivals
from tests.truth import PRESETS, make_effect
from tests.truth.campaign import write_campaign
from tests.truth.outside_effects import FrameBending
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import fit_baseline
from wheelhop.diagnose.critic import cramped
from wheelhop.diagnose.ladder import fit_with
from wheelhop.diagnose.look import step_of
from wheelhop.vehicle import read_nominal


@pytest.mark.parametrize("name", MACHINES)
def test_a_machine_is_called_by_its_name(name, tmp_path):
    hidden = make_effect(name, MACHINES[name])
    write_campaign(tmp_path, PRESETS["atv"], [hidden], seed=101, short=True)
    diagnosis = diagnosed(tmp_path, rivals(name))
    assert diagnosis.verdict == (name,)
    assert diagnosis.confidence > 0.9
    oracle = oracle_of(tmp_path / "truth.toml")
    assert diagnosis.ladder[-1].rung.error_validate <= 1.05 * oracle


@pytest.mark.slow
@pytest.mark.parametrize("name", FURTHER)
def test_what_comes_first_is_its_name(name, tmp_path):
    hidden = make_effect(name, FURTHER[name])
    write_campaign(tmp_path, PRESETS["atv"], [hidden], seed=101, short=True)
    assert diagnosed(tmp_path, rivals(name)).verdict[0] == name


def test_a_frame_that_bends_is_no_driver(tmp_path):
    """Its middle moves all four points exactly as a mass on a spring would that no person is."""
    bending = FrameBending(freq_hz=23.0, zeta=0.05, modal_mass_kg=140.0)
    write_campaign(tmp_path, PRESETS["formula-student"], [bending], seed=101, short=True)
    campaign = read_campaign(tmp_path)
    base = fit_baseline(campaign, read_nominal(campaign), progress=lambda text: None)
    rung = fit_with(base, [LIBRARY["driver-seat"]], progress=lambda text: None)[-1]
    assert rung.error > 1.3 * oracle_of(tmp_path / "truth.toml")
    assert cramped(step_of(base.workshop, rung)) == ["driver-seat.mass_kg"]
