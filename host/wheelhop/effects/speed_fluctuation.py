"""The driver does not hold the speed: it wanders within a run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, Parameter, Probe, RunSetting, Values
from wheelhop.effects.history import History

KNOT_S = 0.4
"""Spacing of the spline's knots: a wander of 2.5 s period is followed to 0.1 %."""

EXPECTED = 0.04
"""Relative size of the wander believed of a driver who holds the speed by hand."""

WINDOW_S = 1.0


class SpeedFluctuation(Effect):
    """The distance gained over constant speed is a cubic spline in time, free in every run."""

    id = "speed-fluctuation"
    place = "speed"
    title = "the forward speed is not constant within a run"
    equation = (
        r"x(t) = x_0 + v t + \sum_j c_j B_j(t),\quad B_j \text{ cubic B-splines, 0.4 s apart}"
    )
    source = "thesis 4.3.1 (fluctuations on the high-severity washboard); C. de Boor's B-splines"
    needs_road = True

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """All of it differs from run to run."""
        return ()

    def per_run(self, run: RunSetting) -> Sequence[Parameter]:
        """The spline's coefficients, metres."""
        if not run.on_road or run.speed_m_s <= 0:
            return ()
        # A wander of period T and relative size f moves the vehicle by v f T / 2π; T about 5 s.
        scale = EXPECTED * run.speed_m_s * 5.0 / (2 * np.pi)
        return History(run, KNOT_S).parameters("m", "distance gained", scale)

    def travel(
        self, theta: Values, run: RunSetting, time_s: Array, position_m: Array, speed_m_s: float
    ) -> tuple[Array, Array] | None:
        """All four wheels gain the same distance."""
        gained = History(run, KNOT_S).at(theta, time_s)
        if gained is None:
            return None
        gain, rate = gained
        return np.repeat(gain[:, None], 4, axis=1), np.repeat(rate[:, None], 4, axis=1)

    def summary(self, runs: Sequence[tuple[RunSetting, Values]]) -> dict[str, float]:
        """Wander over mean speed: root mean square, and its peak averaged over the runs."""
        shares, peaks = [], []
        for run, theta in runs:
            time = np.linspace(run.record_start_s, run.end_s, 400)
            gained = History(run, KNOT_S).at(theta, time)
            if gained is not None:
                wander = (gained[1] - gained[1].mean()) / run.speed_m_s
                shares.append(np.mean(wander**2))
                peaks.append(np.abs(wander).max())
        if not shares:
            return {}
        rms = float(np.sqrt(np.mean(shares)))
        return {"rms_fraction": rms, "peak_fraction": float(np.mean(peaks))}

    def run_start(self, probe: Probe, run: RunSetting) -> Values:
        """Follow the phase: in short windows the record agrees with the model shifted along the
        track; the cheapest smooth path through these shifts is the start."""
        if not run.on_road or run.speed_m_s <= 0:
            return {}
        centres, shifts, mismatch = _local_mismatch(probe, run)
        path = shifts[_cheapest_path(mismatch, shifts / run.speed_m_s, centres)]
        return History(run, KNOT_S).through(centres, path)


def _local_mismatch(probe: Probe, run: RunSetting) -> tuple[Array, Array, Array]:
    """Window centres (w,), s, shifts (s,), m, and Σ residual² / Σ record² (w, s) of each window
    when the model is shifted along the track."""
    time, record = probe.time_s(run.run_id), probe.measured(run.run_id)
    centres = np.arange(time[0] + WINDOW_S / 2, time[-1] - WINDOW_S / 2, WINDOW_S / 4)
    # The distance gained in 0.13 s: ± a third of a second's drive is more than drivers wander.
    shifts = run.speed_m_s * np.linspace(-0.13, 0.13, 35)
    inside = np.abs(time - centres[:, None]) <= WINDOW_S / 2
    energy = inside @ (record**2).sum(axis=1)
    mismatch = np.empty((len(centres), len(shifts)))
    modelled = probe.all_modelled(run.run_id, [{"start_m": float(shift)} for shift in shifts])
    for i, signal in enumerate(modelled):
        mismatch[:, i] = inside @ ((record - signal) ** 2).sum(axis=1) / energy
    return centres, shifts, mismatch


def _cheapest_path(mismatch: Array, shift_s: Array, centres: Array) -> NDArray[np.intp]:
    """Dynamic programming: mismatch along the path plus what changes of speed it asks for."""
    rate = (shift_s[:, None] - shift_s[None, :]) / (centres[1] - centres[0])
    change = 0.02 * (rate / EXPECTED) ** 2
    cost, came_from = mismatch[0], []
    for row in mismatch[1:]:
        total = cost[None, :] + change
        came_from.append(total.argmin(axis=1))
        cost = row + total.min(axis=1)
    path = [int(cost.argmin())]
    for back in reversed(came_from):
        path.append(int(back[path[-1]]))
    return np.array(path[::-1])
