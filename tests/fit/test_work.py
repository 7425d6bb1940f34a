"""Work is counted by what is simulated, and refused beyond what is allowed."""

from threading import Event

import pytest

from tests.fit.test_bench import MODEL, workshop_of
from tests.patience import PATIENCE_S
from wheelhop.effects import load_effects
from wheelhop.fit import OutOfBudget
from wheelhop.fit.work import SIMULATED_PER_SECOND, WITH_LAWS


def test_a_second_of_driving_is_a_second_of_work_and_laws_cost_more():
    shop = workshop_of(jobs=2)
    friction = load_effects(None)["dry-friction"]
    held = MODEL.with_effect(friction, shop.parameters_of(friction)).with_values(
        {"dry-friction.front_N": 10.0}
    )
    bench = shop.benches["run"]
    seconds = bench.run.time_s[-1] - bench.run.time_s[0]
    for model, cost in ((MODEL, 1.0), (held, WITH_LAWS)):
        before = shop.work.done
        bench.modelled(model, shop.systems(model))
        assert shop.work.done - before == pytest.approx(cost * seconds)
    before, trial = shop.work.done, (MODEL, shop.systems(MODEL))
    bench.changes(trial, [trial, trial])
    assert shop.work.done - before == pytest.approx(2.0 * seconds)
    assert shop.work.seconds == pytest.approx(shop.work.done / SIMULATED_PER_SECOND)


def test_beyond_what_is_allowed_nothing_is_begun():
    """What has been begun is finished; afterwards any amount is allowed again."""
    shop, done = workshop_of(jobs=2), []

    def one(amount):
        shop.work.add(amount)
        done.append(amount)
        return amount

    with pytest.raises(OutOfBudget), shop.work.limited(1.0):
        assert shop.each(one, [0.4 * SIMULATED_PER_SECOND] * 2) == [0.4 * SIMULATED_PER_SECOND] * 2
        assert len(shop.each(one, [0.4 * SIMULATED_PER_SECOND] * 2)) == 2
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
