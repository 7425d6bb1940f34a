"""A plan: what each run that could be driven would tell, and what the chosen show of effects."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wheelhop.files import write_picture
from wheelhop.predict.plan import Plan
from wheelhop.predict.plan_files import track_words
from wheelhop.report.figures import AFTER, BEFORE, INK, MEASURED, SOFT, WIDTH
from wheelhop.report.svg import STYLE

LARGEST_PT2 = 330.0
"""Area of the dot of the run that tells most."""
NEVER = 10.0
"""A strength above so many times what is clearly visible is drawn there."""


def plan_figure(plan: Plan) -> Figure:
    """Runs by track and speed, their area what they tell alone, the chosen ones numbered; below
    them the least strength of every effect that the chosen runs show, and tell from its rival."""
    tracks = _tracks(plan)
    rows = (0.45 * len(tracks) + 0.9, 0.24 * len(plan.told) + 0.9)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, sum(rows)), layout="constrained")
        if plan.told:
            above, below = figure.subplots(2, 1, height_ratios=rows)
            _draw_effects(below, plan)
        else:
            above = figure.subplots()
        _draw_runs(above, plan, tracks)
    return figure


def write_plan_figure(plan: Plan, file: Path) -> None:
    """Write it, in the form its name says."""
    write_picture(file, plan_figure(plan))


def _tracks(plan: Plan) -> list[str]:
    return list(dict.fromkeys(" ".join(track_words(drive)) for drive in plan.foreseen.drives))


def _draw_runs(axes: Axes, plan: Plan, tracks: list[str]) -> None:
    drives, rank = plan.foreseen.drives, {place: n for n, place in enumerate(plan.chosen, 1)}
    speed = np.array([drive.speed_kmph for drive in drives])
    line = np.array([tracks.index(" ".join(track_words(drive))) for drive in drives])
    nats = np.array([alone.total for alone in plan.alone])
    area = LARGEST_PT2 * nats / nats.max()
    taken = np.isin(np.arange(len(drives)), plan.chosen)
    axes.scatter(speed[~taken], line[~taken], area[~taken], color=MEASURED, linewidths=0)
    axes.scatter(speed[taken], line[taken], area[taken], color=AFTER, linewidths=0)
    for place, number in rank.items():
        axes.annotate(
            str(number), (speed[place], line[place]), ha="center", va="center_baseline",
            color="white", fontsize=8, fontweight="bold",
        )  # fmt: skip
    for x, y, told, size in zip(speed, line, nats, area, strict=True):
        away = 2.0 + np.sqrt(size / np.pi)
        axes.annotate(
            f"{told:.0f}", (x, y), xytext=(away, 0), textcoords="offset points", va="center",
            color=SOFT, fontsize=7,
        )  # fmt: skip
    axes.set_yticks(range(len(tracks)), tracks)
    axes.set_ylim(len(tracks) - 0.4, -0.6)
    axes.set_xlabel("speed, km/h")
    axes.tick_params(axis="y", length=0, colors=INK)
    axes.margins(x=0.06)
    axes.set_title("Runs: what each tells alone, nats; the numbered ones are to be driven")


def _draw_effects(axes: Axes, plan: Plan) -> None:
    found = sorted(plan.told, key=lambda told: told.told_from)
    for y, told in enumerate(found):
        shown, apart = min(told.shown_from, NEVER), min(told.told_from, NEVER)
        axes.plot([100 * shown, 100 * apart], [y, y], "-", color=SOFT, linewidth=1.0)
        axes.plot(100 * shown, y, "o", ms=4.5, color=AFTER)
        axes.plot(100 * apart, y, "o", ms=5.5, mfc="none", mec=BEFORE, mew=1.3)
        if told.rival:
            axes.annotate(
                f"{told.rival}, {told.angle_deg:.0f}°", (100 * apart, y), xytext=(7, 0),
                textcoords="offset points", va="center", fontsize=7.5, color=SOFT,
            )  # fmt: skip
    axes.set_xscale("log")
    axes.margins(x=0.02)
    low, high = axes.get_xlim()
    axes.set_xlim(low, high * (high / low) ** 0.3)  # room for the rivals' names
    axes.xaxis.set_major_formatter("{x:g}")
    axes.plot([], [], "o", ms=4.5, color=AFTER, label="shown from")
    axes.plot(
        [], [], "o", ms=5.5, mfc="none", mec=BEFORE, mew=1.3, label="told from its nearest rival"
    )
    axes.legend(loc="upper right", borderaxespad=0.0)
    axes.set_yticks(range(len(found)), [told.effect for told in found])
    axes.set_ylim(len(found) - 0.4, -0.6)
    axes.tick_params(axis="y", length=0, colors=INK)
    axes.set_xlabel("strength, % of what is clearly visible")
    axes.set_title("Effects: the least strength that the chosen runs show")
