"""One run, simulated: the road under the wheels (or measured axles), vehicle and sensors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len

from wheelhop.campaign import Campaign, Run
from wheelhop.campaign.known import known_of
from wheelhop.effects import Effect, RunSetting
from wheelhop.simulate.abreast import Sampling, integrate_jobs
from wheelhop.simulate.frequency import ForceResponse
from wheelhop.simulate.integrator import Task
from wheelhop.simulate.job import Job, moved_by, without_sensors
from wheelhop.simulate.lanes import LANES
from wheelhop.simulate.measured import driven_by, driving, measured_motion
from wheelhop.simulate.model import Model
from wheelhop.simulate.prescribed import (
    Prescribed,
    applied_forces,
    climbing,
    rise,
    span,
    track_of,
    ways,
    wheel_path,
)
from wheelhop.simulate.runge_kutta import STABLE
from wheelhop.simulate.sensors import as_recorded, sensed
from wheelhop.simulate.unevenness import HeightSeries, slowness
from wheelhop.track import CannotClimb, Wheel, make_track
from wheelhop.vehicle import System, axle_name, corner_position, motions, wheels
from wheelhop.vehicle.frame_modes import longest_step_s

Array = NDArray[np.float64]

STEP_S = 0.0025
"""Longest step of the integration, 1/40 of a period of wheel hop; effects may ask for less."""

KINK, KINKED_STEP_S = 0.05, 0.000625
"""Where the slope of the wheel's path jumps by more than this, no step hits the jump, and shorter
steps are taken: 2.5 ms leave an error of 18 % of the noise on sharp washboards, these 2 %."""

LEAST_RUN_UP_S, AFTER_S = 1.2, 0.2
"""Sensors, which may remember or read late, know the whole run-up, of at least this length, and so
much after the record, or a little more."""

REMEMBERED_S, REMEMBERED_M = 0.7, 3.0
"""Unknown heights begin this long before the record, and this far behind the front wheels: what
the vehicle remembers, and a wheelbase."""

REACH = 1.08
"""A run's speed lies within this factor of the nominal one, or nearly so."""

FARTHEST_M = 1e9
"""So far along a track places are still told apart by a micrometre."""

KEPT_MOTIONS = 2
AT_ONCE = 4 * LANES
"""Of hundreds of starts so many models, each with its motion of the ground, are held at once."""


@dataclass(frozen=True)
class Response:
    """What a model says a run should have measured.

    ``record`` is (n, n_channels) at the run's samples, in the channels' order and units; NaN
    columns are not predicted. ``position_m`` (n,) is the x of the front axle at each sample, None
    when the track is unknown. Where measured axles, or travel, drive the model, ``noise_ratio``
    (count, n_channels) is the noise that all sensors together make of every in-band datum about the
    model, per that of the datum's own sensor, and ``doubt`` the same with motion folded into the
    records that drive it; None where nothing of the kind does.
    """

    run_id: str
    record: Array
    position_m: Array | None
    doubt: Array | None = None
    noise_ratio: Array | None = None


class RunSimulator:
    """Everything about one run that does not change from simulation to simulation.

    Parameters
    ----------
    campaign, run
        What was recorded.
    run_up_s
        How long the vehicle drives before the first sample, so that its start is forgotten.
    """

    def __init__(self, campaign: Campaign, run: Run, run_up_s: float) -> None:
        self.campaign, self.run, self.steps = campaign, run, 0
        self.drive = driven_by(campaign, run)
        period = 1.0 / campaign.sample_rate_hz
        self._margin = math.ceil(2 * campaign.averaging.reach_s / period) + 1
        self._lead, self._before, self._after = self._margin, 0, 0
        if self.drive == "road":
            self._before = math.ceil(max(run_up_s, LEAST_RUN_UP_S) / period)
            known = self._before + len(run.time_s)
            # Readings go to frequencies and back: 1191 of them take six times as long as 1200.
            self._after = next_fast_len(known + math.ceil(AFTER_S / period), real=True) - known
            self._lead = self._margin + self._before
        self.setting = RunSetting(
            run.id,
            run.speed_m_s,
            float(run.time_s[0] - self._lead * period),
            float(run.time_s[0]),
            float(run.time_s[-1] + self._margin * period),
            self.drive == "road",
            by_travel=self.drive == "travel",
            course=run.course,
            driven=run.driven,
            known=known_of(campaign, run),
        )
        self._track = make_track(run.track) if self.drive == "road" else None
        self.series = self._series()
        self._done: list[Job] = []
        self._step_s: float | None = None
        self._instants: dict[int, Array] = {}
        self._motions: dict[tuple[object, ...], tuple[Array, Array]] = {}

    def __getstate__(self) -> dict[str, object]:
        """All but what it remembers of models it has simulated, compiled laws among it."""
        return vars(self) | {"_done": [], "_instants": {}, "_motions": {}}

    def _series(self) -> HeightSeries | None:
        """Heights for as long a way as the record shows."""
        if not self.setting.on_road or self.run.speed_m_s <= 0:
            return None
        seconds = self.setting.end_s - self.setting.record_start_s + REMEMBERED_S
        run, speeds = self.run, [self.run.speed_m_s]
        speeds += run.course.speed_m_s if run.course else ()
        speeds += [run.driven.speed_m_s.max()] if run.driven else ()
        length = max(speeds) * seconds + REACH * REMEMBERED_M
        return HeightSeries(length, math.ceil(self.campaign.band_hz[1] * length / min(speeds)))

    def stride(self, model: Model, system: System) -> int:
        """Integration steps per sample: what the wheel's path asks for, and what the effects do."""
        if self._step_s is None:
            self._step_s = KINKED_STEP_S if self._kinked(model) else STEP_S
        steps = [self._step_s, *(effect.longest_step_s for effect in model.effects)]
        return self._per_sample(model, system, steps)

    def _change_stride(self, model: Model, system: System) -> int:
        """The same for the difference of two records. Kinks of the path get no shorter steps here:
        what they spoil is nearly the same in both, and falls out of the difference."""
        steps = (e.change_step_s(model.theta(e, self.run.id), model.values) for e in model.effects)
        return self._per_sample(model, system, [STEP_S, *steps])

    def _per_sample(self, model: Model, system: System, steps_s: Sequence[float]) -> int:
        stable_s = max(STABLE / system.fastest_1_s, KINKED_STEP_S)  # what is stiffer runs away
        longest = min(longest_step_s(model.values), stable_s, *steps_s)
        return math.ceil(1.0 / (self.campaign.sample_rate_hz * longest) - 1e-9)

    def _kinked(self, model: Model) -> bool:
        """Whether a rigid wheel's path has kinks on this track."""
        if self._track is None:
            return False
        x = ways(model, self.setting, self._times(1))[0]
        rolling = (self._wheel(model, i, x[:, i]) for i in wheels(model.values))
        with climbing(self.campaign, self.run):
            return any(wheel.rigid().sharpest_kink > KINK for wheel in rolling)

    def _times(self, per_sample: int) -> Array:
        """The instants of so many steps per sample, from the run-up on."""
        if per_sample not in self._instants:
            samples = self._lead + len(self.run.time_s) - 1 + self._after + self._margin
            period = 1.0 / self.campaign.sample_rate_hz
            since = (np.arange(samples * per_sample + 1) / per_sample - self._lead) * period
            times = self._instants[per_sample] = self.run.time_s[0] + since
            times.setflags(write=False)  # every effect is given them
        return self._instants[per_sample]

    @property
    def period_m(self) -> float | None:
        """Length after which the run's track repeats; None if it does not, or is not known."""
        return None if self._track is None else self._track.period_m

    def acts(self, effect: Effect) -> bool:
        """Whether the effect can act in this run."""
        return effect.acts_in(self.setting)

    def simulate(self, model: Model, system: System) -> Response:
        """Response of `model`, whose equations of motion for this run's drive are `system`."""
        return Response(self.run.id, self.record(model, system), self._position(model))

    def record(self, model: Model, system: System) -> Array:
        """What the instrument gives (n, n_channels), in the channels' units."""
        return self.records([(model, system)])[0]

    def records(self, trials: Sequence[tuple[Model, System]]) -> list[Array]:
        """The same for several models with their equations of motion; side by side, they cost
        little more than one."""
        steps = [(*trial, self.stride(*trial)) for trial in trials]
        parts = (steps[i : i + AT_ONCE] for i in range(0, len(steps), AT_ONCE))
        return [record for part in parts for record in self._integrated(part)]

    def changes(
        self, base: tuple[Model, System], trials: Sequence[tuple[Model, System]]
    ) -> list[Array]:
        """By how much the records (n, n_channels) of several models differ from that of `base`."""
        strides = [self._change_stride(*trial) for trial in trials]
        bases = {stride: i for i, stride in enumerate(sorted(set(strides)))}
        steps = [(*base, stride) for stride in bases]
        steps += [(*trial, stride) for trial, stride in zip(trials, strides, strict=True)]
        records = self._integrated(steps)
        others = zip(records[len(bases) :], strides, strict=True)
        return [record - records[bases[stride]] for record, stride in others]

    def _integrated(self, trials: Sequence[tuple[Model, System, int]]) -> list[Array]:
        """Records of several models, each at so many steps per sample."""
        jobs, waiting = list[Job](), list[Job]()
        bases = {job.base: job for job in self._done}
        for model, system, stride in trials:
            # What the others are held against comes first, in steps of one length or of two.
            job = self.job(model, system, stride, [*jobs[:2], *jobs[-1:], *self._done])
            if job.acceleration is None and job not in waiting:
                base = bases.setdefault(job.base, job)
                if base is job or not system.is_linear or self.drive != "road":
                    waiting.append(job)
                    alike = sum(other.make == job.make for other in waiting)
                    if alike == LANES:
                        self._integrate(waiting)
                else:
                    if base in waiting:
                        self._integrate(waiting)
                    job.acceleration = self._superposed(base, job)
            jobs.append(job)
        self._integrate(waiting)
        # What only sensors or a force change is asked for next: about the first, or the last.
        self._done = [*jobs[:1], *jobs[-1:]] if self.drive == "road" else []
        return [self._sensed_by(job, trial[0]) for job, trial in zip(jobs, trials, strict=True)]

    def _sensed_by(self, job: Job, model: Model) -> Array:
        """What the instrument makes of the true accelerations, at the run's samples."""
        assert job.acceleration is not None
        per_sample, campaign = job.per_sample, self.campaign
        faults = [(e, model.theta(e, self.run.id)) for e in model.effects if self.acts(e)]
        first, rate_hz = self._before * per_sample, campaign.sample_rate_hz * per_sample
        readings = sensed(job.acceleration, rate_hz, first, faults, campaign.channels)
        return self.at_samples(as_recorded(readings, rate_hz, campaign, model.values), per_sample)

    def at_samples(self, shown: Array, per_sample: int) -> Array:
        """The record's samples (n, outputs) of what a job's steps show, so many per sample."""
        return shown[self._before * per_sample :: per_sample][: len(self.run.time_s)]

    def job(self, model: Model, system: System, stride: int, known: Sequence[Job] = ()) -> Job:
        """The job that a model asks for, or one of those `known` that does."""
        # Sensors' faults and filters act before a sample is taken: on every step.
        finely = any(self.campaign.filters) or any(e.place == "sensor" for e in model.effects)
        per_sample = stride if finely else 1
        key = (stride, per_sample, without_sensors(model, self.run.id, self.campaign.channels))
        same = next((job for job in known if job.key == key), None)
        if same is not None and self.drive == "road":
            return same
        mover = self._mover(model, stride)
        like = next((job for job in known if job.mover == mover), None)
        height, rate = (like.height, like.rate) if like else self._motion(model, stride)
        return Job(model, system, height, rate, stride, per_sample, key, mover)

    def due(self, model: Model, system: System) -> Job | None:
        """What has to be integrated for the record of a model, if anything has: then it may be done
        beside that of other runs, and kept."""
        if self.drive != "road":
            return None
        job = self.job(model, system, self.stride(model, system), self._done)
        superposed = system.is_linear and job.base in [other.base for other in self._done]
        return None if superposed or job.acceleration is not None else job

    def keep(self, job: Job) -> None:
        """The next record is that of this job."""
        self._done.append(job)

    def _integrate(self, waiting: list[Job]) -> None:
        integrate_jobs((self, job) for job in waiting)
        waiting.clear()

    def task(self, job: Job) -> Task:
        """What the integrator is told of a job."""
        forces = self._forces(job.model, job.system, self._times(2 * job.stride))
        initial = self._initial(job.model, job.system)
        return Task(job.system, job.height, job.rate, forces, initial)

    def sampling(self, job: Job) -> Sampling:
        """Which of its steps are sampled."""
        step_s = 1.0 / (self.campaign.sample_rate_hz * job.stride)
        first = (self._lead - self._before) * job.stride
        return Sampling(step_s, first, job.stride // job.per_sample, self.campaign.averaging)

    def samples(self, job: Job) -> int:
        """How many samples."""
        return (self._before + len(self.run.time_s) + self._after) * job.per_sample

    def _superposed(self, base: Job, job: Job) -> Array:
        """What is known of `base` plus the response to the change of the applied forces, all that
        differs: derivatives of a force's history cost next to nothing."""
        assert base.acceleration is not None
        per_sample, time_s = job.per_sample, self._times(job.per_sample)
        change = self._forces(job.model, job.system, time_s)
        change = change - self._forces(base.model, base.system, time_s)
        if base.response is None:
            base.response = ForceResponse(
                base.system,
                len(time_s),
                self._lead * per_sample,
                1.0 / (self.campaign.sample_rate_hz * per_sample),
                self.campaign.averaging,
            )
        first = (self._lead - self._before) * per_sample
        rise = base.response(change)[first : first + len(base.acceleration)]
        return np.asarray(base.acceleration + rise)

    def _forces(self, model: Model, system: System, time_s: Array) -> Array:
        """Applied forces (T, k), N."""
        if not system.force.shape[1]:
            return np.zeros((len(time_s), 0))
        return applied_forces(model, filter(self.acts, model.effects), self.setting, time_s)

    def prescribed(self, model: Model, system: System) -> Prescribed:
        """What moves a model from the beginning of the run-up to after the record."""
        steps = [STEP_S, *(effect.longest_step_s for effect in model.effects)]
        stride = self._per_sample(model, system, steps)
        force = self._forces(model, system, self._times(stride))
        return Prescribed(*self._motion(model, stride), force, stride, self._lead * stride)

    def _motion(self, model: Model, stride: int) -> tuple[Array, Array]:
        """Prescribed motions and rates (T, wheels), m and m/s; the last few are kept."""
        mover = self._mover(model, stride)
        motion = self._motions.pop(mover, None)
        if motion is None:
            make = self._road if self.drive == "road" else self._measured
            motion = make(model, self._times(stride))
            while len(self._motions) >= KEPT_MOTIONS:
                del self._motions[next(iter(self._motions))]
        self._motions[mover] = motion  # the last to go
        return motion

    def _mover(self, model: Model, stride: int) -> tuple[object, ...]:
        """What the motion follows from, at so many steps per sample."""
        columns = driving(self.campaign, self.drive).values()
        measured = [self.campaign.channels[i] for i in columns]
        return (stride, *moved_by(model, self.run.id, measured))

    def way(self, model: Model) -> Array:
        """Distance (n, 4), m, each wheel has come along the track at the run's samples."""
        return ways(model, self.setting, self.run.time_s)[0]

    def _wheel(self, model: Model, corner: int, way_m: Array) -> Wheel:
        assert self._track is not None
        wheel = f"wheel.{axle_name(corner)}"
        radius, width = model.values[f"{wheel}.radius_m"], model.values.get(f"{wheel}.width_m", 0.0)
        y = corner_position(model.values, corner)[1]
        track = track_of(model, self.run, self._track)
        return Wheel(track, y, radius, *span(track, way_m), width)

    def _road(self, model: Model, time_s: Array) -> tuple[Array, Array]:
        x, speed = ways(model, self.setting, time_s)
        rolling = list(wheels(model.values))
        # Where a fit runs away, what it leads to costs infinitely much.
        nowhere = np.full((len(x), len(rolling)), np.nan)
        if not (np.abs(x) < FARTHEST_M).all():
            return nowhere, nowhere
        height, rate = np.empty((2, len(x), len(rolling)))
        for j, i in enumerate(rolling):
            wheel = self._wheel(model, i, x[:, i])
            try:
                height[:, j], slope = wheel_path(model, i, wheel).height_and_slope(x[:, i])
            except CannotClimb:
                return nowhere, nowhere
            rate[:, j] = slope * speed[:, i]
        if self.series is not None and self.run.id in model.heights:
            slow = slowness(model, self.run)
            way = slow * (x - model.start_m(self.run.id))
            more, slopes = self.series.at(model.heights[self.run.id], way)
            height, rate = height + more[:, rolling], rate + (slow * slopes * speed)[:, rolling]
        rise(time_s, height, rate)
        return height, rate

    def _measured(self, model: Model, time_s: Array) -> tuple[Array, Array]:
        asked = self.campaign, self.run, self.drive, model, self._margin
        return measured_motion(*asked, time_s)

    def _initial(self, model: Model, system: System) -> Array:
        """State (2 n,) at the first step: rest, or what a run on measured axles leaves free."""
        n, state = len(system.mass), np.zeros(2 * len(system.mass))
        free = model.runs.get(self.run.id, {})
        for i, name in enumerate(motions(model.values)):
            state[i] = free.get(f"initial_{name}", 0.0)
            state[n + i] = free.get(f"initial_{name}_rate", 0.0)
        return state

    def _position(self, model: Model) -> Array | None:
        return None if self._track is None else np.asarray(self.way(model)[:, :2].mean(axis=1))
