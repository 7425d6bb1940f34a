"""`wheelhop simulate`: a vehicle on its way over tracks, as a campaign or a recording."""

from __future__ import annotations

from argparse import Namespace
from math import isfinite
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from wheelhop.campaign import CampaignError
from wheelhop.cli.output import open_console
from wheelhop.cli.progress import stages
from wheelhop.effects import load_effects
from wheelhop.effects.own_file import read_source
from wheelhop.files.words import titles
from wheelhop.formats import FORMATS
from wheelhop.predict import (
    Case,
    Instrument,
    make_campaign,
    make_recording,
    read_drives,
    read_effects,
    read_speeds,
)
from wheelhop.predict.case import SECONDS
from wheelhop.predict.cluster import cluster
from wheelhop.predict.instrument import NOISE_RMS_M_S2
from wheelhop.predict.journal import run_sweep
from wheelhop.predict.ride import Ride, ride
from wheelhop.predict.sweep import Axis, Sweep
from wheelhop.predict.workers import workers
from wheelhop.vehicle import read_vehicle

SHORTEST_S, LONGEST_S = 2.0, 600.0
HEADINGS = (
    *("Wk rms\nm/s²", "< 50 Hz\nm/s²", "VDV\nm/s^1.75", "front travel\nrms/peak, mm"),
    *("rear travel\nrms/peak, mm", "tyre load\nrms/static f/r", "least load\n/ static"),
)
FOOTNOTE = (
    "Wk, VDV: vertical, where the driver sits (ISO 2631-1). A logger of 100 Hz sees what lies below"
    " 50 Hz."
)
LIFTED = "Below 0 a tyre would have to pull: --with tyre-lift-off lets the wheel leave the ground."


def run(arguments: Namespace) -> int:
    """Simulate, write what was asked for, and print it; raises CampaignError."""
    if arguments.sweep:
        return _sweep(arguments)
    if arguments.cluster is not None:
        raise CampaignError("--cluster: only a sweep is computed on a cluster: give --sweep")
    case, *others = [
        _case(arguments, vehicle) for vehicle in (arguments.vehicle, *arguments.against)
    ]
    noise = NOISE_RMS_M_S2 if arguments.noise is None else arguments.noise
    if not 0.0 <= noise < 100.0:
        raise CampaignError(f"--noise {noise:g}: must be from 0 to 100 m/s²")
    instrument = Instrument(noise, arguments.logger)
    console, out = open_console(), arguments.out
    if out is not None:
        with stages() as progress:
            if out.suffix.lower() in FORMATS:
                make_recording(out, case, instrument)
            else:
                make_campaign(out, case, arguments.vehicle, instrument, progress)
        console.print(f"{out}: {_runs(case)} of {case.seconds:g} s", markup=False)
        if out.is_dir():
            console.print(f"Next: wheelhop compare {out}", markup=False)
    names = titles(
        [one.vehicle.name for one in (case, *others)], [arguments.vehicle, *arguments.against]
    )
    found = {}
    for name, one in zip(names, (case, *others), strict=True):
        if others:
            console.print(name, style="bold", markup=False)
        found[name] = print_rides(one, console)
    console.print(FOOTNOTE, markup=False)
    if min(ride.tyre_load_least for rides in found.values() for ride in rides) < -1e-6:
        console.print(LIFTED, markup=False)
    if arguments.figure is not None:
        from wheelhop.report.ride import write_rides_figure

        write_rides_figure([drive.id for drive in case.drives], found, arguments.figure)
        console.print(f"figure: {arguments.figure}", markup=False)
    return 0


def print_rides(case: Case, console: Console) -> list[Ride]:
    """What each run does to vehicle and driver."""
    with stages() as progress:
        rides = []
        for number, drive in enumerate(case.drives):
            progress(f"riding {drive.id}")
            rides.append(ride(case, number))
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("run", overflow="fold")
    for heading in HEADINGS:
        table.add_column(heading, justify="right")
    for drive, found in zip(case.drives, rides, strict=True):
        table.add_row(Text(drive.id), *_cells(found))
    console.print(table)
    return rides


def _cells(found: Ride) -> tuple[str, ...]:
    cells = (
        f"{found.comfort_wk_rms_m_s2:.2f}",
        f"{found.comfort_wk_rms_below_50_hz_m_s2:.2f}",
        f"{found.comfort_vdv_m_s1_75:.1f}",
        f"{found.travel_front_rms_m * 1e3:.1f}/{found.travel_front_peak_m * 1e3:.0f}",
        f"{found.travel_rear_rms_m * 1e3:.1f}/{found.travel_rear_peak_m * 1e3:.0f}",
        f"{found.dynamic_load_front:.2f}/{found.dynamic_load_rear:.2f}",
        f"{round(found.tyre_load_least, 2) + 0.0:.2f}",  # no minus zero
    )
    return tuple(cell.replace("nan/nan", "").replace("/nan", "") for cell in cells)


def _sweep(arguments: Namespace) -> int:
    """Fill a table; the same command goes on with one that was interrupted."""
    for option in ("noise", "logger"):
        if getattr(arguments, option):
            raise CampaignError(f"--{option}: a sweep has no sensors; leave it out")
    for option in ("against", "figure"):
        if getattr(arguments, option):
            raise CampaignError(f"--{option}: a sweep makes a table alone; leave it out")
    if arguments.out is None or arguments.out.suffix.lower() != ".parquet":
        raise CampaignError("--sweep: say where to with --out TABLE.parquet")
    if arguments.jobs is not None and arguments.cluster is not None:
        raise CampaignError("--jobs: a cluster has its own workers; leave one of the two out")
    if arguments.jobs is not None and arguments.jobs < 1:
        raise CampaignError(f"--jobs {arguments.jobs}: must be 1 or more")
    sweep = Sweep(
        read_vehicle(arguments.vehicle),
        tuple(arguments.tracks),
        read_speeds(arguments.speed),
        tuple(arguments.effects),
        tuple(Axis.parse(text) for text in arguments.sweep),
        _seconds(arguments),
        arguments.seed,
        None if arguments.library is None else read_source(arguments.library),
    )
    sweep.check()
    at = arguments.cluster
    with (
        stages() as progress,
        workers(arguments.jobs) if at is None else cluster(at, progress) as executor,
    ):
        computed, rows = run_sweep(sweep, arguments.out, executor, progress)
    console = open_console()
    known = len(sweep) - computed
    earlier = f", {known} of them earlier" if known else ""
    console.print(
        f"{arguments.out}: {len(rows)} runs at {len(sweep)} points{earlier}", markup=False
    )
    problems = [str(row["problem"]) for row in rows if row["problem"]]
    if problems:
        console.print(
            f"{len(problems)} runs have no result, the first: {problems[0]}", markup=False
        )
    return 0


def _seconds(arguments: Namespace) -> float:
    seconds: float = SECONDS if arguments.seconds is None else arguments.seconds
    if not (isfinite(seconds) and SHORTEST_S <= seconds <= LONGEST_S):
        raise CampaignError(f"--seconds {seconds:g}: must be from {SHORTEST_S:g} to {LONGEST_S:g}")
    if arguments.seed < 0:
        raise CampaignError(f"--seed {arguments.seed}: must be a whole number from 0 up")
    return seconds


def _case(arguments: Namespace, file: Path) -> Case:
    """What is asked for, checked."""
    seconds = _seconds(arguments)
    vehicle = read_vehicle(file)
    effects = read_effects(arguments.effects, load_effects(arguments.library))
    drives = read_drives(arguments.tracks, read_speeds(arguments.speed))
    return Case(vehicle, effects, drives, seconds, arguments.seed)


def _runs(case: Case) -> str:
    count = len(case.drives)
    return f"{count} run{'s' if count > 1 else ''}"
