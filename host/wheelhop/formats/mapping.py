"""The mapping: what a user says of a file that does not tell enough about itself."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from wheelhop.files import read_text_bytes
from wheelhop.files.units import SECONDS
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.stamps import CLOCK, DIGITS, MINUTES, SAMPLE, UNITS

SEPARATORS = {"tab": "\t", "space": None, ",": ",", ";": ";", "|": "|", "\t": "\t", " ": None}
"""None: any run of blanks."""
ASKED = {
    "decimal": 'the decimal sign, "." or ","',
    "time_unit": f"the unit of the time stamps: {', '.join(UNITS)}",
    "rate_hz": "how many samples a second has, a number",
    "resample_hz": "to how many samples a second all channels shall be taken, a number",
}
"""Keys that a draft leaves blank where the file does not say them."""
THOUSANDS = ("", ".", ",", "'", "’", " ", "\u00a0", "\u202f")
LARGEST = 1e300
"""What is larger overflows where it is multiplied."""
KEYS = (
    *("format", "separator", "decimal", "thousands", "encoding"),
    *("header_row", "units_row", "first_row", "last_row"),
    *("time", "time_unit", "rate_hz", "resample_hz", "by", "group", "channel"),
)
CHANNEL_KEYS = (
    "column",
    "name",
    "unit",
    "point",
    "sensor",
    "calibration",
    "scale",
    "offset",
)


@dataclass(frozen=True)
class Pick:
    """One channel: column (its name, or its number from 1) × `scale` + `offset` is in `unit`.

    Texts that are empty stay as the file has them.
    """

    column: str | int
    name: str = ""
    unit: str = ""
    point: str = ""
    sensor: str = ""
    calibration: str = ""
    scale: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Map:
    """How to read a file.

    `separator` is None for any run of blanks; rows are lines from 1, a `header_row` or `units_row`
    of 0 means there is none, a `last_row` of 0 that all lines are rows; names may stand in several
    lines. Time is a column (name or number) in `time_unit`, empty: as the file says; or `rate_hz`.
    With `resample_hz` all channels are taken to that rate. Words in the column `by` say which
    channel a row is of.
    A `group` is chosen where a file has several. Without `picks` every column is a channel.
    """

    separator: str | None = ","
    decimal: str = "."
    encoding: str = ""
    header_row: int | tuple[int, ...] = 1
    units_row: int = 0
    first_row: int = 0
    time: str | int = ""
    time_unit: str = ""
    rate_hz: float | None = None
    group: str = ""
    picks: tuple[Pick, ...] = ()
    thousands: str = ""
    last_row: int = 0
    resample_hz: float | None = None
    by: str | int = ""

    @property
    def header_rows(self) -> tuple[int, ...]:
        """The lines of names, from above to below."""
        rows = (self.header_row,) if isinstance(self.header_row, int) else self.header_row
        return tuple(row for row in rows if row)

    @property
    def first(self) -> int:
        """The line of the first numbers."""
        return self.first_row or max((*self.header_rows, self.units_row), default=0) + 1


def read_mapping(file: Path) -> Map:
    """Read a mapping file. Raises `ExchangeError` that names the file and the key."""
    try:
        text = read_text_bytes(file, ExchangeError).decode("utf-8-sig")
    except OSError as error:
        raise ExchangeError(f"{file}: cannot be read: {error.strerror}") from None
    except ExchangeError:
        raise
    except ValueError as error:
        raise ExchangeError(f"{file}: not valid TOML: {error}") from None
    return parse_mapping(text, file)


def parse_mapping(text: str, file: Path) -> Map:
    """What the text of a mapping says. Raises `ExchangeError` that names `file` and the key."""
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ExchangeError(f"{file}: not valid TOML: {error}") from None
    keys = _Keys(table, file)
    keys.only(KEYS)
    if table.get("format") != 1 or table["format"] is True:
        raise ExchangeError(f"{file}: format = 1 is missing: it is the version of this file")
    if blank := [key for key in ASKED if table.get(key) == ""]:
        said = "; ".join(f"{key} = … ({ASKED[key]})" for key in blank)
        raise ExchangeError(f"{file}: still to be answered: {said}")
    separator = keys.text("separator", ",")
    if separator not in SEPARATORS:
        raise ExchangeError(f'{file}: separator must be ",", ";", "|", "tab" or "space"')
    decimal = keys.text("decimal", ".")
    if decimal not in (".", ","):
        raise ExchangeError(f'{file}: decimal must be "." or ","')
    thousands = keys.text("thousands", "")
    if thousands not in THOUSANDS or thousands == decimal:
        raise ExchangeError(f"{file}: thousands must be one of . , ' or a blank, and not decimal")
    unit = keys.text("time_unit", "")
    if unit not in ("", *SECONDS, CLOCK, MINUTES, DIGITS, SAMPLE):
        known = ", ".join(UNITS)
        raise ExchangeError(f'{file}: time_unit = "{unit}" is not known: {known}')
    rate, resample = (keys.number(key, 0.0) for key in ("rate_hz", "resample_hz"))
    for key, value in (("rate_hz", rate), ("resample_hz", resample)):
        if value < 0.0:
            raise ExchangeError(f"{file}: {key} must be above 0")
    entries = table.get("channel", [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise ExchangeError(f"{file}: begin each channel with [[channel]]")
    return Map(
        separator=SEPARATORS[separator],
        decimal=decimal,
        encoding=keys.text("encoding", ""),
        header_row=keys.rows("header_row", 1),
        units_row=keys.row("units_row", 0),
        first_row=keys.row("first_row", 0),
        time=keys.column("time"),
        time_unit=unit,
        rate_hz=rate or None,
        group=str(keys.column("group")),
        picks=tuple(
            _pick(_Keys(entry, file, f"[[channel]] {number}: "))
            for number, entry in enumerate(entries, start=1)
        ),
        thousands=thousands,
        last_row=keys.row("last_row", 0),
        resample_hz=resample or None,
        by=keys.column("by"),
    )


def _pick(keys: _Keys) -> Pick:
    keys.only(CHANNEL_KEYS)
    column = keys.column("column")
    if column == "":
        raise ExchangeError(f"{keys.place}column is missing: a name, or a number from 1")
    return Pick(
        column,
        name=keys.text("name", ""),
        unit=keys.text("unit", ""),
        point=keys.text("point", ""),
        sensor=keys.text("sensor", ""),
        calibration=keys.text("calibration", ""),
        scale=keys.number("scale", 1.0),
        offset=keys.number("offset", 0.0),
    )


class _Keys:
    """A table of the file; asking for a value checks it."""

    def __init__(self, values: Mapping[str, Any], file: Path, heading: str = "") -> None:
        self.values = values
        self.place = f"{file}: {heading}"

    def only(self, known: tuple[str, ...]) -> None:
        for key in self.values:
            if key not in known:
                raise ExchangeError(f"{self.place}unknown key '{key}'; known: {', '.join(known)}")

    def text(self, key: str, default: str) -> str:
        value = self.values.get(key, default)
        if not isinstance(value, str):
            raise ExchangeError(f'{self.place}{key} must be a text in quotes: {key} = "{value}"')
        return value

    def column(self, key: str) -> str | int:
        value = self.values.get(key, "")
        if isinstance(value, bool) or not isinstance(value, str | int):
            raise ExchangeError(f"{self.place}{key} must be a name in quotes, or a number")
        return value

    def row(self, key: str, default: int) -> int:
        value = self.values.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int) or value < 0:
            raise ExchangeError(f"{self.place}{key} must be the number of a line, or 0 for none")
        return value

    def rows(self, key: str, default: int) -> int | tuple[int, ...]:
        values = self.values.get(key, default)
        if not isinstance(values, list):
            return self.row(key, default)
        if not all(isinstance(v, int) and not isinstance(v, bool) and v > 0 for v in values):
            raise ExchangeError(f"{self.place}{key} must hold the numbers of lines, from 1")
        return tuple(values)

    def number(self, key: str, default: float) -> float:
        value = self.values.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ExchangeError(f"{self.place}{key} must be a number")
        if not abs(value) <= LARGEST:
            raise ExchangeError(f"{self.place}{key} must be a finite number")
        return float(value)
