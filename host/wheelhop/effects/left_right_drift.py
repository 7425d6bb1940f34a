"""Left and right wheels travel different distances."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, Parameter, RunSetting, Values

WAVES = 4


class LeftRightDrift(Effect):
    """How far the left wheels are ahead of the right ones: a line and slow waves, per run."""

    id = "left-right-drift"
    place = "speed"
    title = "left and right wheels travel different distances (no differential, slip, curved path)"
    equation = (
        r"x_\mathrm{left} - x_\mathrm{right} = d_0 + d_1\,s"
        r" + \sum_{j=1}^{4} w_j \sin \pi j s,\quad s = 0 \ldots 1 \text{ over the run}"
    )
    source = "thesis 4.3.1: the vehicle has no differential and the tracks are not exactly straight"
    needs_road = True

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """All of it differs from run to run."""
        return ()

    def per_run(self, run: RunSetting) -> Sequence[Parameter]:
        """Lead at the start, growth over the run, slow waves; metres."""
        if not run.on_road or run.speed_m_s <= 0:
            return ()
        waves = (
            Parameter(f"wave_{j}_m", "m", f"wave {j} of the lead", 0.03 / j)
            for j in range(1, WAVES + 1)
        )
        return (
            Parameter("lead_m", "m", "lead of the left wheels when the record begins", 0.03),
            Parameter("growth_m", "m", "growth of the lead over the record", 0.1),
            *waves,
        )

    def travel(
        self, theta: Values, run: RunSetting, time_s: Array, position_m: Array, speed_m_s: float
    ) -> tuple[Array, Array] | None:
        """Half the lead to the left wheels, half taken from the right ones."""
        if "growth_m" not in theta:
            return None
        duration = run.end_s - run.record_start_s
        share = np.clip((time_s - run.record_start_s) / duration, 0.0, 1.0)
        moving = (time_s >= run.record_start_s) / duration
        lead = theta["lead_m"] + theta["growth_m"] * share
        rate = theta["growth_m"] * moving
        for j in range(1, WAVES + 1):
            wave = theta[f"wave_{j}_m"]
            lead = lead + wave * np.sin(np.pi * j * share)
            rate = rate + wave * np.pi * j * np.cos(np.pi * j * share) * moving
        side = np.array([0.5, -0.5, 0.5, -0.5])
        return lead[:, None] * side, rate[:, None] * side

    def summary(self, runs: Sequence[tuple[RunSetting, Values]]) -> dict[str, float]:
        """Lead gained per metre driven, root mean square over the runs."""
        rates = [
            theta["growth_m"] / (run.speed_m_s * (run.end_s - run.record_start_s))
            for run, theta in runs
            if "growth_m" in theta
        ]
        return {"relative_rate": float(np.sqrt(np.mean(np.square(rates))))} if rates else {}
