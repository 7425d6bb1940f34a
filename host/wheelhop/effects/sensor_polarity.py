"""One channel is inverted, or two are swapped."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, Values
from wheelhop.effects.parameters import Parameter, Switch


class SensorPolarity(Effect):
    """The cable was soldered, or plugged, the wrong way."""

    id = "sensor-polarity"
    place = "sensor"
    title = "one channel is inverted, or two are swapped"
    equation = r"y_i = -a_i, \quad\text{or}\quad y_i = a_j,\ y_j = a_i"
    source = "wiring; a switch, so nothing is fitted"

    def __init__(self, channels: str = "") -> None:
        self.channels = channels

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """Any channel inverted ("B3"), any two of one quantity swapped ("A1/A2")."""
        return list(_wirings([*enumerate(channels)]))

    def with_choice(self, choice: str) -> SensorPolarity:
        """This fault in the channel or the pair `choice`."""
        return SensorPolarity(choice)

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """On or off."""
        return (Switch("wrong", "1", "1: inverted or swapped"),)

    def sense(
        self, theta: Values, acceleration: Array, channels: Sequence[Channel], rate_hz: float
    ) -> Array:
        """Invert or swap, by the share `wrong`."""
        return acceleration + theta["wrong"] * (self._wired(acceleration, channels) - acceleration)

    def restore(
        self, theta: Values, measured: Array, channels: Sequence[Channel], rate_hz: float
    ) -> Array:
        """Wiring is its own inverse."""
        return self.sense(theta, measured, channels, rate_hz)

    def _wired(self, acceleration: Array, channels: Sequence[Channel]) -> Array:
        numbered = [*enumerate(channels)]
        affected = list((_wirings(numbered[::-1]) | _wirings(numbered))[self.channels])
        wired = np.array(acceleration)
        if len(affected) == 1:
            wired[:, affected] *= -1.0
        else:
            wired[:, affected] = acceleration[:, affected[::-1]]
        return wired


def _wirings(numbered: Sequence[tuple[int, Channel]]) -> dict[str, tuple[int, ...]]:
    """The columns that each choice concerns, of channels with the numbers of theirs. A choice is
    what people read, and names may hold any character, so none is ever taken apart; a pair that
    reads as another choice has one "/" more."""
    found: dict[str, tuple[int, ...]] = {c.name: (i,) for i, c in numbered}
    for (i, a), (j, b) in combinations(numbered, 2):
        if a.quantity != b.quantity:
            continue
        between = "/"
        while (choice := f"{a.name}{between}{b.name}") in found:
            between += "/"
        found[choice] = (i, j)
    return found
