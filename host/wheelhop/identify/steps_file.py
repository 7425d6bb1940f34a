"""Step responses from a table: time_s, and one column for each point and force, B1/F1 … B4/F4."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import CampaignError
from wheelhop.files import read_text

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class StepResponses:
    """Displacements (forces, points, n), m, after each force steps up by 1 N at time 0."""

    time_s: Array
    responses: Array
    points: tuple[str, ...]
    forces: tuple[str, ...]


def read_steps(path: Path, force_N: float = 1.0) -> StepResponses:
    """Read a CSV file with the columns time_s and POINT/FORCE, metres for a step of `force_N`.

    Raises
    ------
    CampaignError : a file, header or cell that is wrong, naming its line and column.
    """
    lines = [line for line in read_text(path, CampaignError).split("\n") if line.strip()]
    if len(lines) < 3:
        raise CampaignError(f"{path}: needs a header and two rows or more")
    header = [name.strip() for name in lines[0].split(",")]
    if header[0] != "time_s":
        raise CampaignError(f'{path}: the first column must be time_s, not "{header[0]}"')
    pairs = [name.split("/") for name in header[1:]]
    bad = next((n for n, p in zip(header[1:], pairs, strict=True) if len(p) != 2), None)
    if bad is not None or not pairs:
        raise CampaignError(f'{path}: column "{bad}": name it POINT/FORCE, such as B1/F1')
    points = tuple(dict.fromkeys(point for point, _ in pairs))
    forces = tuple(dict.fromkeys(force for _, force in pairs))
    if len(set(map(tuple, pairs))) != len(pairs) or len(pairs) != len(points) * len(forces):
        raise CampaignError(
            f"{path}: {len(points)} points and {len(forces)} forces need each response once,"
            f" {len(points) * len(forces)} columns, not {len(pairs)}"
        )
    values = _cells(path, header, lines[1:])
    time_s = values[:, 0]
    steps = np.diff(time_s)
    if abs(time_s[0]) > 1e-9 or (np.abs(steps - steps.mean()) > 1e-3 * abs(steps.mean())).any():
        raise CampaignError(f"{path}: time_s must begin at 0, when the force steps, and be uniform")
    out = np.empty((len(forces), len(points), len(time_s)))
    for column, (point, force) in enumerate(pairs, start=1):
        out[forces.index(force), points.index(point)] = values[:, column] / force_N
    return StepResponses(time_s, out, points, forces)


def _cells(path: Path, header: list[str], rows: list[str]) -> Array:
    values = np.empty((len(rows), len(header)))
    for number, row in enumerate(rows, start=2):
        cells = row.split(",")
        if len(cells) != len(header):
            raise CampaignError(
                f"{path}: row {number} has {len(cells)} cells, the header {len(header)}"
            )
        for column, cell in enumerate(cells):
            try:
                values[number - 2, column] = float(cell)
            except ValueError:
                values[number - 2, column] = np.nan
            if not np.isfinite(values[number - 2, column]):
                raise CampaignError(
                    f'{path}: row {number}, column {header[column]}: "{cell.strip()}" is not a'
                    " finite number"
                )
    return values
