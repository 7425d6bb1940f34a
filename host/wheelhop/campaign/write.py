"""From recordings to a campaign on disk; what is written has been read back strictly."""

import filecmp
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np

from wheelhop.campaign.channel import AXLE_POINTS, BODY_POINTS
from wheelhop.campaign.channels import QUANTITIES, Place, place_of, units_of, with_noise
from wheelhop.campaign.course import Course
from wheelhop.campaign.paths import named_by
from wheelhop.campaign.read import CONSTANTS_FILE, check_run
from wheelhop.campaign.sample import VEHICLE
from wheelhop.campaign.types import CampaignError
from wheelhop.files import (
    locked,
    make_folder,
    parse_toml,
    quoted,
    read_text,
    remove,
    replacing,
    write_text,
)
from wheelhop.files.keys import LONGEST_TEXT
from wheelhop.formats.places import good_for, likely_points
from wheelhop.formats.table import uncertain_between
from wheelhop.logger.recording import ACCELERATION, CODE, Recording

DEFAULT_BAND_HZ = (0.5, 30.0)
SPEED_UNIT = QUANTITIES["speed"].unit
TOP_OF_BAND = 0.4  # of the sample rate, where 30 Hz is too much
FILE_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")


@dataclass(frozen=True)
class NewRun:
    """How a run was driven, as campaign.toml says it; `track` holds `kind` and its other keys, and
    a speed of None is the mean of what the campaign's speed channel shows."""

    id: str
    role: str
    speed_kmph: float | None
    track: Mapping[str, str | float]
    source: str = ""
    course: Course | None = None


def new_campaign(
    folder: str | Path,
    title: str,
    like: Recording,
    places: Mapping[str, Place],
    vehicle: str | Path | None = None,
    constants: str | Path | None = None,
    noise_rms: float | None = None,
) -> None:
    """Begin a campaign in a folder: campaign.toml without runs, and vehicle.toml. If anything
    fails, nothing is left behind.

    Parameters
    ----------
    folder
        A new one, or one that holds vehicle.toml alone.
    title
        What reports call it.
    like
        A recording whose sample rate, averaging and channels those to come have.
    places
        Where channels sit, or what they measure (`channels.place_of`), that its points do not tell.
    vehicle
        vehicle.toml; it and the files of mount and frame that it names are copied. Without, one
        that is there stays, or else a sample file is written.
    constants
        calibration.toml of the sensors, which is copied.
    noise_rms
        Of one accelerometer in band, m/s²; without, it is estimated later.

    Raises
    ------
    CampaignError
        There is a campaign already, or a channel has no place.
    """
    if not title.strip() or not title.isprintable() or len(title) > LONGEST_TEXT:
        raise CampaignError(f"title {title[:40]!r}: give a line of text with --title")
    folder = Path(folder)
    file, target = folder / "campaign.toml", folder / "vehicle.toml"
    rate = like.rate_hz
    high = DEFAULT_BAND_HZ[1] if DEFAULT_BAND_HZ[1] < rate / 2 else TOP_OF_BAND * rate
    if high < 2 * DEFAULT_BAND_HZ[0]:
        raise CampaignError(
            f"{folder}: {rate:g} samples a second tell nothing above {high:g} Hz, and a campaign"
            f" needs {DEFAULT_BAND_HZ[0]:g} to {2 * DEFAULT_BAND_HZ[0]:g} Hz at least: was the"
            " recording's time read in the right unit?"
        )
    lines = [
        "format = 1",
        f"title = {quoted(title)}",
        'vehicle = "vehicle.toml"',
        f"sample_rate_hz = {rate!r}",
        f"band_hz = [{DEFAULT_BAND_HZ[0]}, {high:g}]",
        f"averaging_ms = {like.averaging_s * 1e3:g}",
        *([] if noise_rms is None else [f"noise_rms_m_s2 = {noise_rms:.4g}"]),
        *_channel_lines(like, places),
    ]
    given = {} if constants is None else {folder / CONSTANTS_FILE: _text(Path(constants))}
    if vehicle is not None:
        vehicle = Path(vehicle)
        given[target] = _text(vehicle)
        for beside in named_by(vehicle):
            given[folder / beside.relative_to(vehicle.parent)] = _text(beside)
    elif not target.exists():
        given[target] = VEHICLE.format(title=quoted(title))
    given[file] = "\n".join(lines) + "\n"
    _check_units(like, title, units_of(parse_toml(given[file], file, CampaignError)), CODE)
    made = make_folder(folder, CampaignError)
    try:
        with locked(folder, CampaignError):
            if file.exists():
                raise CampaignError(
                    f"{file}: there is a campaign already; campaign add adds runs to it"
                )
            made += make_folder(folder / "runs", CampaignError)
            for path, text in given.items():
                if not path.exists():
                    made += [*make_folder(path.parent, CampaignError), path]
                    write_text(path, text, CampaignError)
                elif _text(path) != text:
                    raise CampaignError(f"{path}: is there already, and differs: delete one")
    except BaseException:
        remove(made)
        raise


def add_run(folder: str | Path, recording: Recording, run: NewRun) -> Path:
    """Write a recording into a campaign as a run.

    Parameters
    ----------
    folder
        The campaign's folder.
    recording
        Its samples, in the units of the campaign's channels.
    run
        What it is called, and how it was driven.

    Returns
    -------
    Path
        The file, in `folder`/runs.

    Raises
    ------
    CampaignError
        There is such a run already, a sample is missing or in codes, or the campaign would not be
        right any more; then everything is as before.
    """
    return add_runs(folder, [(recording, run)])[0]


def add_runs(folder: str | Path, runs: Sequence[tuple[Recording, NewRun]]) -> list[Path]:
    """Write recordings into `folder`/runs and their [[run]] into campaign.toml; return the files.

    campaign.toml and the new recordings are then read; if that fails everything is as before, and
    the CampaignError says why. campaign.toml is written last, and it decides: without its [[run]] a
    recording is not part of the campaign. Others who add runs at the same time wait. Raises
    CampaignError too for codes instead of m/s², and for a gap.
    """
    folder = Path(folder)
    toml, files = folder / "campaign.toml", []
    for _, run in runs:
        if not FILE_NAME.fullmatch(run.id):
            raise CampaignError(f"id = {run.id!r}: use letters, digits, '-', '_' and '.'")
    if not toml.exists():
        raise CampaignError(f"{toml}: no such file; begin with campaign new")
    units = listed(folder)
    for recording, run in runs:
        _check_samples(recording, run.source or run.id, units)
    runs = [(recording, _driven(recording, run, units)) for recording, run in runs]
    with locked(folder, CampaignError):
        text = before = _text(toml)
        made: list[Path] = []
        try:
            for recording, run in runs:
                file, added = folder / "runs" / f"{run.id}.csv", _run_lines(recording, run)
                if {run.id, f"runs/{run.id}.csv"} & _taken(text, toml):
                    raise CampaignError(f"{toml}: there is a run {run.id!r}: choose another --id")
                if not file.exists():
                    made += [*make_folder(file.parent, CampaignError), file]
                with replacing(file, CampaignError, within=folder) as draft:
                    _write_csv(draft, recording)
                    # A power cut may have ended an earlier attempt before it wrote campaign.toml.
                    if file.exists() and not filecmp.cmp(file, draft, shallow=False):
                        raise CampaignError(
                            f"{file}: there is another recording of this name: choose another --id"
                        )
                _check(folder, _excerpt(text, added), run)
                text = text.rstrip("\n") + "\n\n" + added
                files.append(file)
            write_text(toml, text, CampaignError)
        except BaseException:
            if _text(toml) == before:
                remove(made)
            raise
    return files


def _driven(recording: Recording, run: NewRun, units: Mapping[str, str]) -> NewRun:
    """A run with its speed, the mean of a channel of speed where none was said."""
    if run.speed_kmph is not None:
        return run
    told = [i for i, c in enumerate(recording.channels) if units.get(c.name) == SPEED_UNIT]
    mean = float(recording.values[:, told[0]].mean()) if told else 0.0
    if mean <= 0.0:
        raise CampaignError(f"run {run.id}: no channel tells its speed: say it (--speed-kmph)")
    return replace(run, speed_kmph=float(f"{3.6 * mean:.3g}"))


def listed(folder: str | Path) -> dict[str, str]:
    """The unit of every channel that the campaign in `folder` takes, by its name.

    Raises CampaignError as reading its channels does.
    """
    toml = Path(folder) / "campaign.toml"
    return units_of(parse_toml(_text(toml).split("[[run]]\n")[0], toml, CampaignError))


OWN_RUN = re.compile(r'id = "([\w.-]+)"\nfile = "([^"\\\n]+)"\nrole = "(fit|validate)"\n')
"""How a run begins that this module has written, behind [[run]]."""


def _taken(text: str, toml: Path) -> set[str]:
    """Ids and files of the runs in campaign.toml, which is parsed only if others have written in
    it."""
    own = [OWN_RUN.match(piece) for piece in text.split("[[run]]\n")[1:]]
    if all(own):
        return {found[k] for found in own if found for k in (1, 2)}
    runs = parse_toml(text, toml, CampaignError).values.get("run", [])
    return {str(item.get(key)) for item in runs if isinstance(item, dict) for key in ("id", "file")}


def _excerpt(before: str, added: str) -> str:
    """A campaign.toml that is right if the whole is: of many runs of our own writing the first one
    to be fitted stands for all, as those were checked when they were added."""
    head, *pieces = before.split("[[run]]\n")
    own = [OWN_RUN.match(piece) for piece in pieces]
    if all(own):
        fitted = (
            piece for piece, found in zip(pieces, own, strict=True) if found and found[3] == "fit"
        )
        before = "[[run]]\n".join([head, *islice(fitted, 1)])
    return before.rstrip("\n") + "\n\n" + added


def _check(folder: Path, text: str, run: NewRun) -> None:
    try:
        check_run(folder, text, run.id)
    except CampaignError as error:
        if 'has role = "fit"' in str(error):
            raise CampaignError(
                f"{folder / 'campaign.toml'}: the first run must be one to fit: --role fit "
                "(validate comes later)"
            ) from None
        raise


def _text(file: Path) -> str:
    return read_text(file, CampaignError)


def cut(recording: Recording, from_s: float | None, to_s: float | None) -> Recording:
    """The rows of a recording between two instants of its own time, seconds."""
    time_s = recording.time_s
    low = time_s[0] if from_s is None else from_s
    high = time_s[-1] if to_s is None else to_s
    rows = np.flatnonzero((time_s >= low - 1e-9) & (time_s <= high + 1e-9))
    if not len(rows):
        raise CampaignError(
            f"{low:g} … {high:g} s lies outside the recording, {time_s[0]:g} … {time_s[-1]:g} s"
        )
    return recording.after(
        f"cut to {low:g} … {high:g} s",
        values=recording.values[rows],
        start_s=float(time_s[rows[0]]),
    )


def _check_units(recording: Recording, name: str, units: Mapping[str, str], but: str = "") -> None:
    """Raise CampaignError for a channel in another unit than the campaign takes, or than `but`."""
    for channel in recording.channels:
        wanted = units.get(channel.name, ACCELERATION)
        if channel.unit not in (wanted, but or wanted):
            remedy = "say its unit in a mapping (wheelhop import --draft), or leave it out"
            if channel.unit == CODE:
                remedy = "give its constants with --calibration, or --nominal to do without"
            elif word := good_for(channel.name, channel.unit):
                remedy = f"it is good as {word}: campaign new --place says so; or leave it out"
            unit = f"is in {channel.unit}" if channel.unit else "does not say its unit"
            raise CampaignError(
                f"{name}: channel {channel.name} {unit}, a campaign takes {wanted}: {remedy}"
            )


def _check_samples(recording: Recording, name: str, units: Mapping[str, str]) -> None:
    _check_units(recording, name, units)
    missing = np.flatnonzero(recording.missing)
    if len(missing):
        raise CampaignError(
            f"{name}: {len(missing)} samples are missing, the first at "
            f"{recording.time_s[missing[0]]:.3f} s; cut the run before or after (--from, --to)"
        )


def _channel_lines(like: Recording, places: Mapping[str, Place]) -> list[str]:
    """[channels], unless the recording holds the eight points under their names and no more."""
    names = [channel.name for channel in like.channels]
    for name in places:
        if name not in names:
            raise CampaignError(f"{name}: no such channel; the recording has {', '.join(names)}")
    said = {c.name: places.get(c.name, c.point or c.name) for c in like.channels}
    if not places and set(names) == set(AXLE_POINTS + BODY_POINTS):
        return []
    placed = {n: place_of(place) if isinstance(place, str) else place for n, place in said.items()}
    for channel in like.channels:  # one that was resampled states its noise
        if rms := uncertain_between(like).get(channel.name):
            placed[channel.name] = with_noise(placed[channel.name], channel.unit, rms)
    known = (*AXLE_POINTS, *BODY_POINTS, "body")
    unknown = [n for n, place in placed.items() if isinstance(place, str) and place not in known]
    if unknown:
        raise CampaignError(_where(unknown, dict(zip(names, likely_points(names), strict=True))))
    return ["", "[channels]", *(f"{quoted(n)} = {_value(place)}" for n, place in placed.items())]


def _where(unknown: Sequence[str], likely: Mapping[str, str]) -> str:
    """The question where channels sit, with the answer as far as their names give it."""
    answers = [f"--place {shlex.quote(f'{name}={likely[name]}')}" for name in unknown]
    said = " as their names say," if all(likely[name] for name in unknown) else ""
    sit = "where does it sit?" if len(unknown) == 1 else "where do they sit?"
    return (
        f"{', '.join(unknown)}: {sit}{said} {' '.join(answers)} (A1…A4, B1…B4, body, or x,y;"
        " of other quantities travel:CORNER, force:CORNER, rate:pitch, rate:roll, speed)"
    )


def _run_lines(recording: Recording, run: NewRun) -> str:
    steps = [run.source] if run.source else []
    lines = [f"# {_printable(step)}" for step in (*steps, *recording.history)]
    lines += [
        "[[run]]",
        f'id = "{run.id}"',
        f'file = "runs/{run.id}.csv"',
        f"role = {quoted(run.role)}",
        f"speed_kmph = {run.speed_kmph!r}",
        *_course_line(run.course),
        *(f"track.{_key(key)} = {_value(value)}" for key, value in run.track.items()),
    ]
    return "\n".join(lines) + "\n"


def _course_line(course: Course | None) -> list[str]:
    if course is None:
        return []
    pairs = zip(course.x_m, course.speed_m_s, strict=True)
    along = ", ".join(f"[{x:.9g}, {3.6 * speed:.9g}]" for x, speed in pairs)
    return [f"speed_along = [{along}]"]


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else quoted(key)


def _value(value: float | Place) -> str:
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key} = {_value(item)}' for key, item in value.items())} }}"
    return quoted(value) if isinstance(value, str) else repr(value)


def _printable(text: str) -> str:
    return "".join(char if char.isprintable() else "?" for char in text)


def _write_csv(file: Path, recording: Recording) -> None:
    names = ["time_s", *(channel.name for channel in recording.channels)]
    time_s = np.arange(len(recording.values)) / recording.rate_hz
    table = np.column_stack([time_s, recording.values])
    form = ["%.6f"] + ["%.6g"] * (len(names) - 1)
    with file.open("w", encoding="utf-8", newline="\n") as out:
        np.savetxt(out, table, fmt=form, delimiter=",", header=",".join(names), comments="")
