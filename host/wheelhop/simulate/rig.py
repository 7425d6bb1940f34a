"""One run on a rig, simulated: a component m ẍ + c ẋ + k x + Σ p f(p x, p ẋ) = F.

An imposed force is integrated; along an imposed displacement the equation gives the force directly,
laws with memory going through the record step by step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numba
import numpy as np
from numpy.typing import NDArray
from scipy import interpolate

from wheelhop.campaign import ComponentCampaign, RigRun
from wheelhop.effects import Effect, RunSetting
from wheelhop.simulate.integrator import padded
from wheelhop.simulate.model import Model
from wheelhop.simulate.run import STEP_S, Response
from wheelhop.simulate.unevenness import HeightSeries
from wheelhop.vehicle import Drive, Motion, System

Array = NDArray[np.float64]

STEPS_PER_PERIOD = 25
"""Integration steps in a period of the band's upper end, at the least: laws stiffen what they sit
beside. A hard spring at resonance comes out within 1e-4 so."""

FAR_M = 1e3
"""A component that has come so far has run away."""

INITIAL = ("initial_m", "initial_m_s")
"""Displacement and velocity at the first sample, which a run with imposed force leaves free."""


class RigSimulator:
    """Everything about one run on a rig that does not change from simulation to simulation."""

    drive: Drive = "rig"
    period_m: float | None = None
    series: HeightSeries | None = None

    def __init__(self, campaign: ComponentCampaign, run: RigRun) -> None:
        self.campaign, self.run = campaign, run
        begin, end = float(run.time_s[0]), float(run.time_s[-1])
        self.setting = RunSetting(run.id, 0.0, begin, begin, end, on_road=False, on_rig=True)
        self._motions: dict[int, Array] = {}
        self._forces: dict[int, Array] = {}

    def acts(self, effect: Effect) -> bool:
        """Whether the effect can act on a component."""
        return effect.acts_in(self.setting)

    def way(self, model: Model) -> Array:
        """Nothing rolls on a rig: zeros (n, 4)."""
        return np.zeros((len(self.run.time_s), 4))

    def simulate(self, model: Model, system: System) -> Response:
        """Response of `model`, whose equation of motion is `system`."""
        return Response(self.run.id, self.record(model, system), None)

    def record(self, model: Model, system: System) -> Array:
        """What the rig should have measured (n, 1): force, N, or displacement, m."""
        longest = min([STEP_S, *(effect.longest_step_s for effect in model.effects)])
        if self.campaign.drive == "displacement":
            return self._force(system, self._stride(longest))[:, None]
        own = model.runs[self.run.id]
        start = [own[name] for name in INITIAL]
        return self._displacement(system, self._stable(system, longest), start)[:, None]

    def changes(
        self, base: tuple[Model, System], trials: Sequence[tuple[Model, System]]
    ) -> list[Array]:
        """By how much the records of several models differ from that of `base`."""
        record = self.record(*base)
        return [other - record for other in self.records(trials)]

    def records(self, trials: Sequence[tuple[Model, System]]) -> list[Array]:
        """The same for several models."""
        return [self.record(model, system) for model, system in trials]

    def motion(self, stride: int) -> Array:
        """Recorded displacement, velocity and acceleration (3, T), in SI, at so many steps per
        sample."""
        if stride not in self._motions:
            self._motions[stride] = Motion(self.campaign, self.run).at(self._times(stride))
        return self._motions[stride]

    def _stride(self, longest_s: float) -> int:
        """Steps per sample."""
        return math.ceil(1.0 / (self.campaign.sample_rate_hz * longest_s) - 1e-9)

    def _stable(self, system: System, longest_s: float) -> int:
        """The same for an integration; a power of two, so that it rarely changes in a fit."""
        fastest = float(np.abs(system.poles()).max())
        step = min(longest_s, 1.0 / (STEPS_PER_PERIOD * self.campaign.band_hz[1]), 1.0 / fastest)
        return int(2 ** math.ceil(math.log2(self._stride(step))))

    def _times(self, stride: int) -> Array:
        samples = np.arange(len(self.run.time_s))
        steps = np.arange(samples[-1] * stride + 1) / stride
        return np.asarray(np.interp(steps, samples, self.run.time_s))

    def _force(self, system: System, stride: int) -> Array:
        x, v, a = self.motion(stride)
        linear = system.mass[0, 0] * a + system.damping[0, 0] * v + system.stiffness[0, 0] * x
        laws = _follow(x, v, 1.0 / (self.campaign.sample_rate_hz * stride), *_ports(system))
        return np.asarray((linear + laws)[::stride])

    def _imposed(self, stride: int) -> Array:
        """Recorded force (2T+1,) at half steps, at so many steps per sample."""
        if stride not in self._forces:
            spline = interpolate.CubicSpline(self.run.time_s, self.run.force)
            self._forces[stride] = spline(self._times(2 * stride))
        return self._forces[stride]

    def _displacement(self, system: System, stride: int, start: list[float]) -> Array:
        return np.asarray(
            _integrate(
                system.mass[0, 0],
                system.damping[0, 0],
                system.stiffness[0, 0],
                self._imposed(stride),
                start[0],
                start[1],
                1.0 / (self.campaign.sample_rate_hz * stride),
                stride,
                *_ports(system),
            )
        )


def _ports(system: System) -> tuple[object, ...]:
    """The force laws as the loops below take them: coefficients p, laws, their parameters."""
    return (
        np.ascontiguousarray(system.port[:, 0]),
        np.array(system.port_law, dtype=np.int64),
        padded(system.laws),
        system.law_parameters,
    )


@numba.njit(cache=True, nogil=True, error_model="numpy")
def _follow(x, v, dt, p, port_law, laws, law_par):  # type: ignore[no-untyped-def]
    """Force (T,) of the laws along a motion x, v (T,)."""
    total = np.zeros(len(x))
    for port in range(len(p)):
        law, memory, before = port_law[port], 0.0, x[0]
        for t in range(len(x)):
            force, memory = laws[law](
                p[port] * x[t], p[port] * v[t], p[port] * (x[t] - before), dt * min(t, 1),
                memory, law_par[port],
            )  # fmt: skip
            total[t] += p[port] * force
            before = x[t]
    return total


@numba.njit(cache=True, nogil=True, error_model="numpy")
def _integrate(  # type: ignore[no-untyped-def]
    mass, damping, stiffness, w, x0, v0, dt, stride, p, port_law, laws, law_par
):
    """Displacement at every `stride`-th step under the force w (2T+1,), given at half steps;
    classical Runge–Kutta of fourth order, memories advanced at the end of each step."""
    steps = len(w) // 2
    out = np.empty(steps // stride + 1)
    memory = np.zeros(len(p))
    x, v = x0, v0
    out[0] = x
    for t in range(steps):
        trial_x, trial_v, change_x, change_v = x, v, 0.0, 0.0
        for stage in range(4):
            elapsed = 0.5 * dt * ((stage + 1) // 2)
            force = w[2 * t + (stage + 1) // 2] - damping * trial_v - stiffness * trial_x
            for port in range(len(p)):
                own, _ = laws[port_law[port]](
                    p[port] * trial_x, p[port] * trial_v, p[port] * (trial_x - x), elapsed,
                    memory[port], law_par[port],
                )  # fmt: skip
                force -= p[port] * own
            weight = 1.0 if stage == 0 or stage == 3 else 2.0
            change_x += weight * trial_v
            change_v += weight * force / mass
            advance = 0.5 * dt if stage < 2 else dt
            trial_x, trial_v = x + advance * trial_v, v + advance * force / mass
        before = x
        x += dt / 6.0 * change_x
        v += dt / 6.0 * change_v
        for port in range(len(p)):
            _, memory[port] = laws[port_law[port]](
                p[port] * x, p[port] * v, p[port] * (x - before), dt, memory[port], law_par[port]
            )
        if (t + 1) % stride == 0:
            out[(t + 1) // stride] = x
        if not -FAR_M < x < FAR_M:
            out[(t + 1) // stride :] = np.nan
            break
    return out
