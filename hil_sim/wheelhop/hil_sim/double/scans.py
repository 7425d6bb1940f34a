"""Scans as the logger's converter makes them of what the sensors put out."""

import numpy as np
from numpy.typing import NDArray

from wheelhop.hil_sim.double.settings import Settings
from wheelhop.hil_sim.signals import CHANNELS, CODES, Signals
from wheelhop.logger.settings import CODE_BITS, CONVERSION_S

BATCH = 128  # scans


def scan_sums(
    signals: Signals, conversions: int, first: int, count: int, start_s: float = 0.0
) -> NDArray[np.int64]:
    """Return the (count, 8) sums of scans from number `first` on (SPEC.md, "Scans").

    `conversions` of each input in a scan are 8, 4 or 2; scan 0 begins at `start_s` of the signals.
    """
    forward = np.arange(CHANNELS)
    palindrome = np.concatenate([forward, forward[::-1]])
    inputs = np.tile(palindrome, conversions // 2)
    places = np.argsort(inputs, kind="stable").reshape(CHANNELS, conversions)
    begin_s = (first + np.arange(count)) * len(inputs) * CONVERSION_S + start_s
    sums = np.empty((count, CHANNELS), np.int64)
    for channel in range(CHANNELS):
        time_s = begin_s[:, None] + places[channel] * CONVERSION_S
        codes = np.floor(np.clip(_at(signals, channel, time_s), 0, CODES - 1))
        sums[:, channel] = codes.sum(axis=1)
    return sums


def sums_together(
    signals: Signals, settings: Settings, first: int, count: int, start_s: float = 0.0
) -> NDArray[np.int64]:
    """Return the (count, 8) sums of scans of a board that converts all inputs at the same instant
    (SPEC.md, "Format 2"); its codes are finer than those of the signals."""
    kind, conversions = settings.kind, settings.conversions
    finer = 2 ** (kind.code_bits - CODE_BITS)
    numbers = first + np.arange(count)[:, None] + np.arange(conversions) / conversions
    time_s = numbers / settings.rate_hz + start_s
    sums = np.empty((count, CHANNELS), np.int64)
    for channel in range(CHANNELS):
        codes = np.floor(_at(signals, channel, time_s) * finer)
        sums[:, channel] = np.clip(codes, 0, CODES * finer - 1).sum(axis=1)
    return sums


def _at(signals: Signals, channel: int, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Straight lines between the rows, as the simulated board takes them."""
    rows = np.arange(len(signals.codes))
    row = time_s * signals.rate_hz
    period = float(len(rows)) if signals.repeat else None
    values: NDArray[np.float64] = np.interp(row, rows, signals.codes[:, channel], period=period)
    return values


class ScanSource:
    """Sums one scan after the other, computed in batches."""

    def __init__(self, signals: Signals, settings: Settings, start_s: float) -> None:
        self._signals, self._settings, self._start_s = signals, settings, start_s
        self._batch = -1
        self._sums = np.empty((0, CHANNELS), np.int64)

    def take(self, number: int) -> NDArray[np.int64]:
        """The (8,) sums of a scan."""
        batch, row = divmod(number, BATCH)
        if batch != self._batch:
            self._batch = batch
            scans = (batch * BATCH, BATCH, self._start_s)
            if self._settings.kind.together:
                self._sums = sums_together(self._signals, self._settings, *scans)
            else:
                self._sums = scan_sums(self._signals, self._settings.conversions, *scans)
        sums: NDArray[np.int64] = self._sums[row]
        return sums
