"""What columns of time, counters and frequencies are called, in a few languages."""

from __future__ import annotations

import re

TIMES = frozenset(
    (
        *("time", "timestamp", "timestamps", "stamp", "zeit", "zeitstempel", "temps", "tiempo"),
        *("tempo", "elapsed", "clock", "utc", "epoch", "uptime", "datetime", "date", "datum"),
        *("uhrzeit", "seconds", "secs", "sec", "millis", "micros", "nanos", "milliseconds"),
        *("microseconds", "nanoseconds", "msec", "usec", "hhmmss", "t"),
        *("sekunden", "millisekunden", "mikrosekunden", "nanosekunden"),
    )
)
UNITS = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds", "sekunden"), "s"),
    **dict.fromkeys(("ms", "msec", "millis", "millisecond", "milliseconds", "millisekunden"), "ms"),
    **dict.fromkeys(("us", "usec", "micros", "microsecond", "microseconds", "mikrosekunden"), "us"),
    **dict.fromkeys(("ns", "nsec", "nanos", "nanosecond", "nanoseconds", "nanosekunden"), "ns"),
    **dict.fromkeys(("min", "minutes", "minuten"), "min"),
}
"""Units of time as names have them."""
COUNTERS = frozenset(
    (
        *("count", "counter", "cnt", "sample", "samples", "index", "idx", "nr", "no", "num", "n"),
        *("number", "frame", "seq", "sequence", "packet", "id", "row", "record", "tick", "ticks"),
        *("scan", "unnamed", "messwert", "lfd", "point"),
    )
)
OTHERS = frozenset(
    (
        *("distance", "dist", "angle", "temperature", "temp", "speed", "velocity", "position"),
        *("pressure", "force", "travel", "displacement", "acceleration", "constant", "weg"),
    )
)
"""Quantities whose names may hold a word of time: "distance since date"."""
FREQUENCIES = frozenset(("frequency", "freq", "frequenz", "fréquence", "f"))


def words_in(label: str) -> set[str]:
    """The words of a name, "elapsedMs" or "time_ms" apart, in small letters."""
    apart = re.sub(r"([a-z])([A-Z])", r"\1 \2", label)
    return set(re.findall(r"[^\W\d_]+|#", apart.lower()))


def time_words(label: str) -> set[str]:
    """The words of a name, but for a unit of time that something is counted per: "Revs per sec"."""
    head, *behind = re.split(r"/|\bper\b", label, maxsplit=1)
    words = words_in(label)
    return words - UNITS.keys() if behind and not words_in(head) & TIMES else words


def is_time_name(label: str) -> bool:
    """Whether a column is called time, in one language or another, and not another quantity."""
    words = time_words(label)
    x_value = label.strip().lower() == "x_value"  # LabVIEW's
    return x_value or bool(words & TIMES and not words & OTHERS)
