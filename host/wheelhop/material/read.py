"""Rig data on disk: a table of moduli, or time signals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import numpy as np

from wheelhop.campaign.recordings import read_columns
from wheelhop.files import read_text
from wheelhop.material.data import ModulusData, checked
from wheelhop.material.error import MaterialError
from wheelhop.material.model import Array
from wheelhop.material.rig import AmplitudeEffect, Point, amplitude_effects, modulus_data, points

STIFFNESS = {"N_m": 1.0, "N_mm": 1e3, "kN_m": 1e3, "kN_mm": 1e6}
LENGTH = {"m": 1.0, "mm": 1e-3}
FORCE = {"N": 1.0, "kN": 1e3}
HOLDS = (
    "a file holds frequency_hz, dynamic_N_mm, loss_N_mm (or in N_m, kN_mm), or time_s,"
    " displacement_mm, force_N (or in m, kN)"
)


@dataclass(frozen=True, eq=False)
class RigData:
    """What is known of one specimen: the moduli a model is fitted to, and, from time signals, the
    points of every amplitude and the change with it."""

    moduli: ModulusData
    points: tuple[Point, ...] = ()
    amplitude_effects: tuple[AmplitudeEffect, ...] = ()


def read_rig_data(file: Path) -> RigData:
    """Read a table of moduli (.csv) or time signals (.csv, .parquet), in the units
    of the columns' names.

    Raises `MaterialError` or `CampaignError`, one line, for columns that are missing, unknown or in
    units that do not go together, and for moduli no specimen can have.
    """
    table = _table(file) if file.suffix.lower() == ".csv" else None
    if table is not None:
        return RigData(_moduli(file, table))
    names, values = read_columns(file)
    columns = dict(zip(names, values.T, strict=True))
    x, metres = _column(file, columns, "displacement", LENGTH)
    force, newtons = _column(file, columns, "force", FORCE)
    _only(file, columns, 3)
    time_s = columns["time_s"]
    falling = (time_s[1:] <= time_s[:-1]).nonzero()[0]
    if len(falling):
        raise MaterialError(
            f"{file}: time_s does not rise at {time_s[falling[0] + 1]:g} s; cut the file there"
        )
    found = points(str(file), time_s, metres * x, newtons * force)
    moduli = checked(modulus_data(str(file), found))
    return RigData(moduli, tuple(found), tuple(amplitude_effects(found)))


def _table(file: Path) -> dict[str, Array] | None:
    """The columns of a table of moduli; None for a file with time stamps."""
    lines = read_text(file, MaterialError).rstrip().split("\n")
    names = [name.strip().strip('"') for name in lines[0].split(",")]
    if "time_s" in names:
        return None
    if "frequency_hz" not in names:
        raise MaterialError(f"{file}: there is no column frequency_hz or time_s; {HOLDS}")
    if len(set(names)) < len(names):
        raise MaterialError(f"{file}: two columns have the same name")
    rows = []
    for number, line in enumerate(lines[1:], start=2):
        try:
            row = [float(cell) for cell in line.split(",")]
        except ValueError:
            raise MaterialError(f"{file}: line {number}: not numbers between commas") from None
        if len(row) != len(names):
            raise MaterialError(
                f"{file}: line {number}: {len(row)} values under {len(names)} columns"
            )
        for name, value in zip(names, row, strict=True):
            if not isfinite(value):
                raise MaterialError(f"{file}: line {number}: {name} is {value}; leave the row out")
        rows.append(row)
    if not rows:
        raise MaterialError(f"{file}: holds no frequencies")
    return dict(zip(names, np.array(rows).T, strict=True))


def _moduli(file: Path, columns: Mapping[str, Array]) -> ModulusData:
    dynamic, unit = _column(file, columns, "dynamic", STIFFNESS)
    loss, loss_unit = _column(file, columns, "loss", STIFFNESS)
    count, spread, spread_unit = 3, loss * float("nan"), unit
    if any(name.startswith("uncertainty_") for name in columns):
        spread, spread_unit = _column(file, columns, "uncertainty", STIFFNESS)
        count = 4
    _only(file, columns, count)
    if not unit == loss_unit == spread_unit:
        raise MaterialError(
            f"{file}: the columns of dynamic and loss modulus are in different units; write both in"
            " the same"
        )
    return checked(
        ModulusData(
            str(file),
            columns["frequency_hz"],
            np.asarray(unit * (dynamic + 1j * loss), dtype=np.complex128),
            unit * spread,
        )
    )


def _column(
    file: Path, columns: Mapping[str, Array], what: str, units: Mapping[str, float]
) -> tuple[Array, float]:
    """The one column of a quantity, and its unit in SI."""
    found = [name for name in columns if name == what or name.startswith(f"{what}_")]
    if len(found) != 1:
        number = "no column" if not found else "more than one column"
        raise MaterialError(f"{file}: there is {number} {what}_{_choice(units)}; {HOLDS}")
    unit = found[0].removeprefix(what).removeprefix("_")
    if unit not in units:
        raise MaterialError(
            f"{file}: {found[0]}: the unit of {what} is one of {_choice(units)}: write it into the"
            f" column's name, such as {what}_{next(iter(units))}"
        )
    return columns[found[0]], units[unit]


def _choice(units: Sequence[str] | Mapping[str, float]) -> str:
    return ", ".join(units)


def _only(file: Path, columns: Mapping[str, Array], count: int) -> None:
    if len(columns) > count:
        known = ("frequency_hz", "time_s")
        stems = ("dynamic", "loss", "uncertainty", "displacement", "force")
        extra = [n for n in columns if n not in known and n.split("_")[0] not in stems]
        raise MaterialError(f"{file}: unexpected column {(extra or list(columns))[-1]}; {HOLDS}")
