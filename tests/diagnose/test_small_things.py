"""A ladder ends where a further step lowers the error by little beside what the first one did."""

from math import log
from types import SimpleNamespace

import pytest

from tests import truth
from tests.diagnose.cases import CASES
from tests.diagnose.test_budget import EFFECTS
from wheelhop.campaign import read_campaign
from wheelhop.diagnose.search import ladder
from wheelhop.diagnose.search.ladder import SMALL, diagnose_gated
from wheelhop.diagnose.search.scored import BASELINE, Scored, Search, ids_of
from wheelhop.gate import gate
from wheelhop.vehicle import read_vehicle


@pytest.mark.slow  # the rule itself is asked below
def test_what_lowers_the_error_by_less_than_a_tenth_of_the_first_is_not_named(tmp_path):
    """Beside friction a channel's scale is off by so little that the error falls by a tenth.
    (`test_together` has effects that both count.)"""
    case = CASES["dry-friction"]
    off = {"channel": "B2", "gain_error": 0.012}
    folder = truth.make_campaign(
        tmp_path,
        seed=case.seed,
        effects={**case.hidden, "sensor-gain": off},
        short=True,
        seconds=case.seconds,
        draft=True,
    )
    campaign = read_campaign(folder)
    vehicle = read_vehicle(campaign.vehicle_file)
    gated = gate(campaign, vehicle)
    asked, all_of_it = (
        diagnose_gated(gated, vehicle, EFFECTS, to_the_end=to_the_end, jobs=1)[1]
        for to_the_end in (False, True)
    )
    assert all_of_it.verdict == ("dry-friction", "sensor-gain")
    baseline, first, second = (step.rung.error_judging for step in all_of_it.ladder)
    assert log(first / second) < SMALL * log(baseline / first)
    assert asked.verdict == ("dry-friction",)
    assert asked.unfinished is None and asked.confidence > 0.8


@pytest.mark.parametrize(
    ("error", "to_the_end", "taken"),
    [(0.0080, False, False), (0.0079, False, True), (0.0099, True, True)],
)
def test_after_a_fall_to_a_tenth_the_next_has_to_be_by_a_fifth(error, to_the_end, taken):
    """In logarithms a tenth as far: 10^(-1/10) is 0.794."""

    def rung(error, *names):
        model = SimpleNamespace(effects=[SimpleNamespace(id=name) for name in names])
        return SimpleNamespace(error_judging=error, model=model)

    errors = [rung(0.1), rung(0.01, "friction"), rung(error, "friction", "gain")]
    steps = [SimpleNamespace(rung=one, above_floor=False) for one in errors[:2]]
    search = Search(SimpleNamespace(noise=1.0), {}, 4, print, to_the_end=to_the_end)
    search.table[BASELINE] = Scored(errors[0])
    chosen = SimpleNamespace(rung=errors[2])
    search.table[ids_of(errors[1])] = Scored(errors[1], chosen=chosen)
    better, _ = ladder._better(search, steps)
    assert better is (errors[2] if taken else None)
