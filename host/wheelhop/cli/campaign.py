"""`wheelhop campaign`: make a campaign of recordings: `stretches`, `new`, `add`."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence

from rich import box
from rich.table import Table

from wheelhop.campaign import CampaignError
from wheelhop.campaign.activity import stretches
from wheelhop.campaign.recorded import read_recording
from wheelhop.campaign.write import NewRun, add_run, cut, new_campaign
from wheelhop.cli.output import open_console
from wheelhop.logger.recording import Recording


def run(arguments: Namespace) -> int:
    """Do what `arguments.action` says; raises CampaignError and what reading a recording raises."""
    recording = read_recording(arguments.recording, arguments.calibration, arguments.nominal)
    action = {"stretches": _stretches, "new": _new, "add": _add}[arguments.action]
    return action(arguments, recording)


def _stretches(arguments: Namespace, recording: Recording) -> int:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("stretch", "from, s", "to, s", "seconds", f"rms, {recording.channels[0].unit}"):
        table.add_column(heading, justify="right")
    found = stretches(recording)
    time_s = recording.time_s
    for number, piece in enumerate(found, start=1):
        first, last = time_s[piece.first], time_s[piece.last - 1]
        table.add_row(
            str(number), f"{first:.2f}", f"{last:.2f}", f"{last - first:.1f}", f"{piece.rms:.3g}"
        )
    console = open_console()
    console.print(table)
    if not found:
        console.print("no stretch of 5 s or more without a gap")
    return 0


def _new(arguments: Namespace, recording: Recording) -> int:
    title = arguments.title or arguments.folder.resolve().name
    is_own = arguments.vehicle is not None or (arguments.folder / "vehicle.toml").exists()
    places = dict(_place(word) for word in arguments.place)
    constants = arguments.calibration  # tells the diagnosis how well each scale is known
    new_campaign(arguments.folder, title, recording, places, arguments.vehicle, constants)
    print(f"{arguments.folder}: campaign.toml and vehicle.toml are there.")
    if not is_own:
        print("vehicle.toml holds the numbers of a student-built ATV: replace them by yours.")
    print(
        f"Next: wheelhop campaign add {arguments.folder} RECORDING --id … --track … --speed-kmph …"
    )
    return 0


def _add(arguments: Namespace, recording: Recording) -> int:
    span = (arguments.from_s, arguments.to_s)
    if arguments.stretch is not None:
        if span != (None, None):
            raise CampaignError("--stretch says from where to where: leave out --from and --to")
        found = stretches(recording)
        if not 1 <= arguments.stretch <= len(found):
            raise CampaignError(
                f"{arguments.recording}: there are {len(found)} stretches, none is number "
                f"{arguments.stretch}; see wheelhop campaign stretches"
            )
        piece = found[arguments.stretch - 1]
        span = (recording.time_s[piece.first], recording.time_s[piece.last - 1])
    if span != (None, None):
        recording = cut(recording, *span)
    file = add_run(
        arguments.folder,
        recording,
        NewRun(
            id=arguments.id,
            role=arguments.role,
            speed_kmph=arguments.speed_kmph,
            track=_track(arguments.track),
            source=f"from {arguments.recording.name}",
        ),
    )
    seconds = len(recording.values) / recording.rate_hz
    print(f"{file}: {seconds:.1f} s, {len(recording.channels)} channels; run {arguments.id} added")
    return 0


def _track(words: Sequence[str]) -> dict[str, str | float]:
    """`washboard amplitude_mm=15 pitch_mm=400` as the keys of campaign.toml."""
    track: dict[str, str | float] = {"kind": words[0]}
    for word in words[1:]:
        key, equals, value = word.partition("=")
        if not equals:
            raise CampaignError(f"--track: '{word}' is not KEY=VALUE, such as amplitude_mm=15")
        track[key.removeprefix("track.")] = _value(value)
    return track


def _value(text: str) -> str | float:
    try:
        return int(text) if text.lstrip("+-").isdecimal() else float(text)
    except ValueError:
        return text


def _place(word: str) -> tuple[str, str | list[float]]:
    """`dash=0.35,0.0` or `imu=body`."""
    name, equals, place = word.partition("=")
    if not equals:
        raise CampaignError(f"--place: '{word}' is not CHANNEL=PLACE, such as imu=body")
    if "," not in place:
        return name, place
    try:
        return name, [float(part) for part in place.split(",")]
    except ValueError:
        raise CampaignError(f"--place: '{place}' is not x,y in metres, such as 0.35,0.0") from None
