"""Effects that do what few others do: each such thing has a base class of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, OwnValues, Values
from wheelhop.track import Wheel, WheelPath


class Misstatement(Effect):
    """No physics but a mistake in what the campaign says."""

    def stated(self) -> Mapping[str, tuple[str, float]]:
        """What each of its parameters is the error of, as a dotted name, and what the campaign says
        of it."""
        raise NotImplementedError

    def remedy(self, theta: Values) -> str:
        """What to correct in the campaign."""
        raise NotImplementedError


class RandomHeights(Effect):
    """Adds heights nobody knows to the ground: they are estimated run by run, and its parameters,
    all shapes, are found by their evidence."""

    def height_density(self, theta: Values, wave_number_rad_m: Array) -> Array:
        """Spectral density S(κ) (k,), m³ per rad, one-sided, of random heights on top of the track,
        under left and right wheels independent of each other."""
        raise NotImplementedError


class WheelShape(Effect):
    """Makes a wheel roll otherwise than a rigid one."""

    def wheel_path(self, theta: Values, corner: int, wheel: Wheel) -> WheelPath:
        """The path of the wheel's centre over the track; of several such effects in a model the
        first counts."""
        raise NotImplementedError


class TiedRuns(Effect):
    """Ties what it leaves free in several runs: they may contradict it."""

    def contradicted(self, runs: Sequence[OwnValues]) -> bool:
        """Whether what was fitted run by run is against the effect's own nature."""
        raise NotImplementedError


class Ringing(Effect):
    """An instrument that still moves from before the record."""

    def lingering(self, theta: Values, since_s: Array, channels: Sequence[Channel]) -> Array | None:
        """What is left of motion before the record that no simulation knows, in the instrument
        itself (T, c), in the channels' units; ``since_s`` (T,) counts from the record's first
        sample."""
        raise NotImplementedError


METHODS: Mapping[str, type[Effect]] = {
    "stated": Misstatement,
    "remedy": Misstatement,
    "height_density": RandomHeights,
    "wheel_path": WheelShape,
    "contradicted": TiedRuns,
    "lingering": Ringing,
}
"""Which of these classes asks for a method: anywhere else nobody would call it."""
