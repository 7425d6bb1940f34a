"""MATLAB's .mat files, for reading: up to version 7 by SciPy, 7.3 as the HDF5 that they are."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from wheelhop.files import NUMBERS, check_room
from wheelhop.formats.arrays import Folder, tables_of
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.mapping import Map
from wheelhop.formats.table import Table

HDF5 = b"\x89HDF"
HDF5_AT = 512  # behind MATLAB's own header
UNITS = ("unit", "units", "Unit", "Units")


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Read the vectors and matrices of numbers in the workspace and its structs."""
    with path.open("rb") as file:
        head = file.read(HDF5_AT + len(HDF5))
    if head.endswith(HDF5) or head.startswith(HDF5):
        from wheelhop.formats import hdf5

        return hdf5.load(path, mapping)
    from scipy import io

    count = sum(int(np.prod(shape)) for _, shape, _ in io.whosmat(path))
    check_room(path, max(NUMBERS * count, path.stat().st_size), ExchangeError)
    workspace = io.loadmat(path, simplify_cells=True)
    top = Folder()
    _fill(top, {k: v for k, v in workspace.items() if not k.startswith("__")})
    try:
        return tables_of(top, path, "MATLAB", mapping)
    except ExchangeError:
        if "__function_workspace__" not in workspace:
            raise
        raise ExchangeError(
            f"{path}: holds MATLAB objects (timetable, table, timeseries): save a struct of plain"
            " vectors, such as s = table2struct(timetable2table(t), ToScalar=true)"
        ) from None


def _fill(folder: Folder, values: Mapping[str, Any]) -> None:
    said = next((values[key] for key in UNITS if isinstance(values.get(key), str)), "")
    for name, value in values.items():
        for label, item in _items(name, value):
            if isinstance(item, Mapping):
                inside = Folder(f"{folder.name}.{label}" if folder.name else label)
                folder.inside.append(inside)
                _fill(inside, item)
            elif isinstance(item, int | float | np.ndarray) and not isinstance(item, str):
                folder.add(label, np.asarray(item), said if "," not in said else "")


def _items(name: str, value: Any) -> list[tuple[str, Any]]:
    """A value by its name; those of a cell or an array of structs are numbered."""
    if not isinstance(value, list):
        return [(name, value)]
    return [(f"{name} {k}", item) for k, item in enumerate(value, start=1)]
