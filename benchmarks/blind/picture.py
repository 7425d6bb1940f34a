"""The confusion matrix as a picture."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from benchmarks.blind.plan import EFFECTS

INK, SOFT, RIGHT, WRONG = "#22303c", "#8a97a3", "#0b5fa5", "#d1495b"
NAMELESS = ("none", "unknown", "no answer")


def draw_confusion(rows: Mapping[str, Counter[str]], file: Path) -> None:
    """Truth downwards, first entry of the verdict across; the share of a row is a square's area."""
    said = {name for row in rows.values() for name in row}
    columns = [e for e in (*EFFECTS, *NAMELESS) if e in said or e in rows]
    columns += sorted(said - set(columns))
    order = [e for e in (*EFFECTS, "none") if e in rows]
    order += [row for row in rows if row not in order]
    with mpl.rc_context({"font.size": 8, "text.color": INK, "axes.edgecolor": SOFT}):
        width, height = 2.6 + 0.26 * max(len(columns), 14), 1.9 + 0.24 * len(order)
        figure = Figure(figsize=(width, height), layout="constrained")
        axes = figure.add_subplot()
        for y, truth in enumerate(order):
            total = sum(rows[truth].values())
            for name, count in rows[truth].items():
                side = 0.9 * np.sqrt(count / total)
                x = columns.index(name)
                colour = RIGHT if _right(truth, name) else WRONG
                corner = (x - side / 2, y - side / 2)
                axes.add_patch(mpl.patches.Rectangle(corner, side, side, color=colour, lw=0))
                axes.annotate(
                    str(count), (x, y), color="white", ha="center", va="center", fontsize=6
                )
        axes.set_xlim(-0.6, len(columns) - 0.4)
        axes.set_ylim(len(order) - 0.4, -0.6)
        axes.set_xticks(range(len(columns)), columns, rotation=90)
        axes.xaxis.tick_top()
        axes.set_yticks(range(len(order)), order)
        axes.tick_params(length=0, colors=INK)
        axes.set_axisbelow(True)
        axes.grid(color="#e7ebee", linewidth=0.6)
        axes.set_title("first entry of the verdict (across) by what was hidden (down)", loc="left")
        for side_name in axes.spines:
            axes.spines[side_name].set_visible(False)
        figure.savefig(file, dpi=150)


def _right(truth: str, said: str) -> bool:
    named = truth in EFFECTS or truth == "none"
    return said == truth if named else said == "unknown"
