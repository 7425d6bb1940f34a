"""What there is to see while the logger streams."""

from collections import deque
from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from wheelhop.logger.block import scan_bytes, unpack_scans
from wheelhop.logger.clock import ClockError
from wheelhop.logger.frames import Acknowledgement

KEPT_SCANS = 8192  # 20 s at the highest rate
RATE_WINDOW_S = 2.0


@dataclass
class Live:
    """The state of a recording, kept up to date by it and read by whoever shows it.

    `written` and `lost` are scans in and missing from the host's file, `told` what the logger last
    said of its card. Scans are shared with other threads through `window` and `after`.
    """

    port: str = ""
    connected: bool = True
    session: int | None = None
    file: Path | None = None
    channels: tuple[str, ...] = ()
    rate_hz: int = 100
    conversions: int = 8
    written: int = 0
    lost: int = 0
    told: Acknowledgement | None = None
    card: str = ""
    supply_mv: int = 0
    clock: ClockError | None = None
    broken: int = 0  # pieces of the line that were no frames
    messages: deque[str] = field(default_factory=lambda: deque(maxlen=100))
    _scans: deque[tuple[float, bytes]] = field(default_factory=lambda: deque(maxlen=KEPT_SCANS))
    _count: int = 0  # of scans ever
    _lock: Lock = field(default_factory=Lock)

    def describe(self, header: dict[str, str]) -> None:
        """Take the settings over; what does not make sense is left as it was."""
        channels = tuple(name for name in header.get("channels", "").split() if name != "-")
        rate_hz = number_or(header.get("rate_hz"), self.rate_hz)
        with self._lock:
            if (channels, rate_hz) != (self.channels, self.rate_hz):
                self._scans.clear()
            self.channels, self.rate_hz = channels, rate_hz
            self.conversions = number_or(header.get("conversions"), self.conversions)
            self.supply_mv = number_or(header.get("supply_mv"), 0)

    def add(self, at_s: float, stored: bytes, missing: int = 0) -> None:
        """A scan has come; so many before it have not."""
        gap = min(missing, KEPT_SCANS)
        with self._lock:
            self._scans.extend([(at_s, b"")] * gap)
            self._scans.append((at_s, stored))
            self._count += gap + 1

    def say(self, message: str) -> None:
        """Something a user should read."""
        self.messages.append(message)

    def window(self, seconds: float) -> NDArray[np.float64]:
        """(n, channels) mean codes of the last so many seconds, without scans that are missing."""
        with self._lock:
            most = max(round(seconds * self.rate_hz), 1)
            codes = self._codes([stored for _, stored in list(self._scans)[-most:]])
        here: NDArray[np.float64] = codes[~np.isnan(codes).any(axis=1)]
        return here

    def after(self, count: int) -> tuple[int, NDArray[np.float64]]:
        """How many scans there ever were, and the codes of those behind the first `count`, as far
        as they are kept: (n, channels), NaN where one is missing."""
        with self._lock:
            new = min(self._count - count, len(self._scans))
            recent = [stored for _, stored in list(self._scans)[len(self._scans) - new :]]
            return self._count, self._codes(recent)

    def measured_rate_hz(self) -> float:
        """Scans that came in a second of the host's, of late; 0 if hardly any did."""
        with self._lock:
            recent = list(self._scans)[-round(RATE_WINDOW_S * self.rate_hz) :]
        times = [at_s for at_s, stored in recent if stored]
        span = times[-1] - times[0] if len(times) > 1 else 0.0
        return (len(times) - 1) / span if span > 0 else 0.0

    def _codes(self, stored: list[bytes]) -> NDArray[np.float64]:
        count = len(self.channels)
        size = scan_bytes(count)
        here = [len(scan) == size for scan in stored]
        codes = np.full((len(stored), count), np.nan)
        if count and any(here):
            whole = b"".join(scan for scan in stored if len(scan) == size)
            codes[here] = unpack_scans(whole, count) / self.conversions
        return codes


def number_or(text: str | None, otherwise: int) -> int:
    """A number above 0 as a header tells it, or something else where it does not."""
    return int(text) if text and text.isdecimal() and int(text) > 0 else otherwise
