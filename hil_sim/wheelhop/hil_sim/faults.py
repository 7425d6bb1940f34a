"""What goes wrong with the card, and with the program's time, as plain configuration."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

BLOCK_SIZE = 512
REJECTIONS = {"crc": 0xEB, "write": 0xED}  # data response tokens


@dataclass(frozen=True)
class PowerCut:
    """The board's power fails in the middle of one write.

    The first `stored` bytes of write number `write` reach the card. The `tail` of the block keeps
    its old content, is erased ("ones"), or becomes noise.
    """

    write: int
    stored: int = BLOCK_SIZE
    tail: Literal["old", "ones", "noise"] = "old"


@dataclass(frozen=True)
class BadReply:
    """A command that the card does not carry out, and what it answers instead.

    It is the `nth` command of this number, counted from 0 since the faults were set; 0xFF is no
    answer at all.
    """

    command: int
    nth: int = 0
    reply: int = 0xFF


@dataclass(frozen=True)
class Faults:
    """Faults and times of card and program. Writes are blocks, counted from 0 since the card was
    inserted.

    `stalls`: seconds for which the card is busy after a write, beyond `write_busy`.
    `rejects`: writes refused with "crc" or "write" error; nothing is stored.
    `flips`: the bit, 0 … 4095, that is stored inverted.
    `pulled_at`: board time in seconds at which the card leaves its socket.
    `bad_replies`: commands that fail. `bounces`: from and to, board times in seconds between which
    the contacts are open; the card has lost its power by then.
    `holds`: from and to, board times in seconds between which the main program stands still and
    interrupts go on, as where a program waits for something.
    `ignores_crc`: the card answers CMD59 and checks nothing.
    `late_busy`: bytes that the card lets pass, after it is selected and after a block, before it
    shows that it is busy.
    `sheet_latency`: seconds before CSD and CID.
    `write_busy`, `read_latency`: seconds per block; `start_up`: from the first ACMD41 on.
    """

    stalls: Mapping[int, float] = field(default_factory=dict)
    rejects: Mapping[int, Literal["crc", "write"]] = field(default_factory=dict)
    flips: Mapping[int, int] = field(default_factory=dict)
    power_cut: PowerCut | None = None
    pulled_at: float | None = None
    bad_replies: Sequence[BadReply] = ()
    bounces: Sequence[tuple[float, float]] = ()
    holds: Sequence[tuple[float, float]] = ()
    ignores_crc: bool = False
    late_busy: int = 0
    sheet_latency: float = 100e-6
    write_protected: bool = False
    write_busy: float = 300e-6
    read_latency: float = 100e-6
    start_up: float = 20e-3

    def requests(self, cycles_per_second: int) -> Iterator[str]:
        """These faults as requests to the program `board`."""

        def cycles(seconds: float) -> int:
            return round(seconds * cycles_per_second)

        # The program takes 0 for "never".
        pulled = 0 if self.pulled_at is None else max(1, cycles(self.pulled_at))
        yield (
            f"card-times {cycles(self.write_busy)} {cycles(self.read_latency)} "
            f"{cycles(self.start_up)} {pulled} {int(self.write_protected)} "
            f"{cycles(self.sheet_latency)} {int(self.ignores_crc)} {self.late_busy}"
        )
        for bad in self.bad_replies:
            if not (0 <= bad.command < 64 and 0 <= bad.reply < 256):
                raise ValueError(f"faults: no command or no reply: {bad}")
            yield f"bad-reply {bad.command} {bad.nth} {bad.reply}"
        for start, end in self.bounces:
            if end < start:
                raise ValueError(f"faults: the contacts close at {end} s, before they open")
            yield f"loose {cycles(start)} {cycles(end)}"
        for start, end in self.holds:
            if end < start:
                raise ValueError(f"faults: the program goes on at {end} s, before it stops")
            yield f"hold-program {cycles(start)} {cycles(end)}"
        for write, seconds in self.stalls.items():
            yield f"fault stall {write} {cycles(seconds)}"
        for write, error in self.rejects.items():
            yield f"fault reject {write} {REJECTIONS[error]}"
        for write, bit in self.flips.items():
            if not 0 <= bit < 8 * BLOCK_SIZE:
                raise ValueError(f"faults: bit {bit} is not in 0 … {8 * BLOCK_SIZE - 1}")
            yield f"fault flip {write} {bit}"
        if (cut := self.power_cut) is not None:
            if not 0 <= cut.stored <= BLOCK_SIZE:
                raise ValueError(f"faults: {cut.stored} bytes are not in 0 … {BLOCK_SIZE}")
            yield f"fault cut {cut.write} {cut.stored} {cut.tail}"
