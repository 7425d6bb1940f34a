"""An identified body on legs of springs, dampers and masses: the loops closed in state space."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from wheelhop.identify.statespace import StateSpace

Array = NDArray[np.float64]

BODY, GROUND, FIXED = -1, -2, -3
"""Ends of a link that are no masses of a leg."""


@dataclass(frozen=True, eq=False)
class Link:
    """A spring, a damper and Maxwell elements between two places, at each of the four corners: a
    force K e + C e' + Σ Eᵢ (e − wᵢ), wᵢ' = (e − wᵢ)/τᵢ, on `a` towards `b`, e = q_b − q_a."""

    a: int
    b: int
    stiffness_N_m: Array  #: (4,)
    damping_N_s_m: Array  #: (4,)
    strengths_N_m: Array = field(default_factory=lambda: np.zeros((0, 4)))  #: (elements, 4)
    times_s: Array = field(default_factory=lambda: np.zeros(0))  #: (elements,)


@dataclass(frozen=True, eq=False)
class Legs:
    """Masses (places, 4), kg, heavy ones first, and what links them; a place without mass takes a
    damper. The ground moves heavy places alone."""

    mass_kg: Array
    links: tuple[Link, ...]


def check_body(s: StateSpace) -> None:
    """Raise ValueError for a body that cannot be pushed."""
    if s.d.any():
        raise ValueError("a body that jumps when pushed has no inertia: S must be strictly proper")


def closed(s: StateSpace, legs: Legs) -> StateSpace:
    """From the ground under the four legs to the body's four points.

    The states are those of S, the places q, of the heavy ones p = m q' less the ground's share of
    their dampers, and the Maxwell elements' w. Rates of places without mass and the force F on the
    body are what forces in balance leave of them, with x' = C A x + C B F.
    """
    check_body(s)
    n, places = s.order, len(legs.mass_kg)
    heavy = int(np.sum(legs.mass_kg[:, 0] > 0.0))
    elements = sum(len(link.times_s) for link in legs.links)
    order = n + 4 * (places + heavy + elements)
    # Every quantity is a row of (states, ground, rates of light places and F): known, then unknown.
    known, unknown = order + 4, 4 * (places - heavy) + 4
    width = known + unknown

    def unit(first: int) -> Array:
        row = np.zeros((4, width))
        row[:, first : first + 4] = np.eye(4)
        return row

    ground, force = unit(order), unit(width - 4)
    place = {GROUND: ground, FIXED: np.zeros((4, width))}
    rate = {FIXED: np.zeros((4, width))}
    place[BODY] = np.zeros((4, width))
    place[BODY][:, :n] = s.c
    rate[BODY] = s.c @ s.b @ force
    rate[BODY][:, :n] += s.c @ s.a
    momentum = {i: unit(n + 4 * (places + i)) for i in range(heavy)}
    share = {i: np.zeros(4) for i in range(heavy)}
    for link in legs.links:
        if link.a == GROUND:
            share[link.b] = share[link.b] + link.damping_N_s_m
    for i in range(places):
        place[i] = unit(n + 4 * i)
        if i < heavy:
            rate[i] = (momentum[i] + share[i][:, None] * ground) / legs.mass_kg[i][:, None]
        else:
            rate[i] = unit(known + 4 * (i - heavy))
    pull = {i: np.zeros((4, width)) for i in (*range(places), BODY)}
    memory, first = list[Array](), n + 4 * (places + heavy)
    for link in legs.links:
        length = place[link.b] - place[link.a]
        # The damper of a tyre moves with the ground, whose rate p holds: only the wheel's is left.
        stretch = rate[link.b] - (0.0 if link.a == GROUND else rate[link.a])
        tension = link.stiffness_N_m[:, None] * length + link.damping_N_s_m[:, None] * stretch
        for strength, time_s in zip(link.strengths_N_m, link.times_s, strict=True):
            left = length - unit(first)
            tension = tension + strength[:, None] * left
            memory.append(left / time_s)
            first += 4
        for end, sign in ((link.a, 1.0), (link.b, -1.0)):
            if end in pull:
                pull[end] = pull[end] + sign * tension
    balance = np.vstack([*(pull[i] for i in range(heavy, places)), pull[BODY] - force])
    solved = -np.linalg.solve(balance[:, known:], balance[:, :known])

    def freed(row: Array) -> Array:
        return np.asarray(row[:, :known] + row[:, known:] @ solved)

    rates = [freed(rate[i]) for i in range(places)]
    driven = [freed(pull[i]) for i in range(heavy)]
    body = s.b @ freed(force)
    body[:, :n] += s.a
    whole = np.vstack([body, *rates, *driven, *(freed(row) for row in memory)])
    return StateSpace(whole[:, :order], whole[:, order:], place[BODY][:, :order], np.zeros((4, 4)))
