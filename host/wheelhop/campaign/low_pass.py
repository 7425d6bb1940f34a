"""The recorder's low-pass filter: what it lets through before a channel is sampled."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from wheelhop.files import Table

Array = NDArray[np.float64]
Kind = Literal["none", "butterworth", "bessel", "fir"]
KINDS: tuple[Kind, ...] = get_args(Kind)
HIGHEST_ORDER = 20
MOST_TAPS = 10_000


@dataclass(frozen=True)
class LowPass:
    """No filter of kind "none"; or one of `order` whose gain is 1/√2 at `corner_hz`; or, of kind
    "fir", the `taps` at `rate_hz`. A filter of `zero_phase` was run forward and backward over the
    samples: its gain counts twice and it delays nothing. All comes `delay_s` later besides."""

    kind: Kind
    order: int = 0
    corner_hz: float = 0.0
    zero_phase: bool = False
    delay_s: float = 0.0
    taps: tuple[float, ...] = ()
    rate_hz: float = 0.0

    def response(self, frequency_hz: Array) -> NDArray[np.complex128]:
        """Complex gain at frequencies (f,), Hz, with exp(+iωt)."""
        omega = 2 * np.pi * np.asarray(frequency_hz)
        if self.kind == "none":
            gain = np.ones(omega.shape, np.complex128)
        elif self.kind == "fir":
            later = np.outer(omega, np.arange(len(self.taps)) / self.rate_hz)
            gain = np.exp(-1j * later) @ np.array(self.taps)
        else:
            gain = _analog(self.kind, self.order, 2 * np.pi * self.corner_hz, omega)
        if self.zero_phase:
            gain = np.abs(gain) ** 2
        return np.asarray(gain * np.exp(-1j * omega * self.delay_s))

    def __str__(self) -> str:
        if self.kind == "none":
            return "no filter"
        if self.kind == "fir":
            said = f"FIR filter of {len(self.taps)} taps at {self.rate_hz:g} Hz"
        else:
            said = f"{self.kind.capitalize()} filter of order {self.order}, {self.corner_hz:g} Hz"
        return f"{said}, forward and backward" if self.zero_phase else said


def responses(filters: Sequence[LowPass | None], frequency_hz: Array) -> NDArray[np.complex128]:
    """Gains (f, c) of a filter each, 1 where there is none."""
    found = {each: each.response(frequency_hz) for each in filters if each is not None}
    one = np.ones(np.shape(frequency_hz), np.complex128)
    return np.stack([one if each is None else found[each] for each in filters], axis=1)


def _analog(kind: Kind, order: int, corner: float, omega: Array) -> NDArray[np.complex128]:
    if kind == "bessel":
        zpk = signal.bessel(order, corner, analog=True, output="zpk", norm="mag")
    else:
        zpk = signal.butter(order, corner, analog=True, output="zpk")
    return np.asarray(signal.freqs_zpk(*zpk, worN=omega)[1])


def read_filters(table: Table, quantities: Iterable[str]) -> dict[str, LowPass]:
    """The filters that the top of campaign.toml states: one for all channels, under "", or for
    those of a quantity; raises its error for a mistake."""
    if "kind" in table or not set(table.values) & set(quantities):
        return {"": read_low_pass(table)}
    table.only(tuple(quantities))
    return {quantity: read_low_pass(table.table(quantity)) for quantity in table.values}


def read_low_pass(table: Table) -> LowPass:
    """The filter that a table `filter` of campaign.toml states; raises its error for a mistake."""
    kind: Kind = next(k for k in KINDS if k == table.text("kind", choices=KINDS))
    if kind == "none":
        table.only(("kind",))
        return LowPass(kind)
    own = ("taps", "rate_hz") if kind == "fir" else ("order", "corner_hz")
    table.only(("kind", *own, "zero_phase", "delay_ms"))
    forth_and_back = table.values.get("zero_phase", False)
    if not isinstance(forth_and_back, bool):
        raise table.error("zero_phase must be true or false, without quotes")
    delay_s = 1e-3 * table.number("delay_ms", 0.0)
    if kind == "fir":
        taps, rate = table.numbers("taps"), table.number("rate_hz", above=0.0)
        if not 0 < len(taps) <= MOST_TAPS or not any(taps):
            raise table.error(f"taps: give 1 to {MOST_TAPS} numbers, not all of them zero")
        return LowPass(kind, 0, 0.0, forth_and_back, delay_s, tuple(taps), rate)
    order = table.number("order", at_least=1.0)
    if order != int(order) or order > HIGHEST_ORDER:
        raise table.error(f"order = {order:g} must be a whole number from 1 to {HIGHEST_ORDER}")
    corner = table.number("corner_hz", above=0.0)
    return LowPass(
        "bessel" if kind == "bessel" else "butterworth", int(order), corner, forth_and_back, delay_s
    )
