"""A car as it is known: the numbers and effects of a model.toml, or of a vehicle.toml, and how well
they are known together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import isfinite
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import CampaignError
from wheelhop.effects import Effect, Parameter
from wheelhop.files import Table, did_you_mean, read_toml
from wheelhop.predict.drives import CHANNELS, FORM, Chosen
from wheelhop.vehicle import MODELS, Vehicle, vehicle_in, wheels
from wheelhop.vehicle.layout import FULL_CAR, INERTIA

Array = NDArray[np.float64]


MODEL_FILE = "model.toml"
ENDING = "_uncertainty"
CERTAIN = 1e-9
"""Relative uncertainty of what a model.toml states none of: so little that no draw shows it, and
not 0, which a vehicle's file does not take."""
BELIEF = "belief:"
"""How the ids of mistakes in a campaign's files begin: they are no part of the car."""
CORRELATION = "correlation"
LEAST = 0.01
"""Of a number that must be above 0: no draw of the normal distribution makes it less."""
POSITIONS = (".x_m", ".y_m")
GROUPS = ("frame", "mount")
"""Of a vehicle's numbers, those that come from a file of their own."""


@dataclass(frozen=True, eq=False)
class KnownCar:
    """The vehicle and its effects, and the `covariance` (k, k), SI, of those of its numbers that
    are uncertain, `names` (k,). `misfit` is the error E that its model leaves of the runs that
    judge it, 0 where nothing was fitted; `correlated` tells whether correlations are known, else
    the numbers count as independent."""

    vehicle: Vehicle
    effects: tuple[Chosen, ...]
    names: tuple[str, ...]
    covariance: Array
    misfit: float
    correlated: bool

    @property
    def values(self) -> dict[str, float]:
        """All numbers by their dotted names, effects' own as "dry-friction.front_N"."""
        own = {
            f"{one.effect.id}.{name}": value
            for one in self.effects
            for name, value in one.values.items()
        }
        return {**self.vehicle.values, **own}

    def draws(self, count: int, rng: np.random.Generator) -> list[dict[str, float]]:
        """Cars as they may be: so many draws of all uncertain numbers, jointly normal, within their
        `bounds`."""
        spread, along = np.linalg.eigh(self.covariance)
        normal = rng.normal(size=(count, len(spread)))
        moved = normal * np.sqrt(np.maximum(spread, 0.0)) @ along.T
        values = self.values
        rows = moved + [values[name] for name in self.names]
        return [self.bounded(dict(zip(self.names, row.tolist(), strict=True))) for row in rows]

    def bounded(self, changes: Mapping[str, float]) -> dict[str, float]:
        """Numbers within their bounds: effects' own, and what may not be below 0 is no less than
        `LEAST` of what it is."""
        found = dict(changes)
        for name, value in changes.items():
            if name in self._parameters:
                of = self._parameters[name]
                found[name] = min(max(value, of.lower), of.upper)
            elif name in self.vehicle.values and not _any_sign(name):
                found[name] = max(value, LEAST * self.vehicle[name])
        return found

    @cached_property
    def _parameters(self) -> dict[str, Parameter]:
        values = self.vehicle.values
        return {
            f"{one.effect.id}.{p.name}": p
            for one in self.effects
            for p in parameters(one.effect, values)
        }


def parameters(effect: Effect, values: Mapping[str, float]) -> Sequence[Parameter]:
    """An effect's parameters on a vehicle whose points are all recorded."""
    there = wheels(values)
    return effect.parameters_for(values, [c for c in CHANNELS if c.corner in there])


def read_car(source: Path, library: Mapping[str, Effect]) -> KnownCar:
    """Read a campaign's model.toml, given its folder, any model.toml, or a vehicle.toml.

    Faults of sensors, mistakes in the campaign's files, and what an effect left free in each run
    are no part of the car. Raises CampaignError for a folder without a model, and for a file that
    is wrong.
    """
    file = source / MODEL_FILE if source.is_dir() else source
    if source.is_dir() and not file.exists():
        raise CampaignError(
            f"{file}: is not there: wheelhop add {source} EFFECT fits a model and stores it"
        )
    top = read_toml(file, CampaignError)
    if "component" in top:
        raise CampaignError(f"{file}: is the model of a component, and no car")
    if "vehicle" not in top:
        vehicle = vehicle_in(top, file.parent)
        known = {name: sd for name, sd in vehicle.uncertainty.items() if sd > 0.0}
        return KnownCar(vehicle, (), tuple(known), _diagonal(known), 0.0, False)
    top.format()
    vehicle = _vehicle(top)
    chosen, own = _effects(top, vehicle, library)
    spread = {n: sd for n, sd in vehicle.uncertainty.items() if sd > CERTAIN * abs(vehicle[n])}
    spread |= own
    names, correlation = _correlation(top, spread)
    deviation = np.array([spread[name] for name in names])
    covariance = correlation * np.outer(deviation, deviation)
    return KnownCar(
        vehicle, chosen, names, covariance, _misfit(top), CORRELATION in top and bool(names)
    )


def _diagonal(spread: Mapping[str, float]) -> Array:
    return np.diag(np.square(list(spread.values())))


def _any_sign(name: str) -> bool:
    return name.endswith(POSITIONS) or name.split(".")[0] in GROUPS


def _vehicle(top: Table) -> Vehicle:
    """The tables below [vehicle], which are those of a vehicle.toml but for what came from files
    of their own: that stands there as numbers."""
    table = top.table("vehicle")
    tables = {key: value for key, value in table.values.items() if key not in GROUPS}
    body = table.table("body")
    has = [motion for motion, key in INERTIA.items() if key.removeprefix("body.") in body]
    model = next((name for name, motions in MODELS.items() if list(motions) == has), FULL_CAR)
    head = {"format": 1, "name": top.text("vehicle_name"), "model": model}
    head["relative_uncertainty"] = CERTAIN
    vehicle = vehicle_in(Table(head | tables, top.file, kind=CampaignError), top.file.parent)
    more = {
        name: value
        for group in GROUPS
        if group in table
        for name, value in table.table(group).all_numbers(f"{group}.").items()
    }
    certain = {**vehicle.uncertainty, **dict.fromkeys(more, 0.0)}
    return replace(vehicle, values={**vehicle.values, **more}, uncertainty=certain)


def _effects(
    top: Table, vehicle: Vehicle, library: Mapping[str, Effect]
) -> tuple[tuple[Chosen, ...], dict[str, float]]:
    """The car's effects with their numbers, and the standard deviations of those by full names."""
    chosen, spread = list[Chosen](), dict[str, float]()
    for table in top.tables("effect", "id") if top.values.get("effect") else ():
        id_ = table.text("id")
        if id_.startswith(BELIEF) or (id_ in library and library[id_].place == "sensor"):
            continue
        if id_ not in library:
            near = did_you_mean(id_, library) or "; --library names the file that has it"
            raise table.error(f"there is no such effect{near}")
        effect, form = library[id_], table.text(FORM, "")
        if form:
            if form not in effect.choices(CHANNELS):
                raise table.error(f"there is no form {form}")
            effect = effect.with_choice(form)
        if not effect.applies_to(vehicle.values):
            raise table.error("does not apply to this vehicle")
        given = table.table("parameters")
        names = [p.name for p in parameters(effect, vehicle.values)]
        chosen.append(Chosen(effect, {name: given.number(name) for name in names}))
        for name in names:
            if f"{name}{ENDING}" in given:
                spread[f"{id_}.{name}"] = given.number(f"{name}{ENDING}", above=0.0)
    return tuple(chosen), spread


def _correlation(top: Table, spread: Mapping[str, float]) -> tuple[tuple[str, ...], Array]:
    """The uncertain numbers, and their correlations (k, k): those stated, else 0."""
    names = tuple(spread)
    matrix = np.eye(len(names))
    if CORRELATION not in top:
        return names, matrix
    table = top.table(CORRELATION)
    stated = list(table.values)
    for i, name in enumerate(stated):
        row = table.numbers(name)
        if len(row) != i + 1:
            raise table.error(f'"{name}" must have {i + 1} numbers: one each with {stated[:i]}, 1')
        if name in spread:
            for other, value in zip(stated[:i], row[:-1], strict=True):
                if other in spread:
                    a, b = names.index(name), names.index(other)
                    matrix[a, b] = matrix[b, a] = min(max(value, -1.0), 1.0)
    return names, matrix


def _misfit(top: Table) -> float:
    """The error of the last model of the ladder, on the runs held out if there are any."""
    last = top.tables("ladder", "added")[-1]
    held_out = last.values.get("error_validate")
    has_none = isinstance(held_out, float) and not isfinite(held_out)
    return last.number("error_fit" if has_none else "error_validate", at_least=0.0)
