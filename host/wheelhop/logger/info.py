"""Everything about a log on one screen."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.logger.log import Log
from wheelhop.logger.settings import CONVERSION_S, find_settings, number
from wheelhop.logger.supply import supply_change
from wheelhop.logger.survey import Progress, Verdict

MOST_ROWS = 10  # of a list
WORDS = {
    Verdict.DAMAGED: "damaged",
    Verdict.STALE: "of another session",
    Verdict.EMPTY: "empty",
    Verdict.CONTRADICTS: "contradicts its neighbours",
}
ENDS = {
    "command": "closed by command",
    "button": "closed by button",
    "full": "closed: the file was full",
    "recovered": "closed after a reset",
    "gone": "ended: the card came back without the file",
}


@dataclass(frozen=True, eq=False)
class Ranges:
    """Of each channel (n_channels,): lowest, highest and mean code, and scans at either end of
    the converter's range."""

    lowest: NDArray[np.float64]
    highest: NDArray[np.float64]
    mean: NDArray[np.float64]
    at_end: NDArray[np.int64]


def channel_ranges(log: Log, progress: Progress = lambda done: None) -> Ranges | None:
    """Return the ranges of all channels; None of a log without a scan."""
    if not log.written:
        return None
    settings = log.settings
    n, largest = len(settings.inputs), settings.conversions * (2**settings.code_bits - 1)
    lowest, highest = np.full(n, np.inf), np.full(n, -np.inf)
    total, at_end = np.zeros(n), np.zeros(n, np.int64)
    for _, sums in log.scans(progress=progress):
        lowest = np.minimum(lowest, sums.min(axis=0))
        highest = np.maximum(highest, sums.max(axis=0))
        total += sums.sum(axis=0, dtype=np.int64)
        at_end += ((sums == 0) | (sums >= largest)).sum(axis=0)
    codes = settings.codes
    return Ranges(codes(lowest), codes(highest), codes(total / log.written), at_end)


def describe(log: Log, progress: Progress = lambda done: None) -> str:
    """Return what there is to know about a log, as text of some 80 columns."""
    head = log.header
    lines = [
        f"{log.name}: session {log.session >> 16} of logger {head.get('device', '?')},"
        f" firmware {head.get('firmware', '?')}"
    ]
    lines += [f"  {title:<12}{text}" for title, text in _facts(log) if text]
    lines += [f"  ! {text}" for text in warnings(log)]
    lines += _gaps(log) + _damage(log)
    if find_settings(log.header):
        lines += _ranges(log, channel_ranges(log, progress))
    return "\n".join(lines)


def warnings(log: Log) -> Iterator[str]:
    """Yield what a user should know before trusting the log, a line each."""
    head, tail = log.header, log.summary or {}
    digits = re.fullmatch(r"HOP(\d{5})\.HOP", Path(log.name).name, re.IGNORECASE)
    if digits and int(digits[1]) != log.session >> 16:
        yield (
            f"the name says session {int(digits[1])}: renamed, or that session never began and"
            " this is an older one"
        )
    if find_settings(head) is None:
        yield "the header is damaged: rate and channels are lost; see --header-from"
    if log.summary is None:
        yield "not closed: what was in the logger's memory at the end, and perhaps a block, is gone"
    if log.late:
        late_ms = f"{log.late * CONVERSION_S * 1e3:g} ms"
        yield f"late triggers: scans at the end are {late_ms} late; decode allows for it"
    if change := supply_change(log.notes):
        yield f"{change.text}: battery, plug and the 3.3 V regulator; see wheelhop health"
    if number(head, "config_errors"):
        yield f"{head['config_errors']} lines of HOP.CFG were not understood"
    if number(tail, "card_errors"):
        yield f"{tail['card_errors']} writes failed: another card may be better"
    if log.spare_bytes and log.summary is None:
        yield f"the file is cut off: {log.spare_bytes} bytes behind the last whole block"


def _facts(log: Log) -> Iterator[tuple[str, str]]:
    head, tail = log.header, log.summary or {}
    yield "id", f"{log.session:08x}"
    yield "name", head.get("name", "")
    yield "calibration", head.get("calibration", "")
    yield "header", f"taken from {head['header_from']}" if "header_from" in head else ""
    before = log.goes_on_with
    yield "goes on", f"with {before}, after a reset or a full file" if before else ""
    yield "start", _date(log.start_unix_s)
    settings = find_settings(head)
    if settings is None:
        yield "rate", "unknown"
    else:
        span_s = log.due / settings.rate_hz
        yield "duration", f"{_duration(span_s)}, {settings.rate_hz} scans a second"
        yield "channels", ", ".join(f"A{k} {name}" for k, name in settings.inputs)
    end = tail.get("end", "")
    yield "end", ENDS.get(end, end) if log.summary is not None else "not closed"
    yield "supply", _supply(log)
    yield "marks", ", ".join(f"{at_s:.1f} s" for at_s in log.beside.marks_s) if log.beside else ""
    yield "beside", ", ".join(log.beside.found) if log.beside else ""
    yield "reset", head.get("reset", "")
    yield "clock", "never measured" if log.clock_ppm is None else f"{log.clock_ppm:+g} ppm"
    yield "scans", _scans(log)
    yield "late", _count(log.late, "trigger")
    if "stall_ms" in tail:
        memory = f"memory {tail.get('deepest', '?')} of {tail.get('room', '?')} scans"
        errors = f"{tail.get('card_errors', '?')} errors"
        yield "card", f"longest stall {tail['stall_ms']} ms, {memory}, {errors}"
    bad = sum(damage.blocks for damage in log.damage)
    blocks = _count(log.end_block, "block")
    yield "file", f"{blocks}, {bad} of them not good, {log.behind} behind the end"


def _supply(log: Log) -> str:
    told = [number(values, "supply_mv") for values in (log.header, log.summary or {})]
    text = ", ".join(f"{mv:.0f} mV" for mv in told if mv > 0)
    low = log.lowest_supply
    if low and low.mv < min((mv for mv in told if mv > 0), default=np.inf):
        text += f"{', ' if text else ''}lowest {low.mv:.0f} mV"
    return text or "unknown"


def _scans(log: Log) -> str:
    text = f"{log.due} due, {log.written} written, {log.missing} missing"
    if log.missing:
        # A recovered file counts as lost what was damaged before, and says how much that is.
        lost = log.lost - int(number(log.summary or {}, "damaged"))
        who = "never heard" if log.header.get("source") == "stream" else "lost by the logger"
        text += f": {lost} {who}, {log.missing - lost} damaged since"
    return text


def _gaps(log: Log) -> list[str]:
    gaps = log.gaps
    if not gaps:
        return []
    rate = number(log.header, "rate_hz")
    rows = [f"  {_count(len(gaps), 'gap')}:"]
    for gap in gaps[:MOST_ROWS]:
        when = f" at {gap.first / rate:.2f} s, {gap.scans / rate:.2f} s long" if rate else ""
        rows.append(f"    {_count(gap.scans, 'scan')} from {gap.first} on{when}")
    return rows + _more(len(gaps))


def _damage(log: Log) -> list[str]:
    rows = [
        f"    {_count(damage.blocks, 'block')} from byte {damage.offset} on:"
        f" {WORDS[damage.verdict]}"
        for damage in log.damage
    ]
    if not rows:
        return []
    return ["  blocks that are not good:", *rows[:MOST_ROWS], *_more(len(rows))]


def _more(count: int) -> list[str]:
    return [f"    and {count - MOST_ROWS} more"] if count > MOST_ROWS else []


def _ranges(log: Log, ranges: Ranges | None) -> list[str]:
    if ranges is None:
        return ["  no scan in it"]
    rows = [f"  {'channel':<9}{'lowest':>9}{'mean':>9}{'highest':>9}  code, of 0 to 1023"]
    for i, (_, name) in enumerate(log.settings.inputs):
        clipped = f"  {_count(int(ranges.at_end[i]), 'scan')} clipped" if ranges.at_end[i] else ""
        rows.append(
            f"  {name:<9}{ranges.lowest[i]:9.2f}{ranges.mean[i]:9.2f}{ranges.highest[i]:9.2f}"
            + clipped
        )
    return rows


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _date(unix_s: float | None) -> str:
    if unix_s is None:
        return "unknown: no host has told the logger the time"
    try:
        return datetime.fromtimestamp(unix_s, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
    except (OverflowError, ValueError, OSError):
        return f"unix_s={unix_s:g} is no date"


def _duration(seconds: float) -> str:
    if seconds < 120:
        return f"{seconds:.2f} s"
    minutes, rest = divmod(seconds, 60)
    hours, minutes = divmod(int(minutes), 60)
    return f"{hours} h {minutes} min {rest:.0f} s" if hours else f"{minutes} min {rest:.1f} s"
