"""The test kit of effects: does one do what every effect must?"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wheelhop.api.simulating import simulate
from wheelhop.campaign.sample import VEHICLE
from wheelhop.effects import Amplitude, Effect, Given, Parameter, RandomHeights, pick
from wheelhop.files import InputError, quoted, write_text
from wheelhop.files.words import listed, unit_of
from wheelhop.predict.drives import CHANNELS
from wheelhop.vehicle import Vehicle, read_vehicle

if TYPE_CHECKING:
    from pandas import DataFrame

TRACKS, SPEED_KMPH = ("washboard/high", "herringbone/high"), 10.0
"""Waves, straight and slanted, so high and fast that springs, dampers, tyres and roll have work to
do, and wheels lift."""
SECONDS = 4.0
LEAST = 1e-4
"""Of the record's rms: a hundredth of the noise of common sensors. What laws add that do nothing,
by rounding and by shorter steps of the integration, is a fortieth of that."""


def check_effect(effect: Given, vehicle: Vehicle | str | Path | None = None) -> DataFrame:
    """Hold an effect against what every effect must do, on two simulated drives over waves.

    It states its id, place, title, equation and source; its parameters have distinct names that end
    in their units, and scales above 0; with its amplitudes absent the record is that without the
    effect; at its scale every amplitude changes the record, and the record stays finite.

    Parameters
    ----------
    effect
        The effect, as an object or a class.
    vehicle
        The vehicle, or its vehicle.toml; by default wheelhop's sample of a quad.

    Returns
    -------
    DataFrame
        By parameter: unit, kind ("amplitude", "switch" or "shape"), scale, and `change`: by how
        much the record changes with the parameter at its scale, over the record's rms (NaN of a
        shape).

    Raises
    ------
    InputError
        It does not do one of these things: one line that says which, and what to do.
    """
    import pandas

    (made,) = pick(effect, {})
    known = _vehicle(vehicle)
    made = made.with_choice(made.choices(CHANNELS)[0])
    parameters = _parameters(made, known)
    before = _record(made, known, None)
    size = float(np.sqrt(np.mean(before**2)))
    absent = {p.name: p.absent for p in parameters if isinstance(p, Amplitude)}
    # What is free in every run is drawn, and is not nothing.
    drawn = type(made).per_run is not Effect.per_run or isinstance(made, RandomHeights)
    left = 0.0 if drawn else _change(before, _record(made, known, absent)) / size
    if not left <= LEAST:
        raise InputError(
            f"{made.id}: with its amplitudes absent the record still changes, by {left:.2g} of its"
            " rms: let it vanish with them, or state another absent value"
        )
    rows = []
    for p in parameters:
        change = float("nan")
        if isinstance(p, Amplitude):
            change = _change(before, _record(made, known, {**absent, p.name: _at_scale(p)})) / size
        kind = type(p).__name__.lower()
        rows.append({"parameter": p.name, "unit": p.unit, "kind": kind, "scale": p.scale})
        rows[-1]["change"] = change
    table = pandas.DataFrame(rows).set_index("parameter")
    idle = [str(name) for name in table.index[table["change"] <= LEAST]]
    if idle and len(idle) == int(table["change"].notna().sum()):
        raise InputError(
            f"{made.id}: nothing changes with {listed(idle)} at the scale stated: let modify, or"
            " another hook, use it, or state a clearly visible scale"
        )
    return table


def _vehicle(given: Vehicle | str | Path | None) -> Vehicle:
    if isinstance(given, Vehicle):
        return given
    if given is not None:
        return read_vehicle(Path(given))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "vehicle.toml"
        write_text(file, VEHICLE.format(title=quoted("sample")))
        return read_vehicle(file)


def _parameters(effect: Effect, vehicle: Vehicle) -> tuple[Parameter, ...]:
    """The effect's parameters, each as it should be."""
    applies = effect.applies_to(vehicle.values)
    found = tuple(effect.parameters_for(vehicle.values, CHANNELS)) if applies else ()
    if not found:
        raise InputError(f"{effect.id}: does not apply to this vehicle: check it on one it does")
    names = [p.name for p in found]
    for p in found:
        if names.count(p.name) > 1:
            raise InputError(f"{effect.id}: two parameters are called {p.name}: rename one")
        if not (np.isfinite(p.scale) and p.scale > 0.0):
            raise InputError(f"{effect.id}: {p.name} has scale {p.scale:g}: state one above 0")
        if unit_of(p.name) and not _alike(unit_of(p.name), p.unit):
            raise InputError(
                f"{effect.id}: {p.name} is given in {p.unit}, and its name ends in"
                f" {unit_of(p.name)}: end it in the unit"
            )
        if isinstance(p, Amplitude) and not p.lower <= p.absent <= p.upper:
            raise InputError(
                f"{effect.id}: {p.name} is absent at {p.absent:g}, outside its bounds"
                f" {p.lower:g} … {p.upper:g}: move one of them"
            )
    return found


def _alike(unit: str, other: str) -> bool:
    """Whether two spellings are of one unit."""
    plain = [text.replace("·", " ").replace("*", " ").split() for text in (unit, other)]
    return plain[0] == plain[1]


def _at_scale(parameter: Amplitude) -> float:
    return min(max(parameter.typical, parameter.lower), parameter.upper)


def _record(
    effect: Effect, vehicle: Vehicle, values: Mapping[str, float] | None
) -> NDArray[np.float64]:
    """The records (n, 8) of the drives, m/s²; without the effect where no values are given."""
    words = [] if values is None else [f"{k}={v!r}" for k, v in values.items()]
    form = effect.choices(CHANNELS)[0]
    words += [f"form={form}"] if form else []
    add = () if values is None else ":".join([effect.id, *words])
    made = simulate(
        *(vehicle, TRACKS, SPEED_KMPH, add),
        effects={effect.id: effect},
        noise_rms=0.0,
        seconds=SECONDS,
    )
    record = np.concatenate([run.record for run in made])
    if not np.isfinite(record).all():
        raise InputError(f"{effect.id}: the record is not finite: the vehicle runs away with it")
    return record


def _change(before: NDArray[np.float64], after: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean((after - before) ** 2)))
