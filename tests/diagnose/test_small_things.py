"""A ladder ends where a further step lowers the error by little beside what the first one did."""

from math import log

from tests import truth
from tests.diagnose.cases import CASES
from tests.diagnose.test_budget import EFFECTS
from wheelhop.campaign import read_campaign
from wheelhop.diagnose.search.ladder import SMALL, diagnose_gated
from wheelhop.gate import gate
from wheelhop.vehicle import read_vehicle


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
