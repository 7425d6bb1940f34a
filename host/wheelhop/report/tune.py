"""Tuning as a page: before and after, the front, and what every variable does by itself."""

from __future__ import annotations

from html import escape
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wheelhop.files.words import significant, unit_of
from wheelhop.report.figures import AFTER, BEFORE, INK, MEASURED, SOFT, WIDTH
from wheelhop.report.page import bullets, figure, paragraph, section, table, title, write_page
from wheelhop.report.ride import rides_figure
from wheelhop.report.svg import STYLE, inline
from wheelhop.report.tune_words import amount, change, sentences
from wheelhop.tune.tuning import Setting, Tuning
from wheelhop.tune.variables import Variable

FARTHEST = 2.0
"""Settings whose objectives are beyond so many times the present ones are not drawn."""


def write_tune_report(path: Path, found: Tuning) -> None:
    """Write the page; raises InputError."""
    now, proposed = found.rides
    rides = {"proposed": proposed, "now": now}
    runs = [drive.id for drive in found.drives]
    write_page(
        path,
        f"Tuning {found.car.vehicle.name}",
        [
            title(f"Tuning {found.car.vehicle.name}"),
            bullets(sentences(found)),
            section("Before and after", _before_and_after(found), _settings(found)),
            section(
                "The front",
                figure(
                    inline(front_figure(found), "front", "objectives of all settings tried"),
                    "Every setting tried (grey), the present one (orange), and settings of the"
                    " front with the intervals of their gains (blue); the proposed one is filled."
                    " On the front nothing gains in one objective without losing in another.",
                ),
                _front(found),
            ),
            section(
                "Each variable alone",
                figure(
                    inline(alone_figure(found), "alone", "gain of every variable alone"),
                    "The most that each variable gains within its bounds while the others stay.",
                ),
            ),
            section(
                "Run by run",
                figure(
                    inline(rides_figure(runs, rides), "rides", "rides now and proposed"),
                    "Comfort, travel and tyre loads of every run, now and as proposed.",
                ),
            ),
        ],
    )


def _before_and_after(found: Tuning) -> str:
    first = found.front[0]
    rows = [
        [
            escape(f"{o.name}: {o.title}"),
            amount(now, o),
            amount(score, o),
            change(gain, o),
            "yes" if gain.is_sure else "no",
        ]
        for o, now, score, gain in zip(
            found.objectives, found.now.scores, first.scores, first.gains, strict=True
        )
    ]
    headings = ("objective", "now", "proposed", "change, 95 %", "larger than what is not known")
    return table(headings, rows, "lrrrl")


def _settings(found: Tuning) -> str:
    first = found.front[0]
    rows = [
        [
            escape(v.name),
            _value(v, v.now),
            _value(v, first.values[v.name]),
            _bounds(v),
            escape(unit_of(v.key) if "click" not in v.key else "click"),
        ]
        for v in found.variables
    ]
    caption = "" if found.proposed else "No setting is proposed; this is the best compromise."
    headings = ("variable", "now", "proposed", "bounds", "unit")
    return table(headings, rows, "lrrrl") + paragraph(caption)


def _bounds(variable: Variable) -> str:
    if variable.choices:
        return f"{len(variable.choices)} to choose from"
    return f"{significant(variable.low)} … {significant(variable.high)}"


def _value(variable: Variable, value: float) -> str:
    return f"{value:g}" if variable.key.endswith("_click") else significant(value, 4)


def _front(found: Tuning) -> str:
    """The settings of the front that were looked at further."""

    def row(name: str, one: Setting) -> list[str]:
        told = [
            f"{amount(s, o)} ({change(g, o)})" if g.half else amount(s, o)
            for s, o, g in zip(one.scores, found.objectives, one.gains, strict=True)
        ]
        return [name, *told, *(_value(v, one.values[v.name]) for v in found.variables)]

    names = ["proposed" if found.proposed else "compromise"]
    names += [str(number) for number in range(2, len(found.front) + 1)]
    rows = [row("now", found.now), *map(row, names, found.front)]
    objectives = [o.name for o in found.objectives]
    headings = ["", *objectives, *(escape(v.name) for v in found.variables)]
    return table(headings, rows, "l" + "r" * (len(headings) - 1))


def front_figure(found: Tuning) -> Figure:
    """Every pair of objectives, in per cent of now: all settings, the present one, the front."""
    count = len(found.objectives)
    pairs = [(i, j) for j in range(count) for i in range(j)] or [(0, 0)]
    with mpl.rc_context(STYLE):
        columns = min(len(pairs), 3)
        lines = -(-len(pairs) // columns)
        drawn = Figure(figsize=(WIDTH, 2.6 * lines), layout="constrained")
        axes = drawn.subplots(lines, columns, squeeze=False).ravel()
        for axis, (i, j) in zip(axes, pairs, strict=False):
            _draw_pair(axis, found, i, j)
        for axis in axes[len(pairs) :]:
            axis.set_visible(False)
    return drawn


def _draw_pair(axis: Axes, found: Tuning, i: int, j: int) -> None:
    now = found.now.scores
    near = found.tried[(found.tried < FARTHEST * now).all(axis=1)]
    x, y = (100 * near[:, k] / now[k] for k in (i, j))
    axis.plot(x, y, ".", ms=2, color=MEASURED)
    for number, one in enumerate(found.front):
        at = [100 * one.scores[k] / now[k] for k in (i, j)]
        half = [100 * one.gains[k].half / now[k] for k in (i, j)]
        fill = AFTER if number == 0 else "white"
        axis.errorbar(
            at[0], at[1], xerr=half[0], yerr=half[1], fmt="o", ms=5, color=AFTER, mfc=fill,
            elinewidth=0.7, zorder=3,
        )  # fmt: skip
    axis.plot(100, 100, "o", ms=6, color=BEFORE, zorder=4)
    names = [o.name for o in found.objectives]
    axis.set_xlabel(f"{names[i]}, % of now")
    axis.set_ylabel(f"{names[j]}, % of now")


def alone_figure(found: Tuning) -> Figure:
    """The gain of every variable alone in each objective, in per cent of now."""
    names = [v.name for v in found.variables]
    share = 100 * np.maximum(found.alone, 0.0) / found.now.scores
    with mpl.rc_context(STYLE):
        height = 0.7 + 0.24 * len(names)
        drawn = Figure(figsize=(WIDTH, height), layout="constrained")
        axes = np.atleast_1d(drawn.subplots(1, len(found.objectives), sharey=True))
        for axis, objective, column in zip(axes, found.objectives, share.T, strict=True):
            axis.barh(range(len(names)), column, color=AFTER, height=0.6)
            axis.set_title(f"{objective.name}, % gained")
            axis.set_xlim(0, max(1.05 * column.max(), 0.1))
            axis.tick_params(axis="y", length=0, colors=INK)
            axis.grid(axis="y", visible=False)
            axis.tick_params(axis="x", colors=SOFT)
        axes[0].set_yticks(range(len(names)), names)
        axes[0].invert_yaxis()
    return drawn
