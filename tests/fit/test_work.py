"""Work is counted by what is simulated, and refused beyond what is allowed."""

from threading import Event

import pytest

from tests.fit.test_bench import MODEL, workshop_of
from tests.patience import PATIENCE_S
from wheelhop.effects import load_effects
from wheelhop.fit import OutOfBudget
from wheelhop.fit.work import PER_RECORD_S, PER_SECOND, PER_STEP


def test_steps_of_integration_are_work_and_so_are_records():
    """Friction asks for shorter steps; a record that is known is only looked at."""
    shop = workshop_of(jobs=2)
    friction = load_effects(None)["dry-friction"]
    held = MODEL.with_effect(friction, shop.parameters_of(friction)).with_values(
        {"dry-friction.front_N": 10.0}
    )
    bench = shop.benches["run"]
    seconds = bench.run.time_s[-1] - bench.run.time_s[0]
    costs = []
    for model in (MODEL, held, held):
        before, steps = shop.work.done, bench.simulator.steps
        bench.modelled(model, shop.systems(model))
        costs.append(shop.work.done - before)
        made = bench.simulator.steps - steps
        assert costs[-1] == pytest.approx(PER_RECORD_S * seconds + PER_STEP * made)
    linear, with_laws, known = (cost - PER_RECORD_S * seconds for cost in costs)
    assert with_laws > 1.9 * linear > 0.0 and known == pytest.approx(0.0)
    assert shop.work.seconds == pytest.approx(shop.work.done / PER_SECOND)


def test_beyond_what_is_allowed_nothing_is_begun():
    """What has been begun is finished; afterwards any amount is allowed again."""
    shop, done = workshop_of(jobs=2), []

    def one(amount):
        shop.work.add(amount)
        done.append(amount)
        return amount

    with pytest.raises(OutOfBudget), shop.work.limited(1.0):
        assert shop.each(one, [0.4 * PER_SECOND] * 2) == [0.4 * PER_SECOND] * 2
        assert len(shop.each(one, [0.4 * PER_SECOND] * 2)) == 2
        shop.each(one, [1.0])
    assert len(done) == 4
    assert shop.each(one, [1.0, 2.0]) == [1.0, 2.0]


def test_no_thread_is_left_at_work_where_one_is_interrupted():
    """A run's simulator remembers what it did last: nobody else may be at it."""
    shop, begun, raised, finished = workshop_of(jobs=2), Event(), Event(), []

    def work(item):
        if item == "interrupted":
            assert begun.wait(PATIENCE_S)
            raised.set()
            raise KeyboardInterrupt
        begun.set()
        assert raised.wait(PATIENCE_S)
        finished.append(sum(range(10**6)))

    with pytest.raises(KeyboardInterrupt):
        shop.each(work, ["interrupted", "other"])
    assert len(finished) == 1
