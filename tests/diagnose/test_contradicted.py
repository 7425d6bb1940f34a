"""An effect whose numbers, run by run, are against its nature is not accepted."""

import pytest

from tests.simulate.setup import ATV
from wheelhop.effects import OwnValues, RunSetting
from wheelhop.effects.wheel_imbalance import WheelImbalance

SPEEDS = (2.0, 3.0, 4.0, 5.0, 6.0)
EFFECT = WheelImbalance("front_left")


def run(speed, size, known_to=0.0):
    setting = RunSetting(f"at {speed}", speed, -2.0, 0.0, 10.0, True)
    names = [p.name for p in EFFECT.per_run(setting)]
    return OwnValues(setting, ATV | dict.fromkeys(names, size), dict.fromkeys(names, known_to))


def runs(exponent):
    """Amplitudes per speed squared of a force that grows with this power of the speed."""
    return [run(v, v ** (exponent - 2.0)) for v in SPEEDS]


@pytest.mark.parametrize(("exponent", "contradicted"), [(2.0, False), (0.0, True), (1.8, False)])
def test_a_force_that_does_not_grow_with_speed_is_no_imbalance(exponent, contradicted):
    assert EFFECT.contradicted(runs(exponent)) is contradicted


def test_two_runs_at_one_speed_cannot_contradict():
    assert not EFFECT.contradicted(runs(0.0)[:1])


@pytest.mark.parametrize(("known_to", "contradicted"), [(0.5, False), (0.01, True)])
def test_a_slow_run_that_shows_nothing_does_not_contradict(known_to, contradicted):
    """Nearly no force at walking pace: whatever the fit finds there is noise, and says so."""
    faint = [run(v, 0.03, 0.003) for v in (4.5, 4.75, 5.0, 5.5)]
    assert EFFECT.contradicted([run(2.0, 0.3, known_to), *faint]) is contradicted
