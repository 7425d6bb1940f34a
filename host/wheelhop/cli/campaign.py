"""`wheelhop campaign`: make a campaign of recordings: `stretches`, `new`, `add`."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence

from rich import box
from rich.table import Table

from wheelhop.campaign import CampaignError
from wheelhop.campaign.activity import Stretch, stretches
from wheelhop.campaign.recorded import accelerations, read_recording
from wheelhop.campaign.tracks import is_steady
from wheelhop.campaign.write import NewRun, add_run, cut, listed, new_campaign
from wheelhop.cli.output import open_console
from wheelhop.logger.recording import Recording


def run(arguments: Namespace) -> int:
    """Do what `arguments.action` says; raises CampaignError and what reading a recording raises."""
    recording = read_recording(arguments.recording, arguments.calibration, arguments.nominal)
    recording, left_out = accelerations(recording, _asked(arguments))
    if left_out:
        print(f"left out, no accelerations: {', '.join(left_out)}")
    action = {"stretches": _stretches, "new": _new, "add": _add}[arguments.action]
    return action(arguments, recording)


def _asked(arguments: Namespace) -> list[str]:
    """The channels that are placed, or that the campaign takes, whatever they measure."""
    if arguments.action == "new":
        return [word.partition("=")[0] for word in arguments.place]
    there = arguments.action == "add" and (arguments.folder / "campaign.toml").exists()
    return [*listed(arguments.folder)] if there else []


def _stretches(arguments: Namespace, recording: Recording) -> int:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    unit = recording.channels[0].unit
    steady = ("steady from, s", "to, s", "seconds", f"rms, {unit}")
    marks = [float(at_s) for at_s in recording.notes.get("marks_s", "").split()]
    headings = ("stretch", "from, s", "to, s", *steady, *(("marks",) if marks else ()))
    for heading in headings:
        table.add_column(heading, justify="right")
    found = stretches(recording)
    for number, piece in enumerate(found, start=1):
        whole, steadily = _seconds(recording, piece, True), _seconds(recording, piece, False)
        table.add_row(
            str(number),
            *(f"{end:.2f}" for end in (*whole, *steadily)),
            f"{steadily[1] - steadily[0]:.1f}",
            f"{piece.rms:.3g}",
            *((_marks_in(marks, *whole),) if marks else ()),
        )
    console = open_console()
    console.print(table)
    if not found:
        console.print("no stretch of 5 s or more without a gap")
    if marks:
        told = ", ".join(f"{number} at {at_s:.1f} s" for number, at_s in enumerate(marks, start=1))
        console.print(f"marks: {told}")
    return 0


def _marks_in(marks: Sequence[float], first_s: float, last_s: float) -> str:
    """The numbers of the marks that were made in a stretch."""
    inside = [str(k) for k, at_s in enumerate(marks, start=1) if first_s <= at_s <= last_s]
    return ", ".join(inside)


def _seconds(recording: Recording, piece: Stretch, whole: bool) -> tuple[float, float]:
    """From when to when a stretch, or its steady part, lasts."""
    steady = (piece.steady_first, piece.steady_last)
    first, last = (piece.first, piece.last) if whole else steady
    time_s = recording.time_s
    return float(time_s[first]), float(time_s[last - 1])


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
    recording, taken = _taken(arguments, recording)
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
    print(
        f"{file}: {seconds:.1f} s{taken}, {len(recording.channels)} channels;"
        f" run {arguments.id} added"
    )
    return 0


def _taken(arguments: Namespace, recording: Recording) -> tuple[Recording, str]:
    """What of a recording becomes the run, and words on it."""
    span = (arguments.from_s, arguments.to_s)
    if arguments.stretch is None:
        if arguments.whole:
            raise CampaignError("--whole is about --stretch: say which")
        return (recording if span == (None, None) else cut(recording, *span)), ""
    if span != (None, None):
        raise CampaignError("--stretch says from where to where: leave out --from and --to")
    found = stretches(recording)
    if not 1 <= arguments.stretch <= len(found):
        raise CampaignError(
            f"{arguments.recording}: there are {len(found)} stretches, none is number "
            f"{arguments.stretch}; see wheelhop campaign stretches"
        )
    piece = found[arguments.stretch - 1]
    whole = arguments.whole or not is_steady(arguments.track[0])
    first, last = _seconds(recording, piece, whole)
    part = "all" if whole else "the steady part"
    words = f", {part} of stretch {arguments.stretch}, {first:.2f} … {last:.2f} s"
    return cut(recording, first, last), words


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
    """`dash=0.35,0.0`, `imu=body` or `pot=travel:1:0.65`."""
    name, equals, place = word.partition("=")
    if not equals:
        raise CampaignError(f"--place: '{word}' is not CHANNEL=PLACE, such as imu=body")
    if "," not in place:
        return name, place
    try:
        return name, [float(part) for part in place.split(",")]
    except ValueError:
        raise CampaignError(f"--place: '{place}' is not x,y in metres, such as 0.35,0.0") from None
