"""Machines of other laws than the library's: what it calls by the same name still wins."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from tests.diagnose.cases import FRICTION, LIBRARY, SEAT, baseline_of, diagnosed, oracle_of
from tests.diagnose.machines import FURTHER, MACHINES, rivals
from tests.truth import PRESETS, make_effect
from tests.truth.campaign import make_campaign, write_campaign
from tests.truth.outside_effects import FrameBending
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import climb, diagnose
from wheelhop.diagnose.score import of_a_law
from wheelhop.diagnose.search.ladder import fit_with
from wheelhop.diagnose.search.scored import Search, ids_of
from wheelhop.diagnose.search.together import _open, without_idle
from wheelhop.diagnose.verdict.critic import cramped
from wheelhop.vehicle import read_nominal


@pytest.mark.parametrize(
    "name",
    [  # other sensors, rigs and drivers ask for friction, too
        pytest.param(name, marks=pytest.mark.slow if name == "dry-friction" else ())
        for name in MACHINES
    ],
)
def test_a_machine_is_called_by_its_name(name, tmp_path):
    hidden = make_effect(name, MACHINES[name])
    write_campaign(
        tmp_path, PRESETS["atv"], [hidden], seed=101, short=True, seconds=6.4, draft=True
    )
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


BRISTLES = {
    "sliding_front_N": 55.0,
    "sliding_rear_N": 49.0,
    "sticking": 1.3,
    "stribeck_m_s": 0.02,
    "bristle_N_m": 4e5,
    "bristle_N_s_m": 150.0,
}
STRUTS = ("dry-friction", "digressive-damper", "mount-bushing", "asymmetric-damper")


def quiet(text):
    pass


@pytest.mark.slow
def test_what_a_law_of_another_form_leaves_is_no_second_law(tmp_path):
    """Friction that holds more while it sticks: a digressive damper takes most of what Coulomb's
    law leaves of it, and is not there. Nor does it stay where it came with friction."""
    hidden = make_effect("dry-friction", BRISTLES)
    write_campaign(
        tmp_path, PRESETS["passenger-car"], [hidden], seed=101, short=True, seconds=6.4, draft=True
    )
    library = {name: LIBRARY[name] for name in STRUTS}
    base = baseline_of(tmp_path)
    found = climb(base, library, max_effects=4, progress=quiet)
    assert found.verdict == ("dry-friction",)
    both = fit_with(base, [library["dry-friction"], library["digressive-damper"]], quiet)[-1]
    assert both.error < 0.97 * found.ladder[-1].rung.error
    search = Search(base.workshop, library, 4, quiet)
    search.best(base.rung)
    left = without_idle(search, both)
    assert search.table[ids_of(left)].rung.fit is left.fit
    assert [effect.id for effect in left.model.effects] == ["dry-friction"]


@pytest.mark.slow
def test_two_laws_of_the_struts_that_are_there_are_both_named(tmp_path):
    hidden = {"dry-friction": FRICTION, "asymmetric-damper": {"asymmetry": 0.35}}
    folder = make_campaign(tmp_path, seed=101, effects=hidden, short=True, seconds=6.4, draft=True)
    found = diagnosed(folder, {name: LIBRARY[name] for name in STRUTS})
    assert set(found.verdict) == set(hidden)


def test_what_laws_of_one_name_differ_by_is_of_the_law():
    """Of the amplitude that the first explains they leave up to 0.19. Of two that by themselves
    leave 2.5 and 10 times the noise, neither is of the other's law."""
    assert of_a_law(0.19**2, 1.0)
    assert not of_a_law(2.5**2 - 1.0, 10.0**2 - 1.0)
    assert not of_a_law(1e-6, 0.0)  # no law of the struts is there yet


def test_no_group_is_sought_among_laws_that_could_not_hold():
    """Of a hundred times the noise's power three are left, or nine: three its law may leave."""
    workshop = SimpleNamespace(noise=1.0)
    for left, others in ((3.0, {"driver-seat"}), (9.0, {"driver-seat", "dry-friction"})):
        judging = SimpleNamespace(charged=left, size=1)
        rung = SimpleNamespace(judging=judging, by_laws=100.0)
        library = {name: LIBRARY[name] for name in ("driver-seat", "dry-friction")}
        found = _open(Search(workshop, library, 4, quiet), rung)
        assert {effect.id for effect in found} == others


@pytest.mark.slow
def test_a_frame_that_bends_is_no_driver(tmp_path):
    """Its middle moves all four points exactly as a mass on a spring would that no person is. Of
    all numbers only ratios show: the heaviest driver would do, in a car a third lighter than
    stated. But he is bounded as a share of the car, which stays as heavy as it is believed to be.
    So much is left, and the bound is said."""
    bending = FrameBending(freq_hz=23.0, zeta=0.05, modal_mass_kg=140.0)
    write_campaign(
        tmp_path, PRESETS["formula-student"], [bending], seed=101, short=True, draft=True
    )
    found = diagnosed(tmp_path, {"driver-seat": LIBRARY["driver-seat"]})
    assert found.verdict == ("driver-seat", "unknown")
    assert found.confidence < 0.5
    baseline, last = found.ladder[0], found.ladder[-1]
    assert cramped(last) == ["driver-seat.mass_kg"]
    assert 2.0 * oracle_of(tmp_path / "truth.toml") < last.rung.error < 0.8 * baseline.rung.error
    fit = last.rung.fit
    assert fit.belief.scale(fit.model.values) == pytest.approx(1.0, abs=0.02)
    assert "body.mass_kg" not in {belief.what for belief in found.beliefs}


@pytest.mark.slow
def test_a_driver_heavier_than_can_be_is_as_likely_something_else(tmp_path):
    """He is of 68 kg, and 44 kg are stated. All but a little is explained, yet the fit would have
    him heavier than the bound."""
    hidden = {"driver-seat": SEAT}
    folder = make_campaign(tmp_path, seed=101, effects=hidden, short=True, seconds=6.4, draft=True)
    vehicle = read_nominal(read_campaign(folder))
    vehicle = replace(vehicle, values=vehicle.values | {"driver.mass_kg": 44.0})
    seat = {"driver-seat": LIBRARY["driver-seat"]}
    found = diagnose(read_campaign(folder), vehicle, seat, jobs=1)
    assert not found.ladder[-1].above_floor
    assert found.verdict == ("driver-seat", "unknown")
    assert found.confidence < 0.5
    assert any("driver-seat.mass_kg sits on the bound" in line for line in found.explanation)
