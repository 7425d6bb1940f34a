"""What switching an effect on does to the nominal vehicle, simulated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_simpson

from wheelhop.campaign import Campaign, Run, read_campaign
from wheelhop.compare import InBand
from wheelhop.effects import Amplitude, Effect, RandomHeights, RunSetting
from wheelhop.effects.acceleration_moment import KNOT_S, AccelerationMoment
from wheelhop.simulate import Model, RunSimulator
from wheelhop.simulate.prescribed import slow_part
from wheelhop.track import make_track, wheel_envelope
from wheelhop.vehicle import Vehicle, corner_position, read_vehicle

Array = NDArray[np.float64]

RATE_HZ = 800.0  # one integration step of every effect: both models are sampled at the same steps
DURATION_S = 6.4
RUN_UP_S = 6.0
STRENGTH = 0.5  # of an amplitude's scale, as in screening


@dataclass(frozen=True, eq=False)
class Stage:
    """The nominal vehicle of a campaign on the campaign's runs, finely sampled by ideal sensors."""

    campaign: Campaign
    vehicle: Vehicle
    model: Model
    noise_rms: float

    def setting(self, run: Run) -> RunSetting:
        """What an effect knows of a run."""
        return RunSimulator(self.campaign, run, RUN_UP_S).setting

    def heights(self, effect: RandomHeights, run: Run) -> NDArray[np.complex128]:
        """Heights of the ground as an effect's density has them."""
        series = RunSimulator(self.campaign, run, RUN_UP_S).series
        assert series is not None
        density = effect.height_density(strengths(effect, self), series.wave_number_rad_m)
        return series.drawn(density, np.random.default_rng(1))

    def response(self, model: Model, run: Run, run_up_s: float = RUN_UP_S) -> Array:
        """Accelerations (n, c), m/s²."""
        simulator = RunSimulator(self.campaign, run, run_up_s)
        return simulator.record(model, model.system(self.campaign.channels, "road"))


def set_stage(folder: Path) -> Stage:
    """The vehicle as vehicle.toml has it, every run at its nominal speed."""
    campaign = read_campaign(folder)
    vehicle = read_vehicle(campaign.vehicle_file)
    time = np.arange(round(DURATION_S * RATE_HZ)) / RATE_HZ
    silent = np.zeros((len(time), len(campaign.channels)))
    runs = tuple(replace(run, time_s=time, record=silent) for run in campaign.runs)
    own = {run.id: {"speed_m_s": run.speed_m_s, "start_m": 0.0} for run in runs}
    return Stage(
        replace(campaign, sample_rate_hz=RATE_HZ, averaging_s=0.0, runs=runs),
        vehicle,
        Model(vehicle.values, (), own),
        campaign.noise_rms or 0.0,
    )


def strengths(effect: Effect, stage: Stage) -> dict[str, float]:
    """Amplitudes at their visible strength, shapes at their first start, switches on."""
    parameters = effect.parameters_for(stage.vehicle.values, stage.campaign.channels)
    return {
        p.name: p.start + STRENGTH * p.scale if type(p) is Amplitude else p.typical
        for p in parameters
    }


def switched_on(
    model: Model,
    effect: Effect,
    settings: Sequence[RunSetting],
    values: Mapping[str, float],
    own_share: float = STRENGTH,
) -> Model:
    """The model with the effect at these values; what it leaves free in the runs of `settings`
    departs from absence by this share of its scale."""
    prefixed = {f"{effect.id}.{k}": v for k, v in values.items()}
    model = Model({**model.values, **prefixed}, (*model.effects, effect), model.runs)
    for setting in settings:
        free = [p for p in effect.per_run(setting) if isinstance(p, Amplitude)]
        own = {
            f"{effect.id}.{p.name}": p.absent + own_share * p.scale * share
            for p, share in zip(free, history(effect, len(free)), strict=True)
        }
        model = model.with_run(setting.run_id, own)
    return model


def history(effect: Effect, count: int) -> Array:
    """Shares of the scale for the amplitudes free in a run: distance won and lost again, a lead
    that grows, an acceleration that swings, a mount that nobody struck; for other effects all at
    once."""
    if effect.id == "sensor-mount":
        return np.zeros(count)
    if effect.id == "speed-fluctuation":
        return np.hanning(count)
    if effect.id == "left-right-drift":
        return np.linspace(0.0, 1.0, count)
    if isinstance(effect, AccelerationMoment):
        return np.asarray(np.sin(2 * np.pi * np.arange(count) * KNOT_S))  # of 1 s period
    return np.ones(count)


@dataclass(frozen=True, eq=False)
class Change:
    """The run on which an effect tells most: responses without and with it, (n, c), m/s²."""

    run: Run
    model: Model
    before: Array
    after: Array
    band: InBand

    @property
    def in_band(self) -> Array:
        """The change, in band."""
        return self.band.signal(self.after - self.before)


def most_telling(effect: Effect, stage: Stage) -> Change:
    """The run on which the change is the largest share of response and sensor noise, in band."""
    settings = [stage.setting(run) for run in stage.campaign.runs]
    model = switched_on(stage.model, effect, settings, strengths(effect, stage))
    if isinstance(effect, RandomHeights):
        runs = stage.campaign.runs
        model = model.with_heights({run.id: stage.heights(effect, run) for run in runs})
    changes = []
    for run in stage.campaign.runs:
        band = InBand(len(run.time_s), RATE_HZ, stage.campaign.band_hz)
        before, after = stage.response(stage.model, run), stage.response(model, run)
        changes.append(Change(run, model, before, after, band))

    def share(change: Change) -> float:
        response = np.mean(change.band.signal(change.before) ** 2)
        return float(np.mean(change.in_band**2) / (response + stage.noise_rms**2))

    return max(changes, key=share)


def extension(stage: Stage, change: Change) -> tuple[Array, Array]:
    """Extension (n,), m, and its rate, m/s, of the first part with a law: its acceleration
    integrated, without what is slower than the band."""
    simulator = RunSimulator(stage.campaign, change.run, 0.0)
    system = change.model.system(stage.campaign.channels, "road")
    acceleration = simulator.record(
        change.model, replace(system, output=np.vstack([system.port[:1]] * len(system.output)))
    )[:, 0]
    v = cumulative_simpson(acceleration, dx=1 / RATE_HZ, initial=0.0)
    x = cumulative_simpson(v, dx=1 / RATE_HZ, initial=0.0)
    if system.port_input[0].any():  # a tyre: from here the wheel's path over the ground is due
        values = stage.vehicle.values
        position = change.run.speed_m_s * change.run.time_s
        path = wheel_envelope(
            make_track(change.run.track),
            corner_position(values, 0)[1],
            values["wheel.front.radius_m"],
            float(position[0]),
            float(position[-1]),
        )
        x = x + system.port_input[0, 0] * path.height(position)
        v = v + system.port_input[0, 0] * path.slope(position) * change.run.speed_m_s
    drift = slow_part(change.run.time_s, x, 1.0 / stage.campaign.band_hz[0])
    return x - drift(change.run.time_s), v - drift(change.run.time_s, 1)
