"""A model: the numbers of a vehicle, or of a component, and the effects added to it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import prod

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Channel
from wheelhop.effects import Effect, Parameter, RandomHeights, TrackSurvey
from wheelhop.vehicle import Assembly, Drive, System, baseline, body_inertia, component

Values = Mapping[str, float]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True)
class Model:
    """A vehicle with effects.

    ``values`` holds every number under one name: "body.mass_kg" as in vehicle.toml,
    "channel.imu.x_m" for a sensor whose place is estimated, "dry-friction.front_N" for an effect's
    parameter. ``runs`` holds, for each run's id, what that run leaves free: "speed_m_s",
    "start_m" (x of the front axle at time_s = 0) and effects' own, prefixed like the others. Those
    two are in metres of the survey: where its waves are too short, they stay below the wheels.
    ``heights`` holds the coefficients (2, k), m, of a run's `HeightSeries`, where an effect adds
    heights nobody knows.
    """

    values: Values
    effects: tuple[Effect, ...] = ()
    runs: Mapping[str, Values] = field(default_factory=dict)
    heights: Mapping[str, ComplexArray] = field(default_factory=dict)

    def __repr__(self) -> str:
        effects = ", ".join(effect.id for effect in self.effects) or "none"
        return f"<Model: {len(self.values)} numbers, {len(self.runs)} runs, effects: {effects}>"

    @property
    def random_heights(self) -> RandomHeights | None:
        """The effect that adds heights nobody knows; of several the first counts."""
        return next((e for e in self.effects if isinstance(e, RandomHeights)), None)

    def theta(self, effect: Effect, run_id: str | None = None) -> dict[str, float]:
        """An effect's own parameters by their short names, those of one run included."""
        own = dict(self._theta(effect.id))
        if run_id is not None:
            own |= _after(f"{effect.id}.", self.runs.get(run_id, {}))
        return own

    def _theta(self, effect_id: str) -> Values:
        """An effect's shared parameters; every run asks for them, several times."""
        if effect_id not in self._thetas:
            self._thetas[effect_id] = _after(f"{effect_id}.", self.values)
        return self._thetas[effect_id]

    @cached_property
    def _thetas(self) -> dict[str, Values]:
        return {}

    def stretch(self, run_id: str) -> float:
        """How long a metre of the survey of a run's track is, m."""
        surveys = (e for e in self.effects if isinstance(e, TrackSurvey))
        return prod(survey.stretch(self.theta(survey), run_id) for survey in surveys)

    def start_m(self, run_id: str) -> float:
        """Where the front axle of a run is at time_s = 0, m."""
        return self.stretch(run_id) * self.runs.get(run_id, {}).get("start_m", 0.0)

    def speed_m_s(self, run_id: str, nominal_m_s: float) -> float:
        """The mean speed of a run, m/s; the nominal one where none is fitted."""
        return self.stretch(run_id) * self.runs.get(run_id, {}).get("speed_m_s", nominal_m_s)

    def with_values(self, changes: Values) -> Model:
        """This model with some numbers changed."""
        return replace(self, values={**self.values, **changes})

    def with_run(self, run_id: str, changes: Values) -> Model:
        """This model with some of one run's numbers changed."""
        return replace(self, runs={**self.runs, run_id: {**self.runs.get(run_id, {}), **changes}})

    def with_heights(self, heights: Mapping[str, ComplexArray]) -> Model:
        """This model with other heights on top of the track in some runs."""
        return replace(self, heights={**self.heights, **heights})

    def with_effect(self, effect: Effect, parameters: Sequence[Parameter]) -> Model:
        """Add an effect, absent at first: amplitudes at their absent value, shapes at a start."""
        start = {f"{effect.id}.{p.name}": p.start for p in parameters}
        return replace(self, values={**self.values, **start}, effects=(*self.effects, effect))

    def without_effect(self, effect_id: str) -> Model:
        """The model with one effect and all its numbers taken out."""
        prefix = f"{effect_id}."
        effects = tuple(e for e in self.effects if e.id != effect_id)
        return Model(
            values={k: v for k, v in self.values.items() if not k.startswith(prefix)},
            effects=effects,
            runs={
                run: {k: v for k, v in values.items() if not k.startswith(prefix)}
                for run, values in self.runs.items()
            },
            heights=self.heights if any(isinstance(e, RandomHeights) for e in effects) else {},
        )

    def system(self, channels: Sequence[Channel], drive: Drive) -> System:
        """The equations of motion, with the outputs of `channels`."""
        parts = self.parts(channels, drive)
        return parts.system(() if drive == "rig" else body_inertia(self.values))

    def parts(self, channels: Sequence[Channel], drive: Drive) -> Assembly:
        """The parts of the mechanism, those of its effects included."""
        on_rig = drive == "rig"
        parts = component(self.values) if on_rig else baseline(self.values, channels, drive)
        for effect in self.effects:
            if drive in ("road", "rig") or not effect.needs_road:
                effect.modify(self.theta(effect), self.values, parts)
        return parts


def _after(prefix: str, values: Values) -> dict[str, float]:
    """The numbers whose names begin with a prefix, by what comes behind it."""
    return {k[len(prefix) :]: v for k, v in values.items() if k.startswith(prefix)}
