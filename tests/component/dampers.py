"""What dynamometers show of dampers and seals, in other formulations than the host's.

Valves behind a spring as the rate of the node between them, found by bisection of what they resist
with; hysteresis by its authors' own differential equation; friction by its steady curve; a seal by
its closed form along the way.
"""

from __future__ import annotations

from collections.abc import Callable
from math import copysign, exp, inf, tanh

from numba import njit

from tests.component.hysteresis import STEP_S, changes

Law = Callable[[float, float], float]
PARTS = 4


def compliant_damper(
    k: float,
    c: float,
    lag_s: float,
    asymmetry: float,
    opening_N: float,
    bleed: float,
    loss: float = 0.0,
    blow_off_N: float = inf,
) -> Law:
    """A node between a spring of c / lag and valves that resist its rate r with V(r)."""
    node, last, joint = 0.0, None, c / lag_s
    numbers = (c, asymmetry, opening_N, bleed, loss, blow_off_N)

    def force(x: float, v: float) -> float:
        nonlocal node, last
        if last is None:  # the valves have long resisted this rate
            node, last = x - resists(v, *numbers) / joint, x
        node, last = followed(node, last, x, joint, *numbers), x
        return k * x + joint * (x - node)

    return force


@njit(cache=True)  # ten million bisections in Python take minutes
def resists(rate, c, asymmetry, opening_N, bleed, loss, blow_off_N):
    side = c * (1.0 + asymmetry if rate > 0.0 else 1.0 - asymmetry)
    opens, r = opening_N * bleed / side, abs(rate)
    force = min(r, opens) * side / bleed
    more = max(r - opens, 0.0)
    blows = blow_off_N / side
    force += min(more, blows) * side + max(more - blows, 0.0) * side * (1.0 - loss)
    return copysign(force, rate)


@njit(cache=True)
def followed(node, last, x, joint, c, asymmetry, opening_N, bleed, loss, blow_off_N):
    """Where the node is once its spring has come from `last` to x."""
    step = STEP_S / PARTS
    for part in range(PARTS):
        at = last + (x - last) * (part + 1) / PARTS
        most = abs(at - node) / step
        low, high = -most, most
        for _ in range(50):
            rate = 0.5 * (low + high)
            resisted = resists(rate, c, asymmetry, opening_N, bleed, loss, blow_off_N)
            if joint * (at - node - step * rate) > resisted:
                low = rate
            else:
                high = rate
        node += step * low
    return node


def hardening(
    k: float, c: float, alpha_N_m: float, beta_1_m: float, gamma: float, delta: float
) -> Law:
    """z' = α v − β (γ |v| z + δ v |z|) by the midpoint rule; k is the whole first slope."""
    z, since = 0.0, changes()

    def slope(z: float, dx: float) -> float:
        return alpha_N_m * dx - beta_1_m * (gamma * abs(dx) * z + delta * dx * abs(z))

    def force(x: float, v: float) -> float:
        nonlocal z
        dx = since(x) / PARTS
        for _ in range(PARTS):
            z += slope(z + 0.5 * slope(z, dx), dx)
        return (k - alpha_N_m) * x + c * v + z

    return force


def stribeck(
    k: float, c: float, coulomb_N: float, sticking: float, stribeck_m_s: float, creep_m_s: float
) -> Law:
    """A steady curve: what holds at rest falls to what slides, the jump at rest rounded."""

    def force(x: float, v: float) -> float:
        more = (sticking - 1.0) * exp(-((v / stribeck_m_s) ** 2))
        return k * x + c * v + coulomb_N * (1.0 + more) * tanh(v / creep_m_s)

    return force


def seal(k: float, c: float, drag_N: float, lip_m: float) -> Law:
    """Dahl's law: the lip gives way and drags, F − (F − f) exp(−way / lip) either way."""
    drag, since = 0.0, changes()

    def force(x: float, v: float) -> float:
        nonlocal drag
        dx = since(x)
        end = copysign(drag_N, dx)
        drag = end + (drag - end) * exp(-abs(dx) / lip_m)
        return k * x + c * v + drag

    return force
