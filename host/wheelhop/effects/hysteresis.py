"""Force laws with memory of friction, rubber and yielding fluids, one number of memory each."""

from __future__ import annotations

from math import copysign, exp, expm1, log1p, sqrt, tanh

from wheelhop.effects.base import Array, law

STRAIGHT = 1e-9
STAGE = 1.0 - sqrt(0.5)
"""Share of the step in each of two implicit stages: with it they are second order and L-stable
(R. Alexander, SIAM J. Numer. Anal. 14 (1977) 1006, eq. 8)."""


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
    tanh(rate / p[2]). ż = (v − p[2] atanh z) / p[1] in two implicit stages: it may relax much
    faster than the step."""
    if dt <= 0.0:
        return p[0] * z, z
    # The rate grows evenly over the step, from what the way tells to v.
    begin = 2.0 * dx / dt - v
    stage = STAGE * dt / p[1]
    creep, way, end = stage * p[2], z + stage * (begin + STAGE * (v - begin)), 0.0
    for second in range(2):
        if second > 0:
            way = z + (1.0 - STAGE) / STAGE * (end - z) + stage * v
        far = abs(way)
        # tanh(s) + creep s = far, from the left by Halley's steps; the last one errs by its cube.
        s = max((far - 1.0) / creep, far / (1.0 + creep))
        for _ in range(30):
            bent = tanh(s)
            falls = 1.0 - bent * bent
            slope = falls + creep
            step = (far - bent - creep * s) / slope
            step /= max(1.0 - step * bent * falls / slope, 0.5)
            s += step
            if abs(step) <= 1e-5 * s:
                break
        end = copysign(bent + step * falls * (1.0 - step * bent), way)
    return p[0] * end, end


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
