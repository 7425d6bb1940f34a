"""The picture of a law: force over extension and over rate, with what is not known in grey."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from wheelhop.law import Found, Rival
from wheelhop.law.shape import forces, spread
from wheelhop.report.figures import AFTER, INK, SOFT, WIDTH
from wheelhop.report.svg import STYLE

Array = NDArray[np.float64]
SHOWN = 4000  # points of the motion, at most


def law_figure(found: Found) -> Figure:
    """Force–extension and force–rate of the free law with two standard deviations, grey
    where little was recorded; below it each other law with the error it leaves of held-out runs."""
    assert found.free is not None and found.moved is not None
    rivals = [r for r in (found.formula, *found.named) if r is not None][:3]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 1.9 * (1 + len(rivals)) + 0.6), layout="constrained")
        panels = figure.subplots(1 + len(rivals), 2, sharex="col", sharey=True, squeeze=False)
        for row, rival in zip(panels, [found.free, *rivals], strict=True):
            _draw(row, found, rival)
        panels[-1, 0].set_xlabel("extension, mm")
        panels[-1, 1].set_xlabel("rate, m/s")
    return figure


def write_law_figure(found: Found, file: Path) -> None:
    """Write it as PNG."""
    law_figure(found).savefig(file, dpi=150)


def _draw(row: NDArray[np.object_], found: Found, rival: Rival) -> None:
    moved = found.moved
    assert moved is not None and found.free is not None
    free = rival is found.free
    force = forces(found, rival)
    step = max(len(force) // SHOWN, 1)
    panels: tuple[Axes, Axes] = row[0], row[1]
    for panel, along in zip(panels, (1e3 * moved.extension, moved.rate), strict=True):
        panel.plot(along[::step], force[::step], ".", ms=1.2, color=AFTER if free else INK,
                   alpha=0.35, rasterized=True)  # fmt: skip
        if free:
            doubt = 2 * spread(found, rival)
            order = np.argsort(along)[::step]
            panel.fill_between(along[order], (force - doubt)[order], (force + doubt)[order],
                               color=SOFT, alpha=0.15, linewidth=0)  # fmt: skip
        low, high = np.quantile(along, (0.005, 0.995))
        for a, b in ((-1e9, low), (high, 1e9)):
            panel.axvspan(a, b, color="0.5", alpha=0.12, linewidth=0)
        margin = 0.05 * float(np.ptp(along))
        panel.set_xlim(along.min() - margin, along.max() + margin)
        panel.axhline(0.0, color=SOFT, linewidth=0.6)
    panels[0].set_ylabel("force, N")
    panels[0].set_title(f"{rival.name}: held-out error {100 * rival.rung.error:.1f} %", loc="left")
