"""What an effect is: one piece of physics, or one fault of the measurement, the baseline lacks."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Literal, NamedTuple, Protocol

import numba
import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Channel
from wheelhop.campaign.course import Course
from wheelhop.campaign.driven import Driven
from wheelhop.campaign.known import NOTHING, Known
from wheelhop.effects.parameters import Parameter
from wheelhop.vehicle.assembly import Assembly, Law
from wheelhop.vehicle.component import is_component
from wheelhop.vehicle.layout import motions

Array = NDArray[np.float64]
Values = Mapping[str, float]
Place = Literal["track", "speed", "wheel", "tyre", "axle", "suspension", "body", "sensor"]


def law(function: Callable[..., tuple[float, float]]) -> Law:
    """Compile a force law (decorator).

    The function takes the part's extension x (m), its rate v (m/s), the change dx of x and the
    time dt (s) since the beginning of the time step, the law's memory z (0 at the start, what it
    returned at the end of the last step) and its parameters p (an array); it returns the force
    opposing x, N, and the new z. A law without memory returns z unchanged.
    """
    signature = "UniTuple(float64, 2)(float64, float64, float64, float64, float64, float64[::1])"
    compiled: Law = numba.njit(signature, cache=True, nogil=True, error_model="numpy")(function)
    return compiled


@dataclass(frozen=True)
class Becomes:
    """Where a law is no longer itself: with `parameter` at its bound, `at` "lower" or "upper", it
    is not told from `into`, an effect's id or a number of the vehicle; `why`, in a few words."""

    parameter: str
    at: Literal["lower", "upper"]
    into: str
    why: str


class Probe(Protocol):
    """How an effect looks at the data to find where its fit may begin. Signals are in band,
    (n, channels), each per its channel's noise scale, which of accelerations is 1: m/s²."""

    @property
    def settings(self) -> Sequence[RunSetting]:
        """The runs that are fitted."""

    @property
    def channels(self) -> Sequence[Channel]:
        """The channels, in the order of the columns."""

    @property
    def values(self) -> Values:
        """The numbers of the model without the effect, by their dotted names."""

    def time_s(self, run_id: str) -> Array:
        """Sample times (n,)."""

    def recorded(self, run_id: str) -> Array:
        """The record as it is, not in band."""

    def measured(self, run_id: str) -> Array:
        """The record."""

    def modelled(self, run_id: str, changes: Values) -> Array:
        """The model without the effect, some of the run's own numbers changed by an amount."""

    def all_modelled(self, run_id: str, trials: Sequence[Values]) -> Sequence[Array]:
        """`modelled` for several changes, at much less cost than one after the other."""

    def placed(self, run_id: str, channels: Collection[int]) -> Values:
        """Speed ("speed_m_s") and start ("start_m") at which the model without the effect agrees
        best with some of the channels; empty where it does not drive."""

    def period_m(self, run_id: str) -> float | None:
        """Length after which the run's track repeats; None if it does not, or is not known."""

    def way_m(self, run_id: str) -> Array:
        """The way (n, 4), m, each wheel has come along the track, the effect left out."""

    def travel(self, run_id: str) -> Mapping[str, Array]:
        """What the struts of each end ("front", "rear") do in the model without the effect: their
        extensions in band (n, struts), m; empty where no strut has sensors at both its ends."""


@dataclass(frozen=True)
class RunSetting:
    """What an effect may know of a run: its id, nominal speed, the instants at which the run-up
    and the record begin and the record ends, whether the track under it is known, and whether it
    is no vehicle that runs but a component on a rig, or one that measured travel of its struts
    moves; the speed along the track, where it changes, or in time, where it was recorded; and
    whether a spring is believed to hold a component about its rest; and what else is known of it.
    """

    run_id: str
    speed_m_s: float
    start_s: float
    record_start_s: float
    end_s: float
    on_road: bool
    on_rig: bool = False
    by_travel: bool = False
    course: Course | None = None
    driven: Driven | None = None
    is_held: bool = False
    known: Known = NOTHING


class OwnValues(NamedTuple):
    """What an effect leaves free in one run, as fitted: the run, the values, those of the vehicle
    by their full names among them, and their standard deviations as far as they are known."""

    run: RunSetting
    values: Values
    uncertainty: Values = MappingProxyType({})


class Effect:
    """Base class: an effect overrides `parameters_for` and the hooks of its place in the chain.

    Every hook gets `theta`, the effect's own parameters by name.
    """

    id: ClassVar[str]
    place: ClassVar[Place]
    title: ClassVar[str]  #: what it is, in one line
    equation: ClassVar[str]
    source: ClassVar[str]
    needs_road: ClassVar[bool] = False
    """Whether the effect acts upstream of the axle, where an unknown track hides it."""
    needs_motions: ClassVar[Sequence[str]] = ()
    """Motions of the body, "pitch" or "roll", without which it has nothing to act on."""
    on_rig: ClassVar[bool] = False
    """Whether it acts on a component on a rig, too: springs and force laws along the rows of
    `wheelhop.vehicle.struts`, and nothing that has a motion of its own."""
    on_vehicle: ClassVar[bool] = True
    """Whether it is looked for on vehicles, too; where not, only a rig tells it from its likes."""
    becomes: ClassVar[Sequence[Becomes]] = ()
    """What its law degenerates into at bounds of its parameters, for the critic."""
    screened_at: ClassVar[Sequence[float]] = (0.5,)
    """The fractions of its amplitudes' scales at which it is screened: several where what it
    changes takes another shape as it grows."""
    longest_step_s: float = 0.0025
    """Integration step at which its force laws leave an error below the sensors' noise."""

    def __repr__(self) -> str:
        return f"<Effect {self.id}: {self.title}>"

    def acts_in(self, run: RunSetting) -> bool:
        """Whether it can act in a run: upstream of measured axles nothing does."""
        if run.on_rig:
            return self.on_rig
        return self.on_vehicle and (run.on_road or not self.needs_road)

    def applies_to(self, vehicle: Values) -> bool:
        """Whether the vehicle has what it acts on; the other hooks are not called if not."""
        if is_component(vehicle):
            return self.on_rig
        return self.on_vehicle and set(self.needs_motions) <= set(motions(vehicle))

    def change_step_s(self, theta: Values, vehicle: Values) -> float:
        """Integration step for the difference of two records, what a small change makes of them:
        most of the error is in both, and falls out."""
        return self.longest_step_s

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """The parameters, with scales fitting this vehicle; empty: the effect does not apply."""
        raise NotImplementedError

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """Discrete forms of which one is meant ("B3", "A1-A2", "cubic"); one unnamed by default.

        An effect with several forms gets the chosen one in `with_choice`.
        """
        return ("",)

    def with_choice(self, choice: str) -> Effect:
        """The effect in the form `choice`."""
        return self

    def per_run(self, run: RunSetting) -> Sequence[Parameter]:
        """Parameters the effect leaves free in every run (an engine's phase, a speed history)."""
        return ()

    def shape_starts(self, probe: Probe) -> Sequence[Values]:
        """Shape parameters to screen, from the data; empty: every parameter's own starts."""
        return ()

    def run_starts(self, probe: Probe, run: RunSetting, shapes: Values) -> Sequence[Values]:
        """Where the fit of what one run leaves free may begin, from the data and the effect's
        ``shapes`` that are tried: the best of them counts; an empty one: absent. Speed and start of
        the run itself may be among the values. Screening begins shapes of the run at the first."""
        return ({},)

    def summary(self, runs: Sequence[OwnValues]) -> dict[str, float]:
        """Numbers that stand for what is left free per run, for people to read."""
        return {}

    def travel(
        self, theta: Values, run: RunSetting, time_s: Array, position_m: Array, speed_m_s: float
    ) -> tuple[Array, Array] | None:
        """Extra distance of each wheel path (T, 4), m, and its rate (T, 4), m/s."""
        return None

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add parts to the vehicle: springs, masses, modes, force laws, applied forces."""

    def forces(
        self, theta: Values, run: RunSetting, time_s: Array, way_m: Array, speed_m_s: Array
    ) -> Sequence[Array]:
        """Histories (T,) of the forces added in `modify` by `add_force`, in that order: N once they
        are times the coefficients of their rows. ``way_m`` and ``speed_m_s`` (T, 4) are the way
        each wheel has come and its rate."""
        return ()

    def sense(
        self, theta: Values, acceleration: Array, channels: Sequence[Channel], rate_hz: float
    ) -> Array:
        """What the instrument makes of what truly is (n, c), in the channels' units, at rest
        before."""
        return acceleration

    def restore(
        self, theta: Values, measured: Array, channels: Sequence[Channel], rate_hz: float
    ) -> Array:
        """Undo `sense` where that can be done: measured axle motion drives the model."""
        return measured


def form_of(effect: Effect, channels: Sequence[Channel]) -> str:
    """Which of its forms an effect has ("B3", "air"); empty if there is but one."""
    return next(
        (
            choice
            for choice in effect.choices(channels)
            if choice and vars(effect.with_choice(choice)) == vars(effect)
        ),
        "",
    )
