"""Frames: as they stand, and how they move in their first modes."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from wheelhop.files import write_picture
from wheelhop.files.words import significant
from wheelhop.frame import CORNERS, FiniteElements, FrameTwist, Modes
from wheelhop.report.figures import AFTER, INK, MEASURED, WIDTH
from wheelhop.report.svg import STYLE

Array = NDArray[np.float64]

SHOWN = 6
COLUMNS = 3
LARGEST = 0.06
"""The largest displacement drawn, as a share of the frame's longest side."""
AZIMUTH_DEG, ELEVATION_DEG = 40.0, 22.0
"""Where the frame is looked at from: ahead, from the left, and above."""


def frame_figure(name: str, elements: FiniteElements, modes: Modes, twist: FrameTwist) -> Figure:
    """The frame in grey, and over it each of its first six modes, the suspension's corners
    marked; parallel projection."""
    shown = min(SHOWN, len(modes.frequency_hz))
    rows = -(-shown // COLUMNS)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 2.45 * rows + 0.4), layout="constrained")
        figure.suptitle(
            f"{name}: first modes without supports, much enlarged (grey: at rest)",
            x=0.01, ha="left", fontsize=10,
        )  # fmt: skip
        panels = figure.subplots(
            rows, COLUMNS, sharex=True, sharey=True, squeeze=False, subplot_kw={"aspect": "equal"}
        ).ravel()
        for i, axes in enumerate(panels):
            axes.set_axis_off()
            if i >= shown:
                continue
            _draw(axes, elements, modes.shape[:, i].reshape(-1, 6)[:, :3])
            hertz = significant(float(modes.frequency_hz[i]), 3)
            torsional = ", first torsional" if i == twist.first else ""
            axes.set_title(f"{i + 1}: {hertz} Hz{torsional}")
    return figure


def write_frame_figure(
    name: str, elements: FiniteElements, modes: Modes, twist: FrameTwist, file: Path
) -> None:
    """Write it, in the form its name says."""
    write_picture(file, frame_figure(name, elements, modes, twist))


def _draw(axes: Axes, elements: FiniteElements, motion: Array) -> None:
    size = float(np.ptp(elements.position, axis=0).max())
    scale = LARGEST * size / np.linalg.norm(motion, axis=1).max()
    rest, moved = _seen(elements.position), _seen(elements.position + scale * motion)
    for place, colour, width in ((rest, MEASURED, 0.8), (moved, AFTER, 1.2)):
        lines = [place[line] for line in elements.lines]
        axes.add_collection(LineCollection(lines, colors=colour, linewidths=width))
    corners = moved[elements.corners]
    axes.plot(*corners.T, "o", ms=3, color=INK)
    for corner, place in zip(CORNERS, corners.tolist(), strict=True):
        axes.annotate(
            corner, place, xytext=(3, 2), textcoords="offset points", fontsize=7, color=INK
        )
    axes.autoscale_view()


def _seen(points: Array) -> Array:
    """Points (n, 3) on the picture's plane, (n, 2): to the right and up."""
    turn, tilt = np.radians((AZIMUTH_DEG, ELEVATION_DEG))
    right = (-np.sin(turn), np.cos(turn), 0.0)
    up = (-np.sin(tilt) * np.cos(turn), -np.sin(tilt) * np.sin(turn), np.cos(tilt))
    return np.asarray(points @ np.array([right, up]).T)
