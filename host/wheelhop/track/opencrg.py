"""Reading OpenCRG road surfaces (ASAM OpenCRG 1.2): heights on a grid along a reference line.

A text header up to a line of `$$$$`, then the data: per station the channels that the header's
`D:` lines name, among them one height per long section. Four codes tell how numbers are stored:
KRBI and KDBI big-endian binary, 4 and 8 bytes; LRFI and LDFI text, fields of 10 and 20 characters,
80 to a line, each station on a new line.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wheelhop.campaign import CampaignError
from wheelhop.files import TABLE, read_bytes
from wheelhop.track.track import Array

_BINARY = {"KRBI": ">f4", "KDBI": ">f8"}
_TEXT = {"LRFI": 10, "LDFI": 20}  # characters per field
_LINE = 80  # characters


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

    Raises `CampaignError` if the file is not OpenCRG, is truncated, or asks for its grid to be
    modified on reading, and `OSError` if it cannot be opened.
    """
    head, _, data = read_bytes(path, CampaignError, TABLE).partition(b"$$$$")
    _, _, data = data.partition(b"\n")
    header = _Header.parse(head.decode("latin-1"))
    if header.code not in _BINARY and header.code not in _TEXT:
        raise CampaignError(f"{path}: not an OpenCRG file: no data code KRBI, KDBI, LRFI or LDFI")
    if header.modified:
        raise CampaignError(
            f"{path}: $ROAD_CRG_{header.modified} is not supported; save the road with it applied"
        )
    try:
        v = header.long_sections()
        start, step, stations = header.reference_line()
    except (KeyError, ValueError) as error:
        raise CampaignError(f"{path}: OpenCRG header: {error.args[0]}") from error
    table = _read_table(data, header.code, len(header.channels))
    stations = stations or len(table)
    if len(table) < max(stations, 2):
        raise CampaignError(
            f"{path}: holds {len(table)} stations and needs {max(stations, 2)}: truncated, or "
            "damaged by an end-of-line conversion"
        )
    heights = table[:stations, header.height_columns()]
    order = np.argsort(v)
    u = start + step * np.arange(stations, dtype=np.float64)
    return Grid(u, v[order], heights[:, order])


@dataclass(frozen=True)
class _Header:
    """What the text header says."""

    code: str  # how the data are stored
    channels: list[str]  # in the order of the data
    parameters: dict[str, str]  # of $ROAD_CRG, names in lower case
    line: list[str]  # of the U: channel, if there is one: first station and spacing
    modified: str  # MODS or FILE, if the header changes the grid or takes it from elsewhere

    @staticmethod
    def parse(text: str) -> _Header:
        code, section, modified = "", "", ""
        channels, parameters, reference = [], {}, []
        for line in text.splitlines():
            line = line.partition("!")[0].strip()
            if line.startswith("$"):
                section = line[1:].upper()
            elif section == "ROAD_CRG" and "=" in line:
                name, _, value = line.partition("=")
                parameters[name.strip().lower()] = value.strip()
            elif section in ("ROAD_CRG_MODS", "ROAD_CRG_FILE") and line and line[0] != "*":
                modified = section.removeprefix("ROAD_CRG_")
            elif section == "KD_DEFINITION" and line.startswith("#:"):
                code = line[2:].strip().upper()
            elif section == "KD_DEFINITION" and line.startswith("D:"):
                channels.append(line[2:].partition(",")[0].strip().lower())
            elif section == "KD_DEFINITION" and line.startswith("U:"):
                reference = line.split(",")[2:4]
        return _Header(code, channels, parameters, reference, modified)

    def height_columns(self) -> list[int]:
        return [i for i, name in enumerate(self.channels) if name.startswith("long section")]

    def long_sections(self) -> Array:
        """Lateral positions, m, in the order of the channels."""
        names = [self.channels[column] for column in self.height_columns()]
        if len(names) < 2:
            raise ValueError(f"{len(names)} long sections; at least two are needed")
        stated = [re.search(r"v\s*=\s*([-+.\de]+)", name) for name in names]
        if all(stated):
            v = np.array([float(match[1]) for match in stated if match])
        else:
            count = len(names) - 1
            right = self._number("long_section_v_right")
            left = self._number("long_section_v_left")
            step = self._number("long_section_v_increment")
            if step is None:
                if left is None:
                    raise ValueError("where the long sections lie is not stated")
                right = -left if right is None else right
                step = (left - right) / count
            elif right is None:
                right = -step * count / 2
            v = right + step * np.arange(count + 1)
        if len(set(v.tolist())) < len(v):
            raise ValueError("two long sections lie at the same place")
        return v

    def reference_line(self) -> tuple[float, float, int]:
        """First station, m, spacing, m, and number of stations (0: as many as there are data)."""
        first, spacing = self.line if len(self.line) == 2 else ("0", "0")
        start = self._number("reference_line_start_u")
        start = float(first) if start is None else start
        step = self._number("reference_line_increment") or float(spacing)
        if not step > 0:
            raise ValueError("reference_line_increment must be positive")
        end = self._number("reference_line_end_u")
        return start, step, 0 if end is None else round((end - start) / step) + 1

    def _number(self, name: str) -> float | None:
        return float(self.parameters[name]) if name in self.parameters else None


def _read_table(data: bytes, code: str, channels: int) -> Array:
    """All whole stations, (n, channels), NaN where a number is missing."""
    if code in _BINARY:
        number = np.dtype(_BINARY[code])
        stations = len(data) // (channels * number.itemsize)
        flat = np.frombuffer(data, number, stations * channels)
        with np.errstate(invalid="ignore"):  # damaged bytes may be signalling NaN
            flat = flat.astype(np.float64)
        return flat.reshape(stations, channels)
    width = _TEXT[code]
    lines = data.decode("latin-1").splitlines()
    lines_per_station = -(-channels * width // _LINE)
    table = []
    for first in range(0, len(lines) - lines_per_station + 1, lines_per_station):
        text = "".join(line.ljust(_LINE) for line in lines[first : first + lines_per_station])
        table.append([_field(text[i * width : (i + 1) * width]) for i in range(channels)])
    return np.array(table, dtype=np.float64).reshape(-1, channels)


def _field(text: str) -> float:
    """A number, NaN for a field of asterisks or the word *missing*."""
    return np.nan if "*" in text or not text.strip() else float(text)
