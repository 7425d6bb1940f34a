"""Force laws with memory of friction, rubber and yielding fluids, one number of memory each."""

from __future__ import annotations

from math import atanh, copysign, cosh, exp, expm1, log1p, tanh

from wheelhop.effects.base import Array, law

ALMOST = 1.0 - 1e-12
STRAIGHT = 1e-9
PARTS = 4
"""Of a step, in which a yielding fluid follows the rate: it may relax much faster than that."""


@law
def bristles(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """LuGre's bristles without their own damping: slip force p[0] while sliding, p[0] p[2] at rest,
    falling over the speed p[3]; p[1] is their stiffness, z their deflection times it.

    ż = p[1] v (1 − sgn(v) z / g(v)), g = p[0] (1 + (p[2] − 1) exp(−(v/p[3])²)), solved exactly for
    a constant rate over the step.
    """
    ratio = v / p[3]
    held = p[0] * (1.0 + (p[2] - 1.0) * exp(-ratio * ratio))
    if held <= 0.0:
        return 0.0, 0.0
    end = copysign(held, dx)
    z = end + (z - end) * exp(-p[1] * abs(dx) / held)
    return z, z


@law
def bouc_wen(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """p[0] z with dz/dx = (1 − p[2] |z|) / p[1] where it loads, (1 + p[3] |z|) / p[1] where it
    unloads: Bouc and Wen's law of exponent 1, α = p[0] / p[1], β (γ + δ) = p[2] / p[1] and
    β (γ − δ) = p[3] / p[1], solved exactly along the way dx."""
    way = abs(dx) / p[1]
    along = copysign(1.0, dx) * z  # seen so that the way is forwards
    if along < 0.0:
        # d along = 1 − p[3] along, until it has come to 0.
        if abs(p[3]) < STRAIGHT:
            grown, until = way, -along
        else:
            grown, until = -expm1(-p[3] * way) / p[3], log1p(-p[3] * along) / p[3]
        if way <= until:
            along, way = along + grown * (1.0 - p[3] * along), 0.0
        else:
            along, way = 0.0, way - until
    # d along = 1 − p[2] along.
    grown = way if abs(p[2]) < STRAIGHT else -expm1(-p[2] * way) / p[2]
    z = copysign(1.0, dx) * (along + grown * (1.0 - p[2] * along))
    return p[0] * z, z


@law
def yielding(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """p[0] z: a spring that gives way by p[1] at that force, in series with what creeps as
    tanh(rate / p[2]). ż = (v − p[2] atanh z) / p[1]; the creep is that at the end of each
    part of a step, so that any step is stable."""
    if dt <= 0.0:
        return p[0] * z, z
    # The rate grows evenly over the step, from what the way tells to v.
    begin = 2.0 * dx / dt - v
    creep = dt / PARTS * p[2] / p[1]
    for part in range(PARTS):
        rate = begin + (v - begin) * (part + 0.5) / PARTS
        end = z + rate * dt / PARTS / p[1]
        way = abs(end)
        # tanh(s) + creep s = way: from the left Newton's steps of a concave function never pass it.
        s = max((way - 1.0) / creep, atanh(min(way / (1.0 + creep), ALMOST)))
        for _ in range(30):
            grown = cosh(min(s, 300.0))
            step = (way - tanh(s) - creep * s) / (1.0 / (grown * grown) + creep)
            s += step
            if abs(step) <= 1e-10 * s:
                break
        z = copysign(tanh(s), end)
    return p[0] * z, z


@law
def slip_behind_play(
    x: float, v: float, dx: float, dt: float, z: float, p: Array
) -> tuple[float, float]:
    """A spring of stiffness p[1] that slips at the force p[0], behind a gap of width p[2]; z is the
    way between its ends, 0 in the middle of the gap. Exact as long as the motion does not turn
    within the step."""
    half = 0.5 * p[2]
    most = half + p[0] / p[1]
    z = min(max(z + dx, -most), most)
    beyond = abs(z) - half
    return (copysign(p[1] * beyond, z) if beyond > 0.0 else 0.0), z
