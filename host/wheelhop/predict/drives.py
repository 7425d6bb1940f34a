"""What is asked for on the command line: tracks, speeds, effects, as `NAME:key=value:key=value`."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite
from pathlib import Path

from wheelhop.campaign import AXLE_POINTS, BODY_POINTS, CampaignError, Channel, TrackSpec
from wheelhop.campaign.course import Course
from wheelhop.campaign.proving_ground import proving_ground, table_5_1
from wheelhop.campaign.tracks import read_track
from wheelhop.effects import Effect
from wheelhop.files import Table, did_you_mean
from wheelhop.track import make_track

CHANNELS = tuple(Channel(point, point) for point in (*BODY_POINTS, *AXLE_POINTS))
"""What is recorded of a full car, in the order of the logger's inputs."""
TABLE_5_1 = "table-5.1"
"""As a track: the eighteen tests of the thesis."""
FORM = "form"
"""As an effect's parameter: which of its forms is meant."""
VALIDATE_EVERY = 3
"""Every third run is held out."""


@dataclass(frozen=True)
class Word:
    """A name, and the values given with it."""

    name: str
    options: Mapping[str, str | float]

    @staticmethod
    def parse(text: str, option: str) -> Word:
        """`washboard:amplitude_mm=15:pitch_mm=400`; raises CampaignError that begins with the
        command's `option`."""
        name, *pairs = text.split(":")
        options: dict[str, str | float] = {}
        for pair in pairs:
            key, equals, value = pair.partition("=")
            if not (name and key and equals and value):
                raise CampaignError(f"{option} {text}: '{pair}' is not KEY=VALUE")
            if key in options:
                raise CampaignError(f"{option} {text}: {key} is given twice")
            options[key] = _number_or_text(value)
        return Word(name, options)


@dataclass(frozen=True)
class Drive:
    """One run to be simulated: its id, role, exact speed, the mean of a `course` if it has one, and
    its track as campaign.toml says it (`keys`) and in SI (`track`); `file` is the survey of a
    profile."""

    id: str
    role: str
    speed_kmph: float
    keys: Mapping[str, str | float]
    track: TrackSpec
    file: Path | None = None
    course: Course | None = None


@dataclass(frozen=True)
class Chosen:
    """An effect in one of its forms, and the values of its parameters that are stated."""

    effect: Effect
    values: Mapping[str, float]


def read_speeds(texts: Sequence[str]) -> tuple[float | Course, ...]:
    """Speeds, km/h, or courses as pairs of place, m, and speed, km/h: "0:5,20:12". Raises
    CampaignError."""
    found: list[float | Course] = []
    for text in texts:
        try:
            pairs = [[float(word) for word in pair.split(":")] for pair in text.split(",")]
        except ValueError:
            raise CampaignError(
                f"--speed {text}: is no speed in km/h, nor a course such as 0:5,20:12"
            ) from None
        if len(pairs) == 1 and len(pairs[0]) == 1:
            found.append(pairs[0][0])
            continue
        try:
            found.append(Course.of(pairs))
        except ValueError as error:
            raise CampaignError(f"--speed {text}: {error}") from None
    return tuple(found)


def read_drives(tracks: Sequence[str], speeds_kmph: Sequence[float | Course]) -> tuple[Drive, ...]:
    """Every track at every speed or course; without, at the speeds the thesis drove it at.

    Raises CampaignError for a track or a key that is not known, a survey that cannot be used, a
    speed that is not above 0, and a track of no known speed.
    """
    for speed in speeds_kmph:
        if not (isinstance(speed, Course) or 0.0 < speed < inf):
            raise CampaignError(f"--speed {speed:g}: must be above 0 km/h")
    words = [Word.parse(text, "--tracks") for text in tracks]
    names = [word for one in words for word in _expanded(one)]
    drives: list[Drive] = []
    for word in names:
        keys, spec, file = _track(word)
        known = proving_ground()[word.name].speeds_kmph if word.name in proving_ground() else ()
        if not (speeds_kmph or known):
            raise CampaignError(f"--tracks {word.name}: say how fast, such as --speed 10")
        for speed in speeds_kmph or known:
            role = "fit" if len(drives) % VALIDATE_EVERY < VALIDATE_EVERY - 1 else "validate"
            label = re.sub(r"[^A-Za-z0-9_-]+", "-", file.stem if file else word.name).strip("-")
            id_ = _distinct(f"{label}-{_named(speed)}kmph", drives)
            course = speed if isinstance(speed, Course) else None
            mean = 3.6 * speed.mean_m_s if isinstance(speed, Course) else speed
            drives.append(Drive(id_, role, mean, keys, spec, file, course))
    return tuple(drives)


def read_effects(texts: Sequence[str], library: Mapping[str, Effect]) -> tuple[Chosen, ...]:
    """Effects with the values stated, each once; which parameters they have depends on the
    vehicle, and is checked with it. Raises CampaignError."""
    chosen: list[Chosen] = []
    for text in texts:
        word = Word.parse(text, "--with")
        if word.name not in library:
            near = did_you_mean(word.name, library) or f"; there are {', '.join(library)}"
            raise CampaignError(f"--with {word.name}: there is no such effect{near}")
        if any(one.effect.id == word.name for one in chosen):
            raise CampaignError(f"--with {word.name}: is given twice")
        effect, form = library[word.name], str(word.options.get(FORM, ""))
        if form:
            forms = effect.choices(CHANNELS)
            if form not in forms:
                there = ", ".join(filter(None, forms)) or "it has only one"
                raise CampaignError(f"--with {text}: there is no form '{form}': {there}")
            effect = effect.with_choice(form)
        chosen.append(Chosen(effect, _numbers(word, text)))
    return tuple(chosen)


def absolute(text: str) -> str:
    """A track's word, the path of a survey in it the one that leads there from anywhere."""
    name, *pairs = text.split(":")
    split = [pair.partition("=") for pair in pairs]
    return ":".join(
        [name, *(f"file={Path(v).resolve()}" if k == "file" else f"{k}{e}{v}" for k, e, v in split)]
    )


def _numbers(word: Word, text: str) -> dict[str, float]:
    """The values of an effect's parameters."""
    numbers: dict[str, float] = {}
    for key, value in word.options.items():
        if key != FORM:
            if isinstance(value, str) or not isfinite(value):
                raise CampaignError(f"--with {text}: {key} = {value} is not a number")
            numbers[key] = value
    return numbers


def _expanded(word: Word) -> list[Word]:
    if word.name != TABLE_5_1:
        return [word]
    return [Word(name, word.options) for name in table_5_1()]


def _track(word: Word) -> tuple[dict[str, str | float], TrackSpec, Path | None]:
    """The keys of campaign.toml, their meaning in SI, and the survey to be copied."""
    keys: dict[str, str | float] = {"kind": word.name, **word.options}
    if word.name == "unknown":
        raise CampaignError("--tracks unknown: has no shape; choose one that has")
    folder, file = Path(), None
    if word.name == "profile" and "file" in keys:
        file = Path(str(keys["file"]))
        folder, keys["file"] = file.parent, file.name
    table = Table({"track": keys}, Path(f"--tracks {word.name}"), kind=CampaignError)
    spec = read_track(table, folder)
    make_track(spec)  # reads a survey
    if file is not None:
        keys["file"] = f"tracks/{file.name}"
    return keys, spec, file


def _named(speed: float | Course) -> str:
    """A speed, or the first and last of a course, as part of a run's id."""
    if not isinstance(speed, Course):
        return f"{speed:g}"
    return f"{3.6 * speed.speed_m_s[0]:.3g}to{3.6 * speed.speed_m_s[-1]:.3g}"


def _distinct(id_: str, drives: Sequence[Drive]) -> str:
    """The id, numbered where another run has it."""
    taken = {drive.id for drive in drives}
    numbered = (f"{id_}-{number}" for number in range(2, len(taken) + 3))
    return id_ if id_ not in taken else next(one for one in numbered if one not in taken)


def _number_or_text(text: str) -> str | float:
    try:
        return float(text)
    except ValueError:
        return text
