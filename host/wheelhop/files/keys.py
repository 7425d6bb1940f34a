"""Strict reading of TOML: every mistake becomes one line that names file, key and remedy."""

import math
import re
import tomllib
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import date, datetime
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from wheelhop.files.error import InputError
from wheelhop.files.read import read_text_bytes
from wheelhop.files.units import UNITS, beyond, split_unit

LONGEST_WORD = 200  # that may be a misspelt one
LONGEST_TEXT = 4000  # that somebody means to read
COMMA = re.compile(r"[=\[,{]\s*([+-]?\d+,\d+)\s*(?:#|[\]},]|$)")
SLIP = 0.8  # likeness of two keys of which one is the other, misspelt


@contextmanager
def readable(path: Path, kind: type[InputError] = InputError) -> Iterator[None]:
    """What keeps a file from being read in the block is an error of this `kind`, in one line."""
    try:
        yield
    except FileNotFoundError:
        raise kind(f"{path}: no such file{similar_file(path)}") from None
    except InputError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a NUL character in the path
        reason = getattr(error, "strerror", None) or error
        raise kind(f"{str(path)!r}: cannot be read: {reason}") from None


def read_text(path: Path, kind: type[InputError] = InputError) -> str:
    """Read a UTF-8 text file, any line ends and a byte order mark allowed.

    Raises an error of this `kind` for a file that is missing, unreadable or in another encoding,
    and for what is no plain file, no text, or more than the memory holds.
    """
    with readable(path, kind):
        data = read_text_bytes(path, kind)
    try:
        return data.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise kind(
            f"{path}: line {line}: byte 0x{data[error.start]:02x} is not UTF-8; "
            "save the file as UTF-8"
        ) from None


def read_toml(path: Path, kind: type[InputError] = InputError) -> "Table":
    """Read a TOML file; an error of this `kind` passes on the parser's line and column."""
    return parse_toml(read_text(path, kind), path, kind)


def parse_toml(text: str, path: Path, kind: type[InputError] = InputError) -> "Table":
    """The TOML file that `path` is, or is to become."""
    try:
        return Table(tomllib.loads(text), path, kind=kind)
    except (ValueError, RecursionError) as error:
        said = _decimal_comma(text, str(error)) or f"not valid TOML: {_one_line(error)}"
        raise kind(f"{path}: {said}") from None


class Table:
    """One table of a TOML file. Asking for a value checks it; `only` rejects the unknown keys.

    `heading` is how the user finds the table ("[suspension.front]"), `prefix` what precedes the
    keys as the user writes them there ("track."), `kind` the package's own error.
    """

    def __init__(
        self,
        values: Mapping[str, Any],
        file: Path,
        heading: str = "",
        prefix: str = "",
        kind: type[InputError] = InputError,
    ):
        self.values = values
        self.file = file
        self.heading = heading
        self.prefix = prefix
        self.kind = kind

    def __contains__(self, key: str) -> bool:
        return key in self.values

    def error(self, what: str) -> InputError:
        """The line "file: table: what" as an exception to raise."""
        return self.kind(": ".join(part for part in (str(self.file), self.heading, what) if part))

    def only(self, known: Collection[str], hint: str = "") -> None:
        """Raise for the first key that is not `known`, naming the one that was probably meant."""
        for key, value in self.values.items():
            if key not in known:
                raise self.error(self._unknown(key, value, known, hint))

    def needs(self, keys: Collection[str]) -> list[str]:
        """Those of these keys that are missing, as the user would write them: "[body] mass_kg"."""
        missing = [key for key in keys if key not in self.values]
        others = [key for key in self.values if key not in keys]
        return [
            f"{self.heading} {self.prefix}{key}{_written(key, others)}".lstrip() for key in missing
        ]

    def number(
        self,
        key: str,
        default: float | None = None,
        *,
        above: float | None = None,
        at_least: float | None = None,
        below: float | None = None,
    ) -> float:
        """A finite number inside the given limits; required unless there is a `default`."""
        if key not in self.values and default is not None:
            return default
        number = self._as_number(key, self._required(key, "a number"))
        if wrong := beyond(key, number):
            raise self.error(f"{self.prefix}{key} = {number:g} {wrong}")
        if above is not None and not number > above:
            raise self.error(f"{self.prefix}{key} = {number:g} must be greater than {above:g}")
        if at_least is not None and not number >= at_least:
            raise self.error(f"{self.prefix}{key} = {number:g} must not be below {at_least:g}")
        if below is not None and not number < below:
            raise self.error(f"{self.prefix}{key} = {number:g} must be less than {below:g}")
        return number

    def text(self, key: str, default: str | None = None, choices: Sequence[str] = ()) -> str:
        """A line of text, one of `choices` if there are any; not empty unless the `default` is."""
        if key not in self.values and default is not None:
            return default
        value = self._required(key, "a text" if not choices else " or ".join(map(repr, choices)))
        if not isinstance(value, str):
            raise self.error(f'{self.prefix}{key} must be a text in quotes: {key} = "{value}"')
        if not (value.strip() or default == "") or not value.isprintable():
            raise self.error(f"{self.prefix}{key} must be a non-empty line of text")
        if len(value) > LONGEST_TEXT:
            raise self.error(
                f"{self.prefix}{key} = {shown(value)} has {len(value)} characters: give at most "
                f"{LONGEST_TEXT}"
            )
        if choices and value not in choices:
            raise self.error(
                f"{self.prefix}{key} = {shown(value)} is not known"
                + (did_you_mean(value, choices) or f"; choose from {', '.join(choices)}")
            )
        return value

    def date(self, key: str) -> date:
        """A day, written 2026-05-31 without quotes."""
        value = self._required(key, "a day without quotes: 2026-05-31")
        if isinstance(value, datetime):
            return value.date()
        if not isinstance(value, date):
            raise self.error(f"{self.prefix}{key} must be a day without quotes: {key} = 2026-05-31")
        return value

    def pair(self, key: str) -> tuple[float, float]:
        """Two finite numbers, `key = [a, b]`."""
        value = self._required(key, "two numbers")
        if not isinstance(value, list) or len(value) != 2:
            raise self.error(f"{self.prefix}{key} must be two numbers in brackets: {key} = [a, b]")
        first, second = (self._as_number(key, item) for item in value)
        return first, second

    def numbers(self, key: str) -> list[float]:
        """A list of finite numbers under `key`."""
        value = self._required(key, "a list of numbers")
        if not isinstance(value, list):
            raise self.error(f"{self.prefix}{key} must be a list of numbers, not {shown(value)}")
        return [self._as_number(key, item) for item in value]

    def texts(self, key: str) -> list[str]:
        """A list of texts under `key`; an empty one if it is not there."""
        value = self.values.get(key, [])
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            raise self.error(f"{self.prefix}{key} must be a list of texts, not {shown(value)}")
        return value

    def table(self, key: str, heading: str | None = None, prefix: str = "") -> "Table":
        """The table below `key`, which must be there."""
        value = self._required(key, "a table")
        if not isinstance(value, dict):
            raise self.error(f"{self.prefix}{key} must be a table, not {shown(value)}")
        name = heading if heading is not None else self._subheading(key)
        return Table(value, self.file, name, prefix, self.kind)

    def table_if_any(self, key: str) -> "Table":
        """The table below `key`; an empty one if it is not there."""
        if key in self.values:
            return self.table(key)
        return Table({}, self.file, self._subheading(key), kind=self.kind)

    def tables(self, key: str, name_key: str) -> list["Table"]:
        """The array of tables `[[key]]`; each is called by its `name_key`, or its number."""
        value = self._required(key, f"one [[{key}]] or more")
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            raise self.error(f"'{key}' is a list of tables: begin each with [[{key}]]")
        found = []
        for number, item in enumerate(value, start=1):
            name = item.get(name_key)
            told = isinstance(name, str) and name.isprintable() and len(name) <= LONGEST_WORD
            label = f'"{name}"' if told else f"no. {number}"
            found.append(Table(item, self.file, f"[[{key}]] {label}", kind=self.kind))
        return found

    def all_numbers(self, prefix: str = "", but: str | None = None) -> dict[str, float]:
        """Every number of this table and of those in it, by its dotted name behind a prefix; left
        out are those whose names end with `but`."""
        found: dict[str, float] = {}
        for key, value in self.values.items():
            if isinstance(value, dict):
                found |= self.table(key).all_numbers(f"{prefix}{key}.", but)
            elif but is None or not key.endswith(but):
                found[f"{prefix}{key}"] = self.number(key)
        return found

    def format(self) -> None:
        """Check the format version at the top of the file."""
        version = self._required("format", "1")
        if version != 1 or isinstance(version, bool):
            raise self.error(
                f"format = {shown(version)} is not known; this wheelhop reads format = 1"
            )

    def _required(self, key: str, what: str) -> Any:
        if key in self.values:
            return self.values[key]
        raise self.error(f"'{self.prefix}{key}' is missing: give {what}{_unit_note(key)}")

    def _as_number(self, key: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.error(f"{self.prefix}{key} must be a number, not {shown(value)}")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self.error(f"{self.prefix}{key} must be a finite number")
        return number

    def _subheading(self, key: str) -> str:
        return f"[{self.heading[1:-1]}.{key}]" if self.heading else f"[{key}]"

    def _unknown(self, key: str, value: Any, known: Collection[str], hint: str) -> str:
        wrong_unit = _wrong_unit(key, value, known, self.prefix)
        if wrong_unit:
            return wrong_unit
        guess = did_you_mean(key, known) or hint or f"; known here: {', '.join(sorted(known))}"
        return f"unknown key '{self.prefix}{key}'{guess}"


def _decimal_comma(text: str, error: str) -> str:
    """What is wrong with the line that the parser stopped at, if that is a number with a decimal
    comma; else empty."""
    place = re.search(r"at line (\d+)", error)
    lines = text.split("\n")
    if place is None or int(place[1]) > len(lines):
        return ""
    found = COMMA.search(lines[int(place[1]) - 1])
    if found is None:
        return ""
    point = found[1].replace(",", ".")
    return f"line {place[1]}: {found[1]} has a decimal comma: TOML takes a point, {point}"


def _written(key: str, others: Sequence[str]) -> str:
    """How a key that is missing was written, if that is another unit or a slip of the pen."""
    stem, _ = split_unit(key)
    alike = [other for other in others if split_unit(other)[0] == stem]
    near = alike or get_close_matches(key, others, n=1, cutoff=SLIP)
    return f" (not {near[0]})" if near else ""


def did_you_mean(word: str, known: Collection[str]) -> str:
    """ ", did you mean '…'?" for the nearest of the known words, or an empty text."""
    if len(word) > LONGEST_WORD:
        return ""
    lower = {name.lower(): name for name in known}
    near = get_close_matches(word.lower(), lower, n=1, cutoff=0.6)
    return f", did you mean '{lower[near[0]]}'?" if near else ""


def _wrong_unit(key: str, value: Any, known: Collection[str], prefix: str) -> str:
    """The line for a quantity that is known, written in another unit or without one."""
    stem, unit = split_unit(key)
    for candidate in known:
        known_stem, known_unit = split_unit(candidate)
        if known_unit is None or known_stem != stem or known_unit == unit:
            continue
        wanted = UNITS[known_unit]
        amount = "…"
        if unit is not None:
            found = UNITS[unit]
            if found.dimension != wanted.dimension:
                continue
            if isinstance(value, int | float) and -1e99 < value < 1e99:
                amount = f"{value * found.in_si / wanted.in_si:.6g}"
        quantity = f"{prefix}{stem}".removesuffix("_uncertainty").replace("_", " ").strip()
        return (
            f"'{prefix}{key}': {quantity} is given in {wanted.words}: "
            f"write {prefix}{candidate} = {amount}"
        )
    return ""


def _unit_note(key: str) -> str:
    unit = split_unit(key)[1]
    return f" in {UNITS[unit].words}" if unit else ""


def similar_file(path: Path) -> str:
    """ ", did you mean '…'?" for the file beside `path` whose name is nearest, or an empty text."""
    try:
        return did_you_mean(path.name, [entry.name for entry in path.parent.iterdir()])
    except OSError:
        return ""


def shown(value: Any) -> str:
    """A value of a TOML file as a line can quote it."""
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        return "a list"
    text = repr(value)
    return text if len(text) <= 40 else text[:37] + "…"


def _one_line(error: BaseException) -> str:
    text = " ".join(str(error).split())
    return text if len(text) <= 200 else text[:197] + "…"
