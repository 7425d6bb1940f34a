"""What happened when, to the cycle."""

from collections.abc import Iterator
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

CPU_HZ = 16_000_000
CHANNELS = 8
EVENT = np.dtype(
    [
        ("cycle", "<u8"),
        ("kind", "u1"),
        ("which", "u1"),
        ("value", "<u2"),
        ("unused", "<u4"),
    ]
)


class Event(IntEnum):
    """Kinds of events, and what the fields `which` and `value` hold."""

    CONVERSION = 1  # which: channel by the multiplexer; value: code
    MISSED = 2  # a trigger that started no conversion
    ISR_ENTER = 3  # which: vector number
    ISR_EXIT = 4
    LED = 5  # value: 1 on, 0 off
    RESET = 6


class Trace:
    """Events in the order in which they happened.

    `events` is a structured array with the fields cycle, kind (an `Event`), which and value. The
    cycle of a conversion is that of its trigger; the converter samples 259 cycles later.
    """

    def __init__(self, data: bytes = b""):
        self.events: NDArray[np.void] = np.frombuffer(data, dtype=EVENT)

    def of(self, kind: Event) -> NDArray[np.void]:
        """The events of one kind."""
        chosen: NDArray[np.void] = self.events[self.events["kind"] == kind]
        return chosen

    def conversion_jitter(self) -> int:
        """Largest deviation of the time between conversions from what it should be, in cycles.

        It should be the median. In a scan of L conversions with one of the internal reference in
        its middle, the others are s clocks closer together, and the reference is converted
        (L − 1)·s clocks, and one step, after the one before it (firmware/SPEC.md, "The supply").
        """
        events = self.of(Event.CONVERSION)
        steps = np.diff(events["cycle"].astype(np.int64))
        if not len(steps):
            return 0
        usual = int(np.median(steps))
        due = np.full(len(steps), usual)
        for at in np.flatnonzero(events["which"][1:-1] >= CHANNELS) + 1:
            closer = usual - int(steps[at])
            half = round((steps[at - 1] / closer + 1) / 2) if closer else 0
            due[max(at - half, 0) : at + half] = usual - closer
            due[at - 1] = (2 * half - 1) * closer
        return int(np.abs(steps - due).max())

    def interrupts(self, vector: int) -> NDArray[np.int64]:
        """Start and end of every run of one interrupt routine, in cycles: shape (n, 2).

        The four cycles of entry count, and so does what interrupted the routine itself.
        """
        return np.array(
            [span for number, *span in self._runs() if number == vector], dtype=np.int64
        ).reshape(-1, 2)

    def _runs(self) -> Iterator[tuple[int, int, int]]:
        """Vector, start and end of every interrupt routine that ended."""
        nested: list[tuple[int, int]] = []
        for cycle, kind, which in self.events[["cycle", "kind", "which"]].tolist():
            if kind == Event.ISR_ENTER:
                nested.append((which, cycle))
            elif kind == Event.ISR_EXIT and nested:
                yield (*nested.pop(), cycle)
            elif kind == Event.RESET:
                nested.clear()

    def led(self) -> list[tuple[float, bool]]:
        """When, in seconds of board time, the LED went on (True) or off."""
        return [(int(e["cycle"]) / CPU_HZ, bool(e["value"])) for e in self.of(Event.LED)]
