"""Exchange: a wrong effect on the ladder makes way for the right one."""

import pytest

from tests import truth
from tests.diagnose.cases import CASES, LIBRARY, baseline_of
from wheelhop.diagnose.score import lead
from wheelhop.diagnose.search.ladder import fit_with
from wheelhop.diagnose.search.look import Look
from wheelhop.diagnose.search.together import exchange

FEW = ("dry-friction", "digressive-damper", "sensor-gain", "driver-seat")


def quiet(text):
    pass


@pytest.mark.slow
def test_whichever_effect_came_first_the_right_ones_stay(tmp_path):
    """Friction and a wrong gain are hidden, the ladder has come by a digressive damper and the
    gain: friction takes the damper's place, and then nothing is exchanged any more."""
    hidden = {**CASES["dry-friction"].hidden, **CASES["sensor-gain"].hidden}
    folder = truth.make_campaign(tmp_path, seed=104, effects=hidden, short=True)
    base = baseline_of(folder)
    library = {name: LIBRARY[name] for name in FEW}
    wrong = fit_with(base, [library["digressive-damper"], library["sensor-gain"]], quiet)[-1]

    first = exchange(base.workshop, wrong, {}, [], library, quiet)
    assert first.rung is not None
    assert {e.id for e in first.rung.model.effects} == {"dry-friction", "sensor-gain"}

    second = exchange(base.workshop, first.rung, {}, [], library, quiet)
    assert second.rung is None
    assert set(second.stands) == {"dry-friction", "sensor-gain"}
    for name, stand in second.stands.items():
        # What the confidence is made of: the best without each effect leaves clearly more.
        assert name not in {e.id for e in stand.without.model.effects}
        assert name not in {e.id for e in stand.rival.model.effects}
        assert first.rung.evidence > stand.rival.evidence
        assert lead(first.rung, stand.without) >= lead(first.rung, stand.rival) > 0.03

    # A look has tried the library beside friction alone: nothing is simulated in the gain's place.
    alone = second.stands["sensor-gain"].without
    told = []
    looks = [Look(alone, (), (), None)]
    third = exchange(base.workshop, first.rung, {}, looks, library, told.append)
    assert told == ["could another effect stand for dry-friction?"]
    assert third.stands["sensor-gain"].rival is third.stands["sensor-gain"].without
