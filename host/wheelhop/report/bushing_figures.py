"""Figures of bushings: moduli against frequency, hysteresis loops, loss angles."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wheelhop.material.rig import Point, model_loop
from wheelhop.report.figures import AFTER, BEFORE, INK, MEASURED, SOFT, WIDTH, log_axis
from wheelhop.report.svg import COLOURS, STYLE

if TYPE_CHECKING:
    from wheelhop.report.bushings import BushingResult

LINES = ((AFTER, "-"), (BEFORE, "--"), (INK, ":"))
"""The best models, as many as can be told apart."""
LOOPS = 4
N_MM = 1e-3


def moduli_figure(result: BushingResult) -> Figure:
    """Dynamic and loss modulus in N/mm, measured with the best three models, and what is left."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 3.6), layout="constrained")
        panels = figure.subplots(2, 2, height_ratios=(2.2, 1), sharex=True)
        data = result.data.moduli
        parts = ("dynamic", "loss")
        omega = np.geomspace(data.omega[0], data.omega[-1], 200)
        for column, (part, pick) in enumerate(zip(parts, (np.real, np.imag), strict=True)):
            upper, lower = panels[0, column], panels[1, column]
            measured = pick(data.modulus)
            known = np.isfinite(data.uncertainty).all()
            bars = 2 * N_MM * data.uncertainty if known else None
            upper.errorbar(
                data.frequency_hz, N_MM * measured, bars, fmt="o", ms=4.5, color=MEASURED,
                linewidth=1.0, label="measured",
            )  # fmt: skip
            for candidate, (colour, style) in zip(result.candidates, LINES, strict=False):
                fit = candidate.fit
                drawn: dict[str, Any] = {"color": colour, "linestyle": style}
                curve = pick(fit.modulus(omega))
                upper.plot(omega / 2 / np.pi, N_MM * curve, label=fit.model.title, **drawn)
                off = 100 * (pick(fit.modulus(data.omega)) / measured - 1)
                lower.plot(data.frequency_hz, off, **drawn)
            upper.set_title(f"{part} modulus")
            upper.set_ylabel("N/mm")
            lower.axhline(0.0, color=SOFT, linewidth=0.6)
            lower.set_ylabel("model off, %")
            lower.set_xlabel("frequency, Hz")
            log_axis(lower, 0.93 * data.frequency_hz[0], 1.07 * data.frequency_hz[-1], "x")
        figure.align_ylabels(panels)
        handles, labels = panels[0, 0].get_legend_handles_labels()
        order = [labels.index("measured"), *(i for i, v in enumerate(labels) if v != "measured")]
        figure.legend(
            [handles[i] for i in order], [labels[i] for i in order], loc="outside upper left",
            ncols=4,
        )  # fmt: skip
    return figure


def loops_figure(result: BushingResult) -> Figure:
    """Loops of some of the frequencies, from the lowest to the highest."""
    points = _some(result.data.points)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 3.4), layout="constrained")
        panels = figure.subplots(2, len(points), height_ratios=(2.2, 1), squeeze=False)
        for i, point in enumerate(points):
            _draw_loop(panels[0, i], panels[1, i], result, point)
        panels[0, 0].set_ylabel("force, N")
        panels[1, 0].set_ylabel("difference, N")
        figure.align_ylabels(panels)
        handles, labels = panels[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=4)
    return figure


def _some(points: Sequence[Point]) -> list[Point]:
    """Those of the smallest amplitude, spread over the frequencies."""
    least = min(point.amplitude_m for point in points)
    small = sorted((p for p in points if p.amplitude_m < 1.1 * least), key=lambda p: p.frequency_hz)
    places = np.unique(np.linspace(0, len(small) - 1, LOOPS).round().astype(int))
    return [small[i] for i in places]


def _draw_loop(upper: Axes, lower: Axes, result: BushingResult, point: Point) -> None:
    x, force, phase = point.loop.T
    upper.plot(1e3 * x, force, color=MEASURED, linewidth=3.0, label="measured")
    omega = np.array([2 * np.pi * point.frequency_hz])
    for candidate, (colour, style) in zip(result.candidates, LINES[:2], strict=False):
        modulus = complex(candidate.fit.modulus(omega)[0])
        loop = model_loop(modulus, point.amplitude_m)
        drawn: dict[str, Any] = {"color": colour, "linestyle": style}
        upper.plot(1e3 * loop[:, 0], loop[:, 1], label=candidate.fit.model.title, **drawn)
        off = force - (modulus * point.amplitude_m * np.exp(1j * phase)).real
        lower.plot(1e3 * x, off, **drawn)
    upper.set_title(f"{point.frequency_hz:.3g} Hz")
    lower.axhline(0.0, color=SOFT, linewidth=0.6)
    lower.set_xlabel("displacement, mm")


def _apart(heights: Sequence[float]) -> list[float]:
    """The heights moved apart, so that one line of text fits between them."""
    gap = 0.055 * max(np.ptp(heights), 1.0)
    order = np.argsort(heights)
    moved = np.array(heights)
    for below, above in pairwise(order):
        moved[above] = max(moved[above], moved[below] + gap)
    return [float(value) for value in moved]


def phase_figure(results: Sequence[BushingResult]) -> Figure:
    """Loss angle δ against frequency, as figure 3.6 of the source."""
    colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.85, len(results)))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
        axes = figure.add_subplot()
        ends = [float(np.angle(r.data.moduli.modulus[-1], deg=True)) for r in results]
        for result, colour, height in zip(results, colours, _apart(ends), strict=True):
            data = result.data.moduli
            omega = np.geomspace(data.omega[0], data.omega[-1], 100)
            shade = mpl.colors.to_hex(colour)
            axes.plot(data.frequency_hz, np.angle(data.modulus, deg=True), "o", ms=3, color=shade)
            angle = np.angle(result.best.modulus(omega), deg=True)
            axes.plot(omega / 2 / np.pi, angle, color=shade)
            axes.annotate(
                result.name, (data.frequency_hz[-1], height), xytext=(7, 0),
                textcoords="offset points", va="center", color=COLOURS["soft"],
            )  # fmt: skip
        axes.set_ylabel("loss angle, °")
        axes.set_xlabel("frequency, Hz")
        low = min(r.data.moduli.frequency_hz[0] for r in results)
        high = max(r.data.moduli.frequency_hz[-1] for r in results)
        log_axis(axes, 0.93 * low, high * (high / low) ** 0.15, "x")
    return figure
