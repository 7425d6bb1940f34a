"""`wheelhop demo`: from sensors through a logger to what the model of a vehicle is missing."""

from __future__ import annotations

from argparse import Namespace
from itertools import count
from pathlib import Path

from rich.console import Console
from rich.text import Text

from wheelhop.api import MODEL_FILE
from wheelhop.campaign import Campaign, CampaignError, read_campaign
from wheelhop.cli.demo_field import (
    DRIVEN,
    TURNED,
    calibrate,
    find_firmware,
    make_campaign,
    record,
)
from wheelhop.cli.output import open_console
from wheelhop.cli.progress import stages
from wheelhop.cli.show import print_ladder, print_parameters, print_ranking, print_verdict
from wheelhop.compare import describe
from wheelhop.diagnose import Step, climb, fit_baseline
from wheelhop.diagnose.search.look import step_of
from wheelhop.effects import load_effects
from wheelhop.files import make_folder
from wheelhop.files.words import percent
from wheelhop.hil_sim.day import read_day
from wheelhop.report.model_file import write_model
from wheelhop.report.reports import write_diagnosis_report
from wheelhop.vehicle import Vehicle, read_nominal

REPORT_FILE = "report.html"
FOLDER = "wheelhop-demo"


def run(arguments: Namespace) -> int:
    """Run the demo in the folder the user chose, and open it on the workbench if he wants."""
    folder = arguments.folder or free_folder()
    status = run_demo(folder)
    if arguments.workbench and status == 0:
        from wheelhop.workbench.server import serve

        serve(folder)
    return status


def run_demo(folder: Path) -> int:
    """Record a day in the field; compare, diagnose, and add what the diagnosis found."""
    console = open_console()
    begin(folder)
    record_day(folder, console)
    campaign = read_campaign(folder)
    vehicle = read_nominal(campaign)
    library = load_effects()
    _tell_what_it_is(campaign, vehicle, folder, console)

    _tell_command(f"compare {folder}", "where does the model fail?", console)
    with stages() as progress:
        base = fit_baseline(campaign, vehicle, progress=progress)
        first = step_of(base.workshop, base.rung)
    _tell_failure(first, console)

    _tell_command(f"diagnose {folder}", "which physics is missing?", console)
    with stages() as progress:
        diagnosis = climb(base, library, max_effects=4, progress=progress)
    print_verdict(diagnosis, console, explain=False)
    print_ranking(diagnosis.ranking, console, rows=5)

    last = diagnosis.ladder[-1]
    if last.added:
        _tell_command(f"add {folder} {' '.join(last.added)}", "does that explain it?", console)
        print_ladder(diagnosis.ladder, console)
        print_parameters(last, console)
        write_model(folder / MODEL_FILE, campaign, vehicle, diagnosis.ladder)
        console.print(f"\nThe model is in {folder / MODEL_FILE}.", markup=False)
    write_diagnosis_report(folder / REPORT_FILE, campaign, diagnosis, library)
    console.print(f"The report is {folder / REPORT_FILE}: open it in a browser.", markup=False)
    return 0


def free_folder() -> Path:
    """./wheelhop-demo, or with a number behind it where earlier demos are."""
    folder = Path(FOLDER)
    for number in count(2):
        if not folder.exists():
            break
        folder = Path(f"{FOLDER}-{number}")
    return folder


def begin(folder: Path) -> None:
    """Make the folder; nothing that is in one is ever deleted. Raises CampaignError."""
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise CampaignError(f"{folder}: is there already, and not empty: choose another name")
    make_folder(folder)


def record_day(folder: Path, console: Console) -> None:
    """A vehicle's sensors, recorded by a logger, calibrated, and cut into runs of a campaign."""
    day = read_day()
    with stages() as progress:
        progress("looking for the firmware's tools")
        elf = find_firmware()
    which = "its double in Python (the firmware takes the source tree, gcc-avr and simavr)"
    if elf is not None:
        which = "the real firmware on a simulated board"
    console.print(
        Text(
            "Eight accelerometers on a vehicle, their voltages made by a simulator that knows"
            f" nothing of wheelhop. The logger is {which}."
        )
    )
    for name, signals, question in (
        (TURNED, day.turning, "the sensors at rest, turned over and back"),
        (DRIVEN, day.driving, f"{len(day.drives)} drives"),
    ):
        _tell_command(f"logger start … stop; wheelhop download --out {folder}", question, console)
        with stages() as progress:
            progress(f"recording {name}")
            done = record(signals, folder, name, elf)
        console.print(Text(f"{done.file}: {done.due} scans of 8 channels due, {done.lost} lost"))
    _tell_command(f"calibrate --flip {folder / TURNED}", "what is a code worth?", console)
    constants = calibrate(folder)
    gains = [sensor.gain for sensor in constants.sensors]
    console.print(
        Text(
            f"{min(g.value for g in gains):.3f} … {max(g.value for g in gains):.3f} m/s² per code,"
            f" each ± {max(g.relative for g in gains):.1%} (k = 2)"
        )
    )
    _tell_command(f"campaign stretches {folder / DRIVEN}", "when was it driven?", console)
    spans = make_campaign(folder, day)
    console.print(Text(", ".join(f"{first:.0f} … {last:.0f} s" for first, last in spans)))
    _tell_command(f"campaign new …; wheelhop campaign add {folder} … --stretch 1", "…", console)


def _tell_what_it_is(campaign: Campaign, vehicle: Vehicle, folder: Path, console: Console) -> None:
    tracks = list(dict.fromkeys(run.track.kind for run in campaign.runs))
    text = (
        f"{folder} is a campaign: {len(campaign.runs)} runs of one vehicle, {vehicle.name}, over"
        f" {', '.join(tracks)}; {len(campaign.channels)} accelerometers on axles and body. The"
        f" model knows masses, springs, dampers and tyres, all linear. {len(campaign.fit_runs)}"
        f" runs may be fitted, {len(campaign.validate_runs)} only judge."
    )
    console.print(Text(text))


def _tell_command(words: str, question: str, console: Console) -> None:
    console.print()
    console.print(Text.assemble(("$ wheelhop " + words, "bold cyan"), ("   # " + question, "dim")))


def _tell_failure(step: Step, console: Console) -> None:
    error, floor = step.rung.error, step.floor
    console.print(
        Text(
            f"Fitted as well as it can be, it misses the held-out runs by {percent(error)};"
            f" the sensors alone would leave {percent(floor)}."
        )
    )
    for sentence in describe(step.comparison.breakdown):
        console.print(Text(sentence))
    cells = [f"{part.name} {part.ratio:.1f}" for part in step.comparison.breakdown.channel]
    console.print(Text(f"Residual / noise floor by channel: {', '.join(cells)}"))
