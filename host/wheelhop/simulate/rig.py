"""One run on a rig, simulated: a component m ẍ + c ẋ + k x + Σ p f(p x, p ẋ) = F.

An imposed force is integrated; along an imposed displacement the equation gives the force directly,
laws with memory going through the record step by step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import interpolate

from wheelhop.campaign import ComponentCampaign, RigRun
from wheelhop.effects import Effect, RunSetting
from wheelhop.simulate.imposed import forces
from wheelhop.simulate.laws import remembers
from wheelhop.simulate.model import Model
from wheelhop.simulate.oscillator import displacements
from wheelhop.simulate.run import STEP_S, Response
from wheelhop.simulate.unevenness import HeightSeries
from wheelhop.vehicle import Drive, Motion, System

Array = NDArray[np.float64]

STEPS_PER_PERIOD, LEAST_PER_PERIOD = 30, 10
"""Integration steps in a period of twice the component's own frequency, as laws stiffen what they
sit beside, or of the band's upper end if that is slower; and in one of the band's upper end at the
least. A hard spring at resonance comes out within 2e-4 so."""

INITIAL = ("initial_m", "initial_m_s", "offset_N")
"""What a run with imposed force leaves free: displacement and velocity at the first sample, and,
where no spring holds the component or it may be preloaded, a constant force beside that recorded.
"""


class RigSimulator:
    """Everything about one run on a rig that does not change from simulation to simulation."""

    drive: Drive = "rig"
    period_m: float | None = None
    series: HeightSeries | None = None

    def __init__(self, campaign: ComponentCampaign, run: RigRun) -> None:
        self.campaign, self.run, self.steps = campaign, run, 0
        begin, end = float(run.time_s[0]), float(run.time_s[-1])
        held = campaign.nominal["stiffness_N_m"] > 0.0 and not campaign.preloaded
        self.setting = RunSetting(run.id, 0.0, begin, begin, end, False, on_rig=True, is_held=held)
        self._motions: dict[int, Array] = {}
        self._forces: dict[int, Array] = {}

    def __getstate__(self) -> dict[str, object]:
        """All but what it remembers of models it has simulated."""
        return vars(self) | {"_motions": {}, "_forces": {}}

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
        return self.records([(model, system)])[0]

    def records(self, trials: Sequence[tuple[Model, System]]) -> list[Array]:
        """The same for several models; under a force they are integrated side by side."""
        return self._records([(*trial, self._stride(*trial)) for trial in trials])

    def changes(
        self, base: tuple[Model, System], trials: Sequence[tuple[Model, System]]
    ) -> list[Array]:
        """By how much the records of several models differ from that of `base`. Steps twice as long
        serve here: what is lost by them is nearly the same in both, and falls out."""
        strides = [self._stride(*trial, longer=2.0) for trial in trials]
        bases = {stride: i for i, stride in enumerate(sorted(set(strides)))}
        steps = [(*base, stride) for stride in bases]
        steps += [(*trial, stride) for trial, stride in zip(trials, strides, strict=True)]
        records = self._records(steps)
        others = zip(records[len(bases) :], strides, strict=True)
        return [record - records[bases[stride]] for record, stride in others]

    def _records(self, trials: Sequence[tuple[Model, System, int]]) -> list[Array]:
        """Records of several models, each at so many steps per sample."""
        self.steps += len(self.run.time_s) * sum(stride for _, _, stride in trials)
        alike: dict[tuple[Any, ...], list[int]] = {}
        for i, (_, system, stride) in enumerate(trials):
            alike.setdefault((stride, system.port_law, system.laws, system.port_by), []).append(i)
        answers = self._displacements if self.campaign.drive == "force" else self._measured_forces
        found = [np.empty(0)] * len(trials)
        for (stride, *_), places in alike.items():
            records = answers([trials[i][:2] for i in places], stride)
            for i, record in zip(places, records, strict=True):
                found[i] = record[:, None]
        return found

    def _displacements(self, trials: Sequence[tuple[Model, System]], stride: int) -> list[Array]:
        """How models of one make move under the force."""
        return displacements(
            [system for _, system in trials],
            [[*self._initial(one[0]), *self._begins(*one)] for one in trials],
            self._imposed(stride),
            self._weights(trials[0][1], 2 * stride),
            1.0 / (self.campaign.sample_rate_hz * stride),
            stride,
        )

    def _measured_forces(self, trials: Sequence[tuple[Model, System]], stride: int) -> list[Array]:
        """The forces of models of one make along the displacement."""
        return forces(
            [system for _, system in trials],
            [self._begins(*trial) for trial in trials],
            self.motion(stride),
            self._weights(trials[0][1], stride),
            1.0 / (self.campaign.sample_rate_hz * stride),
            stride,
        )

    def motion(self, stride: int) -> Array:
        """Recorded displacement, velocity and acceleration (3, T), in SI, at so many steps per
        sample."""
        if stride not in self._motions:
            self._motions[stride] = Motion(self.campaign, self.run).at(self._times(stride))
        return self._motions[stride]

    def _stride(self, model: Model, system: System, longer: float = 1.0) -> int:
        """Steps per sample; of an integration one of few numbers, that it rarely changes in a
        fit. Along an imposed displacement only laws with a memory go step by step."""
        step = min([STEP_S, *(effect.longest_step_s for effect in model.effects)])
        integrated = self.campaign.drive == "force"
        if not integrated and not any(map(remembers, system.laws)):
            return 1
        if integrated:
            highest_hz = self.campaign.band_hz[1]
            fastest = system.fastest_1_s
            per_second = STEPS_PER_PERIOD * min(highest_hz, fastest / np.pi)
            needed_hz = max(per_second, LEAST_PER_PERIOD * highest_hz) / longer
            step = min(step, 1.0 / max(needed_hz, fastest))
        needed = math.ceil(1.0 / (self.campaign.sample_rate_hz * step) - 1e-9)
        if not integrated or needed < 3:
            return needed
        whole: int = 2 ** math.ceil(math.log2(needed))
        return whole * 3 // 4 if needed <= whole * 3 // 4 else whole

    def _times(self, stride: int) -> Array:
        samples = np.arange(len(self.run.time_s))
        steps = np.arange(samples[-1] * stride + 1) / stride
        return np.asarray(np.interp(steps, samples, self.run.time_s))

    def _initial(self, model: Model) -> list[float]:
        own = model.runs[self.run.id]
        return [own[INITIAL[0]], own[INITIAL[1]], own.get(INITIAL[2], 0.0)]

    def _begins(self, model: Model, system: System) -> list[float]:
        """What the law of each port (p,) remembers as the run begins."""
        own = model.runs.get(self.run.id, {})
        return [own.get(name, 0.0) for name in system.port_begins]

    def _weights(self, system: System, stride: int) -> Array:
        """What each port's force is times (p, T); (0, 0) if none depends on an input."""
        if not any(system.port_by):
            return np.zeros((0, 0))
        time_s, run = self._times(stride), self.run
        inputs = {name: np.interp(time_s, run.time_s, run.inputs[name]) for name in run.inputs}
        return np.stack([inputs[by] if by else np.ones(len(time_s)) for by in system.port_by])

    def _imposed(self, stride: int) -> Array:
        """Recorded force (2T+1,) at half steps, at so many steps per sample."""
        if stride not in self._forces:
            spline = interpolate.CubicSpline(self.run.time_s, self.run.force)
            self._forces[stride] = spline(self._times(2 * stride))
        return self._forces[stride]
