"""A frame's file: TOML, docs/frames.md."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import dist, hypot
from pathlib import Path

from wheelhop.files import Table, did_you_mean, read_toml
from wheelhop.frame.bdf import UNITS, Bulk, read_bdf, read_grids
from wheelhop.frame.error import FrameError
from wheelhop.frame.model import CORNERS, ELEMENT_M, Frame, Point, PointMass, Tube
from wheelhop.frame.section import Material, Section, round_tube

LEAST_LENGTH_M = 1e-4
FARTHEST_M = 1000.0
MOST_ELEMENTS = 50_000
SMALL, LARGE = 1e-6, 1e12
"""Between these lie the numbers of every section, in mm² and mm⁴, and the length of a direction."""
ROUND = ("outer_diameter_mm", "wall_thickness_mm")
GENERAL = ("A_mm2", "Iy_mm4", "Iz_mm4", "J_mm4", "shear_coefficient")
USUAL_SHEAR = 5 / 6
"""κ of a rectangle, for sections given by their numbers."""
TABLES = (
    "format",
    "name",
    "element_mm",
    "material",
    "section",
    "node",
    "tube",
    "mass",
    "interface",
)


def read_frame(path: Path) -> Frame:
    """Read a frame's file.

    Raises `FrameError`, one line, for what is unknown, missing or impossible, tubes without length
    or listed twice, and a frame that is not one piece.
    """
    top = read_toml(path, FrameError)
    top.format()
    found = _bulk(top, path) if "bdf" in top else _written(top)
    _check_one_piece(top, found.nodes, found.tubes)
    tables = top.tables("mass", "node") if "mass" in top else ()
    masses = (*found.masses, *(_mass(table, found.nodes) for table in tables))
    interface = _interface(top.table("interface"), found.nodes)
    element_m = _element_m(top, found.nodes, found.tubes)
    return Frame(
        top.text("name"),
        found.material,
        found.sections,
        found.nodes,
        found.tubes,
        masses,
        interface,
        element_m,
    )


def read_places(path: Path) -> tuple[list[tuple[str, Point]], float]:
    """The corners' GRIDs and where they are, m, of a frame's file that names bulk data, whatever
    elements these hold; and the kilograms of their unit of mass. Raises `FrameError`."""
    top = read_toml(path, FrameError)
    top.format()
    top.only(("format", "name", "bdf", "bdf_units", "f06", "interface"))
    units = top.text("bdf_units", choices=tuple(UNITS))
    nodes = read_grids(_bdf(top, path), units)
    interface = _interface(top.table("interface"), nodes)
    corners = [(interface[corner], nodes[interface[corner]]) for corner in CORNERS]
    return corners, UNITS[units][1]


def _written(top: Table) -> Bulk:
    """Material, sections, nodes and tubes as the file itself has them."""
    top.only(TABLES)
    material = _material(top)
    sections = {name: _section(table, material) for name, table in _named(top, "section")}
    nodes = _nodes(top.table("node"))
    return Bulk(material, sections, nodes, tuple(_tubes(top, nodes, sections)), ())


def _bulk(top: Table, path: Path) -> Bulk:
    """Material, sections, nodes and tubes from the Nastran bulk data file that `bdf` names."""
    if "f06" in top:
        raise top.error(
            "f06: Nastran has found its modes already: name this file under [frame] in"
            " vehicle.toml, and ask wheelhop modes"
        )
    top.only(("format", "name", "element_mm", "bdf", "bdf_units", "mass", "interface"))
    return read_bdf(_bdf(top, path), top.text("bdf_units", choices=tuple(UNITS)))


def _bdf(top: Table, path: Path) -> Path:
    file = path.parent / top.text("bdf")
    if not file.is_file():
        raise top.error(f"bdf: there is no file {file}")
    return file


def _element_m(top: Table, nodes: Mapping[str, Point], tubes: Sequence[Tube]) -> float:
    element_m = top.number("element_mm", 1e3 * ELEMENT_M, at_least=1.0) / 1e3
    count = sum(dist(nodes[tube.start], nodes[tube.end]) / element_m for tube in tubes)
    if count > MOST_ELEMENTS:
        raise top.error(
            f"element_mm = {1e3 * element_m:g} would make {count:.0f} elements:"
            f" {MOST_ELEMENTS} are allowed"
        )
    return element_m


def _material(top: Table) -> Material:
    table = top.table("material")
    table.only(("E_GPa", "G_GPa", "nu", "density_kg_m3"))
    young = table.number("E_GPa", above=0.0)
    if ("nu" in table) == ("G_GPa" in table):
        raise table.error("give either nu or G_GPa: E = 2 G (1 + nu)")
    if "nu" in table:
        shear = young / 2 / (1 + table.number("nu", at_least=0.0, below=0.5))
    else:
        shear = table.number("G_GPa", above=0.0)
        if not young / 3 < shear <= young / 2:
            raise table.error(
                f"G_GPa = {shear:g} must lie between E/3 and E/2, {young / 3:.4g} and"
                f" {young / 2:.4g}"
            )
    return Material(1e9 * young, 1e9 * shear, table.number("density_kg_m3", above=0.0))


def _section(table: Table, material: Material) -> Section:
    if any(key in table for key in ROUND):
        table.only(ROUND)
        outer, wall = (table.number(key, above=0.0) for key in ROUND)
        if wall > outer / 2:
            raise table.error(
                f"wall_thickness_mm = {wall:g} is more than the radius, {outer / 2:g} mm"
            )
        return round_tube(outer / 1e3, wall / 1e3, material.poisson)
    table.only(GENERAL, f"; give {' and '.join(ROUND)}, or {', '.join(GENERAL[:-1])}")
    area, *second = (table.number(key, at_least=SMALL, below=LARGE) for key in GENERAL[:-1])
    bend_y, bend_z, torsion = (1e-12 * value for value in second)
    kappa = table.number("shear_coefficient", USUAL_SHEAR, at_least=1e-3, below=LARGE)
    return Section(1e-6 * area, bend_y, bend_z, torsion, kappa)


def _named(top: Table, key: str) -> Iterator[tuple[str, Table]]:
    outer = top.table(key)
    for name in outer.values:
        yield name, outer.table(name)


def _nodes(table: Table) -> dict[str, Point]:
    places: dict[Point, str] = {}
    for name in table.values:
        place = _point(table, name)
        if max(map(abs, place)) > FARTHEST_M:
            raise table.error(f"{name} lies more than {FARTHEST_M:g} m away: write metres")
        if place in places:
            raise table.error(f"{name} lies where {places[place]} lies: use one node for both")
        places[place] = name
    if not places:
        raise table.error("there are no nodes")
    return {name: place for place, name in places.items()}


def _point(table: Table, key: str) -> Point:
    values = table.numbers(key)
    if len(values) != 3:
        raise table.error(f"{key} must be three numbers, {key} = [x, y, z], not {len(values)}")
    return values[0], values[1], values[2]


def _tubes(
    top: Table, nodes: Mapping[str, Point], sections: Mapping[str, Section]
) -> Iterator[Tube]:
    """The tubes; a list of nodes is a chain of them."""
    seen = set()
    for table in top.tables("tube", "nodes"):
        table.only(("from", "to", "nodes", "section", "up"))
        chain = _chain(table)
        for name in chain:
            _check_node(table, name, nodes)
        section = table.text("section")
        if section not in sections:
            raise table.error(f"there is no [section.{section}]{did_you_mean(section, sections)}")
        up = _direction(table, "up") if "up" in table else None
        for start, end in pairwise(chain):
            ends = f"the tube from {start} to {end}"
            length = dist(nodes[start], nodes[end])
            if length < LEAST_LENGTH_M:
                raise table.error(f"{ends} has no length")
            if frozenset((start, end)) in seen:
                raise table.error(f"{ends} is listed twice")
            seen.add(frozenset((start, end)))
            if up is not None:
                _check_up(table, up, nodes[start], nodes[end])
            yield Tube(start, end, section, up)


def _chain(table: Table) -> Sequence[str]:
    if "nodes" not in table:
        return table.text("from"), table.text("to")
    if "from" in table or "to" in table:
        raise table.error("give either nodes, or from and to")
    chain = table.texts("nodes")
    if len(chain) < 2:
        raise table.error("nodes must be two names or more")
    return chain


def _check_node(table: Table, name: str, nodes: Mapping[str, Point]) -> None:
    if name not in nodes:
        raise table.error(f'there is no node "{name}"{did_you_mean(name, nodes)}')


def _direction(table: Table, key: str) -> Point:
    x, y, z = _point(table, key)
    length = hypot(x, y, z)
    if not SMALL < length < LARGE:
        raise table.error(f"{key} is a direction, such as {key} = [0, 0, 1]")
    return x / length, y / length, z / length


def _check_up(table: Table, up: Point, start: Point, end: Point) -> None:
    x, y, z = (b - a for a, b in zip(start, end, strict=True))
    across = (up[1] * z - up[2] * y, up[2] * x - up[0] * z, up[0] * y - up[1] * x)
    if not hypot(*across) > 1e-6 * dist(start, end):
        raise table.error("up must not point along the tube")


def _check_one_piece(top: Table, nodes: Mapping[str, Point], tubes: Sequence[Tube]) -> None:
    neighbours: dict[str, list[str]] = {name: [] for name in nodes}
    for tube in tubes:
        neighbours[tube.start].append(tube.end)
        neighbours[tube.end].append(tube.start)
    for name, others in neighbours.items():
        if not others:
            raise top.error(f"[node]: {name} is not connected: no tube begins or ends there")
    first = next(iter(nodes))
    reached, todo = {first}, [first]
    while todo:
        for name in neighbours[todo.pop()]:
            if name not in reached:
                reached.add(name)
                todo.append(name)
    if apart := [name for name in nodes if name not in reached]:
        raise top.error(f"[node]: {apart[0]} is not connected with {first}: join the two parts")


def _mass(table: Table, nodes: Mapping[str, Point]) -> PointMass:
    table.only(("node", "mass_kg", "inertia_kg_m2"))
    node = table.text("node")
    _check_node(table, node, nodes)
    inertia = _point(table, "inertia_kg_m2") if "inertia_kg_m2" in table else (0.0, 0.0, 0.0)
    if min(inertia) < 0.0:
        raise table.error(f"inertia_kg_m2 = {list(inertia)} must not be negative")
    return PointMass(node, table.number("mass_kg", at_least=0.0), inertia)


def _interface(table: Table, nodes: Mapping[str, Point]) -> dict[str, str]:
    """Which node each point is; the four corners lie as their names say."""
    for corner in CORNERS:
        table.text(corner)
    found = {name: table.text(name) for name in table.values}
    for node in found.values():
        _check_node(table, node, nodes)
    if len({found[corner] for corner in CORNERS}) < len(CORNERS):
        raise table.error(f"{', '.join(CORNERS)} must be four different nodes")
    for ahead, behind in (("FL", "RL"), ("FR", "RR")):
        if not nodes[found[ahead]][0] > nodes[found[behind]][0]:
            raise table.error(f"{ahead} must lie ahead of {behind}: x points ahead")
    for left, right in (("FL", "FR"), ("RL", "RR")):
        if not nodes[found[left]][1] > nodes[found[right]][1]:
            raise table.error(f"{left} must lie to the left of {right}: y points to the left")
    return found
