"""Exchange: a wrong effect on the ladder makes way for the right one."""

from dataclasses import replace

import pytest

from tests import truth
from tests.diagnose.cases import CASES, LIBRARY, baseline_of
from wheelhop.diagnose.score import lead
from wheelhop.diagnose.search.ladder import fit_with
from wheelhop.diagnose.search.scored import BASELINE, Scored, Search, ids_of
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

    search = Search(base.workshop, library, 4, quiet)
    search.best(base.rung)

    first = exchange(search, wrong)
    assert first is not None
    assert ids_of(first) == {"dry-friction", "sensor-gain"}

    assert exchange(search, first) is None
    for name in ("dry-friction", "sensor-gain"):
        # What the confidence is made of: the best without each effect leaves clearly more.
        stand = search.stand(first, name)
        without, rival = stand.without, stand.rivals[0]
        assert stand.accepted is first
        assert name not in ids_of(without) | ids_of(rival)
        assert first.evidence > rival.evidence
        assert lead(first, without) >= lead(first, rival) > 0.03

    # What could stand for each is known: nothing is fitted again.
    told = []
    assert exchange(replace(search, progress=told.append), first) is None
    assert told == []
    # Where the library has been tried beside friction alone, nothing is simulated for the gain.
    alone = search.table[frozenset(["dry-friction"])].rung
    others = {k: v for k, v in search.table.items() if k == BASELINE}
    search = replace(search, progress=told.append, table=others)
    search.table[ids_of(alone)] = Scored(alone, looked=True)
    assert exchange(search, first) is None
    assert "could another effect stand for dry-friction?" in told
    assert "could another effect stand for sensor-gain?" not in told
    stand = search.stand(first, "sensor-gain")
    assert stand.rivals == [stand.without]
