"""Free play in a strut's joint."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, expm1, log

from wheelhop.campaign import Channel
from wheelhop.effects.balance import balance, share
from wheelhop.effects.base import Array, Effect, Values, law
from wheelhop.effects.parameters import Amplitude, Parameter, Shape
from wheelhop.vehicle import Assembly, ends, struts

RISE_S = 0.0002
"""How fast the force rises when the gap closes. It would jump by the damper's force at an instant
that falls between the steps, and derivatives of the fit would be noise; the rise overshoots so
that its impulse is the jump's."""

UNLIKE = 0.15
"""How much front and rear gaps are believed to differ: a gap that is never used up might be of any
width."""

BALANCES = (0.0, 0.7, -0.7)
TOUCHING_M = 1e-9
TINY = 1e-9
"""A strut may lack its spring or its damper, but not divide by it."""


@law
def free_play(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """What a gap p[0] takes away from a strut of stiffness p[1] and damping p[2] that carries the
    load p[3]. The strut's own extension e lies in x − p[0] ≤ e ≤ x.

    The joint passes on push at e = x and pull at e = x − p[0]; in between the strut is left to
    itself and relaxes towards its free length, exactly for any step. z is e; the number by which
    it lies outside of the gap is exp(−t/p[4]), t the time since the gap closed on that side.
    """
    gap, stiffness, damping, load = p[0], max(p[1], TINY), max(p[2], TINY), p[3]
    rise = p[4]
    linear = stiffness * x + damping * v
    if gap <= 0.0:
        return 0.0, x
    start = min(max(z, x - dx - gap), x - dx)
    own = start - (load / stiffness - start) * expm1(-stiffness / damping * dt)
    if x - gap < own < x:
        return load - linear, own  # about equilibrium: a strut without force misses its load
    push = own >= x
    end = x if push else x - gap
    way = abs(end - dx - start)
    if way < TOUCHING_M:
        young = abs(z - start) * exp(-dt / rise)
    else:
        beyond = abs(own - end)
        young = exp(-dt / rise * beyond / (beyond + way))
    passed = stiffness * end + damping * v - load
    passed = min(passed, 0.0) if push else max(passed, 0.0)
    if young > TINY:
        passed *= 1.0 - young * (1.0 + log(young))
    return load + passed - linear, end + young if push else end - young


class Backlash(Effect):
    """A gap in series with every strut: it opens where the strut's total force, static load
    included, changes sign."""

    id = "backlash"
    place = "suspension"
    on_rig = True
    title = "free play: the gap opens where the strut's total force changes sign"
    equation = (
        r"k e + c\dot e - F_0 < 0:\ e = x;\quad > 0:\ e = x - g;"
        r"\quad = 0:\ x - g \leq e \leq x,\quad f = k e + c \dot e - k x - c \dot x"
    )
    screened_at = (0.5, 0.05, 0.005)  # a wide gap is never crossed, a narrow one always
    longest_step_s = 0.0005  # the damper's force jumps when the gap closes
    source = (
        "physical backlash model (spring, damper and gap in series): M. Nordin, J. Galic, P.-O."
        " Gutman, New models for backlash and gear play, Int. J. Adapt. Control 11 (1997) 49, eq. 5"
    )

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """The mean gap and how it is shared out between the axles; where a component's play lies
        if its load is not known."""
        first, *others = ends(vehicle).values()
        usual = first.usual
        gap = Amplitude("gap_m", "m", "free play of a strut", 0.1 * usual.travel_m, lower=0.0)
        if not others:
            if first.load_is_known:
                return (gap,)
            meaning = "displacement at which the component lies in the middle of its play"
            middle = first.static_load_N / max(first.stiffness_N_m, usual.stiffness_N_m)
            scale = 0.1 * usual.travel_m
            return gap, Shape("middle_m", "m", meaning, scale, starts=(0.0, middle))
        return gap, balance("balance", "gap", UNLIKE, starts=BALANCES)

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Take away from each strut what its gap does not pass on."""
        for strut in struts(vehicle):
            gap = share(theta, "gap_m", "balance", strut.end)
            load = strut.static_load_N
            if "middle_m" in theta:
                load = strut.stiffness_N_m * (theta["middle_m"] - 0.5 * gap)
            # Along an imposed displacement the gap closes where it must.
            rise = RISE_S if strut.load_is_known else TINY
            values = (gap, strut.stiffness_N_m, strut.damping_N_s_m, load, rise)
            parts.add_law(strut.row, free_play, values)
