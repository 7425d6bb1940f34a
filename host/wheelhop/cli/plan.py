"""`wheelhop plan`: which runs to drive."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from math import isfinite

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from wheelhop.api.planning import RUNS, plan
from wheelhop.campaign import CampaignError
from wheelhop.cli.output import open_console, write_json
from wheelhop.cli.progress import stages
from wheelhop.files.words import listed, significant
from wheelhop.predict import Case
from wheelhop.predict.case import SECONDS
from wheelhop.predict.instrument import NOISE_RMS_M_S2
from wheelhop.predict.plan import Plan
from wheelhop.predict.plan_files import to_json, write_skeleton
from wheelhop.predict.ride import ride
from wheelhop.vehicle import read_vehicle

HARDLY = 0.3
"""A number whose uncertainty stays above this share of what is believed is named."""


def run(arguments: Namespace) -> int:
    """Choose, print, and write what was asked for; raises CampaignError."""
    seconds: float = SECONDS if arguments.seconds is None else arguments.seconds
    noise = NOISE_RMS_M_S2 if arguments.noise is None else arguments.noise
    if arguments.out is not None and arguments.out.exists():
        raise CampaignError(f"{arguments.out}: is there already: choose another folder")
    with stages() as progress:
        found = plan(
            arguments.vehicle,
            arguments.tracks,
            arguments.speeds,
            runs=_runs(arguments, seconds),
            only=arguments.only,
            effects=arguments.library,
            noise_rms=noise,
            seconds=seconds,
            progress=progress,
        )
        if arguments.out is not None:
            write_skeleton(arguments.out, found, arguments.vehicle, noise)
        progress("riding the chosen runs")
        case = Case(read_vehicle(arguments.vehicle), (), found.drives, seconds)
        loads = [ride(case, number).tyre_load_least for number in range(len(found.drives))]
    console = open_console()
    show(console, found, seconds, loads)
    if arguments.json is not None:
        write_json(arguments.json, to_json(found))
    if arguments.figure is not None:
        from wheelhop.report.plan import write_plan_figure

        write_plan_figure(found, arguments.figure)
        console.print(f"figure: {arguments.figure}", markup=False)
    if arguments.out is not None:
        console.print(f"{arguments.out}: campaign.toml lists the runs to drive", markup=False)
    return 0


def _runs(arguments: Namespace, seconds: float) -> int:
    if arguments.minutes is None:
        return RUNS if arguments.runs is None else int(arguments.runs)
    if not (isfinite(arguments.minutes) and arguments.minutes * 60 >= seconds):
        raise CampaignError(
            f"--minutes {arguments.minutes:g}: one run alone takes {seconds:g} s of recording"
        )
    return int(arguments.minutes * 60 // seconds)


def show(console: Console, found: Plan, seconds: float, loads: Sequence[float]) -> None:
    """Print a plan; `loads` are the least of a tyre in each chosen run, over its static load."""
    count = len(found.chosen)
    console.print(
        f"{count} of {len(found.foreseen.drives)} runs, {count * seconds / 60:.1f} min of recording"
    )
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("", justify="right")
    table.add_column("run", overflow="fold")
    for heading in ("km/h", "role", "numbers\nnats", "effects\nnats", "least load\n/ static"):
        table.add_column(heading, justify="left" if heading == "role" else "right")
    for number, (drive, role, after, load) in enumerate(
        zip(found.drives, found.roles, found.after, loads, strict=True), start=1
    ):
        told = (f"{after.numbers:.1f}", f"{after.effects:.1f}", f"{round(load, 2) + 0.0:.2f}")
        table.add_row(str(number), Text(drive.id), f"{drive.speed_kmph:g}", role, *told)
    console.print(table)
    console.print(
        "What these runs and those above them tell: of the vehicle's numbers, and of the effects,"
        " each beside its nearest rival."
    )
    if min(loads) < 0.0:
        console.print(
            "Below 0 a tyre would leave the ground: drive there with care, or ask for lower speeds."
        )
    _show_numbers(console, found)
    _show_effects(console, found)


def _show_numbers(console: Console, found: Plan) -> None:
    left = {name: after / believed for name, (believed, after) in found.uncertainty.items()}
    hardly = [name for name, share in sorted(left.items(), key=lambda p: -p[1]) if share > HARDLY]
    if hardly:
        words = [f"{name} ({100 * left[name]:.0f} %)" for name in hardly]
        console.print(
            f"Of the uncertainty believed, more than {100 * HARDLY:.0f} % would stay of"
            f" {listed(words)}.",
            markup=False,
        )


def _show_effects(console: Console, found: Plan) -> None:
    if not found.told:
        return
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("effect")
    for heading in ("shown from", "told apart from"):
        table.add_column(heading, justify="right")
    table.add_column("nearest rival")
    table.add_column("angle", justify="right")
    for told in found.told:
        strengths = (_strength(told.shown_from), _strength(told.told_from))
        angle = f"{told.angle_deg:.0f}°" if told.rival else ""
        form = f" ({told.form})" if told.form else ""
        table.add_row(Text(told.effect + form), *strengths, Text(told.rival), angle)
    console.print(table)
    console.print("Strengths as a share of what is clearly visible (wheelhop simulate --with).")
    for one, other, apart in found.confused:
        console.print(
            f"These runs would hardly tell {one} from {other} ({apart:.0f}°).", markup=False
        )


def _strength(share: float) -> str:
    return f"{significant(100 * share, 2)} %" if isfinite(share) else "never"
