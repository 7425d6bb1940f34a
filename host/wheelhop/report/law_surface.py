"""A law as a surface over extension and rate: its force, and how well it is known."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from numpy.typing import NDArray

from wheelhop.law import Found, Moved, Rival
from wheelhop.law.shape import forces, spread
from wheelhop.report.figures import AFTER, BEFORE, SOFT

Array = NDArray[np.float64]

CELLS = 41
UNKNOWN = "0.88"
"""Colour of what nothing recorded tells."""

DOUBTFUL = 0.25
"""Two standard deviations of this share of the largest force are grey, too."""

SIGNED = LinearSegmentedColormap.from_list("force", [BEFORE, "#ffffff", AFTER])


CERTAIN = LinearSegmentedColormap.from_list("doubt", ["#ffffff", SOFT])


def draw_surface(panels: tuple[Axes, Axes], found: Found, rival: Rival) -> None:
    """Force of a law over extension and rate on the left, two standard deviations of it on the
    right, grey where no motion went or little is known; lines enclose half and nine tenths of
    the motion recorded. Its history is left out."""
    moved = found.moved
    assert moved is not None
    at = [np.linspace(x.min(), x.max(), CELLS) for x in (moved.extension, moved.rate)]
    x, v = (grid.ravel() for grid in np.meshgrid(*at))
    inputs = {name: np.full(len(x), np.mean(u)) for name, u in moved.inputs.items()}
    grid = Moved(x, v, (1,) * len(x), inputs)  # each point by itself: nothing came before it
    force, doubt = forces(found, rival, grid), 2.0 * spread(found, rival, grid)
    went = _density(moved, at)
    largest = float(np.abs(force[went.ravel() > 0.0]).max())
    known = (went.ravel() > 0.0) & (doubt < DOUBTFUL * largest)
    shape = (CELLS, CELLS)
    most = float(doubt[known].max(initial=1e-9))
    pictures = (
        (force, (-largest, largest), SIGNED, "free: force, N"),
        (doubt, (0.0, most), CERTAIN, "two standard deviations, N"),
    )
    for panel, (values, (low, high), colours, label) in zip(panels, pictures, strict=True):
        panel.set_facecolor(UNKNOWN)
        shown = np.ma.masked_array(values.reshape(shape), ~known.reshape(shape))
        image = panel.pcolormesh(
            1e3 * at[0], at[1], shown, cmap=colours, vmin=low, vmax=high, rasterized=True
        )
        bar = panel.figure.colorbar(image, ax=panel)
        bar.outline.set_visible(False)
        panel.contour(1e3 * at[0], at[1], went, levels=_levels(went), colors=SOFT, linewidths=0.6)
        panel.set_title(label, loc="left")
        panel.set_xlabel("extension, mm")
        panel.set_ylabel("rate, m/s")


def _density(moved: Moved, at: list[Array]) -> Array:
    """How often the motion was near each point of the grid (v, x), a little smoothed."""
    edges = [np.append(a - 0.5 * (a[1] - a[0]), a[-1] + 0.5 * (a[1] - a[0])) for a in at]
    count = np.histogram2d(moved.rate, moved.extension, bins=(edges[1], edges[0]))[0]
    padded = np.pad(count, 1)
    around = [padded[i : i + CELLS, j : j + CELLS] for i in range(3) for j in range(3)]
    return np.asarray(np.mean(around, axis=0))


def _levels(density: Array) -> list[float]:
    """Densities whose lines enclose nine tenths and half of the motion, rising."""
    falling = np.sort(density.ravel())[::-1]
    enclosed = np.cumsum(falling) / falling.sum()
    levels = {float(falling[np.searchsorted(enclosed, share)]) for share in (0.9, 0.5)}
    return sorted(level for level in levels if level > 0.0)
