"""Which numbers of a model are free, and what is believed of them before the fit."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite, log

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, Channel, ComponentCampaign, RigRun, Run
from wheelhop.effects import Effect, Parameter, RandomHeights, RunSetting, Shape, Switch
from wheelhop.simulate import Model
from wheelhop.simulate.job import PATH_KEYS
from wheelhop.simulate.measured import offset_name
from wheelhop.simulate.rig import INITIAL as RIG_INITIAL
from wheelhop.vehicle import ABOARD, Measured, Vehicle, motions, on_mounts, wheels

Array = NDArray[np.float64]

SPEED_UNCERTAINTY = 0.06
"""A driver holds the nominal speed within ±10 %, nearly always: one standard deviation of it."""

REST_M = 0.005
"""How far from its mean in a run a strut may rest, one standard deviation."""

PLACES = (".x_m", ".y_m")
"""How numbers end that may be negative."""


def of_forces(name: str) -> int:
    """Whether a number counts masses or forces, as the unit says that its name ends with: were all
    of these twice as large, the vehicle would move as it does. −1 where they divide: "m_N"."""
    parts = name.rpartition(".")[2].split("_")
    where = next((i for i, part in enumerate(parts) if part in ("N", "kg")), None)
    if where is None:
        return 0
    return -1 if where and parts[where - 1] in ("1", "m") else 1


def scale_is_given(free: Iterable[Free], values: Iterable[str]) -> bool:
    """Whether one of a model's masses or forces is certain, and tells the others. What is stated
    of somebody aboard who moves with the body moves nothing."""
    aboard, names = tuple(f"{name}." for name in ABOARD), {f.name for f in free}
    return any(of_forces(k) and k not in names and not k.startswith(aboard) for k in values)


@dataclass(frozen=True)
class Free:
    """A free number: its prior mean and standard deviation (inf: nothing is known), the scale on
    which it is varied, and its bounds, all in its own unit; and when in its run it acts, s."""

    name: str
    mean: float
    sigma: float
    scale: float
    lower: float = -np.inf
    upper: float = np.inf
    span_s: tuple[float, float] = (-np.inf, np.inf)
    is_shape: bool = False  #: of an effect, and meaningless while that is absent
    in_proportion: bool = False  #: its logarithm is normal, with the deviation sigma / mean
    follows_scale: bool = False
    """Whether mean, sigma and bounds are multiples of the common scale of masses and forces."""

    def at(self, scale: float) -> Free:
        """The number in a model whose masses and forces have this common scale."""
        if not self.follows_scale:
            return self
        sigma, mean = scale * self.sigma, scale * self.mean
        return replace(
            self, mean=mean, sigma=sigma, lower=scale * self.lower, upper=scale * self.upper
        )

    @classmethod
    def of(cls, measured: Measured) -> Free:
        """A relation of several numbers, as if it were one of them."""
        m = measured
        return cls(m.name, m.value, m.sigma, m.sigma, in_proportion=True)

    def away(self, value: float) -> float:
        """By how many standard deviations a value is more than what is believed."""
        more = self.mean * log(value / self.mean) if self.in_proportion else value - self.mean
        return more / self.sigma

    def sigma_at(self, value: float) -> float:
        """The standard deviation believed of it if its value lies there."""
        return self.sigma * value / self.mean if self.in_proportion else self.sigma

    @property
    def step(self) -> float:
        """Fraction of the scale over which differences are taken.

        Small: the common scale of all masses and forces must come out as the direction without
        any effect that it is. Larger where the tabulated wheel envelope changes with it.
        """
        return 0.02 if self.name in PATH_KEYS else 5e-5


def stepped(free: Free, values: Mapping[str, float]) -> dict[str, float]:
    """The number where a difference is taken to."""
    return {free.name: values.get(free.name, free.mean) + free.step * free.scale}


def between(free: Sequence[Free], before: Mapping[str, float], after: Mapping[str, float]) -> Array:
    """How far numbers went (p,), per `Free.scale`."""
    return np.array([(after[f.name] - before.get(f.name, f.mean)) / f.scale for f in free])


def after(free: Sequence[Free], values: Mapping[str, float], step: Array) -> dict[str, float]:
    """Numbers after a step (p,), per `Free.scale`, within their bounds."""
    return {
        f.name: min(max(values.get(f.name, f.mean) + f.scale * float(d), f.lower), f.upper)
        for f, d in zip(free, step, strict=True)
    }


def initial_model(campaign: Campaign, vehicle: Vehicle) -> Model:
    """The nominal vehicle, no effects; sensors of unknown place sit at the centre of mass, and all
    are as their calibration says."""
    unknown = {
        f"{c.key}.{what}": 0.0
        for c in campaign.channels
        for what in (*(("x_m", "y_m") if c.point == "body" else ()), *calibrated(c))
    }
    return Model(values={**vehicle.values, **unknown})


def vehicle_parameters(campaign: Campaign, vehicle: Vehicle) -> list[Free]:
    """The vehicle's own numbers, as far as these runs can show them, or the component's."""
    if isinstance(campaign, ComponentCampaign):
        return _component_parameters(campaign, vehicle)
    on_road = any(run.track.kind != "unknown" for run in campaign.runs)
    # Nothing of the baseline depends on these; what an effect takes from them it says itself.
    bolted = [f"{name}." for name in ABOARD if name not in on_mounts(vehicle.values)]
    idle: tuple[str, ...] = ("geometry.cg_height_m", *bolted)
    if not on_road:
        idle += ("wheel.",)
    free = [
        Free(key, value, sigma, sigma)
        if key.endswith(PLACES)
        # What may be nothing is not believed in proportion.
        else Free(
            key,
            value,
            sigma,
            sigma,
            0.02 * value,
            in_proportion=sigma < value,
            follows_scale=of_forces(key) > 0 and sigma >= value,
        )
        for key, value in vehicle.values.items()
        if not key.startswith(idle) and (sigma := vehicle.uncertainty[key]) > 0
    ]
    spread = {"x_m": "geometry.wheelbase_m", "y_m": "geometry.track_width_m"}
    for channel in campaign.channels:
        if channel.point == "body":
            for axis, length in spread.items():
                if length in vehicle.values:  # where the body only heaves, all places are alike
                    sigma = vehicle.values[length] / 4
                    free.append(Free(f"{channel.key}.{axis}", 0.0, sigma, sigma))
        for what, sigma in calibrated(channel).items():
            free.append(Free(f"{channel.key}.{what}", 0.0, sigma, sigma, lower=-0.5))
    return free


def calibrated(channel: Channel) -> dict[str, float]:
    """How well what a calibration says of a channel is known, relative, one standard deviation."""
    known = {"gain": channel.gain_uncertainty, "corner": channel.corner_uncertainty}
    return {what: sigma for what, sigma in known.items() if sigma > 0.0}


def _component_parameters(campaign: ComponentCampaign, component: Vehicle) -> list[Free]:
    # A force needs a mass to move; everything else may turn out to be an effect alone.
    least = {"component.mass_kg": 0.02} if campaign.drive == "force" else {}
    return [
        Free(key, value, sigma, sigma, lower=least.get(key, 0.0) * value)
        for key, value in component.values.items()
        if (sigma := component.uncertainty[key]) > 0
    ]


def _rig_start(run: RigRun, model: Model, is_held: bool) -> Iterator[Free]:
    """What a run that imposes a force leaves free (`wheelhop.simulate.rig.INITIAL`).

    The constant force, a weight or preload that no load cell shows or the error of a cell's zero,
    is believed to be about as large as the force recorded, or in a free decay as the campaign's. A
    spring answers it by another rest, about which it is then counted: of a held component it is
    not free, unless the campaign says that it is preloaded, which matters beside a law that bends.
    """
    if run.drive == "force":
        x = run.displacement
        size, speed = float(x.std()), float(np.gradient(x, run.time_s).std())
        force = float(np.sqrt(np.mean(run.force**2))) or model.values["rig.force_N"]
        means, sigmas = (float(x[0]), 0.0, 0.0), (size, speed, force)
        names = RIG_INITIAL[:2] if is_held else RIG_INITIAL
        for name, mean, sigma in zip(names, means, sigmas, strict=False):
            yield Free(name, mean, sigma, sigma)


def effect_parameters(parameters: Sequence[Parameter], model: Model, effect: Effect) -> list[Free]:
    """Which of an effect's parameters are free; nothing is believed of an amplitude beforehand.
    Those of a density of heights are not among them: no derivative shows them."""
    if isinstance(effect, RandomHeights):
        return []
    free = []
    for p in parameters:
        if isinstance(p, Switch):
            continue
        name, is_shape = f"{effect.id}.{p.name}", isinstance(p, Shape)
        mean, sigma = p.start, np.inf
        if isinstance(p, Shape):
            begun = model.values.get(name, p.start)
            mean, sigma = begun if p.believed is None else p.believed, p.scale
        told = is_shape or any(isfinite(b) and b != 0.0 for b in (p.lower, p.upper))
        follows = told and of_forces(name) > 0
        free.append(
            Free(
                name,
                mean,
                sigma,
                p.scale,
                p.lower,
                p.upper,
                is_shape=is_shape,
                follows_scale=follows,
            )
        )
    return free


def run_parameters(run: Run, setting: RunSetting, model: Model) -> list[Free]:
    """What a run leaves free: speed and start on the track (on measured axles and on a rig that
    imposes a force: what moved how when the record began; where travel is measured: at which
    extension struts rest), and the effects' own."""
    free = list(_rig_start(run, model, setting.is_held)) if isinstance(run, RigRun) else []
    if setting.on_road and run.speed_m_s > 0:
        sigma = speed_uncertainty(run) * run.speed_m_s
        free.append(Free("speed_m_s", run.speed_m_s, sigma, 1e-3 * run.speed_m_s, 0.0))
        free.append(Free("start_m", *(run.start_m or (0.0, np.inf)), 1e-2))
    if setting.by_travel:
        for corner in wheels(model.values):
            free.append(Free(offset_name(corner), 0.0, REST_M, REST_M))
    elif not setting.on_road and not setting.on_rig:
        for name in motions(model.values):
            free.append(Free(f"initial_{name}", 0.0, 0.02, 0.02))
            free.append(Free(f"initial_{name}_rate", 0.0, 0.2, 0.2))
    for effect in model.effects:
        if effect.acts_in(setting):
            free.extend(effect_run_parameters(setting, effect))
    return free


def speed_uncertainty(run: Run) -> float:
    """How well the speed of a run is known, relative, one standard deviation."""
    stated = 0.0 if run.driven is None else run.driven.uncertainty
    return stated or SPEED_UNCERTAINTY


def effect_run_parameters(setting: RunSetting, effect: Effect) -> list[Free]:
    """What an effect leaves free in a run."""
    return [
        Free(
            f"{effect.id}.{p.name}",
            p.start,
            p.scale,
            p.scale,
            p.lower,
            p.upper,
            p.span_s,
            isinstance(p, Shape),
        )
        for p in effect.per_run(setting)
    ]
