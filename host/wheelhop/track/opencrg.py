"""Reading OpenCRG road surfaces (ASAM OpenCRG 1.2, chapter 3): heights on a grid along a reference
line.

A text header in sections, each begun by `$NAME` and ended by `$`, up to the line that *begins* with
`$$$$`; then the data: per station the channels that the header's `D:` lines name, among them one
height per long section. `*` at the beginning of a header line makes it a comment, `!` the rest of
one. Four codes tell how numbers are stored: KRBI (where none is said) and KDBI big-endian binary, 4
and 8 bytes; LRFI and LDFI text, fields of 10 and 20 characters, 80 to a line, each station on a new
line, a field that begins with `*` being a number that is missing.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from math import inf, isfinite, nan
from pathlib import Path

import numpy as np

from wheelhop.campaign import CampaignError
from wheelhop.files import TABLE, read_bytes, readable
from wheelhop.track.track import Array

_BINARY = {"KRBI": ">f4", "KDBI": ">f8"}
_TEXT = {"LRFI": 10, "LDFI": 20}  # characters per field
_LINE = 80  # characters
_HEADER_ENDS = re.compile(rb"^\$\$\$\$[^\n]*\n?", re.MULTILINE)
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([EeDd][-+]?\d+)?", re.ASCII)


@dataclass(frozen=True, eq=False)
class Grid:
    """A surveyed surface along its reference line, NaN where nothing was measured.

    Heights are relative to the reference line. Its own course (heading, slope, banking) is left
    out: a vehicle does not feel it as unevenness.
    """

    u_m: Array  # (n,) stations along the reference line
    v_m: Array  # (k,) lateral positions of the long sections, increasing, positive to the left
    height_m: Array  # (n, k)


def read_opencrg(path: Path) -> Grid:
    """The grid in an OpenCRG file.

    Raises `CampaignError` if the file cannot be opened, is not OpenCRG, is truncated, contains what
    is no number, or asks for its grid to be modified on reading.
    """
    with readable(path, CampaignError):
        content = read_bytes(path, CampaignError, TABLE)
    mark = _HEADER_ENDS.search(content)
    header = _Header.parse(content[: mark.start()] if mark else content, path)
    if mark is None:
        raise CampaignError(f"{path}: no line of $$$$ ends the header: there are no data")
    v = header.long_sections()
    start, step, said = header.reference_line()
    table = _read_table(content, mark.end(), header)
    if said is None:  # NaN fills up the last record, and may be whole stations
        table = table[: np.flatnonzero(~np.isnan(table).all(axis=1)).max(initial=-1) + 1]
        said = float(len(table))
    spare = (len(table) - said) * header.station_bytes
    if not 0.0 <= spare < (_LINE if header.code in _BINARY else 1):
        raise CampaignError(
            f"{path}: holds {len(table)} stations, and its header says {said:.9g}: truncated,"
            " damaged by an end-of-line conversion, or reference_line_end_u is wrong"
        )
    if said < 2.0:
        raise CampaignError(f"{path}: {said:g} stations; a profile needs at least two")
    table = table[: int(said)]
    heights = table[:, [i for i, channel in enumerate(header.channels) if channel.is_height]]
    order = np.argsort(v)
    u = start + step * np.arange(len(table), dtype=np.float64)
    return Grid(u, v[order], heights[:, order])


@dataclass(frozen=True)
class _Channel:
    """A `D:` line: what a column of the data is, in lower case."""

    line: int
    name: str
    unit: str

    @property
    def is_height(self) -> bool:
        return self.name.startswith("long section")


@dataclass
class _Header:
    """What the text header says. Texts stand with the line they are in."""

    path: Path
    code: str = "KRBI"  # how the data are stored
    channels: list[_Channel] = field(default_factory=list)  # in the order of the data
    parameters: dict[str, tuple[int, str]] = field(default_factory=dict)  # $ROAD_CRG, in lower case

    @staticmethod
    def parse(head: bytes, path: Path) -> _Header:
        """Raises CampaignError for what is no OpenCRG file, and one that is more than its data."""
        header, section = _Header(path), ""
        lines = re.split(r"\r\n|\r|\n", head.decode("latin-1"))
        for number, whole in enumerate(lines, start=1):
            line = whole.partition("!")[0].strip()
            if line.startswith("$"):
                section = line[1:].strip().upper()
            elif line and not line.startswith("*"):
                header._take(section, number, line)
        if not header.channels:
            raise CampaignError(f"{path}: not an OpenCRG file: no D: line names a column of data")
        return header

    def _take(self, section: str, number: int, line: str) -> None:
        """Note a line of a section."""
        begins, rest = line[:2].upper(), line[2:].strip()
        if section == "ROAD_CRG" and "=" in line:
            name, _, value = line.partition("=")
            self.parameters[name.strip().lower()] = number, value.strip()
        elif section in ("ROAD_CRG_MODS", "ROAD_CRG_FILE"):
            raise self.error(number, f"${section} is not supported; save the road with it applied")
        elif section == "KD_DEFINITION" and begins == "#:":
            self.code = rest.upper()
            if self.code not in {*_BINARY, *_TEXT}:
                raise self.error(number, f"'{line}': no data code KRBI, KDBI, LRFI or LDFI")
        elif section == "KD_DEFINITION" and begins == "D:":
            name, _, unit = rest.lower().partition(",")
            self.channels.append(_Channel(number, name.strip(), unit.strip()))
        elif section == "KD_DEFINITION" and begins == "U:":
            name, _, start, step = [*(word.strip() for word in rest.split(",")), "", "", ""][:4]
            if name.lower() == "reference line u":  # in its unit, from the first station on
                stated = {"u_start": start, "u_increment": step}
                self.parameters |= {key: (number, text) for key, text in stated.items() if text}

    @property
    def station_bytes(self) -> int:
        """What the numbers of a station take."""
        number = np.dtype(_BINARY[self.code]).itemsize if self.code in _BINARY else _TEXT[self.code]
        return number * len(self.channels)

    def error(self, line: int, text: str) -> CampaignError:
        """About a line of the file."""
        return CampaignError(f"{self.path}: line {line}: {text}")

    def number(self, line: int, text: str, what: str) -> float:
        """The number in a text; `what` says which one it is to be."""
        value = float(re.sub("[Dd]", "e", text)) if _NUMBER.fullmatch(text) else nan
        if not isfinite(value):
            raise self.error(line, f"{what} '{text}' is no number")
        return value

    def long_sections(self) -> Array:
        """Lateral positions, m, in the order of the channels."""
        sections = [channel for channel in self.channels if channel.is_height]
        if len(sections) < 2:
            raise CampaignError(
                f"{self.path}: {len(sections)} long sections; at least two are needed"
            )
        for one in sections:
            if one.unit != "m":
                raise self.error(one.line, f"the unit of '{one.name}' is '{one.unit}': must be m")
        placed = [one for one in sections if one.name.startswith("long section at")]
        v = np.array([self._which(one) for one in sections])
        if not placed:
            if sorted(v) != list(range(1, len(v) + 1)):
                raise self.error(sections[0].line, f"number long sections from 1 to {len(v)}")
            right, step = self._right_and_step(len(v) - 1)
            v = right + step * (v - 1.0)
        elif len(placed) < len(sections):
            raise self.error(placed[0].line, "number all long sections, or place them all")
        if len(set(v.tolist())) < len(v):
            raise CampaignError(f"{self.path}: two long sections lie at the same place")
        return v

    def _which(self, section: _Channel) -> float:
        """Where a long section lies, m, or its number, as its name says."""
        text = re.sub(r"^long section( at v\s*=)?", "", section.name).strip()
        return self.number(section.line, text, "which long section:")

    def _right_and_step(self, gaps: int) -> tuple[float, float]:
        """Where the rightmost of numbered long sections lies, and their spacing, m."""
        right, left, step = (
            self._parameter(f"long_section_v_{name}") for name in ("right", "left", "increment")
        )
        if step is None:
            if left is None:
                raise CampaignError(f"{self.path}: where the long sections lie is not stated")
            right = -left if right is None else right
            step = (left - right) / gaps
        elif right is None:
            right = -step * gaps / 2 if left is None else left - step * gaps
        if not 0.0 < step < inf or (
            left is not None and abs(left - right - step * gaps) > step / 2
        ):
            raise CampaignError(
                f"{self.path}: {gaps + 1} long sections do not fit long_section_v_right, _left and"
                " _increment"
            )
        return right, step

    def reference_line(self) -> tuple[float, float, float | None]:
        """First station, m, spacing, m, and number of stations, a whole one, None where only
        the data tell it."""
        start = self._parameter("reference_line_start_u", "u_start")
        step = self._parameter("reference_line_increment", "u_increment")
        if step is None or not step > 0.0:
            raise CampaignError(f"{self.path}: reference_line_increment must be positive")
        start, end = start or 0.0, self._parameter("reference_line_end_u")
        return start, step, None if end is None else float(np.rint((end - start) / step)) + 1.0

    def _parameter(self, *names: str) -> float | None:
        """The first of these that the header states."""
        for name in names:
            if name in self.parameters:
                line, text = self.parameters[name]
                return self.number(line, text, f"{name} =")
        return None


def _read_table(content: bytes, start: int, header: _Header) -> Array:
    """All whole stations, (n, channels), NaN where a number is missing; `start` is the first byte.

    Raises CampaignError, with the line, for text that is not what the header says.
    """
    channels = len(header.channels)
    if header.code in _BINARY:
        stations = (len(content) - start) // header.station_bytes
        flat = np.frombuffer(content, _BINARY[header.code], stations * channels, start)
        with np.errstate(invalid="ignore"):  # damaged bytes may be signalling NaN
            return flat.astype(np.float64).reshape(stations, channels)
    width, first = _TEXT[header.code], content.count(b"\n", 0, start) + 1
    text = content[start:].decode("latin-1").rstrip()
    lines = text.split("\n") if text else []
    widths = [min(_LINE, header.station_bytes - at) for at in range(0, header.station_bytes, _LINE)]
    values: list[float] = []
    for number, line in enumerate(lines, start=first):
        filled, ends = line.rstrip(), widths[(number - first) % len(widths)]
        if len(filled) > ends:
            raise header.error(number, f"goes beyond column {ends}, where its last number ends")
        for at in range(0, ends, width):
            values.append(_field(filled[at : at + width], header, number, at))
    if len(lines) % len(widths):
        raise header.error(first + len(lines) - 1, "the last station is cut off")
    return np.array(values, dtype=np.float64).reshape(-1, channels)


def _field(text: str, header: _Header, line: int, at: int) -> float:
    """The number in a field, NaN where it begins with an asterisk: none was measured."""
    text = text.strip()
    return nan if text.startswith("*") else header.number(line, text, f"column {at + 1}:")
