"""What the header of a session says about its scans."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.logger.block import MOST_CHANNELS, MOST_SCANS, SUM_BITS, scans_per_block
from wheelhop.logger.error import LoggerError

CONVERSION_S = 156.25e-6
CONVERSIONS = {100: 8, 200: 4, 400: 2}  # per sum, by scans per second
NOT_RECORDED = "-"
CODE_BITS, MOST_BITS = 10, 32
TOGETHER = "together"

Inputs = tuple[tuple[int, str], ...]


@dataclass(frozen=True)
class Settings:
    """Scans per second, conversions in each sum, and the recorded inputs: (number, name) each.

    Sums have `sum_bits`, the converter's codes `code_bits`. It converts one input after the other,
    or all `together`, every `step_s` seconds.
    """

    rate_hz: int
    conversions: int
    inputs: Inputs
    sum_bits: int = SUM_BITS
    code_bits: int = CODE_BITS
    together: bool = False
    step_s: float = CONVERSION_S

    @property
    def steps(self) -> int:
        """How many conversions, one after the other, a scan takes."""
        return self.conversions if self.together else MOST_CHANNELS * self.conversions

    @property
    def mean_instant_s(self) -> float:
        """Mean sampling instant of scan 0 after the first conversion (SPEC.md, "Scans")."""
        return (self.steps - 1) / 2 * self.step_s

    def codes(self, sums: NDArray[np.unsignedinteger]) -> NDArray[np.float64]:
        """Mean codes of sums, where code 1024 is the reference, whatever the converter has."""
        scale = self.conversions * 2.0 ** (self.code_bits - CODE_BITS)
        return np.asarray(sums / scale)


def parse_settings(header: Mapping[str, str], name: str) -> Settings:
    """Return the settings in a header's values. Raises LoggerError where they are none."""
    if not header:
        raise LoggerError(
            f"{name}: byte 0: the header is damaged, so rate and channels are unknown: give another"
            " log of the same logger and settings with --header-from"
        )
    rate = header.get("rate_hz", "")
    conversions = header.get("conversions", "")
    words = header.get("channels", "").split()
    inputs = tuple((i, word) for i, word in enumerate(words) if word != NOT_RECORDED)
    make = _together if header.get("order") == TOGETHER else _in_turn
    settings = make(header, rate, conversions, inputs)
    if settings is None:
        raise LoggerError(
            f"{name}: header: rate_hz={rate} with conversions={conversions} is nothing that a"
            " logger writes: give another log's header with --header-from"
        )
    distinct = {word for _, word in inputs}
    if len(words) != MOST_CHANNELS or not inputs or len(distinct) != len(inputs):
        raise LoggerError(
            f"{name}: header: channels={' '.join(words)}: not a name, or -, for each of the eight"
            " inputs, all different: give another log's header with --header-from"
        )
    return settings


def _in_turn(
    header: Mapping[str, str], rate: str, conversions: str, inputs: Inputs
) -> Settings | None:
    """Those of format 1; None where they contradict one another."""
    if not rate.isdecimal() or conversions != str(CONVERSIONS.get(int(rate))):
        return None
    return Settings(int(rate), int(conversions), inputs)


def _together(
    header: Mapping[str, str], rate: str, conversions: str, inputs: Inputs
) -> Settings | None:
    """Those of format 2; None where they contradict one another."""
    keys = ("sum_bits", "code_bits", "conversions_hz")
    words = [rate, conversions, *(header.get(key, "") for key in keys)]
    if not all(word.isdecimal() for word in words):
        return None
    rate_hz, count, sum_bits, code_bits, conversions_hz = map(int, words)
    fits = CODE_BITS <= code_bits <= sum_bits <= MOST_BITS and count << code_bits <= 1 << sum_bits
    if not fits or not rate_hz or rate_hz * count != conversions_hz:
        return None
    return Settings(rate_hz, count, inputs, sum_bits, code_bits, True, 1 / conversions_hz)


def find_settings(header: Mapping[str, str]) -> Settings | None:
    """Return the settings in a header's values; None where they are none."""
    try:
        return parse_settings(header, "header")
    except LoggerError:
        return None


def block_capacity(header: Mapping[str, str]) -> int:
    """Return the most scans that a block of this session can hold, whatever its header is like."""
    settings = find_settings(header)
    return scans_per_block(len(settings.inputs), settings.sum_bits) if settings else MOST_SCANS


def number(values: Mapping[str, str], key: str, missing: float = 0.0) -> float:
    """Return a decimal number of a header or summary, or `missing` where there is none."""
    try:
        value = float(values.get(key, ""))
    except ValueError:
        return missing
    return value if math.isfinite(value) else missing
