"""What later looks ask of an earlier one, and what it takes to answer."""

import gc
from dataclasses import replace
from types import FunctionType, ModuleType, SimpleNamespace

import numpy as np
import pytest

from tests.diagnose.test_score import noise, rung
from tests.report.small import write_small_campaign
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import fit_baseline
from wheelhop.diagnose.score import Rung, log_odds
from wheelhop.diagnose.screen.first_order import Screened
from wheelhop.diagnose.search import ladder
from wheelhop.diagnose.search import look as looking
from wheelhop.diagnose.search.ladder import one_more
from wheelhop.diagnose.search.look import Candidate, Look, reached
from wheelhop.diagnose.search.together import Exchange
from wheelhop.effects import load_effects
from wheelhop.fit import Fit
from wheelhop.fit.result import Derivatives
from wheelhop.vehicle import read_nominal


def with_columns(fit: Fit) -> Fit:
    """The same with a shared number's derivatives in every run."""
    runs = [replace(r, derivatives=Derivatives([np.ones(len(r.residual))], 1)) for r in fit.runs]
    return replace(fit, runs=tuple(runs))


def remembered(rung: Rung) -> Rung:
    screened = Screened(None, {}, 0.0, 0.0, 0.0, 0.0, {"0": np.ones(9)}, np.zeros((0, 0)))
    look = Look(rung, (screened,), (Candidate(screened, rung, 0.0, 1, True),), None)
    after = look.remembered()
    assert not any(s.contribution for s in (*after.screened, after.candidates[0].screened))
    assert after.rung.judging.has_derivatives == after.candidates[0].rung.judging.has_derivatives
    return after.candidates[0].rung


@pytest.mark.parametrize(("held_out", "kept"), [(1, 1), (2, 0)])
def test_derivatives_are_kept_only_where_few_held_out_runs_judge(held_out, kept):
    """One run of ten seconds does not judge by itself, and the fitted ones need derivatives to be
    foreseen (`score.left_out`). Two do: to keep them would take tens of megabytes a model."""
    rng = np.random.default_rng(3)
    loud, quiet = (rung(noise(rng, size)[:held_out]) for size in (2.0, 1.0))
    loud, quiet = (replace(r, validation=with_columns(r.validation)) for r in (loud, quiet))
    after = remembered(quiet)
    assert [len(run.derivatives.columns) for run in after.judging.runs] == [kept] * held_out
    assert after.evidence == quiet.evidence
    assert log_odds(loud, after) == log_odds(loud, quiet) > 1.0


def test_a_ladder_goes_on_from_a_rung_it_has_only_remembered(tmp_path):
    """In the workbench an effect may be added to any step of a diagnosis: the derivatives that the
    step no longer holds are made again."""
    campaign = read_campaign(write_small_campaign(tmp_path / "c"))
    base = fit_baseline(campaign, read_nominal(campaign), progress=lambda text: None)
    friction, said = load_effects()["dry-friction"], []
    known = one_more(base.workshop, base.rung, friction, said.append)
    without = replace(base.rung, fit=base.rung.fit.without_derivatives)
    assert not without.fit.has_derivatives
    again = one_more(base.workshop, without, friction, said.append)
    assert again.fit.has_derivatives
    assert again.error_fit == pytest.approx(known.error_fit, rel=1e-3)


def test_a_minimum_reached_by_way_of_another_effect_is_the_effects_own(tmp_path, monkeypatch):
    """Fitted alone friction ends where it explains nothing, and a driver is chosen; beside him it
    is found, and he is not needed (as a bushing in blind seed 13013, by way of a curved path). What
    it leaves alone is what it is held against others by, and what the ranking says of it."""
    campaign = read_campaign(write_small_campaign(tmp_path / "c"))
    base = fit_baseline(campaign, read_nominal(campaign), progress=lambda text: None)
    library = {name: load_effects()[name] for name in ("dry-friction", "driver-seat")}
    look_truly, looks = ladder.look_at, []

    def look_misled(*arguments):
        looks.append(look_truly(*arguments))
        if len(looks) > 1:
            return looks[-1]
        (friction,) = looks[0].candidates
        lost = replace(base.rung, fit=replace(base.rung.fit, model=friction.rung.model))
        item = next(s for s in looks[0].screened if s.variant.effect.id == "driver-seat")
        driven = one_more(base.workshop, base.rung, library["driver-seat"], lambda text: None)
        seat = replace(friction, screened=item, rung=driven)
        lost = replace(friction, rung=lost, log_odds=0.0, holds=False)
        return replace(looks[0], candidates=(seat, lost), chosen=seat)

    monkeypatch.setattr(ladder, "look_at", look_misled)
    found = ladder.climb(base, library, max_effects=2, progress=lambda text: None)
    assert [step.added for step in found.ladder] == [(), ("driver-seat",), ("dry-friction",)]
    assert found.verdict == ("dry-friction",)
    assert found.confidence > 0.95
    assert found.ranking[0].effect == "dry-friction"
    assert found.ranking[0].validated_error == found.ladder[-1].rung.error_validate
    assert found.ranking[0].reason.startswith("accepted: ")


@pytest.mark.parametrize("stays", [("driver-seat",), ("driver-seat", "anti-roll-bar")])
def test_a_search_that_comes_back_to_where_it_stood_ends(tmp_path, monkeypatch, stays):
    """Beside what was wrongly chosen a group is found, and each of its members is found idle again,
    alone (as beside a measured damper's law in blind seed 13367: three laws explain together what
    its form leaves, and none of them as much as counts). A second search would find the same, as
    would an eighth. What could stand for each of two that stay is asked all the same."""
    campaign = read_campaign(write_small_campaign(tmp_path / "c"))
    base = fit_baseline(campaign, read_nominal(campaign), progress=lambda text: None)
    library = {name: load_effects()[name] for name in (*stays, "dry-friction")}
    wrong = ladder.fit_with(base, [library[name] for name in stays], lambda text: None)[-1]
    more = one_more(base.workshop, wrong, library["dry-friction"], lambda text: None)
    look_truly, looks, groups = ladder.look_at, [], []

    def look_misled(*arguments):
        looks.append(look_truly(*arguments))
        chosen = replace(looks[0].candidates[0], rung=wrong)
        return replace(looks[-1], chosen=chosen if len(looks) == 1 else None)

    def a_group(workshop, look, *arguments, **named):
        groups.append(look)
        return replace(look, chosen=replace(looks[0].candidates[0], rung=more))

    def no_exchange(workshop, rung, *arguments):
        return Exchange(None, {effect.id: None for effect in rung.model.effects})

    def what_is_known(workshop, steps, first, last, stands, effects):
        return steps[-1].added, set(stands), last

    monkeypatch.setattr(ladder, "look_at", look_misled)
    monkeypatch.setattr(ladder, "look_for_several", a_group)
    monkeypatch.setattr(ladder, "without_idle", lambda *arguments: (wrong, {}))
    monkeypatch.setattr(ladder, "exchange", no_exchange)
    monkeypatch.setattr(ladder, "conclude", what_is_known)
    added, stands, last = ladder.climb(base, library, max_effects=4, progress=lambda text: None)
    assert added == stays
    assert len(groups) == 1
    assert len(looks) == 2  # what is said of the rest was seen when it stood there first
    assert [s.error for s in last.screened] == [s.error for s in looks[1].screened] != []
    assert stands == (set(stays) if len(stays) > 1 else set())


def test_a_look_that_could_not_screen_an_effect_says_nothing_of_it():
    """Of rough ground whose heights follow lines until another effect explains these."""
    ground = load_effects()["small-scale-roughness"]
    look = Look(rung(noise(np.random.default_rng(3), 1.0)), (), (), None)
    alone = SimpleNamespace(model=SimpleNamespace(effects=(ground,)))
    assert reached(None, look, alone) is look


def reachable(thing):
    """All that is kept in memory because `thing` is; what functions close over, but not the
    modules they stand in."""
    seen, waiting = {}, [thing]
    while waiting:
        one = waiting.pop()
        if id(one) in seen or issubclass(type(one), ModuleType | type):
            continue
        seen[id(one)] = one
        if type(one) is FunctionType:
            waiting += [cell.cell_contents for cell in one.__closure__ or ()]
        else:
            waiting += gc.get_referents(one)
    return seen.values()


def columns_kept_by(thing):
    return sum(len(one.columns) for one in reachable(thing) if type(one) is Derivatives)


def test_nothing_that_a_remembered_rung_closes_over_holds_derivatives(tmp_path, monkeypatch):
    """They are by far most of a model's memory, and of four effects in 18 runs dozens are tried."""
    campaign = read_campaign(write_small_campaign(tmp_path / "c"))
    base = fit_baseline(campaign, read_nominal(campaign), progress=lambda text: None)
    rung = one_more(base.workshop, base.rung, load_effects()["dry-friction"], lambda text: None)
    monkeypatch.setattr(looking, "enough_held_out", lambda rung: True)
    assert columns_kept_by(rung) > 0
    assert columns_kept_by(looking.remembered(rung)) == 0
