"""HDF5, through h5py, for reading; MATLAB's 7.3 is one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from wheelhop.files import NUMBERS, check_room
from wheelhop.formats.arrays import Folder, tables_of
from wheelhop.formats.error import ExchangeError, need
from wheelhop.formats.mapping import Map
from wheelhop.formats.table import Table

UNITS = ("unit", "units", "Unit", "Units", "UNITS")
SCALINGS = {
    **dict.fromkeys(("scale", "scale_factor", "gain", "factor", "slope", "multiplier"), 1.0),
    **dict.fromkeys(("offset", "add_offset"), 0.0),
}
"""Attributes that say how values would have to be converted, each with the number that says
nothing."""
MISSING = frozenset(("_FillValue", "missing_value"))
"""Attributes that hold the number that stands where there is no sample."""
MATLAB_TEXT = b"char"
REFERENCES = "#refs#"  # where MATLAB keeps what cells point at


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Read the vectors, matrices and tables of numbers in every group."""
    h5py = need("h5py", "hdf5", path)
    top, sizes = Folder(), []
    with h5py.File(path, "r") as file:
        file.visititems(lambda _, item: sizes.append(getattr(item, "size", 0) or 0))
        check_room(path, NUMBERS * sum(sizes), ExchangeError)
        _fill(top, file, h5py)
    return tables_of(top, path, "HDF5", mapping)


def _fill(folder: Folder, group: Any, h5py: Any) -> None:
    for name, number in group.attrs.items():
        if np.ndim(number) == 0 and isinstance(number, int | float | np.number):
            folder.numbers[name] = float(number)
    for name, item in group.items():
        if name == REFERENCES:
            continue
        if isinstance(item, h5py.Group):
            inside = Folder(f"{folder.name}/{name}" if folder.name else name)
            folder.inside.append(inside)
            _fill(inside, item, h5py)
        elif item.attrs.get("MATLAB_class") != MATLAB_TEXT:
            _add(folder, name, item)


def _add(folder: Folder, name: str, item: Any) -> None:
    """A dataset of numbers; one of records by its fields, in a folder of its own."""
    numbers = {
        key: float(np.reshape(number, -1)[0])
        for key, number in item.attrs.items()
        if np.size(number) == 1 and np.asarray(number).dtype.kind in "iuf"
    }
    folder.numbers |= {f"{name}.{key}": number for key, number in numbers.items()}
    raw = [f"{k} = {v:g}" for k, v in numbers.items() if SCALINGS.get(k.lower(), v) != v]
    if raw:
        said = f"{name}: {', '.join(raw)} is not applied: the values are raw, in an unknown unit"
        folder.remarks.append(said)
    if item.dtype.names:
        inside = Folder(f"{folder.name}/{name}" if folder.name else name)
        folder.inside.append(inside)
        for part in item.dtype.names:
            inside.add(part, item[part])
    elif item.dtype.kind in "iufb" and item.shape is not None:
        values = item[()]
        for key in MISSING & numbers.keys():
            values = np.where(values == numbers[key], np.nan, values)
        folder.add(name, values, "" if raw else _unit(item))


def _unit(item: Any) -> str:
    found = (item.attrs.get(key) for key in UNITS)
    said = next((unit for unit in found if isinstance(unit, str | bytes)), "")
    return said.decode("utf-8", "replace") if isinstance(said, bytes) else said
