"""What columns of time, counters and frequencies are called, in a few languages."""

from __future__ import annotations

import re

TIMES = frozenset(
    (
        *("time", "timestamp", "timestamps", "stamp", "zeit", "zeitstempel", "temps", "tiempo"),
        *("tempo", "elapsed", "clock", "utc", "epoch", "uptime", "datetime", "date", "datum"),
        *("uhrzeit", "seconds", "secs", "sec", "millis", "micros", "nanos", "milliseconds"),
        *("microseconds", "nanoseconds", "msec", "usec", "hhmmss", "t"),
    )
)
UNITS = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("ms", "msec", "millis", "millisecond", "milliseconds"), "ms"),
    **dict.fromkeys(("us", "usec", "micros", "microsecond", "microseconds"), "us"),
    **dict.fromkeys(("ns", "nsec", "nanos", "nanosecond", "nanoseconds"), "ns"),
    **dict.fromkeys(("min", "minutes"), "min"),
}
"""Units of time as names have them."""
COUNTERS = frozenset(
    (
        *("count", "counter", "cnt", "sample", "samples", "index", "idx", "nr", "no", "num", "n"),
        *("number", "frame", "seq", "sequence", "packet", "id", "row", "record", "tick", "ticks"),
        *("scan", "unnamed", "messwert", "lfd", "point"),
    )
)
FREQUENCIES = frozenset(("frequency", "freq", "frequenz", "fréquence", "f"))


def words_in(label: str) -> set[str]:
    """The words of a name, "elapsedMs" or "time_ms" apart, in small letters."""
    apart = re.sub(r"([a-z])([A-Z])", r"\1 \2", label)
    return set(re.findall(r"[^\W\d_]+|#", apart.lower()))


def is_time_name(label: str) -> bool:
    """Whether a column is called time, in one language or another."""
    return bool(words_in(label) & TIMES) or label.strip().lower() == "x_value"  # LabVIEW's
