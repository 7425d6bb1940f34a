"""A search that is ended has a verdict at any time, and says what it has not tried."""

import json
from types import SimpleNamespace

import pytest

from tests import truth
from tests.diagnose.cases import CASES, LIBRARY
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import to_json
from wheelhop.diagnose.posterior import AS_LIKELY
from wheelhop.diagnose.search.ladder import diagnose_gated
from wheelhop.diagnose.search.scored import Scored, Stand
from wheelhop.diagnose.verdict.conclude import _untried
from wheelhop.fit import OutOfBudget
from wheelhop.gate import gate
from wheelhop.vehicle import read_vehicle

NAMES = ("dry-friction", "digressive-damper", "asymmetric-damper", "driver-seat", "sensor-gain")
EFFECTS = {name: LIBRARY[name] for name in NAMES}


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """Eight short runs with friction, of which five effects are known."""
    case = CASES["dry-friction"]
    folder = truth.make_campaign(
        tmp_path_factory.mktemp("budget"),
        seed=case.seed,
        effects=case.hidden,
        short=True,
        seconds=case.seconds,
        draft=True,
    )
    return read_campaign(folder)


def diagnosed(campaign, budget_s=None, jobs=1, progress=lambda text: None):
    vehicle = read_vehicle(campaign.vehicle_file)
    gated = gate(campaign, vehicle)
    return diagnose_gated(gated, vehicle, EFFECTS, budget_s=budget_s, jobs=jobs, progress=progress)[
        1
    ]


@pytest.fixture(scope="module")
def unlimited(campaign):
    return diagnosed(campaign)


def test_what_is_found_within_the_budget_is_what_is_found_without(campaign, unlimited):
    assert unlimited.unfinished is None and unlimited.verdict == ("dry-friction",)
    enough = diagnosed(campaign, budget_s=1e3)
    assert enough.verdict == unlimited.verdict
    assert enough.confidence == unlimited.confidence
    assert to_json(enough) == to_json(unlimited)


def test_nothing_but_the_baseline_is_an_answer_too(campaign, unlimited):
    """Nothing of the library was tried: that something else is missing is no verdict yet."""
    found = diagnosed(campaign, budget_s=0.0)
    assert found.verdict == ("unknown",) and found.confidence == 0.0
    assert found.unfinished.ended_by == "budget" and found.unfinished.untried == ()
    assert found.ranking == () and len(found.ladder) == 1
    assert found.unfinished.sentence in found.explanation
    assert json.loads(json.dumps(to_json(found)))["unfinished"]["ended_by"] == "budget"
    rss = [d.ladder[0].rung.fit.rss for d in (found, unlimited)]
    assert rss[0] == pytest.approx(rss[1], rel=1e-12)


@pytest.mark.slow
def test_more_budget_is_never_less_sure_of_what_is_there(campaign, unlimited):
    """What is known of friction grows; a verdict does not depend on how many threads work."""
    said, sure = [], 0.0
    for budget_s in (0.5, 2.0, 4.0):
        found = diagnosed(campaign, budget_s=budget_s)
        said.append(found.verdict)
        if found.verdict[0] == "dry-friction":
            assert found.confidence >= sure - 1e-6
            sure = found.confidence
    assert said[0] == ("unknown",) and said[-1] == unlimited.verdict
    again = diagnosed(campaign, budget_s=budget_s, jobs=2)
    assert (again.verdict, again.unfinished) == (found.verdict, found.unfinished)
    assert again.confidence == pytest.approx(found.confidence, abs=1e-6)


@pytest.mark.parametrize("end", [KeyboardInterrupt, OutOfBudget])
@pytest.mark.parametrize("stage", ["screening", "simulating", "fitting the vehicle"])
def test_interrupted_anywhere_it_says_what_is_known_by_then(campaign, unlimited, end, stage):
    """Whoever is told of the progress may end it, as Ctrl-C does."""

    def stop(text):
        if text.startswith(stage):
            raise end

    found = diagnosed(campaign, progress=stop)
    expected = "budget" if end is OutOfBudget else "interrupted"
    assert found.unfinished.ended_by == expected
    names = {name for name, _ in found.unfinished.untried}
    if stage == "screening":
        assert found.verdict == ("unknown",) and found.confidence == 0.0
    elif stage == "simulating":
        assert found.verdict == ("unknown",) and "dry-friction" in names
        assert found.confidence < 0.5
    else:
        assert found.verdict[0] == "dry-friction" and "dry-friction" not in names
        assert 0.2 < found.confidence <= unlimited.confidence


@pytest.mark.parametrize(("came_to_its_choice", "chance"), [(True, 0.0), (False, AS_LIKELY)])
def test_what_a_look_passed_over_before_it_chose_is_no_doubt(came_to_its_choice, chance):
    """A search that goes to its end passes it over, too. One that is still at it may yet choose
    it: to first order it leaves half of what the effect accepted does."""
    model = SimpleNamespace(effects=(LIBRARY["dry-friction"],))
    accepted = SimpleNamespace(model=model, fit=SimpleNamespace(error=0.02))
    promising = SimpleNamespace(id="backlash", score=1.0, error=0.01)
    beside = Scored(None, (promising,), looked=came_to_its_choice)
    step, stand = SimpleNamespace(rung=accepted), Stand(accepted, None, (), beside, accepted)
    assert _untried(step, "dry-friction", beside, stand) == chance


def test_what_did_better_by_itself_may_do_as_well_beside_the_others():
    stand = SimpleNamespace(is_behind=True)
    assert _untried(None, "dry-friction", None, stand) == AS_LIKELY
