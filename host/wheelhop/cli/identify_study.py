"""`wheelhop identify --study`: one number of the car varied."""

from __future__ import annotations

from argparse import Namespace

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from wheelhop.identify import Car, WheelHop, study
from wheelhop.identify.figure import draw_study
from wheelhop.vehicle import axle_name


def print_study(arguments: Namespace, car: Car, console: Console) -> None:
    """Print and draw what was asked for; raises CampaignError."""
    varied, factors = arguments.study
    corner = arguments.study_corner
    variants = study(car, varied, factors, corner - 1)
    here = axle_name(corner - 1)
    title = f"ground under A{corner} to B{corner}, {varied} varied"
    table = Table(box=box.SIMPLE_HEAD, title=title)
    for name in ("factor", "static", "largest of a step", f"{here} wheel hop, Hz (ζ)"):
        table.add_column(name, justify="right")
    time_s = np.arange(0, 3.0, 0.005)
    for variant in variants:
        table.add_row(
            *(f"{variant.factor:g}", f"{variant.static:.3f}"),
            *(f"{variant.step(time_s).max():.3f}", _hops(variant.wheel_hops)),
        )
    console.print(table)
    there = "rear" if here == "front" else "front"
    console.print(
        "Wheel hop: modes that oscillate with more kinetic energy in the wheels than in the body,"
        f" and more in the {here} wheels than in the {there} ones; ζ is the damping ratio.",
        soft_wrap=True,
    )
    if arguments.study_figure:
        draw_study(variants, varied, arguments.study_figure)


def _hops(found: tuple[WheelHop, ...]) -> str:
    each = (f"{hop.frequency_hz:.2f} ({hop.damping_ratio:.2f})" for hop in found)
    return ", ".join(each) or "none oscillates"
