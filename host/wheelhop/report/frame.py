"""Frames: as they stand, and how they move in their first modes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from numpy.typing import NDArray

from wheelhop.files.words import significant
from wheelhop.frame import CORNERS, FiniteElements, FrameTwist, Modes
from wheelhop.report.figures import AFTER, INK, MEASURED, WIDTH
from wheelhop.report.svg import STYLE

Array = NDArray[np.float64]

SHOWN = 6
COLUMNS = 3
LARGEST = 0.08
"""The largest displacement drawn, as a share of the frame's longest side."""
MARGIN = 0.03


def frame_figure(name: str, elements: FiniteElements, modes: Modes, twist: FrameTwist) -> Figure:
    """The frame in grey, and over it each of its first six modes, seen from ahead and the left;
    the suspension's corners are marked."""
    shown = min(SHOWN, len(modes.frequency_hz))
    rows = -(-shown // COLUMNS)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 2.5 * rows + 0.4), layout="constrained")
        figure.suptitle(
            f"{name}: first modes without supports (grey: at rest)", x=0.01, ha="left", fontsize=10
        )
        grid = figure.add_gridspec(rows, COLUMNS)
        for i in range(shown):
            axes: Any = figure.add_subplot(
                grid[i // COLUMNS, i % COLUMNS], projection="3d", proj_type="ortho"
            )
            _draw(axes, elements, modes.shape[:, i].reshape(-1, 6)[:, :3])
            note = ", first torsional" if i == twist.first else ""
            hertz = significant(float(modes.frequency_hz[i]), 3)
            axes.set_title(f"{i + 1}: {hertz} Hz{note}", y=0.96)
    return figure


def write_frame_figure(
    name: str, elements: FiniteElements, modes: Modes, twist: FrameTwist, file: Path
) -> None:
    """Write it, as PNG unless the file's name says otherwise."""
    frame_figure(name, elements, modes, twist).savefig(file, dpi=150)


def _draw(axes: Any, elements: FiniteElements, motion: Array) -> None:
    rest = elements.position
    size = np.ptp(rest, axis=0)
    scale = LARGEST * size.max() / np.linalg.norm(motion, axis=1).max()
    moved = rest + scale * motion
    for place, colour, width in ((rest, MEASURED, 0.8), (moved, AFTER, 1.3)):
        axes.add_collection3d(
            Line3DCollection(
                [place[line] for line in elements.lines], colors=colour, linewidths=width
            )
        )
    corners = elements.corners
    axes.scatter(*moved[corners].T, s=9, color=INK, depthshade=False)
    for corner, place in zip(CORNERS, moved[corners], strict=True):
        axes.text(*place, f" {corner}", fontsize=6.5, color=INK)
    low, high = np.minimum(rest, moved).min(axis=0), np.maximum(rest, moved).max(axis=0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low + MARGIN * size.max(), zoom=1.35)
    axes.view_init(elev=24, azim=38)
    axes.set_axis_off()
