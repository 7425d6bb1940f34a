"""Where along the track a vehicle really was, told window by window."""

import numpy as np
import pytest

from wheelhop.campaign import Channel
from wheelhop.effects.base import RunSetting
from wheelhop.effects.phase import shift_along

SPEED = 2.0


class Driven:
    """Two sensors over waves of 0.7 and 0.31 m; the left one's side gains on the model, the right
    one's falls back. ``pace`` is the real speed over the nominal one."""

    channels = (Channel("A1", "A1"), Channel("A2", "A2"))

    def __init__(self, pace):
        self.pace, self.simulated = pace, 0

    def time_s(self, run_id):
        return np.arange(1000) / 100.0

    def ahead_m(self, time_s):
        return 0.12 * np.sin(0.5 * time_s)[:, None] * np.array([1.0, -1.0])

    def _signal(self, ahead_m):
        way = self.pace * SPEED * self.time_s("")[:, None] + ahead_m
        return np.sin(2 * np.pi * way / 0.7) + 0.5 * np.sin(2 * np.pi * way / 0.31)

    def measured(self, run_id):
        return self._signal(self.ahead_m(self.time_s("")))

    def all_modelled(self, run_id, trials):
        self.simulated += len(trials)
        return [self._signal(trial["start_m"]) for trial in trials]


@pytest.mark.parametrize("pace", [0.4, 1.0, 1.5])
def test_either_side_is_followed_and_few_shifts_are_simulated(pace):
    """To 22 mm, with shifts 15 mm apart and windows of a second. One simulation tells several
    shifts and both sides, and the run need not keep its nominal speed."""
    probe, run = Driven(pace), RunSetting("r", SPEED, 0.0, 0.0, 10.0, True)
    time, (left, right) = shift_along(probe, run, (0, 2), (1, 3))
    true = probe.ahead_m(time)
    np.testing.assert_allclose(left, true[:, 0], atol=0.022)
    np.testing.assert_allclose(right, true[:, 1], atol=0.022)
    assert probe.simulated <= 7
