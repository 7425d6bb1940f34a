"""An effect whose numbers, run by run, are against its nature is not accepted."""

import pytest

from wheelhop.effects import RunSetting
from wheelhop.effects.wheel_imbalance import WheelImbalance

SPEEDS = (2.0, 3.0, 4.0, 5.0, 6.0)


def runs(exponent):
    """Amplitudes per speed squared of a force that grows with this power of the speed."""
    found = []
    for speed in SPEEDS:
        setting = RunSetting(f"at {speed}", speed, -2.0, 0.0, 10.0, True)
        size = speed ** (exponent - 2.0)
        effect = WheelImbalance("front_left")
        names = [p.name for p in effect.per_run(setting)]
        found.append((setting, dict.fromkeys(names, size)))
    return found


@pytest.mark.parametrize(("exponent", "contradicted"), [(2.0, False), (0.0, True), (1.8, False)])
def test_a_force_that_does_not_grow_with_speed_is_no_imbalance(exponent, contradicted):
    assert WheelImbalance("front_left").contradicted(runs(exponent)) is contradicted


def test_two_runs_at_one_speed_cannot_contradict():
    assert not WheelImbalance("front_left").contradicted(runs(0.0)[:1])
