"""`Log`: what a log file of the logger holds, found without believing anything it says."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import NUMBERS, check_room
from wheelhop.logger.beside import Beside
from wheelhop.logger.block import (
    BLOCK_BYTES,
    FIELDS,
    scan_bytes,
    scans_per_block,
    unpack_scans,
)
from wheelhop.logger.error import LoggerError
from wheelhop.logger.late import at_equal_steps
from wheelhop.logger.recording import CODE, Channel, Recording
from wheelhop.logger.settings import (
    CONVERSION_S,
    Settings,
    number,
    parse_settings,
)
from wheelhop.logger.survey import ROUND, Progress, Verdict, open_source, pieces

POINTS = frozenset(f"{end}{corner}" for end in "AB" for corner in range(1, 5))
LATE_END = 65535  # at which their count stays
MOST_INVENTED_BYTES = 1 << 30  # of rows without a sample, beyond which a gap is not believed


def log_name(session: int) -> str:
    """The name of a session's file on the card."""
    return f"HOP{session >> 16:05d}.HOP"


class Gap(NamedTuple):
    """Scans in no good block: `scans` from number `first` on, noticed at byte `offset`."""

    first: int
    scans: int
    offset: int


class Supply(NamedTuple):
    """The sensors' supply was found to be `mv` millivolts in scan number `scan`."""

    scan: int
    mv: float


class Damage(NamedTuple):
    """`blocks` blocks in a row inside the session, from byte `offset` on, that are not good."""

    offset: int
    blocks: int
    verdict: Verdict


@dataclass(frozen=True, eq=False)
class Log:
    """A session in a file. `source` is the file (or its bytes), `name` what errors call it.

    `header` and `summary` map keys to texts as in SPEC.md; the header is empty where block 0 is
    damaged, the summary None where the session was not closed. `blocks` (n,) are the facts of the
    good data blocks, `supply` the changes of the sensors' supply. `due` counts the scans that
    should be there: without a summary, those up to the last good block.
    """

    source: Path | bytes
    name: str
    session: int
    header: Mapping[str, str]
    summary: Mapping[str, str] | None
    blocks: NDArray[np.void]
    due: int
    lost: int
    late: int
    supply: tuple[Supply, ...]
    beside: Beside | None  # inputs beside the eight
    damage: tuple[Damage, ...]
    end_block: int  # number of the first block behind the session
    behind: int  # blocks from there to the end of the file
    spare_bytes: int  # behind the last whole block

    @property
    def settings(self) -> Settings:
        """Rate and channels. Raises LoggerError where the header is damaged."""
        return parse_settings(self.header, self.name)

    @property
    def written(self) -> int:
        """Scans in good blocks."""
        return int(self.blocks["count"].sum())

    @property
    def missing(self) -> int:
        """Scans in no good block: lost by the logger, or damaged since."""
        return self.due - self.written

    @property
    def gaps(self) -> tuple[Gap, ...]:
        """Where scans are missing."""
        first, count = self.blocks["first_scan"], self.blocks["count"]
        begins = np.append(0, first + count)
        ends = np.append(first, self.due)
        offsets = np.append(self.blocks["block"], self.end_block - 1) * BLOCK_BYTES
        return tuple(
            Gap(int(begins[i]), int(ends[i] - begins[i]), int(offsets[i]))
            for i in np.flatnonzero(ends > begins)
        )

    @property
    def clock_ppm(self) -> float | None:
        """Error of the logger's clock, the later of two measurements; None: never measured."""
        values = {**self.header, **(self.summary or {})}
        return number(values, "clock_ppm") if values.get("clock_ppm") else None

    @property
    def lowest_supply(self) -> Supply | None:
        """The lowest reading of the sensors' supply during the session; None: there is none.

        Its scan is -1 where the summary alone knows of it.
        """
        low = min(self.supply, key=lambda reading: reading.mv, default=None)
        told = number(self.summary or {}, "lowest_mv")
        if told > 0 and (low is None or told < low.mv):
            return Supply(-1, told)
        return low

    @property
    def goes_on_with(self) -> str:
        """The card's name of the file that this one goes on with, after a reset or a full file;
        empty: it stands alone."""
        before = self.header.get("continues", "")
        try:
            return log_name(int(before, 16)) if before else ""
        except ValueError:
            return ""

    @property
    def start_unix_s(self) -> float | None:
        """True time of the first conversion, seconds since 1970; None: nobody told the logger."""
        return number(self.header, "unix_s") or None

    def late_before(self, numbers: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return (m,) how many late triggers each scan has behind it: so many conversions later
        than its number says it was taken (SPEC.md, "Scans").

        A block tells those up to its last scan: where they have grown, its scans are taken to have
        half of the growth behind them.
        """
        told = np.concatenate([[0], self.blocks["late"], [self.late]]).astype(np.float64)
        ends = self.blocks["first_scan"] + self.blocks["count"]
        halfway: NDArray[np.float64] = (told[:-1] + told[1:]) / 2
        return halfway[np.searchsorted(ends, numbers, "right")]

    def scans(
        self, first: int = 0, stop: int | None = None, progress: Progress = lambda done: None
    ) -> Iterator[tuple[NDArray[np.int64], NDArray[np.unsignedinteger]]]:
        """Yield scans `first` … `stop` − 1 in pieces: numbers (m,) and sums (m, channels).

        A piece is of 1 MiB of file at most, whatever its length. Raises LoggerError where the
        header is damaged, or the file changes meanwhile.
        """
        settings = self.settings
        channels, bits = len(settings.inputs), settings.sum_bits
        size, capacity = scan_bytes(channels, bits), scans_per_block(channels, bits)
        stop = self.due if stop is None else stop
        ends = self.blocks["first_scan"] + self.blocks["count"]
        begin = int(np.searchsorted(ends, first, "right"))
        blocks = self.blocks[begin : np.searchsorted(self.blocks["first_scan"], stop)]
        done = 0
        with open_source(self.source) as file:
            for number, raw in pieces(file, int(blocks["block"][0])) if len(blocks) else ():
                upto = int(np.searchsorted(blocks["block"], number + len(raw)))
                facts = blocks[done:upto]
                if not len(facts):
                    continue
                fields = raw.view(FIELDS)[:, 0][facts["block"] - number]
                self._check_same(facts, fields)
                if fields["payload"][0, int(facts["count"][0]) * size :].any():
                    raise LoggerError(
                        f"{self.name}: byte {int(facts['block'][0]) * BLOCK_BYTES}: holds more than"
                        f" {channels} channels: the header is not of this session"
                    )
                numbers = facts["first_scan"][:, None] + np.arange(capacity)
                there = np.arange(capacity) < facts["count"][:, None]
                there &= (numbers >= first) & (numbers < stop)
                stored = fields["payload"][:, : capacity * size].reshape(-1, size)
                if not there.all():
                    numbers, stored = numbers[there], stored[there.ravel()]
                yield numbers.ravel(), unpack_scans(stored, channels, bits)
                done = upto
                progress(done / len(blocks))
                if done == len(blocks):
                    return
        if done < len(blocks):
            raise LoggerError(f"{self.name}: became shorter while it was read: try again")

    def _check_same(self, facts: NDArray[np.void], fields: NDArray[np.void]) -> None:
        same = (fields["first_scan"] == facts["first_scan"] % ROUND) & (
            fields["count"] == facts["count"]
        )
        same &= fields["session"] == self.session
        if not same.all():
            offset = int(facts["block"][~same][0]) * BLOCK_BYTES
            raise LoggerError(f"{self.name}: byte {offset}: changed while it was read: try again")

    def recording(
        self,
        first: int = 0,
        stop: int | None = None,
        progress: Progress = lambda done: None,
        by_number: bool = False,
    ) -> Recording:
        """Return scans `first` … `stop` − 1, all by default, in codes; missing ones are NaN.

        Where triggers were late, rows are the signal at equal steps of time, and there are more of
        them than scans; with `by_number` they are the scans as they are.

        Raises LoggerError where the header is damaged, or where they would fill the memory.
        """
        settings = self.settings
        stop = self.due if stop is None else min(stop, self.due)
        first = min(first, stop)
        channels = tuple(
            Channel(name, CODE, name if name in POINTS else "") for _, name in settings.inputs
        )
        gaps = [gap for gap in self.gaps if gap.first < stop and gap.first + gap.scans > first]
        self._check_believable(gaps, first, stop)
        check_room(Path(self.name), NUMBERS * (stop - first) * len(channels), LoggerError)
        values = np.empty((stop - first, len(channels)))
        for gap in gaps:
            values[max(gap.first - first, 0) : gap.first + gap.scans - first] = np.nan
        for numbers, sums in self.scans(first, stop, progress):
            run = slice(int(numbers[0]) - first, int(numbers[-1]) - first + 1)
            if run.stop - run.start == len(numbers):
                values[run] = settings.codes(sums)
            else:
                values[numbers - first] = settings.codes(sums)
        history = list(self._history(int(np.isnan(values[:, 0]).sum()), stop - first))
        late = self.late_before(np.arange(first, stop + 1))
        if self.late:
            history.append(_lateness(late, by_number))
        if (late[:-1] > late[0]).any() and not by_number:
            values = at_equal_steps(values, (late[:-1] - late[0]) / settings.steps)
        return Recording(
            values,
            float(settings.rate_hz),
            channels,
            start_s=settings.mean_instant_s + first / settings.rate_hz + late[0] * settings.step_s,
            averaging_s=settings.steps * settings.step_s,
            start_unix_s=self.start_unix_s,
            history=tuple(history),
            notes=self.notes,
        )

    def _check_believable(self, gaps: list[Gap], first: int, stop: int) -> None:
        inside = [min(gap.first + gap.scans, stop) - max(gap.first, first) for gap in gaps]
        invented = sum(inside) * len(self.settings.inputs) * 8
        if invented <= MOST_INVENTED_BYTES or sum(inside) <= self.written:
            return
        at = int(np.argmax(inside))
        raise LoggerError(
            f"{self.name}: byte {gaps[at].offset}: says that the {inside[at]} scans from number"
            f" {gaps[at].first} on are missing, {inside[at] / self.settings.rate_hz / 86400:.0f}"
            " days; decode the parts on either side with --scans FIRST:STOP"
        )

    def _history(self, missing: int, rows: int) -> Iterator[str]:
        settings = self.settings
        window_ms = settings.steps * settings.step_s * 1e3
        yield (
            f"logger {self.header.get('device', '?')}, session {self.session:08x}: means of"
            f" {settings.conversions} conversions, spread over {window_ms:g} ms"
        )
        if missing:
            yield f"{missing} of {rows} scans are missing: left out, as NaN"

    @property
    def notes(self) -> dict[str, str]:
        """What header and summary say, as a recording carries it."""
        notes = {**(self.summary or {}), **self.header, "session": f"{self.session:08x}"}
        if self.summary and "clock_ppm" in self.summary:
            notes["clock_ppm"] = self.summary["clock_ppm"]
        if self.summary and "supply_mv" in self.summary:  # the header's is that of the start
            notes["end_supply_mv"] = self.summary["supply_mv"]
        if self.beside and len(marks := self.beside.marks_s):
            notes["marks_s"] = " ".join(f"{at_s:.1f}" for at_s in marks)
        if low := self.lowest_supply:
            notes["low_supply_mv"] = f"{low.mv:.0f}"
            rate_hz = number(self.header, "rate_hz")
            if low.scan >= 0 and rate_hz > 0:
                notes["low_supply_s"] = f"{low.scan / rate_hz:.2f}"
        return notes


def _lateness(late: NDArray[np.float64], by_number: bool) -> str:
    """What late triggers mean for rows whose scans have so many behind them, (n + 1,)."""
    if late[-1] >= LATE_END:
        return f"{LATE_END} late triggers or more: times at the end are unknown"
    text = f"late triggers: by {late[-1] * CONVERSION_S * 1e3:g} ms at the end"
    return text + (", rows are by number all the same" if by_number else ", brought to equal steps")
