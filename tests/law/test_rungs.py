"""Where the names of a component end above the floor, the formula and the free law are the ladder's
last rungs: one answer, in one result and one report."""

import json
from dataclasses import replace

import pytest

import wheelhop
from tests.component import rig
from tests.component.cases import DAMPER
from tests.component.rig import Component
from wheelhop.cli.diagnose import print_diagnosis
from wheelhop.cli.output import open_console
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
    assert "What no name explains" in page and "The formula" in page
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


def test_there_are_none_where_names_do_or_nobody_asks(folder, tmp_path):
    clean = rig.make_campaign(tmp_path / "c", "displacement", DAMPER, seed=2, noise=0.01)
    found = wheelhop.diagnose(clean, effects=FEW, jobs=1)
    assert found.verdict == ("none",)
    assert found.law is None and found.to_json()["law"] is None
    assert wheelhop.diagnose(folder, effects=FEW, law=False, jobs=1).law is None


def test_nor_beyond_the_work_that_is_allowed(folder):
    found = wheelhop.diagnose(folder, effects=FEW, budget_s=0.0, jobs=1)
    assert found.diagnosis.unfinished is not None and found.law is None
