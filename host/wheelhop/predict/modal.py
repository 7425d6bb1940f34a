"""A vehicle's modes, where their energy sits, what moves them, and what the vehicle makes of waves.

All of it is of the linear part: force laws (friction, stops) are left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import pi
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wheelhop.campaign import CampaignError, Channel
from wheelhop.predict.case import check_stable
from wheelhop.predict.ride import driver_output
from wheelhop.simulate import Model
from wheelhop.vehicle import (
    System,
    axle_name,
    axles,
    behind_m,
    kinetic_shares,
    static_tyre_load,
    wheels,
)

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

STEP = 1e-4
"""Of a number, relative, over which differences are taken; matrices are smooth in them."""
SPRINGS: Mapping[str, float] = {"_N_m": 1.0, "_hz": 0.5}
DAMPERS: Mapping[str, float] = {"_N_s_m": 1.0, "zeta": 1.0, "damping_ratio": 1.0}
"""How keys of stiffness and damping end, and the share of K p ∂/∂p that is theirs: stiffness is
quadratic in a frequency."""


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes by frequency (k), over free coordinates (n) and numbers of the model (p).

    `pole` (k,), rad/s, has an imaginary part of 0 where a mode does not oscillate. `shape` (k, n)
    is 1 where it is largest. `kinetic` (k, n) are the coordinates' shares of the kinetic energy,
    `strain` and `dissipated` (k, p) those of springs and dampers of the potential energy and of
    what is lost; they add up to 1. `frequency_by` and `damping_by` (k, p) are sensitivities: the
    relative change of frequency or damping ratio per relative change of a number.
    `frequency_sd_hz` (k,) is what the numbers' uncertainties, as far as stated, make of the
    frequency. `left_out` are effects whose force laws are not in it.
    """

    name: str
    coordinates: tuple[str, ...]
    numbers: tuple[str, ...]
    pole: ComplexArray
    shape: ComplexArray
    kinetic: Array
    strain: Array
    dissipated: Array
    frequency_by: Array
    damping_by: Array
    frequency_sd_hz: Array
    left_out: tuple[str, ...] = ()

    @cached_property
    def frequency_hz(self) -> Array:
        """Natural frequencies |λ|/2π (k,)."""
        return np.abs(self.pole) / (2 * pi)

    @cached_property
    def damping_ratio(self) -> Array:
        """−Re λ/|λ| (k,); 1 where a mode does not oscillate."""
        return np.asarray(-self.pole.real / np.abs(self.pole))

    def to_dataframe(self) -> DataFrame:
        """One row for each mode: frequency, its uncertainty, damping, and where its energy is."""
        import pandas

        table = pandas.DataFrame(
            {
                "frequency_hz": self.frequency_hz,
                "frequency_sd_hz": self.frequency_sd_hz,
                "damping_ratio": self.damping_ratio,
            }
        )
        for what, names, shares in (
            ("kinetic", self.coordinates, self.kinetic),
            ("strain", self.numbers, self.strain),
            ("dissipated", self.numbers, self.dissipated),
        ):
            for name, share in zip(names, shares.T, strict=True):
                if what == "kinetic" or share.any():
                    table[f"{what} {name}"] = share
        return table

    def sensitivities(self) -> DataFrame:
        """∂ln f/∂ln p: a row for each number, a column for each mode by its frequency."""
        import pandas

        columns = [f"{f:.3g} Hz" for f in self.frequency_hz]
        return pandas.DataFrame(self.frequency_by.T, list(self.numbers), columns)

    def __repr__(self) -> str:
        found = ", ".join(f"{f:.3g}" for f in self.frequency_hz)
        return f"<Modes of {self.name}: {found} Hz>"


def modes(model: Model, name: str, uncertainty: Mapping[str, float]) -> Modes:
    """The modes of a vehicle on its tyres, which stand still.

    With M, C, K symmetric and a mode's (λ, x), ∂λ/∂p = −xᵀ(λ²∂M + λ∂C + ∂K)x / xᵀ(2λM + C)x
    (e.g. S. Adhikari, Structural Dynamic Analysis with Generalized Damping Models: Analysis, Wiley
    2014, section 1.4).

    Raises CampaignError for a vehicle that is not stable.
    """
    system = model.system((), "road")
    check_stable(system)
    pole, shape = _solved(system)
    numbers, change = _changes(model, system)
    raised = (pole**2)[:, None], pole[:, None], np.ones((len(pole), 1))
    moved = sum(a * _forms(shape, matrix) for a, matrix in zip(raised, change, strict=True))
    own = 2 * pole * _form(shape, system.mass) + _form(shape, system.damping)
    rate = -moved / own[:, None]  # p ∂λ/∂p
    by_frequency = (np.conj(pole)[:, None] * rate).real / (np.abs(pole) ** 2)[:, None]
    fixed = (pole.imag == 0.0) | (pole.real == 0.0)  # at 1, or at 0
    by_damping = rate.real / np.where(fixed, np.inf, pole.real)[:, None] - by_frequency
    by_damping[fixed] = 0.0
    relative = np.array(
        [uncertainty.get(key, 0.0) / abs(model.values[key]) for key in numbers], dtype=float
    )
    frequency = np.abs(pole) / (2 * pi)
    return Modes(
        name,
        system.coordinates,
        numbers,
        pole,
        shape,
        kinetic_shares(shape, system.mass),
        _shares(shape, system.stiffness, change[2], numbers, SPRINGS),
        _shares(shape, system.damping, change[1], numbers, DAMPERS),
        by_frequency,
        by_damping,
        frequency * np.sqrt((by_frequency**2) @ relative**2),
        tuple(e.id for e in model.effects if _has_laws(model, e.id)),
    )


@dataclass(frozen=True, eq=False)
class Transmissibility:
    """What ground that rises and falls evenly under all wheels does, per its height (f,).

    `driver` is his acceleration over that of the ground; `travel` of the struts of an axle, by its
    end, m per m, the mean of both; `tyre_load` the load of its tyres beyond the static one, over
    that, per m.
    """

    frequency_hz: Array
    driver: ComplexArray
    travel: Mapping[str, ComplexArray]
    tyre_load: Mapping[str, ComplexArray]


def transmissibility(
    model: Model, frequency_hz: ArrayLike, speed_m_s: float | None = None
) -> Transmissibility:
    """Of a vehicle's linear part; at a speed the rear wheels meet the waves later.

    Raises CampaignError for a vehicle that is not stable, and frequencies that are not above 0.
    """
    frequency = np.atleast_1d(np.asarray(frequency_hz, dtype=np.float64))
    if not (np.isfinite(frequency).all() and (frequency > 0.0).all()):
        raise CampaignError("frequencies must be above 0 Hz")
    rolling = wheels(model.values)
    points = [Channel(p, p) for end in "BA" for i in rolling for p in (f"{end}{i + 1}",)]
    system = model.system(points, "road")
    check_stable(system)
    omega = 2 * pi * frequency[:, None, None]
    late_s = [behind_m(model.values, i) / speed_m_s if speed_m_s else 0.0 for i in rolling]
    height = np.exp(-1j * omega * np.array(late_s)[:, None])
    dynamic = system.stiffness - omega**2 * system.mass + 1j * omega * system.damping
    driven = system.input_stiffness + 1j * omega * system.input_damping
    moved = np.linalg.solve(dynamic, driven @ height)
    half = len(rolling)
    body, hub = (system.output[rows] @ moved for rows in (slice(half), slice(half, None)))
    extension = np.asarray((body - hub)[:, :, 0], dtype=np.complex128)
    # The ground's own stiffness and damping are the sums of those that couple it.
    b, d = system.input_stiffness, system.input_damping
    rigid = np.array([(b + 1j * w * d).sum(axis=0) for w in omega[:, 0, 0]])
    force = rigid * height[:, :, 0] - (np.swapaxes(driven, 1, 2) @ moved)[:, :, 0]
    static = np.array([static_tyre_load(model.values, i) for i in rolling])
    load = np.asarray(force / static, dtype=np.complex128)
    ends = {end: [axle_name(i) == end for i in rolling] for end in axles(model.values)}
    return Transmissibility(
        frequency,
        np.asarray(driver_output(model) @ moved[:, :, 0].T),
        {end: extension[:, both].mean(axis=1) for end, both in ends.items()},
        {end: load[:, both].mean(axis=1) for end, both in ends.items()},
    )


def _solved(system: System) -> tuple[ComplexArray, ComplexArray]:
    """Poles (k,) and shapes (k, n), one of each conjugate pair, by frequency."""
    n = len(system.mass)
    a = np.zeros((2 * n, 2 * n))
    a[:n, n:] = np.eye(n)
    a[n:, :n] = -np.linalg.solve(system.mass, system.stiffness)
    a[n:, n:] = -np.linalg.solve(system.mass, system.damping)
    pole, vector = np.linalg.eig(a)
    kept = np.flatnonzero(pole.imag >= 0.0)
    kept = kept[np.argsort(np.abs(pole[kept]))]
    shape = vector[:n, kept].T
    largest = np.abs(shape).argmax(axis=1)
    found = shape / shape[np.arange(len(kept)), largest][:, None]
    return pole[kept].astype(complex), found.astype(complex)


def _changes(model: Model, system: System) -> tuple[tuple[str, ...], tuple[Array, Array, Array]]:
    """Numbers that the matrices depend on, and p ∂M/∂p, p ∂C/∂p, p ∂K/∂p, (p, n, n) each."""
    numbers: list[str] = []
    found: tuple[list[Array], list[Array], list[Array]] = ([], [], [])
    for key, value in model.values.items():
        if value == 0.0:
            continue
        beside = [
            model.with_values({key: value * (1 + step)}).system((), "road")
            for step in (STEP, -STEP)
        ]
        if any(len(other.mass) != len(system.mass) for other in beside):
            continue  # at a bound where a part of the model disappears
        changes = [
            (getattr(beside[0], what) - getattr(beside[1], what)) / (2 * STEP)
            for what in ("mass", "damping", "stiffness")
        ]
        if any(change.any() for change in changes):
            numbers.append(key)
            for collected, change in zip(found, changes, strict=True):
                collected.append(change)
    mass, damping, stiffness = (np.array(one) for one in found)
    return tuple(numbers), (mass, damping, stiffness)


def _form(shape: ComplexArray, matrix: Array) -> ComplexArray:
    """xᵀ A x (k,) of every mode."""
    return np.asarray(np.einsum("ki,ij,kj->k", shape, matrix, shape))


def _forms(shape: ComplexArray, matrices: Array) -> ComplexArray:
    """xᵀ A x (k, p) of every mode and matrix (p, n, n)."""
    return np.asarray(np.einsum("ki,pij,kj->kp", shape, matrices, shape))


def _shares(
    shape: ComplexArray,
    whole: Array,
    changes: Array,
    numbers: tuple[str, ...],
    endings: Mapping[str, float],
) -> Array:
    """What each number has of xᴴ A x, of a matrix A that is the sum of what numbers make."""
    total = np.einsum("ki,ij,kj->k", np.conj(shape), whole, shape).real
    each = np.einsum("ki,pij,kj->kp", np.conj(shape), changes, shape).real
    factor = [max((f for end, f in endings.items() if n.endswith(end)), default=0) for n in numbers]
    return np.asarray(each * factor / np.where(total > 0.0, total, np.inf)[:, None])


def _has_laws(model: Model, effect_id: str) -> bool:
    """Whether an effect of the model adds force laws."""
    with_it = len(model.system((), "road").port_law)
    return len(model.without_effect(effect_id).system((), "road").port_law) < with_it
