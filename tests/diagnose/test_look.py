"""What the table knows of a set of effects, and what it takes to answer."""

import gc
from dataclasses import replace
from threading import Thread
from types import FunctionType, ModuleType, SimpleNamespace

import numpy as np
import pytest
from numba.core.dispatcher import Dispatcher

from tests.diagnose.test_score import noise, rung
from tests.report.small import write_small_campaign
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import fit_baseline
from wheelhop.diagnose.score import Rung, log_odds
from wheelhop.diagnose.screen.first_order import Screened
from wheelhop.diagnose.search import ladder, scored
from wheelhop.diagnose.search.ladder import one_more
from wheelhop.diagnose.search.look import stood_on_alone
from wheelhop.diagnose.search.scored import BASELINE, Candidate, Scored, Search, ids_of
from wheelhop.effects import load_effects
from wheelhop.fit import Fit
from wheelhop.fit.result import Derivatives
from wheelhop.vehicle import read_nominal


def with_columns(fit: Fit) -> Fit:
    """The same with a shared number's derivatives in every run."""
    runs = [replace(r, derivatives=Derivatives([np.ones(len(r.residual))], 1)) for r in fit.runs]
    return replace(fit, runs=tuple(runs))


def quiet(text):
    pass


def remembered(rung: Rung) -> Rung:
    screened = Screened(None, {}, 0.0, 0.0, 0.0, 0.0, {"0": np.ones(9)}, np.zeros((0, 0)))
    after = Scored(rung, (screened,), (Candidate(screened, rung, 0.0, 1, True),)).remembered()
    assert not any(s.contribution for s in (*after.screened, after.candidates[0].screened))
    assert after.rung.judging.has_derivatives == after.candidates[0].rung.judging.has_derivatives
    return after.candidates[0].rung


@pytest.mark.parametrize(("held_out", "kept"), [(1, 1), (2, 0)])
def test_derivatives_are_kept_only_where_few_held_out_runs_judge(held_out, kept):
    """One run of ten seconds does not judge by itself, and the fitted ones need derivatives to be
    foreseen (`left_out`). Two do: to keep them would take tens of megabytes a model."""
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
    base = fit_baseline(campaign, read_nominal(campaign), progress=quiet)
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
    base = fit_baseline(campaign, read_nominal(campaign), progress=quiet)
    library = {name: load_effects()[name] for name in ("dry-friction", "driver-seat")}
    look_truly = ladder.look_at

    def look_misled(search, step):
        seen = look_truly(search, step)
        if step.added:
            return
        (friction,) = seen.candidates
        lost = replace(base.rung, fit=replace(base.rung.fit, model=friction.rung.model))
        item = next(s for s in seen.screened if s.id == "driver-seat")
        driven = one_more(base.workshop, base.rung, library["driver-seat"], quiet)
        seat = replace(friction, screened=item, rung=driven)
        lost = replace(friction, rung=lost, log_odds=0.0, holds=False)
        search.table[BASELINE] = replace(seen, candidates=(seat, lost), chosen=seat)

    monkeypatch.setattr(ladder, "look_at", look_misled)
    found = ladder.climb(base, library, max_effects=2, progress=quiet)
    assert [step.added for step in found.ladder] == [(), ("driver-seat",), ("dry-friction",)]
    assert found.verdict == ("dry-friction",)
    assert found.confidence > 0.95
    assert found.ranking[0].effect == "dry-friction"
    assert found.ranking[0].validated_error == found.ladder[-1].rung.error_validate
    assert found.ranking[0].reason.startswith("accepted: ")


@pytest.fixture
def searched(tmp_path):
    """A search that knows its baseline, with friction and a driver in its library."""
    campaign = read_campaign(write_small_campaign(tmp_path / "c"))
    base = fit_baseline(campaign, read_nominal(campaign), progress=quiet)
    library = {name: load_effects()[name] for name in ("dry-friction", "driver-seat")}
    search = Search(base.workshop, library, 2, quiet)
    search.best(base.rung)
    return search


def test_of_two_models_of_a_set_the_better_one_is_known(searched):
    """A better one forgets what was screened beside the other; one in the same minimum, or a worse
    one, does not, and what is handed out is the better one, with derivatives."""
    base = searched.table[BASELINE].rung
    friction = one_more(searched.workshop, base, searched.effects["dry-friction"], quiet)
    fitted = friction.fit
    worse = replace(friction, fit=replace(fitted, cost=1.01 * fitted.cost))
    ids = ids_of(friction)
    assert searched.best(worse) is worse
    searched.table[ids] = replace(searched.table[ids], looked=True)
    assert searched.best(friction) is friction
    assert searched.table[ids].rung is friction and not searched.table[ids].looked
    again = replace(friction, fit=replace(fitted, cost=0.9999 * fitted.cost))
    searched.table[ids] = replace(searched.table[ids], looked=True)
    assert searched.best(again) is again  # its derivatives are there
    assert searched.table[ids].rung is friction and searched.table[ids].looked
    assert searched.best(worse) is friction
    bare = replace(friction, fit=fitted.without_derivatives)
    searched.table[ids] = replace(searched.table[ids], rung=bare)
    known = searched.best(worse)
    assert known.fit.has_derivatives and known.fit.cost == pytest.approx(fitted.cost, rel=1e-3)


def test_what_an_effect_stands_against_is_read_off_its_neighbours(searched):
    base = searched.table[BASELINE].rung
    alone = {k: one_more(searched.workshop, base, e, quiet) for k, e in searched.effects.items()}
    friction, seat = alone["dry-friction"], alone["driver-seat"]
    stand = searched.stand(friction, "dry-friction")
    assert ids_of(stand.without) == BASELINE and stand.rivals == [stand.without]  # none was tried
    beside = [candidate(seat, "driver-seat", searched)]
    searched.table[BASELINE] = replace(searched.table[BASELINE], candidates=tuple(beside))
    assert searched.stand(friction, "dry-friction").rivals == [seat]
    assert searched.stand(seat, "driver-seat").rivals != [seat]  # none is its own rival
    both = one_more(searched.workshop, seat, searched.effects["dry-friction"], quiet)
    # Nobody has fitted a driver alone, nor friction: the baseline is all it stands against.
    stand = searched.stand(both, "dry-friction")
    assert stand.accepted is both and stand.rivals == [stand.without]
    assert stand.without.fit is base.fit
    # Friction and a driver who does better were simulated beside the baseline: he might do better
    # beside the effects that came after, too.
    better = replace(friction, fit=replace(friction.fit, runs=quieter(friction.fit.runs)))
    for rival, behind in ((better, True), (friction, False)):
        known = [candidate(friction, "dry-friction", searched), candidate(rival, "stop", searched)]
        searched.table[BASELINE] = replace(searched.table[BASELINE], candidates=tuple(known))
        stand = searched.stand(both, "dry-friction")
        assert stand.accepted is both and stand.without.fit is base.fit
        assert stand.rivals == [rival] and stand.is_behind == behind
    assert stand.beside is searched.table[BASELINE]
    searched.best(seat)
    stand = searched.stand(both, "dry-friction")
    assert stand.accepted is both and stand.without.fit is seat.fit


def quieter(runs):
    return tuple(replace(run, residual=0.9 * run.residual) for run in runs)


def candidate(rung, name, search):
    """An effect as it was simulated in full."""
    effect = search.effects.get(name, SimpleNamespace(id=name))
    screened = Screened(SimpleNamespace(effect=effect), {}, 0, 0, 0, 0, {}, None)
    return Candidate(screened, rung, 0.0, 2, False)


def test_a_search_that_comes_back_to_where_it_stood_ends(searched, monkeypatch):
    """Beside what was wrongly chosen a group is found, and each of its members is found idle again,
    alone (as beside a measured damper's law in blind seed 13367: three laws explain together what
    its form leaves, and none of them as much as counts). A second search would find the same, as
    would an eighth."""
    base = ladder.Baseline(searched.workshop, (), searched.table[BASELINE].rung)
    wrong = one_more(base.workshop, base.rung, searched.effects["driver-seat"], quiet)
    more = one_more(base.workshop, wrong, searched.effects["dry-friction"], quiet)
    look_truly, looks, groups = ladder.look_at, [], []

    def look_misled(search, step):
        seen = look_truly(search, step)
        looks.append(step.added)
        chosen = None if step.added else replace(seen.candidates[0], rung=wrong)
        search.table[ids_of(step.rung)] = replace(seen, chosen=chosen)

    def a_group(search, found):
        groups.append(ids_of(found.rung))
        return more if ids_of(found.rung) else None

    def what_is_known(search, steps, ended_by):
        return steps[-1].added, search.table[ids_of(steps[-1].rung)]

    monkeypatch.setattr(ladder, "look_at", look_misled)
    monkeypatch.setattr(ladder, "look_for_several", a_group)
    monkeypatch.setattr(ladder, "without_idle", lambda search, rung: wrong)
    monkeypatch.setattr(ladder, "conclude", what_is_known)
    added, known = ladder.climb(base, searched.effects, max_effects=4, progress=quiet)
    assert added == ("driver-seat",)
    assert groups == [BASELINE, {"driver-seat"}]
    assert looks == [(), ("driver-seat",)]  # what is said of the rest was seen then
    assert [s.id for s in known.screened] == ["dry-friction"]


def test_where_an_effect_could_not_be_screened_it_says_nothing_of_it(searched):
    """Of rough ground where no run rolls on a track."""
    known = searched.table[BASELINE]
    friction = one_more(searched.workshop, known.rung, searched.effects["dry-friction"], quiet)
    stood_on_alone(searched, friction)
    assert searched.table[BASELINE] is known


def reachable(thing):
    """All that is kept in memory because `thing` is; what functions close over, but not the
    modules they stand in, nor what numba holds with a compiled function and pytest with a thread
    (in the end all that the tests before this one have left)."""
    seen, waiting = {}, [thing]
    while waiting:
        one = waiting.pop()
        if id(one) in seen or issubclass(type(one), ModuleType | type | Dispatcher | Thread):
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
    base = fit_baseline(campaign, read_nominal(campaign), progress=quiet)
    rung = one_more(base.workshop, base.rung, load_effects()["dry-friction"], quiet)
    monkeypatch.setattr(scored, "enough_held_out", lambda rung: True)
    assert columns_kept_by(rung) > 0
    assert columns_kept_by(scored.remembered(rung)) == 0
