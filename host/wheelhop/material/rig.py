"""From a rig's time signals to complex moduli: sine steps or sweeps, any number of amplitudes.

The record is cut into whole cycles of the displacement. In every cycle the first harmonics of force
and displacement give one modulus; neighbouring cycles alike in frequency and amplitude are one
point, and their scatter is its uncertainty. A sweep is cut where it has come 5 % further.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from wheelhop.material.data import ModulusData
from wheelhop.material.error import MaterialError
from wheelhop.material.model import Array, ComplexArray

ALIKE = 0.05
"""Cycles of one point differ by no more in frequency and in amplitude."""
FEWEST_CYCLES = 3
"""In a point, after the first, which is not steady yet."""
LEAST_SAMPLES = 12
"""In a cycle: three harmonics and a mean are solved for."""
HARMONICS = 3
STILL = 0.02
"""Where the displacement stays below this part of its largest, the rig rests."""
SIGNIFICANT = 3.0
"""Standard deviations beyond which a change with amplitude is called one."""


@dataclass(frozen=True, eq=False)
class Point:
    """One frequency and amplitude.

    ``modulus`` is the mean over the cycles, N/m, ``uncertainty`` one standard deviation of its real
    and imaginary part, ``third`` the third harmonic of the force as a fraction of the first, and
    ``loop`` (n, 2) displacement, m, and force, N, about their means over one cycle in its middle.
    """

    frequency_hz: float
    amplitude_m: float
    modulus: complex
    uncertainty: float
    cycles: int
    third: float
    loop: Array


@dataclass(frozen=True)
class AmplitudeEffect:
    """How the dynamic stiffness |M| changes with amplitude at one frequency (A. R. Payne, J. Appl.
    Polymer Science 6 (1962) 57–63): relative change per doubling, and its standard deviation."""

    frequency_hz: float
    amplitudes_m: tuple[float, ...]
    per_doubling: float
    uncertainty: float

    @property
    def significant(self) -> bool:
        """Whether linear theory ends here."""
        return abs(self.per_doubling) > SIGNIFICANT * self.uncertainty


@dataclass(frozen=True, eq=False)
class _Cycle:
    first: int
    last: int
    phase: Array
    frequency_hz: float
    displacement: complex
    force: complex
    third: complex


def points(name: str, time_s: Array, displacement_m: Array, force_N: Array) -> list[Point]:
    """The points in a record (n,), in the order in which they were driven.

    Raises `MaterialError` if there is no point: too few cycles, or too few samples in them.
    """
    cycles = _cycles(time_s, displacement_m, force_N)
    found = []
    for group in _alike(cycles):
        steady = group[1:]
        if len(steady) >= FEWEST_CYCLES:
            found.append(_point(steady, displacement_m, force_N))
    if not found:
        raise MaterialError(
            f"{name}: no {FEWEST_CYCLES + 1} whole cycles of the displacement alike in frequency"
            f" and amplitude, each of {LEAST_SAMPLES} samples or more"
        )
    return found


def modulus_data(
    name: str, found: Sequence[Point], amplitude_m: float | None = None
) -> ModulusData:
    """The moduli at one amplitude (the smallest if none is given: linear theory holds there best),
    points at the same frequency averaged."""
    amplitude = min(p.amplitude_m for p in found) if amplitude_m is None else amplitude_m
    chosen = [p for p in found if abs(np.log(p.amplitude_m / amplitude)) < 2 * ALIKE]
    merged = _merged(chosen)
    return ModulusData(
        name,
        np.array([p.frequency_hz for p in merged]),
        np.array([p.modulus for p in merged]),
        np.array([p.uncertainty for p in merged]),
    )


def amplitude_effects(found: Sequence[Point]) -> list[AmplitudeEffect]:
    """The change with amplitude at every frequency that was driven at two or more of them."""
    effects = []
    for same in _by_frequency(found):
        size = np.log2([p.amplitude_m for p in same])
        if np.ptp(size) < 2 * np.log2(1 + ALIKE):
            continue
        stiffness = np.log(np.abs([p.modulus for p in same]))
        spread = np.array([p.uncertainty / abs(p.modulus) for p in same])
        weight = 1 / np.maximum(spread, 1e-9) ** 2
        middle = (weight * size).sum() / weight.sum()
        moment = (weight * (size - middle) ** 2).sum()
        effects.append(
            AmplitudeEffect(
                float(np.mean([p.frequency_hz for p in same])),
                tuple(sorted(p.amplitude_m for p in same)),
                float((weight * (size - middle) * stiffness).sum() / moment),
                float(moment**-0.5),
            )
        )
    return effects


def model_loop(modulus: complex, amplitude_m: float, n: int = 200) -> Array:
    """The ellipse (n, 2) of displacement, m, and force, N, of a linear specimen."""
    turn = amplitude_m * np.exp(2j * np.pi * np.arange(n) / (n - 1))
    return np.stack([turn.real, (modulus * turn).real], axis=1)


def _cycles(time_s: Array, x: Array, force: Array) -> list[_Cycle]:
    crossings = _upward(time_s, x - _middle(x))
    found = []
    for begin, end in pairwise(crossings):
        first, last = np.searchsorted(time_s, [begin, end])
        if last - first >= LEAST_SAMPLES:
            phase = 2 * np.pi * (time_s[first:last] - begin) / (end - begin)
            moved = _harmonics(phase, x[first:last])
            pushed = _harmonics(phase, force[first:last])
            found.append(
                _Cycle(
                    int(first), int(last), phase, 1 / (end - begin), moved[0], pushed[0], pushed[2]
                )
            )
    return found


def _middle(x: Array) -> float:
    return float(0.5 * (x.max() + x.min()))


def _upward(time_s: Array, x: Array) -> list[float]:
    """Instants at which x passes zero upward, each after it has been clearly below."""
    least = STILL * float(np.abs(x).max())
    found: list[float] = []
    armed = False
    for i in range(1, len(x)):
        if x[i] < -least:
            armed = True
        if armed and x[i - 1] < 0.0 <= x[i]:
            share = x[i - 1] / (x[i - 1] - x[i])
            found.append(float(time_s[i - 1] + share * (time_s[i] - time_s[i - 1])))
            armed = False
    return found


def _harmonics(phase: Array, values: Array) -> ComplexArray:
    """Complex amplitudes (HARMONICS,) of exp(ikφ), beside a mean and a drift."""
    columns = [np.ones(len(phase)), phase]
    for k in range(1, HARMONICS + 1):
        columns += [np.cos(k * phase), -np.sin(k * phase)]
    solved = np.linalg.lstsq(np.stack(columns, axis=1), values, rcond=None)[0]
    return np.asarray(solved[2::2] + 1j * solved[3::2])


def _alike(cycles: Sequence[_Cycle]) -> list[list[_Cycle]]:
    """Neighbours that differ little from the first of their group."""
    groups: list[list[_Cycle]] = []
    for cycle in cycles:
        if groups and cycle.first - groups[-1][-1].last <= 1:
            other = groups[-1][0] if len(groups[-1]) == 1 else groups[-1][1]
            change = (
                cycle.frequency_hz / other.frequency_hz,
                abs(cycle.displacement / other.displacement),
            )
            if max(abs(np.log(change))) < ALIKE:
                groups[-1].append(cycle)
                continue
        groups.append([cycle])
    return groups


def _point(cycles: Sequence[_Cycle], x: Array, force: Array) -> Point:
    ratios = np.array([c.force / c.displacement for c in cycles])
    spread = np.sqrt(0.5 * (np.abs(ratios - ratios.mean()) ** 2).sum() / (len(ratios) - 1))
    middle = cycles[len(cycles) // 2]
    part = slice(middle.first, middle.last)
    phase = middle.phase + np.angle(middle.displacement)
    loop = np.stack([x[part] - x[part].mean(), force[part] - force[part].mean(), phase], axis=1)
    return Point(
        float(np.mean([c.frequency_hz for c in cycles])),
        float(np.mean([abs(c.displacement) for c in cycles])),
        complex(ratios.mean()),
        float(spread / np.sqrt(len(ratios))),
        len(cycles),
        float(np.mean([abs(c.third / c.force) for c in cycles])),
        loop,
    )


def _by_frequency(found: Sequence[Point]) -> list[list[Point]]:
    groups: list[list[Point]] = []
    for point in sorted(found, key=lambda p: p.frequency_hz):
        if groups and np.log(point.frequency_hz / groups[-1][0].frequency_hz) < 0.4 * ALIKE:
            groups[-1].append(point)
        else:
            groups.append([point])
    return groups


def _merged(found: Sequence[Point]) -> list[Point]:
    """Points at one frequency made one, weighed by their cycles."""
    merged = []
    for same in _by_frequency(found):
        cycles = np.array([p.cycles for p in same])
        share = cycles / cycles.sum()
        merged.append(
            Point(
                float(share @ [p.frequency_hz for p in same]),
                float(share @ [p.amplitude_m for p in same]),
                complex(share @ [p.modulus for p in same]),
                float(np.sqrt((share**2) @ [p.uncertainty**2 for p in same])),
                int(cycles.sum()),
                float(share @ [p.third for p in same]),
                same[0].loop,
            )
        )
    return merged
