"""The engine shakes the body, locked to time and not to the road."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, OwnValues, Probe, RunSetting, Values
from wheelhop.effects.history import History
from wheelhop.effects.line import phase_along, shared, strength
from wheelhop.effects.parameters import Amplitude, Parameter, Shape
from wheelhop.vehicle import Assembly, node_of

EXPECTED_M_S2 = 1.0
"""Force over the body's mass that is believed of an engine. Forces themselves would not do: records
show a force and a mass only by their ratio, and a belief in small ones makes the vehicle light."""

SPREAD = 0.05
"""An idling engine's speed differs so much from run to run: one standard deviation."""

REACH = 3.0
"""Lines of one engine lie within this many of these."""

WANDER = 0.02
"""And wanders by about so much within one, in some seconds."""

KNOTS_S = 0.4
"""Spacing of the knots of its history: a wander of 2.5 s period is followed to 0.3 %."""

LOGARITHMS = np.arange(np.log(1.0), np.log(45.0), 0.002)
"""Of the frequencies, Hz, at which a line is sought."""

STARTS = 3
"""So many lines are tried."""


class EngineVibration(Effect):
    """A harmonic vertical force at the engine. Its phase and strength differ from run to run, as
    does the engine's speed, which also wanders within a run: the force turns with the engine.

    Where a channel shows the engine's speed, the force turns as that does: its frequency, that at
    the mean speed of all runs, is the order times that speed, and no run has one of its own.
    """

    id = "engine-vibration"
    place = "body"
    title = "a harmonic force at the engine, locked to time and not to the road"
    equation = (
        r"F = m (a_c \cos \varphi + a_s \sin \varphi),"
        r"\quad \varphi = 2\pi f \left[(1 + \delta)(t - t_m) + \sum_j c_j B_j(t)\right],"
        r"\quad B_j \text{ cubic B-splines, 0.4 s apart, } t_m \text{ mid-record}"
    )
    source = (
        "unbalance and firing order, e.g. H. Dresig, F. Holzweissig, Dynamics of Machinery, ch. 3;"
        " idle speed not held exactly, e.g. L. Guzzella, C. Onder, Introduction to Modeling and"
        " Control of Internal Combustion Engine Systems (Springer 2010), section 5.3"
    )

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """The frequency about which all runs' own lie; `shape_starts` finds it."""
        # The line that was found tells it to a run's spread. A wider belief would let a fit shift
        # it against the shares of all runs, which changes no record.
        scale = 10.0 * SPREAD
        return (Shape("freq_hz", "Hz", "frequency of the force", scale, lower=1.0, starts=(20.0,)),)

    def per_run(self, run: RunSetting) -> Sequence[Parameter]:
        """Cosine and sine part of the force; unless that is recorded, by how much the engine runs
        faster, and its wander."""
        force = (
            Amplitude("cos_m_s2", "m/s²", "cosine part of the force per mass of the body",
                      EXPECTED_M_S2),
            Amplitude("sin_m_s2", "m/s²", "sine part of the force per mass of the body",
                      EXPECTED_M_S2),
        )  # fmt: skip
        if run.known.engine is not None:
            return force
        history = self._history(run)
        # A wander of period T and relative size w gains a time of w T / 2π; T about 5 s.
        scale = WANDER * 5.0 / (2 * pi)
        return (
            *force,
            Shape("excess", "1", "frequency over that of all runs, less one", SPREAD,
                      lower=-0.5, upper=0.5, starts=(0.0,)),
            *history.parameters("s", "time gained by a faster engine", scale, is_shape=True),
        )  # fmt: skip

    def shape_starts(self, probe: Probe) -> Sequence[Values]:
        """The strongest lines of the residual's spectrum, near one frequency in all runs, whatever
        the vehicle's speed."""
        grid, step, total = np.exp(LOGARITHMS), LOGARITHMS[1] - LOGARITHMS[0], np.array(0.0)
        for known in (False, True):
            alike = [run for run in probe.settings if (run.known.engine is not None) == known]
            runs = [strength(*_turning(probe, run), grid) for run in alike]
            if runs:
                total = total + shared(np.array(runs), step, step if known else SPREAD, REACH)
        lines = []
        for _ in range(STARTS):
            best = int(np.argmax(total))
            lines.append({"freq_hz": float(grid[best])})
            total[np.abs(LOGARITHMS - LOGARITHMS[best]) < 2 * REACH * SPREAD] = -np.inf
        return lines

    def run_starts(self, probe: Probe, run: RunSetting, shapes: Values) -> Sequence[Values]:
        """The run's line near the shared frequency, and its phase as far as noise lets see it."""
        if run.known.engine is not None:
            return ({},)
        time, residual = _residual(probe, run)
        middle, near = (run.record_start_s + run.end_s) / 2, shapes["freq_hz"]
        excess = np.linspace(-REACH * SPREAD, REACH * SPREAD, 301)
        worth = strength(time, residual, near * (1 + excess)) - 0.5 * (excess / SPREAD) ** 2
        faster = float(excess[np.argmax(worth)])
        centres, phase, uncertain = phase_along(time, residual, near * (1 + faster))
        gained, uncertain = phase / (2 * pi * near), uncertain / (2 * pi * near)
        slope, level = np.polyfit(centres - middle, gained, 1, w=1.0 / uncertain)
        wander = gained - level - slope * (centres - middle)
        scale = WANDER * 5.0 / (2 * pi)
        start = {
            "excess": float(np.clip(faster + slope, excess[0], excess[-1])),
            **self._history(run).likely(centres, wander, uncertain, scale),
        }
        return (start,)

    def summary(self, runs: Sequence[OwnValues]) -> dict[str, float]:
        """Amplitude of the force and relative wander within a run, root mean squares over the runs;
        the frequencies' standard deviation from run to run, relative."""
        forces = [
            theta["body.mass_kg"] ** 2 * (theta["cos_m_s2"] ** 2 + theta["sin_m_s2"] ** 2)
            for _, theta, _ in runs
        ]
        found = {"force_N": float(np.sqrt(np.mean(forces)))}
        wanders = []
        for run, theta, _ in runs:
            if run.known.engine is not None:
                continue
            time = np.linspace(run.record_start_s, run.end_s, 400)
            gained = self._history(run).at(theta, time)
            wanders.append(0.0 if gained is None else float(np.var(gained[1])))
        shown = [(r.known.engine, theta) for r, theta, _ in runs if r.known.engine is not None]
        if shown and shown[0][0].stated_m_s > 0.0:
            engine, theta = shown[0]
            found["order"] = 2 * pi * theta["freq_hz"] / engine.stated_m_s
        if wanders:
            excess = [theta.get("excess", 0.0) for run, theta, _ in runs]
            found["spread_fraction"] = float(np.std(excess))
            found["wander_fraction"] = float(np.sqrt(np.mean(wanders)))
        return found

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """A force on the engine: on the body at its place, if it has no mount of its own."""
        parts.add_force(((vehicle["body.mass_kg"], node_of(vehicle, "engine")),))

    def forces(
        self, theta: Values, run: RunSetting, time_s: Array, way_m: Array, speed_m_s: Array
    ) -> Sequence[Array]:
        """History of the force per mass of the body."""
        angle = 2 * pi * theta["freq_hz"] * self._turned_s(theta, run, time_s)
        cosine, sine = theta.get("cos_m_s2", 0.0), theta.get("sin_m_s2", 0.0)
        return (cosine * np.cos(angle) + sine * np.sin(angle),)

    def _turned_s(self, theta: Values, run: RunSetting, time_s: Array) -> Array:
        """Angle of the engine since mid-record over its speed in all runs."""
        if run.known.engine is not None:
            return _as_shown(run, time_s)
        middle = (run.record_start_s + run.end_s) / 2
        turned_s = (1.0 + theta.get("excess", 0.0)) * (time_s - middle)
        gained = self._history(run).at(theta, time_s)
        return turned_s if gained is None else turned_s + gained[0]

    def _history(self, run: RunSetting) -> History:
        return History(run, KNOTS_S, "s")


def _residual(probe: Probe, run: RunSetting) -> tuple[Array, Array]:
    """Times (n,), and what the model leaves of the record (n, c)."""
    left = probe.measured(run.run_id) - probe.modelled(run.run_id, {})
    return probe.time_s(run.run_id), left


def _turning(probe: Probe, run: RunSetting) -> tuple[Array, Array]:
    """The same over the engine's angle, which goes on by equal steps, where that is known."""
    time, left = _residual(probe, run)
    if run.known.engine is None:
        return time, left
    turned = _as_shown(run, time)
    even = np.linspace(turned[0], turned[-1], len(turned))
    then = np.interp(even, turned, time)
    return even, np.stack([np.interp(then, time, channel) for channel in left.T], axis=1)


def _as_shown(run: RunSetting, time_s: Array) -> Array:
    """Angle since mid-record, as a channel shows it, over the mean speed of all runs, s."""
    engine = run.known.engine
    assert engine is not None
    middle = (run.record_start_s + run.end_s) / 2
    pace = engine.mean_m_s / (engine.stated_m_s or engine.mean_m_s)
    return np.asarray(pace * (engine.gone(time_s) - engine.gone(middle)))
