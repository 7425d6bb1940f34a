"""Reading and writing Adams road data files (.rdf, TeimOrbit: blocks in [], tables of numbers).

Two of its roads are surveys. METHOD = '3D' has [NODES], number x y z, and [ELEMENTS], triangles of
three node numbers and a friction factor; read are nodes on a grid. METHOD = '2D' with
ROAD_TYPE = 'poly_line' has (XZ_DATA): x, height of the left track, of the right one, or one for
both. Lengths are in the file's unit. What begins with $ or ! is a comment.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from math import inf, isfinite
from pathlib import Path

import numpy as np

from wheelhop.campaign import CampaignError
from wheelhop.files import read_text, replacing
from wheelhop.track.track import Array

LENGTHS_M = {
    "meter": 1.0,
    "metre": 1.0,
    "m": 1.0,
    "mm": 1e-3,
    "millimeter": 1e-3,
    "cm": 1e-2,
    "centimeter": 1e-2,
    "km": 1e3,
    "kilometer": 1e3,
    "inch": 0.0254,
    "foot": 0.3048,
}
TOGETHER = 1e-6
"""Nodes whose coordinates differ by less, in the file's unit and relative to the extent, are in
one row or column of the grid."""
HEADER = """$ written by wheelhop
[MDI_HEADER]
FILE_TYPE = 'rdf'
FILE_VERSION = 5.00
FILE_FORMAT = 'ASCII'
[UNITS]
LENGTH = 'mm'
FORCE = 'newton'
ANGLE = 'degree'
MASS = 'kg'
TIME = 'sec'
[MODEL]
METHOD = '3D'
FUNCTION_NAME = 'ARC903'
[OFFSET]
X = 0.0
Y = 0.0
Z = 0.0
"""


@dataclass
class _Block:
    """What stands under a heading: parameters, and lines of numbers with where they stand."""

    values: dict[str, str] = field(default_factory=dict)
    rows: list[tuple[int, list[float]]] = field(default_factory=list)


def read_rdf(path: Path) -> tuple[Array, Array, Array | None]:
    """Stations (n,), heights (n, k) and where the k columns lie, (k,), all m; a survey of two
    tracks has k = 2, right and left, and no places. Heights that are missing are NaN.

    Raises CampaignError for another kind of road, a table that is cut off or no grid, and
    unknown units; and for a file that cannot be read.
    """
    blocks = _blocks(path)
    unit = blocks.get("UNITS", _Block()).values.get("LENGTH", "")
    if unit.lower() not in LENGTHS_M:
        known = ", ".join(("meter", "mm", "inch"))
        raise CampaignError(f"{path}: [UNITS] LENGTH = '{unit}': must be one of {known}, …")
    scale = LENGTHS_M[unit.lower()]
    model = blocks.get("MODEL", _Block()).values
    method = model.get("METHOD", "").upper()
    kind = model.get("ROAD_TYPE", "").lower()
    if "REFSYS" in blocks:
        raise CampaignError(f"{path}: [REFSYS] is not supported: save the road in its own axes")
    if method == "3D":
        x, y, height = _grid(path, blocks)
        return x * scale, height * scale, y * scale
    if method == "2D" and kind == "poly_line":
        x, height = _tracks(path, blocks)
        return x * scale, height * scale, None
    named = f"METHOD = '{method}'" + (f", ROAD_TYPE = '{kind}'" if kind else "")
    raise CampaignError(f"{path}: {named}: a survey has METHOD = '3D', or '2D' with 'poly_line'")


def write_rdf(file: Path, x_m: Array, y_m: Array, height_m: Array) -> None:
    """Write a grid, stations (n,), places across (k,) and heights (n, k), m, as two triangles for
    each of its cells; where a height is NaN there is no node, and no triangle."""
    number = np.zeros(height_m.shape, dtype=np.int64)
    known = np.isfinite(height_m)
    number[known] = np.arange(1, known.sum() + 1)
    rows, columns = np.nonzero(known)
    nodes = np.column_stack([number[known], x_m[rows], y_m[columns], height_m[known]])
    nodes[:, 1:] *= 1e3
    # Counterclockwise seen from above.
    corners = number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]
    a, b, c, d = (corner.ravel() for corner in corners)
    triangles = np.stack([np.column_stack([a, b, c]), np.column_stack([b, d, c])], axis=1)
    triangles = triangles.reshape(-1, 3)
    triangles = triangles[(triangles > 0).all(axis=1)]
    with (
        replacing(file, CampaignError) as draft,
        draft.open("w", encoding="ascii", newline="\n") as out,
    ):
        out.write(f"{HEADER}[NODES]\nNUMBER_OF_NODES = {len(nodes)}\n")
        out.write("{ node x_value y_value z_value }\n")
        np.savetxt(out, nodes, ["%d", "%.9g", "%.9g", "%.9g"])
        out.write(f"[ELEMENTS]\nNUMBER_OF_ELEMENTS = {len(triangles)}\n")
        out.write("{ node_1 node_2 node_3 mu }\n")
        np.savetxt(out, triangles, "%d", newline=" 1.0\n")


def _blocks(path: Path) -> dict[str, _Block]:
    blocks: dict[str, _Block] = {}
    block = _Block()
    for number, line in enumerate(read_text(path, CampaignError).split("\n"), start=1):
        text = re.split(r"[$!]", line)[0].strip()
        heading = re.fullmatch(r"\[(\w+)\]|\((\w+)\)", text)
        if heading:
            block = blocks.setdefault((heading[1] or heading[2]).upper(), _Block())
        elif "=" in text:
            key, _, value = text.partition("=")
            block.values[key.strip().upper()] = value.strip().strip("'\"").strip()
        elif text and not text.startswith("{"):
            try:
                block.rows.append((number, [float(word) for word in re.split(r"[\s,]+", text)]))
            except ValueError:
                raise CampaignError(
                    f"{path}: line {number}: '{text}' is no row of numbers"
                ) from None
    return blocks


def _table(path: Path, blocks: dict[str, _Block], name: str, widths: tuple[int, ...]) -> Array:
    """The rows of a block, all equally long."""
    block = blocks.get(name, _Block())
    if len(block.rows) < 2:
        raise CampaignError(f"{path}: [{name}] has {len(block.rows)} rows; two at least are needed")
    said = block.values.get(f"NUMBER_OF_{name}")
    if said is not None and said != str(len(block.rows)):
        raise CampaignError(
            f"{path}: [{name}] has {len(block.rows)} rows, and NUMBER_OF_{name} = {said}: cut off?"
        )
    width = len(block.rows[0][1])
    for number, row in block.rows:
        if len(row) not in widths or len(row) != width or not np.isfinite(row).all():
            wanted = " or ".join(str(w) for w in widths)
            raise CampaignError(f"{path}: line {number}: {wanted} numbers are needed in each row")
    return np.array([row for _, row in block.rows])


def _grid(path: Path, blocks: dict[str, _Block]) -> tuple[Array, Array, Array]:
    """Stations, places across and heights of nodes on a grid, NaN where there is no node."""
    table = _table(path, blocks, "NODES", (4,))
    nodes = table[:, 1:] + [_offset(path, blocks, axis) for axis in "XYZ"]
    (x, row), (y, column) = (_lines(nodes[:, axis]) for axis in (0, 1))
    if len(x) * len(y) > 4 * len(nodes) or min(len(x), len(y)) < 2:
        raise CampaignError(
            f"{path}: its {len(nodes)} nodes are no grid, {len(x)} different x and {len(y)}"
            " different y: resample the road on one"
        )
    height = np.full((len(x), len(y)), np.nan)
    height[row, column] = nodes[:, 2]
    other = np.flatnonzero(height[row, column] != nodes[:, 2])
    if len(other):
        number = blocks["NODES"].rows[other[0]][0]
        raise CampaignError(f"{path}: line {number}: another node at this x and y has another z")
    return x, y, height


def _offset(path: Path, blocks: dict[str, _Block], axis: str) -> float:
    """How far all nodes are to be moved along an axis, in the file's unit."""
    said = blocks.get("OFFSET", _Block()).values.get(axis, "0")
    try:
        offset = float(said)
    except ValueError:
        offset = inf
    if not isfinite(offset):
        raise CampaignError(f"{path}: [OFFSET] {axis} = {said}: must be a number")
    return offset


def _lines(values: Array) -> tuple[Array, np.ndarray[tuple[int], np.dtype[np.intp]]]:
    """Different values, increasing, and which of them each is."""
    order = np.argsort(values)
    apart = np.diff(values[order]) > TOGETHER * max(float(np.ptp(values)), 1e-300)
    place = np.empty(len(values), dtype=np.intp)
    place[order] = np.concatenate([[0], np.cumsum(apart)])
    return values[order][np.concatenate([[True], apart])], place


def _tracks(path: Path, blocks: dict[str, _Block]) -> tuple[Array, Array]:
    """Stations, and heights of the right and the left track."""
    table = _table(path, blocks, "XZ_DATA", (2, 3))
    if not (np.diff(table[:, 0]) > 0.0).all():
        raise CampaignError(f"{path}: (XZ_DATA): x must increase")
    return table[:, 0], table[:, [-1, 1]]
