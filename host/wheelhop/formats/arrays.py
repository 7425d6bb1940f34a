"""Named arrays, as MATLAB and HDF5 keep them: which were sampled together, and over what."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.formats.columns import Column, Stated, Timing
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.groups import only_recordings
from wheelhop.formats.labels import name_and_unit
from wheelhop.formats.mapping import Map
from wheelhop.formats.table import Table, plain_channel
from wheelhop.formats.timing import find_timing, stamps_of

RATES = frozenset(
    ("fs", "fsamp", "samplerate", "samplingrate", "samplefrequency", "samplingfrequency")
)
STEPS = frozenset(("dt", "ts", "sampletime", "samplingtime", "sampleinterval"))
"""What a single number is called that is a rate, Hz, or a step, s; without blanks, case and _."""
MOST_COLUMNS = 256
"""An array that is wider in both directions is a picture or a matrix, not channels."""
FEWEST_ROWS = 3


@dataclass
class Folder:
    """A workspace, a struct or a group: its arrays by name with their units, its single numbers,
    the folders inside it, and what is worth a line in the history."""

    name: str = ""
    arrays: dict[str, tuple[NDArray[np.float64], str]] = field(default_factory=dict)
    numbers: dict[str, float] = field(default_factory=dict)
    inside: list[Folder] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def add(self, name: str, values: NDArray[np.generic], unit: str = "") -> None:
        """Keep an array of numbers: one of a single number as that, others by their columns, which
        run along the longer side; what holds no channels is passed over."""
        values = np.squeeze(values)
        if values.dtype.kind not in "iufb" or values.ndim > 2:
            return
        if values.ndim == 0:
            self.numbers[name] = float(values)
        elif values.ndim == 1 and len(values) >= FEWEST_ROWS:
            self.arrays[name] = values.astype(np.float64), unit
        elif values.ndim == 2 and min(values.shape) <= MOST_COLUMNS:
            columns = values if values.shape[0] > values.shape[1] else values.T
            for k, column in enumerate(columns.T, start=1):
                self.arrays[f"{name} {k}"] = column.astype(np.float64), unit


def tables_of(top: Folder, path: Path, kind: str, mapping: Map | None) -> list[Table]:
    """The recordings in a folder: arrays of one length that stand together, over their time.

    Raises `ExchangeError` where there are none.
    """
    refused: list[str] = []
    tables = list(_tables(top, {}, path, kind, mapping, refused))
    count = len({table.group for table in tables})
    if count < len(tables):
        tables = [replace(t, group=f"{t.group} {k}") for k, t in enumerate(tables, start=1)]
    if not tables and not refused:
        raise ExchangeError(f"{path}: holds no arrays of numbers, of {FEWEST_ROWS} or more")
    return only_recordings(tables, refused, path)


def _tables(
    folder: Folder,
    above: Mapping[str, float],
    path: Path,
    kind: str,
    mapping: Map | None,
    refused: list[str],
) -> Iterator[Table]:
    numbers = {**above, **folder.numbers}
    by_length: dict[int, list[Column]] = {}
    for name, (values, said) in folder.arrays.items():
        short, unit = name_and_unit(name, endings=False)  # z_g is no acceleration
        by_length.setdefault(len(values), []).append(Column(name, short, said or unit, values))
    for length, columns in by_length.items():
        group = folder.name or (f"{length} rows" if len(by_length) > 1 else "")
        try:
            bare = Table(path, kind, (), EMPTY, group=group, remarks=tuple(folder.remarks))
            table = _table(columns, numbers, bare, mapping)
        except ExchangeError as error:
            refused.append(str(error).removeprefix(f"{path}: "))
            continue
        if table is not None:
            yield table
    for inside in folder.inside:
        yield from _tables(inside, numbers, path, kind, mapping, refused)


EMPTY = np.empty((0, 0))


def _table(
    columns: Sequence[Column], numbers: Mapping[str, float], bare: Table, mapping: Map | None
) -> Table | None:
    """Columns of one length over the one of them that is time, or at the rate that a number says;
    None if there is nothing but time."""
    chosen = str(mapping.time) if mapping is not None else ""
    known = mapping.rate_hz if mapping is not None else None
    if chosen:
        index = next((k for k, column in enumerate(columns) if column.label == chosen), None)
        timing = Timing(index, mapping.time_unit if mapping else "")
    else:
        timing = find_timing(columns, _rates(numbers))
    index, aside = timing.index, set(timing.aside)
    asked = timing.questions[0].words if timing.questions else ""
    known = known or timing.rate_hz
    stamps, said = None, []
    if index is not None and not asked:
        stamps = stamps_of(columns[index], timing.unit, known, bare.file)
        aside |= {index}
        why = f", {timing.why}" if timing.why else ""
        said = [f"time is {columns[index].label}{why}", *stamps.remarks]
    elif timing.rate_hz is not None:
        said = [f"{timing.rate_hz:g} Hz: {timing.why}"]
    measured = [k for k in range(len(columns)) if k not in aside]
    if not measured:
        return None
    return replace(
        bare,
        channels=tuple(plain_channel(columns[k].label, columns[k].unit) for k in measured),
        values=np.column_stack([v for k in measured if (v := columns[k].values) is not None]),
        time_s=None if stamps is None else stamps.time_s,
        start_unix_s=None if stamps is None else stamps.start_unix_s,
        rate_hz=None if stamps is not None else known,
        numbers=tuple(k + 1 for k in measured),
        remarks=(*bare.remarks, *said),
        asked=asked,
        granted=timing.guess,
        same_clock=stamps is not None and stamps.start_unix_s is None,
    )


def _rates(numbers: Mapping[str, float]) -> dict[float, Stated]:
    """Rates, Hz, that single numbers state, by where they stand."""
    found: dict[float, Stated] = {}
    for name, value in numbers.items():
        plain = name.rpartition(".")[2].lower().replace("_", "").replace(" ", "")
        if plain in RATES and value > 0.0:
            found.setdefault(value, Stated(name))
        elif plain in STEPS and value > 0.0:
            found.setdefault(float(f"{1.0 / value:.9g}"), Stated(name))
    return found
