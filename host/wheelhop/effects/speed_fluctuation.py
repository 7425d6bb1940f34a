"""The driver does not hold the speed: it wanders within a run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, OwnValues, Probe, RunSetting, Values
from wheelhop.effects.history import KNOTS_S, History
from wheelhop.effects.parameters import Parameter
from wheelhop.effects.phase import EXPECTED, shift_along


class SpeedFluctuation(Effect):
    """The distance gained over constant speed is a cubic spline in time, free in every run."""

    id = "speed-fluctuation"
    place = "speed"
    title = "the forward speed is not constant within a run"
    equation = (
        r"x(t) = x_0 + v t + \sum_j c_j B_j(t),"
        r"\quad B_j \text{ cubic B-splines, 0.4 s apart (slow) or 0.15 s (fast)}"
    )
    source = "thesis 4.3.1 (fluctuations on the high-severity washboard); C. de Boor's B-splines"
    needs_road = True

    def __init__(self, form: str = "slow") -> None:
        self._knot_s = KNOTS_S[form]

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """How fast it may change."""
        return tuple(KNOTS_S)

    def with_choice(self, choice: str) -> SpeedFluctuation:
        """A driver who lets the speed wander, or one who brakes and accelerates."""
        return SpeedFluctuation(choice)

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """All of it differs from run to run."""
        return ()

    def per_run(self, run: RunSetting) -> Sequence[Parameter]:
        """The spline's coefficients, metres."""
        if not run.on_road or run.speed_m_s <= 0:
            return ()
        # A wander of period T and relative size f moves the vehicle by v f T / 2π; T about 5 s.
        # Of a speed that a channel shows, only the channel's noise is left.
        noise = run.driven.noise_rms if run.driven else 0.0
        wander = min(EXPECTED * run.speed_m_s, noise or np.inf)
        scale = wander * 5.0 / (2 * np.pi)
        return History(run, self._knot_s).parameters("m", "distance gained", scale)

    def travel(
        self, theta: Values, run: RunSetting, time_s: Array, position_m: Array, speed_m_s: float
    ) -> tuple[Array, Array] | None:
        """All four wheels gain the same distance."""
        gained = History(run, self._knot_s).at(theta, time_s)
        if gained is None:
            return None
        gain, rate = gained
        return np.repeat(gain[:, None], 4, axis=1), np.repeat(rate[:, None], 4, axis=1)

    def summary(self, runs: Sequence[OwnValues]) -> dict[str, float]:
        """Wander over mean speed: root mean square, and its peak averaged over the runs."""
        shares, peaks = [], []
        for run, theta, _ in runs:
            time = np.linspace(run.record_start_s, run.end_s, 400)
            gained = History(run, self._knot_s).at(theta, time)
            if gained is not None:
                wander = (gained[1] - gained[1].mean()) / run.speed_m_s
                shares.append(np.mean(wander**2))
                peaks.append(np.abs(wander).max())
        if not shares:
            return {}
        rms = float(np.sqrt(np.mean(shares)))
        return {"rms_fraction": rms, "peak_fraction": float(np.mean(peaks))}

    def run_starts(self, probe: Probe, run: RunSetting, shapes: Values) -> Sequence[Values]:
        """Follow the phase of all channels along the track."""
        if not run.on_road or run.speed_m_s <= 0:
            return ({},)
        time, (ahead,) = shift_along(probe, run, range(4))
        return (History(run, self._knot_s).through(time, ahead),)
