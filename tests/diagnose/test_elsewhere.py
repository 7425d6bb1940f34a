"""A held-out run that shows a stop which the fitted runs do not reach, and where its fit begins."""

from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.fit.linear import START, LinearBench, Shop, benches_of
from wheelhop.diagnose.confirm.validate import from_elsewhere
from wheelhop.fit import Free, fit, update

TRAVEL, FORESEEN, UNCERTAIN = 0.4, 0.5, 0.15
CLEARANCE = Free("stop.clearance", FORESEEN, UNCERTAIN, 1.0, is_shape=True)
STOP = SimpleNamespace(id="stop", acts_in=lambda setting: False)


class HeldOut(LinearBench):
    """A run that shows by how much the travel goes beyond the gap."""

    predicted = slice(None)
    energy = 1.0

    def record(self, model):
        gap = model.values["stop.clearance"]
        return 100.0 * self.matrix @ np.array([max(TRAVEL - gap, 0.0)])

    def records(self, trials):
        return [self.record(model) for model, _ in trials]

    def residual(self, model, systems):
        return self.measured[0] - self.record(model)


def parting(truth):
    """A workshop, the fit of a run that shows nothing of the stop, where a run begins that may, and
    the update that begins there."""
    shop, (bench,) = Shop(), benches_of(1, 0.0, count=1, names=("stop.clearance",), noise=0.0)
    held_out = HeldOut(**{field.name: getattr(bench, field.name) for field in fields(bench)})
    held_out.measured = held_out.record(at(truth))[None, :]
    bench.record = lambda model: bench.measured
    shop.of_role = {"fit": [bench], "validate": [held_out]}.__getitem__
    begin = replace(START, effects=(STOP,))
    fitted = fit(shop, begin.with_values({"stop.clearance": FORESEEN}), [CLEARANCE], [bench])
    return shop, fitted, fitted.model, update(shop, fitted, fitted.model, [held_out])


def at(gap):
    return SimpleNamespace(values={"stop.clearance": gap})


def test_a_stop_that_no_wheel_is_foreseen_to_reach_is_sought_within_what_is_uncertain():
    shop, fitted, foreseen, moved = parting(truth=0.3)
    assert moved.model.values["stop.clearance"] == pytest.approx(FORESEEN) and moved.cost > 1e3
    found = from_elsewhere(shop, fitted, foreseen, moved)
    assert found.model.values["stop.clearance"] == pytest.approx(0.3, abs=1e-3)
    assert found.cost < 3.0  # (0.2 / 0.15)² of what was believed


def test_an_update_that_costs_least_stays():
    shop, fitted, foreseen, moved = parting(truth=0.55)  # the stop is out of reach indeed
    assert from_elsewhere(shop, fitted, foreseen, moved) is moved


def test_of_numbers_that_are_no_shapes_no_other_place_is_sought():
    shop, fitted, foreseen, moved = parting(truth=0.3)
    plain = replace(fitted, shared=tuple(replace(f, is_shape=False) for f in fitted.shared))
    assert from_elsewhere(shop, plain, foreseen, moved) is moved
