"""From rig to wheel: the curves, and the number that stands for each."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wheelhop.files import write_picture
from wheelhop.report.figures import AFTER, BEFORE, MEASURED, SOFT, WIDTH
from wheelhop.report.svg import STYLE
from wheelhop.vehicle.curves import Array, Slope
from wheelhop.vehicle.rates import WheelRates


def rates_figure(found: WheelRates) -> Figure:
    """Force over compression of the strut, force over velocity of the damper, and the motion ratio;
    over each the straight line that stands for it, with one standard deviation."""
    strut, damper = found.strut, found.damper
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
        left, middle, right = figure.subplots(1, 3)
        travel = 1e3 * (strut.compression_m - strut.ride_m)
        left.plot(travel, strut.force_N, ".", ms=2.5, color=MEASURED)
        _line(left, travel, strut.ride_force_N, strut.stiffness, 1e-3)
        left.set_title(f"strut: {1e-3 * strut.stiffness.value:.3g} N/mm")
        left.set(xlabel="compression from ride height, mm", ylabel="force, N")
        velocity = 1e3 * damper.velocity_m_s
        middle.plot(velocity, damper.force_N, ".", ms=4, color=MEASURED)
        _line(middle, velocity, damper.rest_force_N, damper.damping, 1e-3)
        middle.set_title(f"damper: {1e-3 * damper.damping.value:.3g} N s/mm")
        middle.set(xlabel="velocity of compression, mm/s", ylabel="force, N")
        _draw_ratio(right, found)
    return figure


def write_rates_figure(found: WheelRates, file: Path) -> None:
    """Write it, in the form its name says."""
    write_picture(file, rates_figure(found))


def _line(axes: Axes, x: Array, offset: float, slope: Slope, unit: float) -> None:
    """The line, and how far it turns within one standard deviation."""
    ends = np.array([x.min(), 0.0, x.max()])
    middle = offset + unit * slope.value * ends
    around = np.abs(unit * slope.uncertainty * ends)
    axes.fill_between(ends, middle - around, middle + around, color=AFTER, alpha=0.18, linewidth=0)
    axes.plot(ends, middle, color=AFTER)


def _draw_ratio(axes: Axes, found: WheelRates) -> None:
    linkage = found.linkage
    ratio = linkage.ratio
    if len(linkage.travel_m):
        axes.plot(1e3 * linkage.travel_m, linkage.curve, color=SOFT)
        low, high = axes.get_xlim()
    else:
        low, high = -50.0, 50.0
    axes.axhspan(
        ratio.value - ratio.uncertainty, ratio.value + ratio.uncertainty, color=AFTER, alpha=0.18,
        linewidth=0,
    )  # fmt: skip
    axes.plot([low, high], [ratio.value] * 2, color=AFTER)
    axes.plot(0.0, ratio.value, "o", ms=5, color=BEFORE)
    axes.set_xlim(low, high)
    half = max(0.05, 4 * ratio.uncertainty)
    axes.set_ylim(ratio.value - half, ratio.value + half)
    axes.set_title(f"motion ratio: {ratio.value:.3g}")
    axes.set(xlabel="wheel, up from ride height, mm", ylabel="strut over wheel")
