"""A session of the double: from scans to blocks in a file."""

from collections.abc import Mapping
from pathlib import Path

from wheelhop.hil_sim.double.card import Card, log_name
from wheelhop.hil_sim.double.memory import Memory
from wheelhop.hil_sim.double.settings import Settings
from wheelhop.logger.block import BLOCK_BYTES, HEADER, SUMMARY, SUPPLY, pack_block, pack_text
from wheelhop.logger.frames import Acknowledgement

MEBIBYTE = 1 << 20
SUPPLY_STEP_MV = 50  # a larger change goes into the file
SOON = 8  # scans that may wait when it does
SPARE_BLOCKS = 5  # what the firmware leaves free for the last blocks


class Session:
    """The running session, or the last one; `blocks`, `written` and so on are safe on the card."""

    def __init__(
        self, card: Card, identity: int, settings: Settings, stalls: Mapping[int, float]
    ) -> None:
        self.id = identity
        self.memory = Memory(len(settings.recorded), settings.kind)
        self._magic = settings.kind.magic
        self.blocks = self.written = self.unsent = self.stall_ms = 0
        self.end = ""
        self.lowest_mv = 0
        self._told_mv = 0
        self._untold: tuple[int, int] | None = None  # scan and millivolts
        self._card = card
        self._stalls = stalls
        self._most_blocks = settings.size_mb * MEBIBYTE // BLOCK_BYTES
        self._busy_until_s = 0.0
        self._in_flight = 0  # scans of the block that the card is busy with
        self._writing = False

    @property
    def number(self) -> int:
        """The session number."""
        return self.id >> 16

    @property
    def running(self) -> bool:
        """Whether it has not ended."""
        return not self.end

    @property
    def full(self) -> bool:
        """Whether the file takes no more."""
        return self.blocks + SPARE_BLOCKS > self._most_blocks

    @property
    def idle(self) -> bool:
        """Whether all that came is safe on the card."""
        return not self.memory.depth and not self._writing and self._untold is None

    def read_supply(self, scan: int, mv: int) -> None:
        """Take a reading of the sensors' supply."""
        self.lowest_mv = min(self.lowest_mv or mv, mv)
        changed = abs(mv - self._told_mv) > SUPPLY_STEP_MV
        if changed and (self._untold is None or mv < self._untold[1]):
            self._untold = scan, mv

    @property
    def path(self) -> Path:
        """The file."""
        return self._card.folder / log_name(self.number)

    def begin(self, header: Mapping[str, object]) -> None:
        """Write the header."""
        self._told_mv = int(str(header["supply_mv"]))
        text = pack_text(header)
        block = pack_block(HEADER, self.id, 0, payload=text, magic=self._magic)
        self._card.append(self.number, block)
        self.blocks = 1

    def poll(self, now_s: float) -> bool:
        """Bring the card one step further; True when a block has become safe."""
        if now_s < self._busy_until_s:
            return False
        if self._writing:
            self._writing = False
            self.blocks += 1
            self.written += self._in_flight
            return True
        if (waiting := self.memory.waiting) is not None:
            self._card.append(self.number, waiting.pack(self.id, self.blocks, self._magic))
            stall_s = self._stalls.get(self.blocks, 0.0)
            self.stall_ms = max(self.stall_ms, round(1000 * stall_s))
            self._busy_until_s = now_s + stall_s
            self._in_flight, self._writing = len(waiting.scans), True
            self.memory.release()
        elif self._untold and self.memory.depth < SOON:
            scan, self._told_mv = self._untold
            self._untold = None
            first_scan, lost = self.memory.next_block
            text = pack_text({"supply_mv": self._told_mv, "scan": scan})
            block = pack_block(
                SUPPLY,
                self.id,
                self.blocks,
                first_scan=first_scan,
                lost=lost,
                payload=text,
                magic=self._magic,
            )
            self._card.append(self.number, block)
            self._in_flight, self._writing = 0, True
        return False

    def close(self, end: str, rest: Mapping[str, object]) -> None:
        """Write the summary; `rest` is what the session does not know of itself."""
        self.end = end
        memory = self.memory
        block = pack_block(
            SUMMARY,
            self.id,
            self.blocks,
            first_scan=memory.due,
            lost=memory.lost,
            payload=pack_text({**self.summary(), **rest}),
            magic=self._magic,
        )
        self._card.append(self.number, block)
        self.blocks += 1

    def summary(self) -> dict[str, object]:
        """The lines of the summary that are the session's own."""
        memory = self.memory
        return {
            "end": self.end,
            "due": memory.due,
            "written": self.written,
            "lost": memory.lost,
            "late": 0,
            "stall_ms": self.stall_ms,
            "deepest": memory.deepest,
            "room": memory.room,
            "card_errors": 0,
            "unsent": self.unsent,
        }

    def acknowledgement(self) -> Acknowledgement:
        """What a `B` frame says."""
        memory = self.memory
        return Acknowledgement(
            *(self.id, self.blocks, memory.due, self.written, memory.lost),
            *(0, self.stall_ms, memory.deepest, 0),
        )
