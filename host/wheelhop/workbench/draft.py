"""A campaign in the making: recordings, what their columns are, which stretches were driven where,
and what the vehicle is believed to be."""

from __future__ import annotations

import re
import tempfile
import threading
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import CampaignError
from wheelhop.campaign.activity import stretches
from wheelhop.campaign.channel import ROTATION
from wheelhop.campaign.channels import QUANTITIES, place_of
from wheelhop.campaign.recorded import accelerations, read_recording
from wheelhop.campaign.tracks import KINDS, is_steady
from wheelhop.campaign.write import NewRun, add_runs, cut, new_campaign
from wheelhop.files import InputError, remove
from wheelhop.files.units import to_si
from wheelhop.formats import Map, Pick, read, understand
from wheelhop.formats.columns import Question
from wheelhop.formats.places import likely_on_body, likely_quantity
from wheelhop.logger.recording import ACCELERATION, Recording
from wheelhop.vehicle.estimate import SPRING, Number, vehicle_toml
from wheelhop.vehicle.vehicle import read_vehicle
from wheelhop.workbench.questions import FIELD_WORDS, QUESTIONS, RECORDER_WORDS, known

UNITS: Mapping[str, tuple[str, ...]] = {
    "m/s²": ("m/s²", "g", "mg", "mm/s²", "cm/s²"),
    "m": ("mm", "m", "cm", "in"),
    "rad/s": ("rad/s", "deg/s", "rpm"),
    "N": ("N", "kN", "lbf"),
    "m/s": ("km/h", "m/s", "mph"),
}
"""What may be chosen as the unit of a column, by the SI unit of what it measures."""
NOT_USED = "not used"
POINTS = tuple(f"{place}{i}" for place in "AB" for i in (1, 2, 3, 4))
PER_WHEEL = tuple(f"{quantity}:{i}" for quantity in ("travel", "force") for i in (1, 2, 3, 4))
"""Places at a strut, whose sensor shows so much per what happens at the wheel."""
WHEELS = tuple(f"speed:wheel:{i}" for i in (1, 2, 3, 4))
ON_BODY = ("along:x", "along:y", "on:driver", "on:engine")
OTHERS = (*ON_BODY, *PER_WHEEL, "rate:pitch", "rate:roll", "speed", "speed:engine", *WHEELS)
PLACES = (*POINTS, "body", *OTHERS, NOT_USED)
TRACKS = tuple(kind for kind in KINDS if kind not in ("profile", "iso8608", "cobblestone"))
"""Kinds of track that need no file and no drawing of lots."""
SHORT = {"twist": "chassis-twist", "sweep": "sine-sweep"}
"""What people call them, too."""


@dataclass
class Column:
    """One column of the recordings: its name there, in what unit it is, where it sits, as a point
    or as the word of another quantity, and, at a strut, what it shows per what the wheel does."""

    key: str | int
    name: str
    unit: str
    place: str
    per_wheel: float | None = 1.0

    @property
    def si_unit(self) -> str:
        """The unit of what it measures there."""
        place = place_of(self.place)
        if not isinstance(place, dict):
            return ACCELERATION
        return ROTATION if "of" in place else QUANTITIES[str(place["quantity"])].unit

    @property
    def point(self) -> str:
        """Place and ratio as one word, which a campaign is made of."""
        ratio = 1.0 if self.per_wheel is None else self.per_wheel
        return f"{self.place}:{ratio:g}" if self.place in PER_WHEEL and ratio != 1 else self.place


@dataclass
class Piece:
    """A stretch of a recording that may become a run. `whole` and `steady` are from when to when
    all of the drive that was found lasts, and its steady part, s; empty where none was found."""

    file: Path
    from_s: float
    to_s: float
    rms: float
    id: str
    taken: bool = True
    role: str = "fit"
    speed_kmph: float | None = None
    kind: str = "unknown"
    track: dict[str, float | None] = field(default_factory=dict)
    whole: list[float] = field(default_factory=list)
    steady: list[float] = field(default_factory=list)

    def choose(self, kind: str) -> None:
        """Another kind of track; what it shares with the last one stays. Ends that nobody has moved
        become those of the steady part on a track that goes on alike, else of all of the drive."""
        numbers = {key: value for key, value in KINDS[kind].items() if not isinstance(value, str)}
        self.kind = kind
        self.track = {key: self.track.get(key, value) for key, value in numbers.items()}
        if [self.from_s, self.to_s] in (self.whole, self.steady):
            self.from_s, self.to_s = self.steady if is_steady(kind) else self.whole


class Draft:
    """What the guided page fills in: a new campaign, or more runs for the one in folder `into`.

    It is kept in `folder` (`kept`), with the recordings that came from the browser. `constants` are
    those of the logger's sensors, None: nominal ones. `answers` are to `QUESTIONS`, `better` are
    numbers of the vehicle known better than estimated, by their dotted names, `recorder` those of
    the instrument, by their keys in campaign.toml; None: not known.
    `waiting` is a recording of which something is `asked`, as import asks it; `said` are the
    answers by the questions' keys.
    `title` and `target` are the campaign's, the latter a folder. `trouble` says why the recordings
    cannot be read as their columns are named now. Files that arrive together are added by threads
    of their own: one at a time.
    """

    def __init__(self, folder: Path, into: Path | None = None) -> None:
        self.folder, self.into = folder, into
        self.constants: Path | None = None
        self.files: list[Path] = []
        self.columns: list[Column] = []
        self.pieces: list[Piece] = []
        self.recordings: dict[Path, Recording] = {}
        self.answers: dict[str, float | None] = dict.fromkeys(q.name for q in QUESTIONS)
        self.better: dict[str, float | None] = {}
        self.recorder: dict[str, float | None] = dict.fromkeys(RECORDER_WORDS)
        self.title, self.target = "My campaign", ""
        self.trouble = self.kept = ""
        self.waiting: Path | None = None
        self.asked: tuple[Question, ...] = ()
        self.said: dict[str, str] = {}
        self._later: list[Path] = []
        self._map: Map | None = None
        self._one_at_a_time = threading.Lock()

    def clear(self) -> None:
        """Begin anew with other recordings; what is known of the vehicle stays."""
        self.files, self.columns, self.pieces, self.recordings = [], [], [], {}
        self.trouble, self._map = "", None
        self.waiting, self.asked, self.said, self._later = None, (), {}, []

    def add(self, file: Path) -> None:
        """One more recording; the first one says what the columns are, and waits if it does not say
        all that has to be known. Raises InputError."""
        with self._one_at_a_time:
            if self.waiting not in (None, file):
                self._later.append(file)
                return
            if self._map is None and file.suffix.lower() != ".hop":
                self._look_at(file)
            if not self.asked:
                self.files = sorted({*self.files, file})

    def answer(self, said: Mapping[str, str]) -> None:
        """Add the recording that waits, with these answers to what is asked of it. Raises
        InputError for one that is none, and then it waits on."""
        assert self.waiting is not None
        before = self.said
        self.said = {**before, **{key: text for key, text in said.items() if text}}
        try:
            self.add(self.waiting)
        except InputError:
            self.said = before
            raise
        while self._later and not self.asked:
            self.add(self._later.pop())

    def _look_at(self, file: Path) -> None:
        found = understand(file, self.said)
        self.asked, self.waiting = found.questions, file if found.questions else None
        if found.questions:
            return
        self._map = found.mapping()
        points = {column.name: column.point for column in found.columns}
        self.columns = [_column(pick, points.get(pick.name, "")) for pick in self._map.picks]
        felt = [c for c in self.columns if c.place == NOT_USED and to_si(c.unit)[0] == ACCELERATION]
        for column, place in zip(felt, likely_on_body([c.name for c in felt]), strict=True):
            column.place = place or NOT_USED

    def units(self, column: Column) -> list[str]:
        """What may be chosen as the unit of a column: what its file says, and those of what it
        measures."""
        return list(dict.fromkeys((self._said(column), column.unit, *UNITS[column.si_unit])))

    def _said(self, column: Column) -> str:
        """The unit in the file that said what the columns are, empty if it said none."""
        picks = self._map.picks if self._map is not None else ()
        return next((pick.unit for pick in picks if pick.column == column.key), "")

    def read(self) -> None:
        """Read every recording and find the stretches that were driven; what was said of those
        found before stays. Raises InputError, and then the recordings stay as they were read."""
        self.trouble = ""
        try:
            self.recordings = {file: self._read(file) for file in self.files}
        except InputError as error:
            self.trouble = str(error)
            raise
        known = {piece.file for piece in self.pieces}
        for file, recording in self.recordings.items():
            if file in known:
                continue
            found = stretches(accelerations(recording)[0])
            time_s = recording.time_s
            for i, piece in enumerate(found, start=1):
                name = _name(file)
                whole = _ends(time_s, piece.first, piece.last)
                steady = _ends(time_s, piece.steady_first, piece.steady_last)
                new = Piece(
                    file,
                    whole[0],
                    whole[1],
                    piece.rms,
                    id=name if len(found) == 1 else f"{name}-{i}",
                    role="validate" if len(self.pieces) % 3 == 2 else "fit",
                    speed_kmph=_speed_in(file.stem),
                    whole=whole,
                    steady=steady,
                )
                new.choose(_track_in(file.stem))
                self.pieces.append(new)
        self.pieces.sort(key=lambda piece: (piece.file, piece.from_s))

    def _read(self, file: Path) -> Recording:
        if file.suffix.lower() == ".hop":
            return read_recording(file, self.constants, True)
        used = [column for column in self.columns if column.place != NOT_USED]
        if not used:
            raise CampaignError(f"{file.name}: no column has a place: say where each sensor sits")
        picks = tuple(
            Pick(
                column.key,
                name=column.place if column.place in POINTS else column.name,
                # Unless the user has chosen another one, every file is in the unit it says.
                unit="" if column.unit == self._said(column) else column.unit,
            )
            for column in used
        )
        assert self._map is not None
        recording = read(file, replace(self._map, picks=picks))
        for column, channel in zip(used, recording.channels, strict=True):
            if channel.unit != column.si_unit:
                unit = column.unit if to_si(column.unit)[0] == channel.unit else channel.unit
                wrong = _no_unit(unit, column.si_unit)
                raise CampaignError(f"{file.name}: column {column.name} {wrong}")
        placed = (
            replace(channel, point=column.point)
            for column, channel in zip(used, recording.channels, strict=True)
        )
        return replace(recording, channels=tuple(placed))

    def new_piece(self, file: Path) -> Piece:
        """One more stretch of a recording: its middle fifth."""
        time_s = self.recordings[file].time_s
        first, last = float(time_s[0]), float(time_s[-1])
        number = 1 + sum(piece.file == file for piece in self.pieces)
        middle, half = (first + last) / 2, (last - first) / 10
        piece = Piece(file, middle - half, middle + half, 0.0, id=f"{_name(file)}-{number}")
        self.pieces.append(piece)
        return piece

    def make(self, folder: Path, title: str) -> None:
        """Write the campaign, or nothing. Raises InputError."""
        taken = self._taken(folder)
        if (folder / "campaign.toml").exists():
            raise CampaignError(f"{folder}: there is a campaign already: choose another folder")
        taken.sort(key=lambda piece: piece.role)  # the first one has to be fitted
        before = {folder, *folder.rglob("*")} if folder.exists() else set()
        try:
            with tempfile.TemporaryDirectory() as other:
                vehicle = Path(other) / "vehicle.toml"
                vehicle.write_text(self._vehicle_text(title), encoding="utf-8")
                read_vehicle(vehicle)  # a number that cannot be is said now
                like = self.recordings[taken[0].file]
                if averaging_ms := self.recorder["averaging_ms"]:
                    like = replace(like, averaging_s=averaging_ms * 1e-3)
                noise = self.recorder["noise_rms_m_s2"]
                new_campaign(folder, title, like, {}, vehicle, self.constants, noise)
            add_runs(folder, [self._run(piece) for piece in taken])
        except BaseException:
            remove([path for path in (folder, *sorted(folder.rglob("*"))) if path not in before])
            raise

    def join(self, folder: Path) -> None:
        """Add the runs to the campaign that is in the folder, all or none. Raises InputError."""
        add_runs(folder, [self._run(piece) for piece in self._taken(folder)])

    def gaps(self) -> list[str]:
        """What has to be filled in before there is a campaign, run by run, then of the vehicle."""
        found = []
        for piece in self.pieces:
            words = [] if piece.speed_kmph is not None or self.tells_speed(piece) else ["speed"]
            words += [
                _short(FIELD_WORDS[key]) for key, value in piece.track.items() if value is None
            ]
            if piece.taken and words:
                found.append(f"run {piece.id}: {' and '.join(words)}")
        if self.into is None:
            missing = [q for q in QUESTIONS if q.needed and self.answers.get(q.name) is None]
            found += [_short(q.words) for q in missing]
        return found

    def tells_speed(self, piece: Piece) -> bool:
        """Whether a channel of its recording measures the vehicle's speed."""
        recording = self.recordings.get(piece.file)
        return recording is not None and any(c.point == "speed" for c in recording.channels)

    def _taken(self, folder: Path) -> list[Piece]:
        if self.trouble:
            raise CampaignError(self.trouble)
        taken = [piece for piece in self.pieces if piece.taken]
        if not taken:
            raise CampaignError(f"{folder}: no stretch is taken: take one that was driven")
        if len({piece.id for piece in taken}) < len(taken):
            raise CampaignError(f"{folder}: two runs have the same name: give each its own")
        if gaps := self.gaps():
            raise CampaignError(f"still needed: {'; '.join(gaps)}")
        return taken

    def _run(self, piece: Piece) -> tuple[Recording, NewRun]:
        recording = cut(self.recordings[piece.file], piece.from_s, piece.to_s)
        numbers = {key: value for key, value in piece.track.items() if value is not None}
        track: dict[str, str | float] = {"kind": piece.kind, **numbers}
        source = f"from {piece.file.name}"
        return recording, NewRun(piece.id, piece.role, piece.speed_kmph, track, source)

    def _vehicle_text(self, name: str) -> str:
        for question in QUESTIONS:
            value = self.answers.get(question.name)
            if value is not None:
                try:
                    question.read(f"{value:.9g}")
                except ValueError as error:
                    raise CampaignError(f"the vehicle: {question.words}: {error}") from None
        given = {question.name: self.answers.get(question.name) for question in QUESTIONS}
        better = {
            key: Number(value, SPRING * abs(value), "given")
            for key, value in self.better.items()
            if value is not None
        }
        return vehicle_toml(known(name, given), better)


def _ends(time_s: NDArray[np.float64], first: int, last: int) -> list[float]:
    """From when to when, to the centisecond that a page shows, so that showing moves nothing."""
    return [round(float(time_s[first]), 2), round(float(time_s[last - 1]), 2)]


def _short(words: str) -> str:
    """Without the unit and what explains it."""
    return words.partition(",")[0]


def _speed_in(name: str) -> float | None:
    """The speed that a file's name tells, km/h: "washboard 7,5kmh"."""
    found = re.search(r"(\d+(?:[.,]\d+)?)[\s_-]*(?:km[-_/]?h|kmph|kph)", name, re.IGNORECASE)
    return (float(found[1].replace(",", ".")) or None) if found else None


def _track_in(name: str) -> str:
    """The kind of track that a file's name tells; "unknown" where it tells none."""
    words = re.sub(r"[^a-z0-9]+", "-", name.lower())
    kinds = sorted(TRACKS, key=len, reverse=True)
    called = {kind: kind for kind in kinds} | SHORT
    return next((kind for word, kind in called.items() if word in words), "unknown")


def _name(file: Path) -> str:
    """A run's name, from a recording's."""
    return re.sub(r"[^A-Za-z0-9_-]+", "-", file.stem).strip("-_") or "run"


def _column(pick: Pick, point: str) -> Column:
    name = pick.name or str(pick.column)
    place = point or likely_quantity(name, to_si(pick.unit)[0]) or NOT_USED
    return Column(pick.column, name, pick.unit, place)


def _no_unit(unit: str, si_unit: str) -> str:
    """What is wrong with a unit of a channel that shall be in another one, and what to do."""
    if not unit:
        return f"does not say its unit: choose it, or '{NOT_USED}'"
    what = next((name for name, q in QUANTITIES.items() if q.unit == si_unit), "rotation")
    return f"is in {unit}, no unit of {what}: choose its unit, or '{NOT_USED}'"
