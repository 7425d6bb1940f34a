"""A tyre cannot pull: the wheel leaves the ground when its static load is used up."""

from __future__ import annotations

from collections.abc import Sequence

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, Values, law
from wheelhop.effects.parameters import Parameter, Switch
from wheelhop.effects.progressive_tyre import bend_of, beyond_linear
from wheelhop.vehicle import Assembly, axle_name, static_tyre_load, tyre, wheels


@law
def no_pull(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """Takes away what pull is in the tyre's force beyond the load p[2]: of p[0] x + p[1] v, and of
    a tyre that stiffens, p[4] and p[5], as `beyond_linear` says."""
    pull = p[0] * x + p[1] * v + beyond_linear(x, p[0], p[4], p[5])
    return -p[3] * max(pull - p[2], 0.0), z


class TyreLiftOff(Effect):
    """The tyre's force is cut off where it would exceed the static load."""

    id = "tyre-lift-off"
    place = "tyre"
    title = "the tyre cannot pull: contact is lost when its static load is used up"
    equation = r"f = -\max(k_t x + c_t \dot x - W, 0),\quad W \text{ the wheel's static load}"
    source = "unilateral contact of a point-contact tyre model; W from vehicle.toml by statics"
    needs_road = True
    longest_step_s = 0.00125  # the tyre's stiffness against the unsprung mass comes and goes

    def change_step_s(self, theta: Values, vehicle: Values) -> float:
        """Twice as long: where contact is lost hardly depends on it."""
        return 2.0 * self.longest_step_s

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """On or off: the load at which contact is lost is known."""
        return (Switch("lifts", "1", "1: the tyre cannot pull"),)

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the correction to each tyre."""
        for i in wheels(vehicle):
            end = axle_name(i)
            stiffness = vehicle[f"wheel.{end}.tyre_stiffness_N_m"]
            damping = vehicle[f"wheel.{end}.tyre_damping_N_s_m"]
            load = static_tyre_load(vehicle, i)
            law = (stiffness, damping, load, theta["lifts"], *bend_of(vehicle, i))
            parts.add_law(tyre(i), no_pull, law)
