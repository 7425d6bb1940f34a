"""A campaign in the making: recordings, what their columns are, which stretches were driven where,
and what the vehicle is believed to be."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from wheelhop.campaign import CampaignError
from wheelhop.campaign.activity import stretches
from wheelhop.campaign.recorded import read_recording
from wheelhop.campaign.tracks import KINDS
from wheelhop.campaign.write import VEHICLE, NewRun, add_run, cut, new_campaign
from wheelhop.files import parse_toml, quoted, remove
from wheelhop.formats import Map, Pick, draft_mapping, read, read_mapping
from wheelhop.formats.places import likely_point
from wheelhop.logger.recording import Recording
from wheelhop.vehicle.vehicle import read_vehicle

UNITS = ("m/s²", "g", "mg", "mm/s²", "cm/s²")
NOT_USED = "not used"
POINTS = tuple(f"{place}{i}" for place in "AB" for i in (1, 2, 3, 4))
PLACES = (*POINTS, "body", NOT_USED)
FREE_FORM = (".csv", ".txt", ".tsv", ".dat", ".asc")
TRACKS = tuple(kind for kind in KINDS if kind not in ("profile", "iso8608"))
"""Kinds of track that need no file and no drawing of lots."""
USUAL = {
    **{"amplitude_mm": 10.0, "pitch_mm": 500.0, "angle_deg": 20.0, "width_mm": 4000.0},
    **{"lateral_offset_mm": 0.0, "pitch_start_mm": 2000.0, "pitch_end_mm": 500.0},
    **{"length_mm": 500.0, "height_mm": 30.0},
}
"""Where a field begins, to be replaced."""


@dataclass
class Column:
    """One column of the recordings: its name there, in what unit it is, and where it sits."""

    key: str | int
    name: str
    unit: str
    place: str


@dataclass
class Piece:
    """A stretch of a recording that may become a run."""

    file: Path
    from_s: float
    to_s: float
    rms: float
    id: str
    taken: bool = True
    role: str = "fit"
    speed_kmph: float = 10.0
    kind: str = "unknown"
    track: dict[str, float] = field(default_factory=dict)

    def choose(self, kind: str) -> None:
        """Another kind of track; what it shares with the last one stays."""
        keys = [key for key in KINDS[kind] if key in USUAL]
        self.kind = kind
        self.track = {key: self.track.get(key, USUAL[key]) for key in keys}


class Draft:
    """What the guided page fills in."""

    def __init__(self) -> None:
        self.files: list[Path] = []
        self.columns: list[Column] = []
        self.pieces: list[Piece] = []
        self.recordings: dict[Path, Recording] = {}
        self.relative_uncertainty = 0.3
        self.vehicle = _template()
        self._map: Map | None = None

    def add(self, file: Path) -> None:
        """One more recording; the first one says what the columns are. Raises InputError."""
        if not self.files and file.suffix.lower() != ".hop":
            self._look_at(file)
        self.files = sorted({*self.files, file})

    def _look_at(self, file: Path) -> None:
        with tempfile.TemporaryDirectory() as folder:
            written = Path(folder) / "map.toml"
            written.write_text(draft_mapping(file), encoding="utf-8")
            self._map = read_mapping(written)
        self.columns = [_column(pick) for pick in self._map.picks]

    def read(self) -> None:
        """Read every recording and find the stretches that were driven. Raises InputError."""
        self.recordings = {file: self._read(file) for file in self.files}
        self.pieces = []
        for file, recording in self.recordings.items():
            found = stretches(recording)
            time_s = recording.time_s
            for i, piece in enumerate(found, start=1):
                name = re.sub(r"[^A-Za-z0-9_-]+", "-", file.stem).strip("-") or "run"
                self.pieces.append(
                    Piece(
                        file,
                        float(time_s[piece.first]),
                        float(time_s[piece.last - 1]),
                        piece.rms,
                        id=name if len(found) == 1 else f"{name}-{i}",
                        role="validate" if len(self.pieces) % 3 == 2 else "fit",
                    )
                )

    def _read(self, file: Path) -> Recording:
        if file.suffix.lower() == ".hop":
            return read_recording(file, None, True)
        used = [column for column in self.columns if column.place != NOT_USED]
        if not used:
            raise CampaignError(f"{file.name}: no column has a place: say where each sensor sits")
        picks = tuple(
            Pick(c.key, name=c.place if c.place in POINTS else c.name, unit=c.unit, point=c.place)
            for c in used
        )
        assert self._map is not None
        return read(file, replace(self._map, picks=picks))

    def make(self, folder: Path, title: str) -> None:
        """Write the campaign, or nothing. Raises InputError."""
        taken = [piece for piece in self.pieces if piece.taken]
        if not taken:
            raise CampaignError(f"{folder}: no stretch is taken: take one that was driven")
        if len({piece.id for piece in taken}) < len(taken):
            raise CampaignError(f"{folder}: two runs have the same name: give each its own")
        if (folder / "campaign.toml").exists():
            raise CampaignError(f"{folder}: there is a campaign already: choose another folder")
        taken.sort(key=lambda piece: piece.role)  # the first one has to be fitted
        before = {folder, *folder.rglob("*")} if folder.exists() else set()
        try:
            with tempfile.TemporaryDirectory() as other:
                vehicle = Path(other) / "vehicle.toml"
                vehicle.write_text(self._vehicle_text(title), encoding="utf-8")
                read_vehicle(vehicle)  # a number that cannot be is said now
                new_campaign(folder, title, self.recordings[taken[0].file], {}, vehicle)
            for piece in taken:
                self._add(folder, piece)
        except BaseException:
            remove([path for path in (folder, *sorted(folder.rglob("*"))) if path not in before])
            raise

    def _add(self, folder: Path, piece: Piece) -> None:
        recording = cut(self.recordings[piece.file], piece.from_s, piece.to_s)
        track: dict[str, str | float] = {"kind": piece.kind, **piece.track}
        source = f"from {piece.file.name}"
        add_run(folder, recording, NewRun(piece.id, piece.role, piece.speed_kmph, track, source))

    def _vehicle_text(self, name: str) -> str:
        lines = ["format = 1", f"name = {quoted(name)}"]
        lines.append(f"relative_uncertainty = {self.relative_uncertainty!r}")
        tables: dict[str, list[str]] = {}
        for key, value in self.vehicle.items():
            table, _, last = key.rpartition(".")
            tables.setdefault(table, []).append(f"{last} = {float(value)!r}")
        for table, rows in tables.items():
            lines += ["", f"[{table}]", *rows]
        return "\n".join(lines) + "\n"


def _column(pick: Pick) -> Column:
    name = pick.name or str(pick.column)
    unit = pick.unit if pick.unit in UNITS else UNITS[0]
    return Column(pick.column, name, unit, pick.point or likely_point(name) or NOT_USED)


def _template() -> dict[str, float]:
    """The numbers of the sample vehicle under dotted keys: to be replaced."""
    top = parse_toml(VEHICLE.format(title='"template"'), Path("vehicle.toml"))
    numbers: dict[str, float] = {}

    def walk(values: object, path: Sequence[str]) -> None:
        if isinstance(values, dict):
            for key, value in values.items():
                walk(value, [*path, key])
        elif isinstance(values, float) and len(path) > 1:
            numbers[".".join(path)] = values

    walk(dict(top.values), [])
    return numbers
