"""The logger's memory for scans: two blocks, as in the firmware's `ring`."""

from dataclasses import dataclass, field

from wheelhop.hil_sim.double.kind import Kind
from wheelhop.logger.block import DATA, pack_block, scans_per_block


@dataclass
class Waiting:
    """A block that is being filled, or waits for the card."""

    first_scan: int = 0
    lost: int = 0
    late: int = 0
    scans: list[bytes] = field(default_factory=list)

    def pack(self, session: int, sequence: int, magic: bytes) -> bytes:
        """The block as it goes to the card."""
        return pack_block(
            DATA,
            session,
            sequence,
            first_scan=self.first_scan,
            lost=self.lost,
            late=self.late,
            count=len(self.scans),
            payload=b"".join(self.scans),
            magic=magic,
        )


class Memory:
    """Takes scans in, gives blocks out; counts what found no room."""

    def __init__(self, channels: int, kind: Kind) -> None:
        self.capacity = scans_per_block(channels, kind.sum_bits)
        self.lost = self.due = self.deepest = 0
        self.waiting: Waiting | None = None
        self._filling = Waiting()

    @property
    def room(self) -> int:
        """Scans that fit."""
        return 2 * self.capacity

    @property
    def depth(self) -> int:
        """Scans that wait."""
        return len(self._filling.scans) + (len(self.waiting.scans) if self.waiting else 0)

    @property
    def next_block(self) -> tuple[int, int]:
        """First scan of the block that goes to the card next, and scans lost before it."""
        block = self.waiting or self._filling
        return (block.first_scan, block.lost) if block.scans else (self.due, self.lost)

    def add(self, number: int, stored: bytes) -> None:
        """Take a scan; numbers that were skipped count as lost."""
        skipped = number - self.due
        self.lost += skipped
        self.due = number + 1
        full = len(self._filling.scans) == self.capacity
        if full or (skipped and self._filling.scans):
            if self.waiting:
                self.lost += 1
                return
            self._hand_over()
        if not self._filling.scans:
            self._filling.first_scan, self._filling.lost = number, self.lost
        self._filling.scans.append(stored)
        self.deepest = max(self.deepest, self.depth)
        if len(self._filling.scans) == self.capacity and not self.waiting:
            self._hand_over()

    def release(self) -> None:
        """The waiting block is on the card."""
        self.waiting = None
        if len(self._filling.scans) == self.capacity:
            self._hand_over()

    def finish(self, due: int) -> None:
        """No scan will come any more."""
        self.lost += due - self.due
        self.due = due
        if self._filling.scans and not self.waiting:
            self._hand_over()

    def _hand_over(self) -> None:
        self.waiting, self._filling = self._filling, Waiting()
