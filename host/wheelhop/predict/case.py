"""A vehicle with effects, on its way over tracks: what is simulated, and the model of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, CampaignError, Channel, Run
from wheelhop.campaign.write import DEFAULT_BAND_HZ
from wheelhop.effects import Parameter, RandomHeights
from wheelhop.files import did_you_mean
from wheelhop.fit.bench import RUNS_AWAY, run_up
from wheelhop.predict.drives import CHANNELS, Chosen, Drive
from wheelhop.simulate import Model
from wheelhop.simulate.motion import Motion, MotionSimulator
from wheelhop.vehicle import System, Vehicle, wheels

Array = NDArray[np.float64]
SAMPLE_RATE_HZ = 100.0
AVERAGING_S = 0.010
"""Of the logger at its usual rate: 8 conversions of 8 channels a sample."""
SECONDS = 10.24
"""Of a run, thesis section 5.2."""
FLAT_S = 1.5
"""A track that begins somewhere is reached so long after the record has begun."""
WANDER_RAD_S = 2 * np.pi / 5.0
"""What an effect leaves free along a run, a driver's speed say, wanders with about this period."""
STILL_1_S = 1e-9
"""A vehicle whose motion grows no faster than this stays in its place: poles are that exact."""
LONGEST_PERIOD_M = 100.0
"""The start of a run is drawn from one period of a track; a random road does not repeat sooner."""


@dataclass(frozen=True, eq=False)
class Case:
    """What is to be simulated. `seed` draws where each run starts and what effects leave free in
    each run; a run's record does not depend on the runs that come after it.

    Raises CampaignError for a parameter no effect has or that is outside its bounds, and for a
    vehicle that is not stable.
    """

    vehicle: Vehicle
    effects: tuple[Chosen, ...]
    drives: tuple[Drive, ...]
    seconds: float = SECONDS
    seed: int = 0

    def __post_init__(self) -> None:
        for chosen in self.effects:
            if not chosen.effect.applies_to(self.vehicle.values):
                raise CampaignError(f"--with {chosen.effect.id}: does not apply to this vehicle")
        setting = self._simulator(0, SAMPLE_RATE_HZ, 0.0, 0.0).setting
        for chosen in self.effects:
            parameters = chosen.effect.parameters_for(self.vehicle.values, self.channels)
            _check_known(chosen, [*parameters, *chosen.effect.per_run(setting)])
        check_stable(self.system)

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """What is recorded: the points of the corners that have a wheel."""
        return channels_of(self.vehicle)

    @cached_property
    def nominal(self) -> Model:
        """The vehicle with its effects, as far as these are alike in all runs."""
        return model_of(self.vehicle, self.effects)

    @cached_property
    def system(self) -> System:
        """The equations of motion."""
        return self.nominal.system(self.channels, "road")

    @RUNS_AWAY
    def record(self, number: int, rate_hz: float, averaging_s: float, lead_s: float = 0.0) -> Array:
        """Accelerations (n, channels), m/s², of a run, without noise; they begin `lead_s` early and
        end as much late. Raises CampaignError where the simulation runs away."""
        simulator = self._simulator(number, rate_hz, averaging_s, lead_s)
        record = simulator.record(self._model(number, simulator), self.system)
        if not np.isfinite(record).all():
            raise self.runs_away(number)
        return record

    def runs_away(self, number: int) -> CampaignError:
        """What there is to say where the simulation of a run does not stay finite."""
        return CampaignError(
            f"run {self.drives[number].id}: the simulation runs away: in large motion the vehicle"
            " is not stable, or something is far too stiff for its mass"
        )

    @RUNS_AWAY
    def motion(self, number: int) -> Motion:
        """All that moves in a run, from rest on."""
        simulator, model = self.prepared(number)
        motion = simulator.motion(model, self.system)
        if not np.isfinite(motion.displacement).all():
            raise self.runs_away(number)
        return motion

    def prepared(self, number: int, run_up_s: float = 0.0) -> tuple[MotionSimulator, Model]:
        """The simulator of a run and its model, for who asks the same run many times; it runs up
        for `run_up_s` at least."""
        simulator = self._simulator(number, SAMPLE_RATE_HZ, 0.0, 0.0, run_up_s)
        return simulator, self._model(number, simulator)

    def campaign(self, noise_rms: float) -> tuple[Campaign, Model]:
        """All drives as an ideal instrument would record them, all of them to be fitted, and the
        model that they come from; `noise_rms`, m/s² in band of a channel, is stated and not added.

        Raises CampaignError where a simulation runs away.
        """
        model, runs = self.nominal, []
        for number, drive in enumerate(self.drives):
            simulator = self._simulator(number, SAMPLE_RATE_HZ, AVERAGING_S, 0.0)
            model = model.with_run(drive.id, self._model(number, simulator).runs[drive.id])
            record = self.record(number, SAMPLE_RATE_HZ, AVERAGING_S)
            runs.append(replace(simulator.run, role="fit", record=record))
        whole = self._campaign(tuple(runs), SAMPLE_RATE_HZ, AVERAGING_S)
        return replace(whole, noise_rms=noise_rms), model

    def _simulator(
        self,
        number: int,
        rate_hz: float,
        averaging_s: float,
        lead_s: float,
        run_up_s: float = 0.0,
    ) -> MotionSimulator:
        drive = self.drives[number]
        time_s = np.arange(round((self.seconds + 2 * lead_s) * rate_hz)) / rate_hz - lead_s
        run = Run(
            drive.id,
            Path(drive.id),
            drive.role,
            drive.speed_kmph / 3.6,
            drive.track,
            time_s,
            np.zeros((len(time_s), len(self.channels))),
            course=drive.course,
        )
        campaign = self._campaign((run,), rate_hz, averaging_s)
        return MotionSimulator(campaign, run, max(run_up({"road": self.system}), run_up_s))

    def _campaign(self, runs: tuple[Run, ...], rate_hz: float, averaging_s: float) -> Campaign:
        return Campaign(
            Path(),
            self.vehicle.name,
            Path(),
            rate_hz,
            DEFAULT_BAND_HZ,
            averaging_s,
            None,
            self.channels,
            runs,
        )

    def _model(self, number: int, simulator: MotionSimulator) -> Model:
        """The model, with what differs from run to run: each run has its own random numbers."""
        rng = np.random.default_rng([self.seed, number])
        drive, run = self.drives[number], simulator.run
        start = -FLAT_S * run.speed_m_s
        if run.course is not None:
            start = float(run.course.place(-FLAT_S))
        elif simulator.period_m is not None:
            start = rng.uniform(0.0, min(simulator.period_m, LONGEST_PERIOD_M))
        own = {"speed_m_s": run.speed_m_s, "start_m": float(start)}
        model = self.nominal
        for chosen in self.effects:
            effect = chosen.effect
            turn, phase = rng.uniform(0.8, 1.25) * WANDER_RAD_S, rng.uniform(0.0, 2 * np.pi)
            for p in effect.per_run(simulator.setting):
                middle = p.start
                deviation = rng.normal()
                if np.isfinite(p.span_s).all():
                    deviation = np.sqrt(2) * np.sin(turn * np.mean(p.span_s) + phase)
                drawn = float(np.clip(middle + p.scale * deviation, p.lower, p.upper))
                own[f"{effect.id}.{p.name}"] = _stated(chosen, p, drawn)
            if isinstance(effect, RandomHeights) and simulator.series is not None:
                series = simulator.series
                density = effect.height_density(model.theta(effect), series.wave_number_rad_m)
                model = model.with_heights({drive.id: series.drawn(density, rng)})
        return model.with_run(drive.id, own)


def channels_of(vehicle: Vehicle) -> tuple[Channel, ...]:
    """The logger's channels at the corners that have a wheel."""
    there = wheels(vehicle.values)
    return tuple(channel for channel in CHANNELS if channel.corner in there)


def model_of(vehicle: Vehicle, effects: Sequence[Chosen]) -> Model:
    """A vehicle with effects, as far as these are alike in all runs; numbers that are not stated
    are such that the effect shows clearly. Raises CampaignError for one outside its bounds."""
    model, channels = Model(values=vehicle.values), channels_of(vehicle)
    for chosen in effects:
        parameters = chosen.effect.parameters_for(vehicle.values, channels)
        values = {f"{chosen.effect.id}.{p.name}": _stated(chosen, p, p.typical) for p in parameters}
        model = model.with_effect(chosen.effect, parameters).with_values(values)
    return model


def _stated(chosen: Chosen, parameter: Parameter, otherwise: float) -> float:
    """The value of a parameter, within its bounds."""
    value = chosen.values.get(parameter.name, otherwise)
    if not parameter.lower <= value <= parameter.upper:
        raise CampaignError(
            f"--with {chosen.effect.id}: {parameter.name} = {value:g} must be within "
            f"{parameter.lower:g} … {parameter.upper:g}"
        )
    return value


def _check_known(chosen: Chosen, parameters: Sequence[Parameter]) -> None:
    names = [parameter.name for parameter in parameters]
    if not names:
        raise CampaignError(f"--with {chosen.effect.id}: does not apply to this vehicle")
    for name in chosen.values:
        if name not in names:
            few = [n for n in names if not n.startswith("coefficient_")]
            near = did_you_mean(name, names) or f"; it has {', '.join(few) or 'none to state'}"
            raise CampaignError(f"--with {chosen.effect.id}: has no parameter {name}{near}")


def stands(system: System) -> bool:
    """Whether a vehicle stays in its place."""
    heavy = np.linalg.eigvalsh(system.mass).min() > 0.0
    return bool(heavy and system.poles().real.max() <= STILL_1_S)


def check_stable(system: System) -> None:
    """Raise CampaignError for a vehicle that does not stay in its place."""
    if np.linalg.eigvalsh(system.mass).min() <= 0.0:
        raise CampaignError("the vehicle: more mass or inertia is taken out of it than it has")
    growth = float(system.poles().real.max())
    if growth > STILL_1_S:
        raise CampaignError(
            f"the vehicle is not stable: it leaves its place by a factor e in {1 / growth:.2g} s; "
            "look at its stiffnesses, and those of the effects"
        )
