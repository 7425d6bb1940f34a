"""Where the names of a component end above the floor, the formula and the free law are the ladder's
last rungs: one answer, in one result and one report."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

import wheelhop
from tests.component import rig
from tests.component.cases import DAMPER
from tests.component.rig import Component
from wheelhop.campaign import read_campaign
from wheelhop.cli.diagnose import print_diagnosis
from wheelhop.cli.output import open_console
from wheelhop.compare import NEIGHBOURS
from wheelhop.effects import load_effects
from wheelhop.law.rungs import Nearest
from wheelhop.report.law import beyond_names

FEW = {
    name: effect
    for name, effect in load_effects().items()
    if name in ("progressive-spring", "bump-stop", "asymmetric-damper")
}
"""A library that has no word for what the damper does."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A damper whose ports shut as it travels, which is in nobody's library."""
    numbers = {"share": 1.0, "travel_m": 0.02}
    component = Component(hidden="bypass-damper", numbers=numbers)
    where = tmp_path_factory.mktemp("rungs") / "c"
    return rig.make_campaign(where, "displacement", component, seed=2, noise=0.01)


@pytest.fixture(scope="module")
def result(folder):
    return wheelhop.diagnose(folder, effects=FEW, jobs=1)


def test_the_formula_and_the_free_law_leave_less_than_the_names(result):
    assert result.verdict[-1] == "unknown"
    assert result.law is not None
    last = result.steps[-1]
    added = [step.added for step in result.law.steps]
    assert added == [("formula",), ("free law",)]
    assert all(step.rung.error < 0.5 * last.rung.error for step in result.law.steps)
    assert all(step.comparison.floor is last.comparison.floor for step in result.law.steps)
    formula = result.law.found.formula
    assert "damping that grows away from rest" in formula.words


def test_one_answer_holds_names_and_law(result, tmp_path):
    found = result.to_json()["law"]
    names = {c["name"]: c["error"] for c in found["candidates"]}
    assert names["formula"] == pytest.approx(result.law.found.formula.rung.error)
    assert found["nearest"] is None and found["words"][-1].startswith("No name of the library")
    result.write_report(tmp_path / "r.html")
    page = (tmp_path / "r.html").read_text()
    assert "Beyond names" in page and "The formula" in page
    json.dumps(found)


@pytest.mark.parametrize(
    ("times", "said"), [(3.0, "of what that law explains"), (1.0, "as little")]
)
def test_the_nearest_name_is_said_with_why_it_does_not_do(result, times, said):
    """By what it leaves, and by what the ranking says of it."""
    least = min(step.rung.error for step in result.law.steps)
    nearest = Nearest("bump-stop", times * least, "not confirmed by held-out runs")
    *_, name, why = beyond_names(replace(result.law, nearest=nearest))
    assert name.startswith("bump-stop comes nearest of all names") and said in name
    assert why == "It was not accepted: not confirmed by held-out runs."


def test_the_terminal_shows_them_as_rungs(result, capsys):
    print_diagnosis(result.diagnosis, open_console(), result.law)
    shown = capsys.readouterr().out
    assert "+ formula" in shown and "+ free law" in shown and "In place of names" in shown


def slow_noise(campaign):
    """The campaign with noise of a tenth of the force, of which a thirtieth as much is seen where
    it is quietest, and none of it stated."""
    rng, runs = np.random.default_rng(4), []
    for run in campaign.runs:
        slow = lfilter([1.0], [1.0, -0.94], rng.normal(size=len(run.force)))
        force = run.force + 0.1 * np.std(run.force) / np.std(slow) * slow
        runs.append(replace(run, force=force, record=force[:, None]))
    return replace(campaign, runs=tuple(runs), noise_rms=None)


def test_noise_that_no_law_explains_is_no_unknown(tmp_path, capsys):
    """No motion repeats, and the quietest parts are far below the noise, which is slow. A law that
    is in the library leaves as much as a free law does: that is the floor. One that is not leaves
    more, and is still unknown."""
    friction = {"coulomb_N": 150.0, "joint_N_m": 4e5}
    component = replace(DAMPER, hidden="dry-friction", numbers=friction)
    known = rig.make_campaign(
        tmp_path / "c", "displacement", component, seed=1, noise=0.001, only="random"
    )
    effects = {**FEW, "dry-friction": load_effects()["dry-friction"]}
    found = wheelhop.diagnose(slow_noise(read_campaign(known)), effects=effects, jobs=1)
    assert found.verdict == ("dry-friction",)
    floor = found.comparison.floor
    assert (floor.basis, floor.uncertainty) == (NEIGHBOURS, 0.05)
    least = min(step.rung.error for step in (found.steps[-1], *found.law.steps))
    assert found.steps[-1].expected == pytest.approx(least, rel=1e-6)
    assert floor.pooled_rms == pytest.approx(0.1 * rms_of(known), rel=0.2)
    assert "Impose one motion twice" in beyond_names(found.law)[-1]
    print_diagnosis(found.diagnosis, open_console(), found.law)
    assert f"noise floor is estimated from {NEIGHBOURS}" in " ".join(
        capsys.readouterr().out.split()
    )

    hidden = Component(hidden="bypass-damper", numbers={"share": 1.0, "travel_m": 0.02})
    strange = rig.make_campaign(
        tmp_path / "d", "displacement", hidden, seed=2, noise=0.001, only="random"
    )
    found = wheelhop.diagnose(slow_noise(read_campaign(strange)), effects=FEW, jobs=1)
    assert found.verdict == ("unknown",) and found.confidence > 0.5


def rms_of(folder):
    """The force of a campaign's runs, r.m.s."""
    return np.sqrt(np.mean([np.var(run.force) for run in read_campaign(folder).runs]))


def test_what_repeats_show_stays_the_floor_whatever_laws_leave(result):
    """The campaign states its noise: laws change what a wrong name could leave, no more."""
    floor = result.comparison.floor
    least = min(step.rung.error for step in result.law.steps)
    assert floor.is_stated
    assert floor.of_laws == pytest.approx(least / result.steps[-1].expected, rel=0.1)
    assert not any("looks for the missing force" in line for line in result.explanation)


def test_there_are_none_where_names_do_or_nobody_asks(folder, tmp_path):
    clean = rig.make_campaign(tmp_path / "c", "displacement", DAMPER, seed=2, noise=0.01)
    found = wheelhop.diagnose(clean, effects=FEW, jobs=1)
    assert found.verdict == ("none",)
    assert found.law is None and found.to_json()["law"] is None
    assert wheelhop.diagnose(folder, effects=FEW, law=False, jobs=1).law is None


def test_nor_beyond_the_work_that_is_allowed(folder):
    found = wheelhop.diagnose(folder, effects=FEW, budget_s=0.0, jobs=1)
    assert found.diagnosis.unfinished is not None and found.law is None
