"""The engine shakes the body, locked to time and not to the road."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np
from scipy import fft

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, OwnValues, Parameter, Probe, RunSetting, Values
from wheelhop.vehicle import Assembly, Body


class EngineVibration(Effect):
    """A harmonic vertical force at the engine; its phase and strength differ from run to run."""

    id = "engine-vibration"
    place = "body"
    title = "a harmonic force at the engine, locked to time and not to the road"
    equation = r"F = F_c \cos 2\pi f t + F_s \sin 2\pi f t"
    source = (
        "unbalance and firing order, e.g. H. Dresig, F. Holzweissig, Dynamics of Machinery, ch. 3"
    )

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """The frequency; where the line is strongest in the residual comes from `shape_starts`."""
        return (
            Parameter("freq_hz", "Hz", "frequency of the force", 10.0, lower=1.0, starts=(20.0,)),
        )

    def per_run(self, run: RunSetting) -> Sequence[Parameter]:
        """Cosine and sine part of the force."""
        return (
            Parameter("cos_N", "N", "cosine part of the force", 30.0),
            Parameter("sin_N", "N", "sine part of the force", 30.0),
        )

    def shape_starts(self, probe: Probe) -> Sequence[Values]:
        """The strongest lines of the residual's spectrum, added up over runs of any speed."""
        lines = []
        grid = np.arange(1.0, 45.0, 0.02)
        total = np.zeros_like(grid)
        for setting in probe.settings:
            time = probe.time_s(setting.run_id)
            residual = probe.measured(setting.run_id) - probe.modelled(setting.run_id, {})
            n = fft.next_fast_len(len(time) * 8)
            rate = (len(time) - 1) / (time[-1] - time[0])
            spectrum = np.abs(fft.rfft(residual * np.hanning(len(time))[:, None], n, axis=0)) ** 2
            power = spectrum.sum(axis=1)
            total += np.interp(grid, fft.rfftfreq(n, 1 / rate), power) / np.median(power)
        for _ in range(3):
            best = float(grid[np.argmax(total)])
            lines.append({"freq_hz": best})
            total[np.abs(grid - best) < 0.5] = 0.0
        return lines

    def summary(self, runs: Sequence[OwnValues]) -> dict[str, float]:
        """Amplitude of the force, root mean square over the runs."""
        power = [theta["cos_N"] ** 2 + theta["sin_N"] ** 2 for _, theta, _ in runs]
        return {"force_N": float(np.sqrt(np.mean(power)))}

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """A force at the engine's place."""
        engine = Body(vehicle.get("engine.x_m", 0.0), vehicle.get("engine.y_m", 0.0))
        parts.add_force(((1.0, engine),))

    def forces(
        self, theta: Values, run: RunSetting, time_s: Array, way_m: Array, speed_m_s: Array
    ) -> Sequence[Array]:
        """The force's history."""
        angle = 2 * pi * theta["freq_hz"] * time_s
        cosine, sine = theta.get("cos_N", 0.0), theta.get("sin_N", 0.0)
        return (cosine * np.cos(angle) + sine * np.sin(angle),)
