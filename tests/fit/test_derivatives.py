"""Numbers that act one after the other in a run: derivatives taken at once as taken apart."""

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import ATV, TIME, campaign_of, model_of
from wheelhop.effects import load_effects
from wheelhop.fit import Free, Workshop, effect_run_parameters, moves

RUN = {
    "run": truth.Run(
        truth.Track("herringbone", {"amplitude_mm": 20.0, "pitch_mm": 800.0}), 4.0, 30.0, TIME
    )
}
LIBRARY = load_effects()


def step(free):
    return 1e-3 * free.scale


@pytest.mark.parametrize("name", ["speed-fluctuation", "left-right-drift", "cornering-roll"])
def test_together_as_apart(name):
    """The vehicle's memory is cut off where 2 % of it are left; derivatives serve to step by."""
    model, workshop = model_of(ATV, RUN), Workshop(campaign_of(RUN), model_of(ATV, RUN), jobs=1)
    (bench,) = workshop.benches.values()
    effect = LIBRARY[name]
    model = model.with_effect(effect, ())
    free = effect_run_parameters(bench.simulator.setting, effect)
    alone = [Free(f.name, f.mean, f.sigma, f.scale) for f in free]  # acting all the time
    systems = workshop.systems(model)
    (base,) = bench.records([(model, systems)])
    found = []
    for numbers in (free, alone):
        together = moves(bench, model, numbers, step)
        records = bench.records([(move.model, systems) for move in together])
        columns = {}
        for move, record in zip(together, records, strict=True):
            columns |= dict(move.parts(bench, record - base))
        found.append((len(together), np.stack([columns[i] for i in range(len(free))])))
    (few, quick), (many, exact) = found
    assert many == len(free) > 1.5 * few
    size = np.linalg.norm(exact, axis=1)
    assert (np.linalg.norm(quick - exact, axis=1) < 0.05 * size.max()).all()


def test_what_acts_at_one_time_is_never_moved_together():
    workshop = Workshop(campaign_of(RUN), model_of(ATV, RUN), jobs=1)
    (bench,) = workshop.benches.values()
    effect = LIBRARY["speed-fluctuation"]
    model = model_of(ATV, RUN).with_effect(effect, ())
    free = effect_run_parameters(bench.simulator.setting, effect)
    together = moves(bench, model, free, step)
    assert sorted(i for move in together for i in move.members) == list(range(len(free)))
    for move in together:
        for one, next_one in zip(move.members, move.members[1:], strict=False):
            assert free[one].span_s[1] + bench.memory_s <= free[next_one].span_s[0]
