"""`wheelhop identify --study` and `--half-car`: the identified body on other legs."""

from __future__ import annotations

from argparse import Namespace
from dataclasses import replace

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from wheelhop.identify import HALVES, Bushings, Car, WheelHop, check_stable, study
from wheelhop.material import approximate, read_specimen
from wheelhop.vehicle import axle_name

STEP_TIME_S = np.arange(0, 3.0, 0.005)


def print_car(arguments: Namespace, car: Car, console: Console) -> None:
    """The study and the half car that were asked for; raises CampaignError and MaterialError."""
    if arguments.bushing:
        elements = approximate(read_specimen(arguments.bushing).modulus)
        car = replace(car, bushings=Bushings(elements))
    if arguments.half_car:
        _print_half_car(arguments.half_car, car, console)
    if arguments.study:
        _print_study(arguments, car, console)


def _print_half_car(which: str, car: Car, console: Console) -> None:
    places, half = HALVES[which], car.half_car(which)
    check_stable(half, "this suspension")
    moved, static = half.step(STEP_TIME_S), half.static()
    table = Table(box=box.SIMPLE_HEAD, title=f"generalized half car, {which}")
    table.add_column("ground stepped up")
    for corner in places:
        table.add_column(f"B{corner + 1}: static", justify="right")
        table.add_column("largest", justify="right")
    for j, corner in enumerate(places):
        cells = (f"{static[i, j]:.3f} {moved[:, i, j].max():.3f}".split() for i in range(2))
        table.add_row(f"A{corner + 1}", *(cell for pair in cells for cell in pair))
    both = moved.sum(axis=2)
    cells = (f"{static[i].sum():.3f} {both[:, i].max():.3f}".split() for i in range(2))
    table.add_row("both", *(cell for pair in cells for cell in pair))
    console.print(table)


def _print_study(arguments: Namespace, car: Car, console: Console) -> None:
    varied, factors = arguments.study
    corner = arguments.study_corner
    variants = study(car, varied, factors, corner - 1)
    here = axle_name(corner - 1)
    title = f"ground under A{corner} to B{corner}, {varied} varied"
    table = Table(box=box.SIMPLE_HEAD, title=title)
    for name in ("factor", "static", "largest of a step", f"{here} wheel hop, Hz (ζ)"):
        table.add_column(name, justify="right")
    for variant in variants:
        table.add_row(
            *(f"{variant.factor:g}", f"{variant.static:.3f}"),
            *(f"{variant.step(STEP_TIME_S).max():.3f}", _hops(variant.wheel_hops)),
        )
    console.print(table)
    there = "rear" if here == "front" else "front"
    console.print(
        "Wheel hop: modes that oscillate with more kinetic energy in the wheels than in the body,"
        f" and more in the {here} wheels than in the {there} ones; ζ is the damping ratio.",
        soft_wrap=True,
    )
    if arguments.study_figure:
        from wheelhop.report.transfer_figures import draw_study

        draw_study(variants, varied, arguments.study_figure)


def _hops(found: tuple[WheelHop, ...]) -> str:
    each = (f"{hop.frequency_hz:.2f} ({hop.damping_ratio:.2f})" for hop in found)
    return ", ".join(each) or "none oscillates"
