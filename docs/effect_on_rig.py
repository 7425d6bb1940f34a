"""An effect that only a rig tells from its likes, in three panels: loops over extension and over
rate at three amplitudes, and what a spring and a damper would make of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
from effect_pictures import BASELINE, EFFECT, INK, PANELS, SOFT, STYLE
from matplotlib.figure import Figure
from numpy.typing import NDArray

from wheelhop.effects import Effect, Shape
from wheelhop.law import Moved, Where
from wheelhop.law.along import force_along
from wheelhop.simulate import Model

Array = NDArray[np.float64]

COMPONENT: Mapping[str, float] = {
    "component.mass_kg": 0.0,
    "component.stiffness_N_m": 20e3,
    "component.damping_N_s_m": 500.0,
    "rig.force_N": 600.0,
    "rig.travel_m": 0.02,
    "rig.speed_m_s": 0.2,
}
"""A strut between a rig's grips, with what is usual for its recordings."""

FREQUENCY_HZ = 1.5
SHOWN_M = (0.004, 0.01, 0.02)
RATE_HZ = 20000.0


def strengths(effect: Effect) -> dict[str, float]:
    """Amplitudes clearly visible, shapes at the middle of their starts."""
    return {
        p.name: p.starts[len(p.starts) // 2] if isinstance(p, Shape) else p.typical
        for p in effect.parameters_for(COMPONENT, ())
    }


def loop(effect: Effect | None, amplitude_m: float) -> tuple[Array, Array, Array]:
    """Extension, rate and force over the last of three turns."""
    time = np.arange(round(3.0 / FREQUENCY_HZ * RATE_HZ)) / RATE_HZ
    omega = 2.0 * np.pi * FREQUENCY_HZ
    x, v = amplitude_m * np.sin(omega * time), amplitude_m * omega * np.cos(omega * time)
    values, effects = dict(COMPONENT), tuple[Effect, ...]()
    if effect is not None:
        values |= {f"{effect.id}.{k}": n for k, n in strengths(effect).items()}
        effects = (effect,)
    where, moved = Where("component", "strut", (0,)), Moved(x, v, (len(x),))
    force = force_along(Model(values, effects), where, moved, 1.0 / RATE_HZ)
    last = slice(2 * len(time) // 3, None)
    return x[last], v[last], force[last]


def picture_on_rig(effect: Effect) -> Figure:
    """The effect's three panels."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10.4, 3.0))
        left, middle, right = (figure.add_axes(place) for place in PANELS)
        for amplitude in SHOWN_M:
            for law, colour in ((None, BASELINE), (effect, EFFECT)):
                x, v, force = loop(law, amplitude)
                left.plot(1e3 * x, force, color=colour, lw=1.0)
                middle.plot(v, force, color=colour, lw=1.0)
        left.set_title("component, without and with", pad=15)
        left.set_xlabel("extension, mm")
        left.set_ylabel("force, N")
        middle.set_title("the same over the rate", pad=15)
        middle.set_xlabel("rate, m/s")
        amplitudes = np.geomspace(2e-4, 0.03, 25)
        for law, colour in ((None, BASELINE), (effect, EFFECT)):
            stiffness = np.array([_harmonic(law, a) for a in amplitudes])
            right.plot(1e3 * amplitudes, 1e-3 * stiffness.real, color=colour)
            right.plot(1e3 * amplitudes, 1e-3 * stiffness.imag, color=colour, ls="--")
        right.set_xscale("log")
        right.set_ylim(bottom=0.0)
        right.set_xticks([0.2, 1, 5, 20], ["0.2", "1", "5", "20"])
        right.set_title("first harmonic: in phase, --- in quadrature", pad=15, color=INK)
        right.set_xlabel("amplitude, mm")
        right.set_ylabel("kN/m")
        words = [f"{k} = {float(f'{n:.3g}'):g}" for k, n in strengths(effect).items()]
        text = f"Sines of {FREQUENCY_HZ:g} Hz.  {', '.join(words)}"
        figure.text(0.012, 0.025, text, fontsize=7.8, color=SOFT)
    return figure


def forms_picture(forms: Sequence[tuple[str, Effect]]) -> Figure:
    """Force over extension and over rate of the forms of one effect, spring and damper left out."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10.4, 4.2), layout="constrained")
        panels = figure.subplots(2, len(forms), sharey=True)
        for (name, form), (over_x, over_v) in zip(forms, panels.T, strict=True):
            for amplitude in SHOWN_M:
                x, v, force = loop(form, amplitude)
                own = force - loop(None, amplitude)[2]
                over_x.plot(1e3 * x, own, color=EFFECT, lw=1.0)
                over_v.plot(v, own, color=EFFECT, lw=1.0)
            over_x.set_title(name)
            over_x.set_xlabel("extension, mm")
            over_v.set_xlabel("rate, m/s")
        for row in panels:
            row[0].set_ylabel("force, N")
    return figure


def _harmonic(effect: Effect | None, amplitude_m: float) -> complex:
    """First harmonic of the force over that of the extension, N/m."""
    x, _, force = loop(effect, amplitude_m)
    turn = np.exp(-2j * np.pi * np.arange(len(x)) / len(x))
    return complex((force @ turn) / (x @ turn))
