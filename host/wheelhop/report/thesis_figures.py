"""Figures of the thesis that compare models: 1.4 and 2.21, 2.7, 2.13, 2.14, 5.25 and 6.1."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from wheelhop.effects import load_effects
from wheelhop.frame import CornerModes, read_corner_modes
from wheelhop.identify import published
from wheelhop.identify.equivalent import (
    STEP_TIME_S,
    equivalent_vehicle,
    ground_to_body,
    step_responses,
)
from wheelhop.identify.quarter_car import Struts, Wheels, compliance, on_wheels
from wheelhop.identify.statespace import StateSpace, balanced_reduction
from wheelhop.identify.steps import fit_damped_sinusoids
from wheelhop.identify.synthetic import thesis_matrix
from wheelhop.identify.thesis_tables import STEP_TIME_S as LONG_S
from wheelhop.identify.thesis_tables import quarter_cars
from wheelhop.predict.case import Case
from wheelhop.predict.drives import read_drives, read_effects
from wheelhop.report.figures import AFTER, BEFORE, INK, MEASURED, SOFT, WIDTH
from wheelhop.report.svg import STYLE
from wheelhop.vehicle import Vehicle
from wheelhop.vehicle.frame_modes import mode_values
from wheelhop.vehicle.vehicle import FRAME_DAMPING, FRAME_MODES

Array = NDArray[np.float64]
INKS = (BEFORE, AFTER, INK, SOFT)
FREQUENCY_HZ: Array = np.geomspace(0.2, 100.0, 500)
ORDERS = (4, 6, 8)
ORDERS_5_25 = (4, 6, 8, 10)
SHOWN_S = 2.0
TRACK, SPEED_KMPH = "one-sided-washboard/high", 13.0
"""Where a frame twists. On the washboard of figure 6.1 both sides are lifted alike."""
OWN_TRACK = ("washboard/high", 11.0)
"""That of figure 6.1, at its low speed."""
RADIUS_M = 0.279
"""Of the wheels: tyres 22x7-10."""
SPRUNG_AHEAD = "cg_to_front_axle_m"


def figure_2_21() -> Figure:
    """Figures 1.4 and 2.21: a step of the ground under one wheel."""
    with mpl.rc_context(STYLE):
        figure, axis = _single(2.8)
        for (name, car), ink in zip(quarter_cars().items(), INKS, strict=False):
            moved = car.step(LONG_S)[:, 0, 0]
            axis.plot(LONG_S, moved, color=ink, label=f"{name} quarter car")
            axis.axhline(car.static()[0, 0], color=ink, lw=0.5, ls=":")
        axis.set_xlabel("time, s")
        axis.set_ylabel("body, m, for a step of 1 m")
        axis.legend(loc="upper right")
    return figure


def figure_2_7() -> Figure:
    """One to three damped sinusoids fitted to the steps at front left and rear left."""
    body = equivalent_vehicle().body()
    responses = step_responses(body)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 5.4), layout="constrained")
        grid = figure.subplots(3, 2, sharex=True)
        for line, count in zip(grid, (1, 2, 3), strict=True):
            fitted = fit_damped_sinusoids(STEP_TIME_S, responses, count, starts_at_rest=False)
            shown = _sinusoids(fitted.sigma, fitted.omega, fitted.residues).reshape(responses.shape)
            for axis, case, where in zip(line, (0, 2), ("front left", "rear left"), strict=True):
                for point, name in enumerate(("FL", "FR", "RL", "RR")):
                    ink = INKS[point]
                    axis.plot(STEP_TIME_S, 1e3 * responses[case, point], ".", ms=2, color=ink)
                    axis.plot(STEP_TIME_S, 1e3 * shown[case, point], color=ink, lw=0.8, label=name)
                axis.set_title(f"j = {count}, 1 kN at {where}")
        for axis in grid[-1]:
            axis.set_xlabel("time, s")
        grid[1, 0].set_ylabel("displacement, mm")
        grid[0, 1].legend(ncols=4, loc="upper right", fontsize=7)
    return figure


def _sinusoids(sigma: Array, omega: Array, residues: Array) -> Array:
    """(2.1) at `STEP_TIME_S`: residues (responses, 2j + 1)."""
    decay = np.exp(-np.outer(sigma, STEP_TIME_S))
    turn = np.outer(omega, STEP_TIME_S)
    basis = np.empty((1 + 2 * len(sigma), len(STEP_TIME_S)))
    basis[0], basis[1::2], basis[2::2] = 1.0, decay * np.sin(turn), decay * np.cos(turn)
    return np.asarray(residues @ basis)


def figure_2_13() -> Figure:
    """Reduced models of G11 against the whole."""
    return _reduced_figure(_g11(), ORDERS, "G11")


def figure_5_25() -> Figure:
    """Reduced models of H_n,11 against the whole."""
    return _reduced_figure(_h_n_11(), ORDERS_5_25, "H_n,11")


def figure_2_14() -> Figure:
    """G_red of sixth order and G11, over frequency and after a step."""
    whole = _g11()
    reduced, _ = balanced_reduction(whole, 6)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 2.8), layout="constrained")
        left, right = figure.subplots(1, 2)
        for system, ink, style, name in (
            (whole, BEFORE, "--", "G11"),
            (reduced, AFTER, "-", "G_red, 6th order"),
        ):
            left.loglog(FREQUENCY_HZ, _magnitude(system), style, color=ink, label=name)
            right.plot(LONG_S, system.step(LONG_S)[:, 0, 0], style, color=ink)
        numerator, denominator = published.G_RED
        s = 2j * np.pi * FREQUENCY_HZ
        printed = np.abs(np.polyval(numerator, s) / np.polyval(denominator, s))
        left.loglog(FREQUENCY_HZ, printed, ":", color=SOFT, label="G_red as printed (A.4)")
        _frequency(left)
        left.legend(loc="lower left", fontsize=7)
        right.set_xlim(0, SHOWN_S)
        right.set_xlabel("time, s")
        right.set_ylabel("body, m, for a step of 1 m")
    return figure


def figure_6_1(frame: CornerModes | None = None) -> Figure:
    """Body accelerations with a rigid and with a flexible frame: on the high one-sided washboard
    with one that twists at the frequency that Table D.1 prints, or on the thesis's own track with
    the modes of a `frame`."""
    records = {
        name: _acceleration(flexible, frame)
        for name, flexible in (("rigid", False), ("flexible", True))
    }
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 2.8), layout="constrained")
        left, right = figure.subplots(1, 2)
        for (name, record), ink, style in zip(records.items(), INKS, ("--", "-"), strict=False):
            time_s = np.arange(len(record)) / 100.0
            left.plot(time_s, record[:, 0], style, color=ink, label=name)
            spectrum = 2 * np.abs(np.fft.rfft(record[:, 0])) / len(record)
            right.plot(np.fft.rfftfreq(len(record), 0.01), spectrum, style, color=ink)
        left.set_xlim(0, SHOWN_S)
        left.set_xlabel("time, s")
        left.set_ylabel("B1, m/s²")
        figure.legend(*left.get_legend_handles_labels(), loc="outside upper left", ncols=2)
        right.set_xlabel("frequency, Hz")
        right.set_ylabel("amplitude, m/s²")
    return figure


FIGURES: Mapping[str, tuple[Callable[[], Figure], str]] = {
    "2.21": (
        figure_2_21,
        "Figures 1.4 and 2.21. The usual quarter car (Table 2.5) and the generalized one, whose"
        " other three wheels stay on the ground and hold the body.",
    ),
    "2.7": (
        figure_2_7,
        "Figure 2.7. Displacements (dots) of the equivalent vehicle after a force of 1 kN, and one"
        " to three damped sinusoids fitted to all of them (lines).",
    ),
    "2.13": (figure_2_13, "Figure 2.13. Reduced models of G11 against the whole."),
    "2.14": (
        figure_2_14,
        "Figure 2.14. G_red and G11 over frequency and after a step, beside the G_red that A.4"
        " prints.",
    ),
    "5.25": (figure_5_25, "Figure 5.25. Reduced models of H_n,11 against the whole."),
    "6.1": (
        figure_6_1,
        "Like figure 6.1: body acceleration with a rigid frame and with one that twists at 26.49 Hz"
        " (Table D.1). The thesis shows the high washboard. There both sides are lifted alike, and"
        " what differs must be bending, of which nothing is printed; this is the one-sided"
        " washboard at 13 km/h.",
    ),
}
"""What draws each figure, and its caption."""


def on_frame(file: Path) -> Mapping[str, tuple[Callable[[], Figure], str]]:
    """Figure 6.1 on its own track, with the frame of a file: what draws it, and its caption. Raises
    FrameError."""
    frame = read_corner_modes(file)
    caption = (
        "Figure 6.1. Body acceleration on the high washboard at 11 km/h with a rigid frame and with"
        f" that of {file.name}, whose first mode is at {frame.frequency_hz[0]:.1f} Hz (Table D.1:"
        " 26.49 Hz)."
    )
    return {"6.1": (partial(figure_6_1, frame), caption)}


@cache
def _g11() -> StateSpace:
    return ground_to_body(equivalent_vehicle().body()).part(0, 0)


@cache
def _h_n_11() -> StateSpace:
    old, new = (Struts(*published.TABLE_5_4[key]) for key in ("old", "new"))
    on = Wheels(*zip(published.TABLE_5_3["front"], published.TABLE_5_3["rear"], strict=True))
    return on_wheels(compliance(thesis_matrix(), old), old, new, on).part(0, 0)


def _magnitude(system: StateSpace) -> Array:
    return np.asarray(np.abs(system(2j * np.pi * FREQUENCY_HZ)[:, 0, 0]))


def _reduced_figure(whole: StateSpace, orders: tuple[int, ...], name: str) -> Figure:
    with mpl.rc_context(STYLE):
        figure, axis = _single(3.0)
        label = f"{name}, order {whole.order}"
        axis.loglog(FREQUENCY_HZ, _magnitude(whole), color=MEASURED, lw=3, label=label)
        for order, ink in zip(orders, INKS, strict=False):
            reduced, _ = balanced_reduction(whole, order)
            axis.loglog(FREQUENCY_HZ, _magnitude(reduced), color=ink, label=f"order {order}")
        _frequency(axis)
        axis.set_ylim(bottom=1e-4)
        axis.legend(loc="lower left")
    return figure


def _single(height: float) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, figure.subplots()


def _frequency(axis: Axes) -> None:
    axis.set_xlabel("frequency, Hz")
    axis.set_ylabel("body over ground")
    axis.set_xlim(FREQUENCY_HZ[0], FREQUENCY_HZ[-1])


def printed_atv() -> Vehicle:
    """The vehicle of chapters 4 and 5, of printed numbers as far as there are any."""
    atv, values = published.ATV, dict[str, float]()
    for name in ("wheelbase_m", "track_width_m", SPRUNG_AHEAD):
        values[f"geometry.{name}"] = atv[name]
    for name in ("mass_kg", "pitch_inertia_kg_m2", "roll_inertia_kg_m2"):
        values[f"body.{name}"] = atv[name]
    old = published.TABLE_5_4["old"]
    for i, end in enumerate(("front", "rear")):
        mass, tyre, loss = published.TABLE_5_3[end]
        values[f"suspension.{end}.stiffness_N_m"] = old[i]
        values[f"suspension.{end}.damping_N_s_m"] = old[2 + i]
        wheel = {"unsprung_mass_kg": mass, "tyre_stiffness_N_m": tyre, "tyre_damping_N_s_m": loss}
        for name, value in {**wheel, "radius_m": RADIUS_M}.items():
            values[f"wheel.{end}.{name}"] = value
    return Vehicle("ATV of chapters 4 and 5", values, dict.fromkeys(values, 0.0))


def _acceleration(flexible: bool, frame: CornerModes | None = None) -> Array:
    """Accelerations (n, 8), m/s², without noise."""
    twist, vehicle, words = published.TABLE_D_1["twist"], printed_atv(), list[str]()
    if flexible and frame is None:
        words = [f"frame-twist:freq_hz={twist}"]
    elif flexible and frame is not None:
        modes = mode_values(frame, FRAME_MODES, FRAME_DAMPING)
        certain = dict.fromkeys(modes, 0.0)
        vehicle = replace(
            vehicle,
            values={**vehicle.values, **modes},
            uncertainty={**vehicle.uncertainty, **certain},
        )
    track, speed = (TRACK, SPEED_KMPH) if frame is None else OWN_TRACK
    drives = read_drives([track], [speed])
    return Case(vehicle, read_effects(words, load_effects()), drives).record(0, 100.0, 0.01)
