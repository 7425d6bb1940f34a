"""To first order terms add up, so that each is simulated once for all sums."""

import pytest

from tests.component import rig
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import fit_baseline
from wheelhop.diagnose.screen.first_order import screen, taken_alone
from wheelhop.diagnose.search.scored import Scored
from wheelhop.diagnose.verdict.limits import limits
from wheelhop.law.first_order import screen_places
from wheelhop.law.formula import Formula
from wheelhop.law.motion import Moves
from wheelhop.law.places import Where
from wheelhop.law.regression import Signatures, Sums
from wheelhop.law.terms import Term, candidates, stop
from wheelhop.vehicle import read_nominal


def test_a_sum_of_terms_screens_as_if_it_were_simulated(tmp_path):
    component = rig.Component(hidden="cubic-spring", numbers={"cubic_N_m3": 2e7})
    folder = rig.make_campaign(
        tmp_path / "c", "displacement", component, seed=3, noise=0.01, only="random"
    )
    campaign = read_campaign(folder)
    base = fit_baseline(campaign, read_nominal(campaign), progress=lambda text: None)
    workshop, fitted, where = base.workshop, base.rung.fit, Where("component", "strut", (0,))
    moves = Moves(workshop, base.rung.model)
    moved, signatures = moves.of(where), Signatures(workshop, fitted, moves, taken_alone(fitted))
    terms = candidates(moved.extension, moved.rate)[:6]
    alone = [Formula(where, [term]) for term in terms]
    sums = Sums(signatures, alone)
    chosen = [1, 2, 5]
    total = Formula(where, [terms[i] for i in chosen])
    added = sums.screen(total, [[(alone[i], f"{terms[i].name}_N")] for i in chosen])
    (simulated,) = screen(workshop, fitted, [total])
    assert added.gain == pytest.approx(simulated.gain, rel=1e-6)
    assert added.error == pytest.approx(simulated.error, rel=1e-6)
    for name, force in simulated.amplitudes.items():
        assert added.amplitudes[name] == pytest.approx(force, rel=1e-4, abs=1e-6)
    best, *_ = screen_places(signatures, base.rung, moves)
    assert best.where.name == "component" and "extension" in best.form.name


def test_what_no_run_shows_is_no_limit(tmp_path):
    """A term of no effect on the record has no strength from which on it shows, not an infinite
    one, which JSON does not take."""
    folder = rig.make_campaign(
        tmp_path / "c", "displacement", rig.Component(), seed=3, noise=0.01, only="random"
    )
    campaign = read_campaign(folder)
    base = fit_baseline(campaign, read_nominal(campaign), progress=lambda text: None)
    far = Term("stop", stop, (9.0, 1.0), "stop beyond 9 m", "")
    effect = Formula(Where("component", "strut", (0,)), [far])
    screened = screen(base.workshop, base.rung.fit, [effect])
    (limit,) = limits(Scored(base.rung, tuple(screened)), ())
    assert not limit.shown and not limit.amplitudes
