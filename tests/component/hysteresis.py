"""Hysteresis of a component as the rig has it: each law in another formulation than the host's.

Bristles and Bouc and Wen's law by small steps of their differential equations, play as the places
of two nodes, a yielding fluid as a node between spring and dashpot found by bisection, rubber as
one curve with the turning points it remembers.
"""

from __future__ import annotations

from collections.abc import Callable
from math import exp, tanh

from numba import njit

Law = Callable[[float, float], float]
STEP_S = 1.0 / 8192.0  # of the rig


def changes() -> Callable[[float], float]:
    """A function that returns how far its argument has come since the last call."""
    last: float | None = None

    def since(x: float) -> float:
        nonlocal last
        came, last = (0.0 if last is None else x - last), x
        return came

    return since


def lugre(
    k: float,
    c: float,
    coulomb_N: float,
    joint_N_m: float,
    sticking: float,
    stribeck_m_s: float,
) -> Law:
    """Bristles of length z: z' = v - joint |v| z / g(v)."""
    bend, since = 0.0, changes()

    def force(x: float, v: float) -> float:
        nonlocal bend
        g = coulomb_N * (1.0 + (sticking - 1.0) * exp(-((v / stribeck_m_s) ** 2)))
        dx = since(x)
        for _ in range(8):
            bend += (dx - joint_N_m * abs(dx) * bend / g) / 8
        return k * x + c * v + joint_N_m * bend

    return force


def bouc_wen(k: float, c: float, force_N: float, yield_m: float, shape: float) -> Law:
    """z' = v (1 - |z| (shape sgn(v z) + 1 - shape)) / yield."""
    z, since = 0.0, changes()

    def force(x: float, v: float) -> float:
        nonlocal z
        dx = since(x)
        for _ in range(4):
            yielding = shape * (1.0 if dx * z > 0.0 else -1.0) + 1.0 - shape
            z += 0.25 * dx * (1.0 - abs(z) * yielding) / yield_m
        return k * x + c * v + force_N * z

    return force


def friction_with_play(k: float, c: float, coulomb_N: float, joint_N_m: float, gap_m: float) -> Law:
    """A block on the ground, pushed by either wall of a cage on a spring: x the other end of the
    cage's spring, `block` where the block lies."""
    block = 0.0
    give = coulomb_N / joint_N_m

    def force(x: float, v: float) -> float:
        nonlocal block
        own = 0.0
        if x - block > gap_m / 2:  # one wall pushes
            block = max(block, x - gap_m / 2 - give)
            own = joint_N_m * (x - gap_m / 2 - block)
        elif block - x > gap_m / 2:
            block = min(block, x + gap_m / 2 + give)
            own = joint_N_m * (x + gap_m / 2 - block)
        return k * x + c * v + own

    return force


def mr_damper(k: float, c: float, yield_N: float, yield_m: float, creep_m_s: float) -> Law:
    """A node between a spring and what flows with yield tanh(rate / creep)."""
    node, joint = 0.0, yield_N / yield_m

    def force(x: float, v: float) -> float:
        nonlocal node
        node += STEP_S * flow(x - node, joint, yield_N, creep_m_s)
        return k * x + c * v + joint * (x - node)

    return force


@njit(cache=True)
def flow(away, joint, yield_N, creep_m_s):
    """The rate at which a node so far away from the other end of its spring follows it."""
    most = abs(away) / STEP_S
    low, high = -most, most
    for _ in range(50):
        rate = 0.5 * (low + high)
        if joint * (away - STEP_S * rate) > yield_N * tanh(rate / creep_m_s):
            low = rate
        else:
            high = rate
    return low


def payne_effect(k: float, c: float, force_N: float, half_way_m: float) -> Law:
    """First loading F x / (half way + x); every branch is that curve, twice as large, from where
    the motion turned, until it meets an older branch (G. Masing 1926)."""
    turns: list[tuple[float, float]] = []
    last, way = 0.0, 0.0

    def first(x: float) -> float:
        return force_N * x / (half_way_m + abs(x))

    def at(x: float) -> float:
        if not turns:
            return first(x)
        x0, f0 = turns[-1]
        return f0 + 2.0 * first(0.5 * (x - x0))

    def force(x: float, v: float) -> float:
        nonlocal last, way
        came = x - last
        if came * way < 0.0:
            turns.append((last, at(last)))
        if came:
            way = came
        # A branch that comes back to where an older one turned closes a loop, which is forgotten.
        while len(turns) > 1 and (x - turns[-2][0]) * way > 0.0:
            del turns[-2:]
        if len(turns) == 1 and abs(x) > abs(turns[0][0]):
            turns.clear()
        last = x
        return k * x + c * v + at(x)

    return force
