"""What goes wrong with the double, as plain configuration."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from wheelhop.hil_sim.signals import CHANNELS, SELF_TEST

SUPPLY_MV = 3300


@dataclass(frozen=True)
class DoubleFaults:
    """Faults of card, line and logger; moments are seconds of the double's time since its start.

    `stalls`: seconds for which the card is busy with a block, by its number in the file.
    `supply`: (moment, millivolts) from which on the sensors' supply is so high; 3300 before.
    `lost`: ranges of scan numbers that never reach memory; they are streamed all the same.
    `noise`, `dropped`, `duplicated`: chance of a byte of either direction to get a wrong bit, to
    vanish, to come twice. `garbled`: the line is heard at a wrong speed.
    `disconnects`: the line is gone from a moment on, for so long. `resets`: moments of restarts.
    `reply_delay_s`: what every reply waits. `self_test`: codes by which it shifts each sensor.
    """

    stalls: Mapping[int, float] = field(default_factory=dict)
    supply: tuple[tuple[float, int], ...] = ()
    lost: tuple[range, ...] = ()
    noise: float = 0.0
    dropped: float = 0.0
    duplicated: float = 0.0
    garbled: bool = False
    disconnects: tuple[tuple[float, float], ...] = ()
    resets: tuple[float, ...] = ()
    reply_delay_s: float = 0.0
    self_test: tuple[float, ...] = (SELF_TEST,) * CHANNELS
    seed: int = 0

    def supply_mv(self, time_s: float) -> int:
        """The sensors' supply at a moment."""
        past = [mv for since_s, mv in sorted(self.supply) if since_s <= time_s]
        return past[-1] if past else SUPPLY_MV
