"""The logger as its user sees it: a board with the firmware, commands, frames, files."""

import itertools
import re
from collections.abc import Iterable
from dataclasses import dataclass

from tests.firmware.promises.reader import (
    Acknowledgement,
    Frame,
    Log,
    acknowledgement,
    checked,
    parse_frame,
    read_log,
    streamed,
)
from wheelhop.hil_sim import Board, CardImage

ADC_VECTOR = 21  # of the ATmega328P
# What fsck.vfat may remark after a cut: space that nobody owns, copies and sums to be refreshed.
HARMLESS = re.compile(
    r"""fsck\.fat\ .* | .*files,\ \d+/\d+\ clusters | Leaving\ filesystem\ unchanged\. |
    Reclaimed\ \d+\ unused\ clusters?\ \(\d+\ bytes\)\. |
    FATs\ differ\ but\ appear\ to\ be\ intact\. | \ \ Using\ first\ FAT\. |
    Free\ cluster\ summary\ wrong\ .* | \ \ Auto-correcting\. |
    /HOP\d+\.HOP | \ \ File\ size\ is\ \d+\ bytes,\ cluster\ chain\ length\ is\ >\ \d+\ bytes\. |
    \ \ Truncating\ file\ to\ \d+\ bytes\. |""",
    re.VERBOSE,
)


@dataclass(frozen=True)
class Reply:
    ok: bool
    text: str
    lines: list[str]

    @property
    def values(self) -> dict[str, str]:
        return dict(line.split("=", 1) for line in self.lines)


class Logger:
    """A board with the firmware, and what has come from it over the serial line."""

    def __init__(self, elf, card: CardImage | None = None, **options):
        self.card = card
        self.board = Board(elf, card, **options)
        self.frames: list[Frame] = []
        self.broken: list[bytes] = []  # pieces between zeros that are no frames
        self.raw = bytearray()  # everything
        self._piece = bytearray()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.board.close()

    def collect(self) -> None:
        """Take what has come."""
        times, data = self.board.serial.read_timed()
        self.raw += data
        for time_s, byte in zip(times, data, strict=True):
            if byte:
                self._piece.append(byte)
                continue
            if self._piece:
                frame = parse_frame(bytes(self._piece), float(time_s))
                if frame is None:
                    self.broken.append(bytes(self._piece))
                else:
                    self.frames.append(frame)
            self._piece.clear()

    def run(self, seconds: float) -> None:
        self.board.run(seconds)
        self.collect()

    def until(self, condition, timeout: float = 20.0, step: float = 5e-3) -> None:
        def holds() -> bool:
            self.collect()
            return condition()

        assert self.board.run_until(holds, timeout, step), (
            f"not within {timeout} s; state {self.board.state}, last frames "
            f"{[(f.kind, f.payload) for f in self.frames[-8:]]}"
        )

    def boot(self) -> None:
        """Run until the logger says that it is ready."""
        begin = len(self.frames)
        self.until(lambda: any(m.startswith("ready") for m in self.texts("M", begin)), 10.0)

    def command(self, line: str, timeout: float = 15.0, step: float = 5e-3) -> Reply:
        """Send, and run until it is answered."""
        begin = len(self.frames)
        self.board.serial.write(checked(line))
        self.until(lambda: any(f.kind in "KE" for f in self.frames[begin:]), timeout, step)
        new = self.frames[begin:]
        end = next(f for f in new if f.kind in "KE")
        return Reply(end.kind == "K", end.text, [f.text for f in new if f.kind == "L"])

    def texts(self, kind: str, begin: int = 0) -> list[str]:
        return [f.text for f in self.frames[begin:] if f.kind == kind]

    def acknowledgements(self, until: float = float("inf")) -> list[Acknowledgement]:
        """Those that had been sent by a moment of board time."""
        return [acknowledgement(f) for f in self.frames if f.kind == "B" and f.time_s < until]

    def streamed(self, channels: int = 8) -> dict[tuple[int, int], tuple[int, ...]]:
        """Sums by session and scan number."""
        frames = (streamed(f, channels) for f in self.frames if f.kind == "D")
        return {(session, number): sums for session, number, sums in frames}

    def flashes(self, seconds: float = 12.0) -> int | None:
        """Flashes in each group of the LED's, as counted from outside; needs `trace`."""
        self.board.trace()
        self.run(seconds)
        rises = [time_s for time_s, on in self.board.trace().led() if on]
        groups: list[int] = []
        for before, now in itertools.pairwise([-10.0, *rises]):
            if now - before > 0.6:
                groups.append(0)
            groups[-1] += 1
        whole = set(groups[1:-1])  # the first and the last may be cut off
        return whole.pop() if len(whole) == 1 else None

    def summary(self) -> dict[str, str]:
        """The last summary that came over the line."""
        return dict(text.split("=", 1) for text in self.texts("S"))

    def log(self, name: str | None = None) -> Log:
        """The file of this name, or the last session's."""
        assert self.card is not None
        log = read_log(self.card.read(name or last_session(self.card.files())))
        assert log is not None
        return log


def last_session(names: Iterable[str]) -> str:
    return max(name for name in names if name.endswith(".HOP"))


def configure(card: CardImage, text: str) -> CardImage:
    """Put a HOP.CFG on the card."""
    card.write("HOP.CFG", text.encode())
    return card


def faults_of(card: CardImage) -> list[str]:
    """What fsck.vfat finds, but for what an interruption may leave and no file suffers from."""
    return [line for line in card.check().splitlines() if not HARMLESS.fullmatch(line)]
