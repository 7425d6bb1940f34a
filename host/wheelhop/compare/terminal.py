"""A comparison on the terminal: one screen of numbers, then where it fails, then in words."""

from __future__ import annotations

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from wheelhop.compare.comparison import Comparison
from wheelhop.compare.describe import describe

# Residual over floor; channels differ in noise, so that 1.2 need not mean anything.
HEAT = ((1.3, "green"), (2.0, "yellow"), (5.0, "dark_orange"), (np.inf, "bold red"))


def print_comparison(comparison: Comparison, console: Console) -> None:
    """Print E, its floor, the residual over its floor by run and channel, and the description."""
    console.print(f"[bold]{escape(comparison.title)}[/bold]")
    console.print(_summary(comparison))
    console.print(_heat_map(comparison))
    for sentence in describe(comparison.breakdown):
        console.print(escape(f"- {sentence}"))


def _summary(comparison: Comparison) -> Table:
    floor = comparison.floor
    table = Table(box=None, pad_edge=False)
    for heading in ("", "error E", "floor", "E / floor", "runs"):
        table.add_column(heading, justify="left" if not heading else "right")
    for role, error, at_best in (
        ("fit", comparison.error_fit, floor.error_fit),
        ("validate", comparison.error_validate, floor.error_validate),
    ):
        runs = sum(r == role for r in comparison.roles.values())
        if runs:
            ratio = error / at_best if at_best > 0.0 else float("nan")
            table.add_row(role, _percent(error), _percent(at_best), _heat(ratio), str(runs))
    for each in comparison.by_quantity:
        for role, error, at_best in (
            ("fit", each.error_fit, each.floor_fit),
            ("validate", each.error_validate, each.floor_validate),
        ):
            if np.isfinite(error):
                ratio = error / at_best if at_best > 0.0 else float("nan")
                row = f"{each.quantity}, {role}"
                table.add_row(row, _percent(error), _percent(at_best), _heat(ratio), "")
    noise = [f"{each.noise_rms:.3g} {each.unit}" for each in comparison.by_quantity]
    said = ", ".join(noise) or f"{floor.pooled_rms:.3g} {floor.unit}"
    table.caption = f"noise {said} rms in band, {floor.origin}"
    table.caption_justify = "left"
    return table


def _heat_map(comparison: Comparison) -> Table:
    where = comparison.breakdown
    title = "residual / noise floor (* never used in a fit)"
    table = Table(title=title, title_justify="left", box=None, pad_edge=False)
    table.add_column("run", no_wrap=True, overflow="ellipsis")
    for name in where.channel:
        table.add_column(escape(name.name), justify="right")
    table.add_column("all", justify="right")
    table.add_column("E", justify="right")
    for run, row in zip(where.run, where.runs_channels.ratio, strict=True):
        cells = [_heat(value) for value in (*row, run.ratio)]
        mark = "" if comparison.roles[run.name] == "fit" else "*"
        table.add_row(escape(run.name) + mark, *cells, _percent(run.error))
    cells = [_heat(channel.ratio) for channel in where.channel]
    table.add_section()
    table.add_row("all", *cells, _heat(where.total.ratio), _percent(where.total.error))
    return table


def _heat(ratio: float) -> Text:
    if not np.isfinite(ratio):
        return Text("-", style="dim")
    style = next(style for limit, style in HEAT if ratio < limit)
    return Text(f"{ratio:.1f}" if ratio < 9.95 else f"{ratio:.0f}", style=style)


def _percent(error: float) -> str:
    return f"{100.0 * error:.2f} %" if np.isfinite(error) else "-"
