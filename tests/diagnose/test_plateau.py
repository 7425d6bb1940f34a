"""A fit that came to rest where a stop is never reached, and how it leaves."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.fit.linear import START, Shop, benches_of
from wheelhop.diagnose.confirm.in_full import off_the_plateau
from wheelhop.fit import Free, fit

TRAVEL, GAP = 0.4, 0.3
CLEARANCE = Free("stop.clearance", 0.5, 0.5, 1.0, is_shape=True)
BALANCE = Free("stop.balance", 0.0, 0.3, 1.0, is_shape=True)
STOP = SimpleNamespace(id="stop", acts_in=lambda setting: False)


def stops(numbers):
    """The rear stop's gap shows as it is; the front one's as far as the travel goes beyond it."""
    clearance, balance = numbers
    return np.array([clearance - balance, max(TRAVEL - clearance - balance, 0.0)])


class Stops(Shop):
    def __init__(self, truth):
        super().__init__()
        (bench,) = benches_of(1, 0.0, count=1, names=("stop.clearance", "stop.balance"), noise=0.0)
        bench.record = lambda model: (
            100.0
            * bench.matrix
            @ stops([model.values["stop.clearance"], model.values["stop.balance"]])
        )
        at = SimpleNamespace(values={"stop.clearance": truth[0], "stop.balance": truth[1]})
        bench.measured = bench.record(at)
        self.benches = [bench]

    def of_role(self, role):
        return self.benches

    def fitted(self, balance=BALANCE):
        """From a gap of half a metre front and rear."""
        begin = START.with_values({"stop.clearance": 0.5, "stop.balance": 0.0})
        model = replace(begin, effects=(STOP,))
        return fit(self, model, (CLEARANCE, balance), self.benches)


def numbers(found):
    return [found.model.values["stop.clearance"], found.model.values["stop.balance"]]


def test_a_stop_that_the_fit_never_reached_is_found_where_it_is_believed_to_be():
    """The rear gap is told; half of what it is too small by went to the balance, and took the front
    stop out of reach."""
    shop = Stops((GAP, 0.0))
    stuck = shop.fitted()
    assert sum(numbers(stuck)) > TRAVEL and stuck.cost > 1e3
    found = off_the_plateau(shop, stuck)
    assert numbers(found) == pytest.approx([GAP, 0.0], abs=1e-3)
    assert found.cost < 1.0


def test_a_fit_that_costs_least_stays():
    shop = Stops((0.45, 0.15))  # the front stop is out of reach indeed
    found = shop.fitted()
    assert off_the_plateau(shop, found) is found


def test_of_what_nothing_is_believed_no_place_is_better_than_another():
    shop = Stops((GAP, 0.0))
    stuck = shop.fitted(replace(BALANCE, sigma=np.inf))
    held = replace(stuck, shared=tuple(replace(f, sigma=np.inf) for f in stuck.shared))
    assert off_the_plateau(shop, held) is held
