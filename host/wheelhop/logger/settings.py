"""What the header of a session says about its scans."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from wheelhop.logger.block import MOST_CHANNELS, MOST_SCANS, scans_per_block
from wheelhop.logger.error import LoggerError

CONVERSION_S = 156.25e-6
CONVERSIONS = {100: 8, 200: 4, 400: 2}  # per sum, by scans per second
NOT_RECORDED = "-"


@dataclass(frozen=True)
class Settings:
    """Scans per second, conversions in each sum, and the recorded inputs: (number, name) each."""

    rate_hz: int
    conversions: int
    inputs: tuple[tuple[int, str], ...]

    @property
    def mean_instant_s(self) -> float:
        """Mean sampling instant of scan 0 after the first conversion (SPEC.md, "Scans")."""
        return (8 * self.conversions - 1) / 2 * CONVERSION_S


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
    if not rate.isdecimal() or conversions != str(CONVERSIONS.get(int(rate))):
        raise LoggerError(
            f"{name}: header: rate_hz={rate} with conversions={conversions} is nothing that a"
            " logger of format 1 writes: give another log's header with --header-from"
        )
    distinct = {word for _, word in inputs}
    if len(words) != MOST_CHANNELS or not inputs or len(distinct) != len(inputs):
        raise LoggerError(
            f"{name}: header: channels={' '.join(words)}: not a name, or -, for each of the eight"
            " inputs, all different: give another log's header with --header-from"
        )
    return Settings(int(rate), int(conversions), inputs)


def find_settings(header: Mapping[str, str]) -> Settings | None:
    """Return the settings in a header's values; None where they are none."""
    try:
        return parse_settings(header, "header")
    except LoggerError:
        return None


def block_capacity(header: Mapping[str, str]) -> int:
    """Return the most scans that a block of this session can hold, whatever its header is like."""
    settings = find_settings(header)
    return scans_per_block(len(settings.inputs)) if settings else MOST_SCANS


def number(values: Mapping[str, str], key: str, missing: float = 0.0) -> float:
    """Return a decimal number of a header or summary, or `missing` where there is none."""
    try:
        value = float(values.get(key, ""))
    except ValueError:
        return missing
    return value if math.isfinite(value) else missing
