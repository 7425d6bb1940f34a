"""`read_campaign`: from the folder on disk to a `Campaign`, or one line that says what is wrong."""

from collections.abc import Callable, Container, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign.channels import NOISE_KEYS, POINTS, QUANTITIES, read_channels
from wheelhop.campaign.common import (
    Entry,
    band,
    check_entries,
    check_resolved,
    column,
    entry,
    frozen,
)
from wheelhop.campaign.component import read_component
from wheelhop.campaign.course import Course
from wheelhop.campaign.driven import Driven
from wheelhop.campaign.duplicates import refuse_leaks
from wheelhop.campaign.factors import read_factors, scaled
from wheelhop.campaign.low_pass import read_low_pass
from wheelhop.campaign.paths import file_inside
from wheelhop.campaign.recordings import check_time, read_columns
from wheelhop.campaign.tracks import read_track
from wheelhop.campaign.types import (
    Campaign,
    CampaignError,
    Channel,
    Run,
    TrackSpec,
)
from wheelhop.files import Table, did_you_mean, parse_toml, read_toml

T = TypeVar("T")
Progress = Callable[[str], None]
Unread = Callable[[Sequence[Entry]], Container[str]]

RUN_KEYS = ("id", "file", "role", "speed_kmph", "track")
TOP_KEYS = (
    *("format", "kind", "title", "vehicle", "sample_rate_hz", "band_hz", "averaging_ms"),
    *(*NOISE_KEYS, "filter", "channels", "factors", "run"),
)
START_KEYS = ("start_m", "start_m_uncertainty")
CONSTANTS_FILE = "calibration.toml"
LONGEST_AVERAGING = 3.0  # sample periods
ROUNDED = 1e-3
"""A window of three periods, written with a few digits, may be longer by this share."""
TOLD = 100  # runs between two words of progress
MOST_SHOWN = 20  # keys that are missing
NOT_RECORDED = "if it was not recorded, list under [channels] in campaign.toml those that were"


def read_campaign(
    folder: str | Path,
    skip: Container[str] = (),
    progress: Progress = lambda text: None,
    unread: Unread = lambda entries: (),
) -> Campaign:
    """Read the campaign in `folder` strictly: nothing is guessed, no mistake is passed over.

    Without [channels] the recordings hold the eight points and nothing else. With [channels] they
    hold at least those; further columns are left alone, so that is how a user leaves one out.
    Either way `channels` follow the column order of the first run's recording.

    Runs whose ids are in `skip` are left out, and their recordings not read; `progress` is told how
    far reading is, every hundred runs. `unread` is asked once, of all runs of a vehicle, for the
    ids of those that are to be listed without their samples: `time_s` and `record` have no rows.

    Raises `CampaignError`, one line naming file, key or row, and remedy, for every mistake in
    campaign.toml and the recordings; the same samples to fit and to judge are one of them.
    vehicle.toml must exist; `read_vehicle` reads it.
    """
    folder = Path(folder)
    if not folder.is_dir():
        what = "give the folder that holds campaign.toml" if folder.is_file() else "no such folder"
        raise CampaignError(f"{folder}: {what}")
    top = read_toml(folder / "campaign.toml", CampaignError)
    campaign = _read(top, folder, lambda id_: id_ not in skip, progress, unread)
    refuse_leaks(campaign)
    return campaign


def check_run(folder: Path, text: str, id_: str) -> None:
    """Raise the `CampaignError` of `read_campaign` if `text` were campaign.toml in `folder`, as far
    as that text and the recording of one run are at fault; the others are not read."""
    top = parse_toml(text, folder / "campaign.toml", CampaignError)
    _read(top, folder, lambda other: other == id_, lambda text: None, lambda entries: ())


def _read(
    top: Table, folder: Path, wanted: Callable[[str], bool], progress: Progress, unread: Unread
) -> Campaign:
    top.format()
    if top.text("kind", "vehicle", choices=("vehicle", "component")) == "component":
        return read_component(top, folder)
    top.only(TOP_KEYS)
    _refuse_gaps(top)
    rate = top.number("sample_rate_hz", above=0.0)
    said = read_channels(top)
    empty = Campaign(
        folder=folder,
        title=top.text("title"),
        vehicle_file=file_inside(folder, top, "vehicle", "vehicle.toml"),
        sample_rate_hz=rate,
        band_hz=band(top, rate),
        averaging_s=_averaging(top, rate),
        noise_rms=said.noise_rms,
        channels=said.compared,
        known=said.known,
        runs=(),
        low_pass=read_low_pass(top.table("filter")) if "filter" in top else None,
        factors=read_factors(top),
    )
    listed = top.tables("run", "id")
    drives = [_drive(run, folder) for run in _counted(listed, "run", progress)]
    check_entries(top, drives)
    drives = [drive for drive in drives if wanted(drive.id)]
    waiting = unread(drives)
    read = _with_recordings(empty, [d for d in drives if d.id not in waiting], progress)
    if len(read.runs) == len(drives):
        return read
    none = frozen(np.zeros((0, len(read.channels))))
    runs = {d.id: Run(**vars(d), time_s=none[:, 0], record=none) for d in drives}
    runs |= {run.id: run for run in read.runs}
    return replace(read, runs=tuple(runs.values()))


def _refuse_gaps(top: Table) -> None:
    """Raise for all keys that are missing, of all runs, if there are several."""
    missing = top.needs(("title", "sample_rate_hz", "band_hz", "run"))
    if "run" in top:
        for run in top.tables("run", "id"):
            missing += run.needs(RUN_KEYS)
    if len(missing) > 1:
        shown = "; ".join(missing[:MOST_SHOWN])
        more = f" and {len(missing) - MOST_SHOWN} more" if len(missing) > MOST_SHOWN else ""
        raise top.error(f"{len(missing)} keys are missing: {shown}{more}")


@dataclass(frozen=True)
class _Drive(Entry):
    """A drive before its recording is read."""

    speed_m_s: float
    course: Course | None
    start_m: tuple[float, float] | None
    track: TrackSpec
    setting: str


def _averaging(top: Table, rate_hz: float) -> float:
    milliseconds = top.number("averaging_ms", 0.0, at_least=0.0)
    longest = LONGEST_AVERAGING * 1e3 / rate_hz
    if milliseconds > longest * (1.0 + ROUNDED):
        raise top.error(
            f"averaging_ms = {milliseconds:g} is more than {LONGEST_AVERAGING:g} sample periods "
            f"({longest:g} ms): give the window of one sample in milliseconds"
        )
    return min(milliseconds, longest) * 1e-3


def _drive(run: Table, folder: Path) -> _Drive:
    run.only((*RUN_KEYS, "speed_along", *START_KEYS, "setting"))
    return _Drive(
        **vars(entry(run, folder)),
        speed_m_s=run.number("speed_kmph", at_least=0.0) / 3.6,
        track=read_track(run, folder),
        course=_course(run),
        start_m=_start(run),
        setting=run.text("setting", ""),
    )


def _start(run: Table) -> tuple[float, float] | None:
    """Where the run began, and how well that is known, m."""
    if not any(key in run for key in START_KEYS):
        return None
    at, uncertainty = START_KEYS
    return run.number(at), run.number(uncertainty, above=0.0)


def _course(run: Table) -> Course | None:
    """The speed along the track, if it changes: pairs of place, m, and speed, km/h."""
    if "speed_along" not in run:
        return None
    pairs = run.values["speed_along"]
    listed = isinstance(pairs, list) and all(isinstance(pair, list) for pair in pairs)
    numbers = listed and all(type(n) in (int, float) for pair in pairs for n in pair)
    try:
        return Course.of(pairs if numbers else ())
    except ValueError as error:
        raise run.error(f"speed_along {error}: [[0, 5.0], [20, 12.0]]") from None


def _counted(items: Sequence[T], what: str, progress: Progress) -> Iterator[T]:
    """The items one by one; `progress` hears of every `TOLD`th."""
    for i, item in enumerate(items):
        if i % TOLD == 0 and len(items) > TOLD:
            progress(f"reading {what} {i} of {len(items)}")
        yield item


def _with_recordings(campaign: Campaign, drives: list[_Drive], progress: Progress) -> Campaign:
    channels, known = campaign.channels, campaign.known
    runs: list[Run] = []
    beside = campaign.folder / CONSTANTS_FILE
    constants = beside if beside.is_file() else None
    for drive in _counted(drives, "recording", progress):
        listed = campaign.channels or tuple(Channel(point, point) for point in POINTS)
        units = {channel.name: channel.unit for channel in (*listed, *known)}
        columns, values = read_columns(drive.file, constants, units)
        values = scaled(drive.file, columns, values, campaign.factors)
        if not campaign.channels:
            _check_only_points(drive.file, columns)
        if not runs:
            channels = _in_order_of(drive.file, columns, listed)
        wanted = [column(drive.file, columns, name, NOT_RECORDED) for name in ("time_s", *units)]
        place = dict(zip(("time_s", *units), wanted, strict=True))
        time_s = frozen(values[:, place["time_s"]])
        check_time(drive.file, time_s, campaign.sample_rate_hz)
        check_resolved(drive.file, len(time_s), campaign.sample_rate_hz, campaign.band_hz)
        record = frozen(values[:, [place[channel.name] for channel in channels]])
        if not np.ptp(record, axis=0).any():
            raise CampaignError(
                f"{drive.file}: no channel ever changes: there is nothing to compare; "
                "leave the run out"
            )
        beside_it = {channel.name: frozen(values[:, place[channel.name]]) for channel in known}
        for channel in (*channels, *known):
            _check_size(drive.file, channel, values[:, place[channel.name]])
        run = Run(**vars(drive), time_s=time_s, record=record, known=beside_it)
        runs.append(_as_driven(run, known))
    if constants is not None:
        channels = _with_uncertainty(channels, constants)
    return replace(campaign, channels=channels, runs=tuple(runs))


def _as_driven(run: Run, known: Sequence[Channel]) -> Run:
    """The run at the speed that the first channel of the vehicle's speed shows, if there is one and
    the run drives over something known."""
    channel = next((c for c in known if (c.quantity, c.unit) == ("speed", "m/s")), None)
    if channel is None or run.track.kind == "unknown" or run.speed_m_s == 0.0:
        return run
    if run.course is not None:
        raise CampaignError(
            f'{run.file}: speed_along of run "{run.id}" and channel {channel.name} both say how'
            " fast it was: delete one of them"
        )
    speed = run.known[channel.name]
    known_to = channel.scale_uncertainty, channel.noise_rms or 0.0
    driven = Driven(channel.name, run.time_s, speed, run.speed_m_s, *known_to)
    if driven.mean_m_s <= 0.0 or speed.min() < 0.0:
        raise CampaignError(
            f"{run.file}: channel {channel.name} shows speeds of {speed.min():g} to"
            f" {speed.max():g} m/s: leave it out under [channels], or correct it"
        )
    return replace(run, speed_m_s=driven.mean_m_s, driven=driven)


def _check_size(file: Path, channel: Channel, values: NDArray[np.float64]) -> None:
    """Raise for a sample that no sensor of its quantity shows."""
    quantity, largest = QUANTITIES[channel.quantity], float(np.abs(values).max())
    most = quantity.largest if channel.unit == quantity.unit else np.inf
    if largest > most:
        sensor = "accelerometer" if channel.is_acceleration else f"sensor of {channel.quantity}"
        remedy = "leave the run out"
        if quantity.hint:
            remedy = f"{quantity.hint} Convert {channel.name} to {channel.unit}, or {remedy}"
        raise CampaignError(
            f"{file}: a sample of {largest:g} {channel.unit}: no {sensor} measures more than "
            f"{most:g}; {remedy}"
        )


def _with_uncertainty(channels: tuple[Channel, ...], file: Path) -> tuple[Channel, ...]:
    from wheelhop.calibration import read_constants  # a campaign without constants does without
    from wheelhop.campaign.recorded import with_uncertainty

    constants = read_constants(file)
    return tuple(with_uncertainty(channel, constants) for channel in channels)


def _in_order_of(
    file: Path, columns: list[str], channels: tuple[Channel, ...]
) -> tuple[Channel, ...]:
    return tuple(sorted(channels, key=lambda item: column(file, columns, item.name, NOT_RECORDED)))


def _check_only_points(file: Path, columns: list[str]) -> None:
    for name in columns:
        if name not in ("time_s", *POINTS):
            missing = [point for point in POINTS if point not in columns]
            raise CampaignError(
                f"{file}: unexpected column {name}{did_you_mean(name, missing)}; the channels "
                "default to A1..A4 and B1..B4; say under [channels] in campaign.toml where others "
                "sit"
            )
