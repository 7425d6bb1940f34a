"""`wheelhop identify --study`: one number of the car varied."""

from __future__ import annotations

from argparse import Namespace

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from wheelhop.identify import Car, study
from wheelhop.identify.figure import draw_study


def print_study(arguments: Namespace, car: Car, console: Console) -> None:
    """Print and draw what was asked for; raises CampaignError."""
    varied, factors = arguments.study
    corner = arguments.study_corner
    variants = study(car, varied, factors, corner - 1)
    title = f"ground under A{corner} to B{corner}, {varied} varied"
    table = Table(box=box.SIMPLE_HEAD, title=title)
    for name in ("factor", "static", "largest of a step", "wheel hop, Hz"):
        table.add_column(name, justify="right")
    time_s = np.arange(0, 3.0, 0.005)
    for variant in variants:
        table.add_row(
            *(f"{variant.factor:g}", f"{variant.static:.3f}"),
            *(f"{variant.step(time_s).max():.3f}", f"{variant.wheel_hop_hz():.2f}"),
        )
    console.print(table)
    if arguments.study_figure:
        draw_study(variants, varied, arguments.study_figure)
