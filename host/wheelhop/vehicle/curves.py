"""One number in place of a curve from the rig or the linkage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CALIBRATED = 0.01
"""How well load cells and travel are known, relative: one standard deviation."""


@dataclass(frozen=True)
class Slope:
    """A number; one standard deviation with which the points tell it (`scatter`), and how far the
    curve's own slope strays from it over the points, rms (`bend`)."""

    value: float
    scatter: float
    bend: float

    @property
    def uncertainty(self) -> float:
        """One standard deviation of the number where it stands for the whole curve, the rig's
        calibration included."""
        return float(np.linalg.norm([self.scatter, self.bend, CALIBRATED * self.value]))


def slope_of(x: Array, y: Array, beside: Array | None = None) -> tuple[Slope, Array]:
    """The straight line through points (n,) by least squares, with a column `beside` (n,) that may
    be in y as well; and the coefficients (2 or 3,): offset, slope, and of that column.

    The bend is the rms of p′(x) − slope, p the cubic through the same points.
    """
    middle, half = float(x.mean()), float(np.ptp(x)) / 2
    u = (x - middle) / half
    more = [] if beside is None else [beside]
    line = np.stack([np.ones_like(u), u, *more], axis=1)
    found, *_ = np.linalg.lstsq(line, y, rcond=None)
    spare = max(len(x) - line.shape[1], 1)
    sigma = np.sqrt(((y - line @ found) ** 2).sum() / spare)
    scatter = sigma * np.sqrt(np.linalg.pinv(line.T @ line)[1, 1]) / half
    cubic = np.column_stack([line, u**2, u**3])
    curved, *_ = np.linalg.lstsq(cubic, y, rcond=None)
    local = (curved[1] + 2 * curved[-2] * u + 3 * curved[-1] * u**2) / half
    slope = found[1] / half
    coefficients = np.concatenate([[found[0] - slope * middle, slope], found[2:]])
    bend = float(np.sqrt(np.mean((local - slope) ** 2)))
    return Slope(float(slope), float(scatter), bend), coefficients
