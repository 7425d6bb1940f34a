"""Beams from Nastran's bulk data: GRID, CBAR, CBEAM, PBAR, PBARL, PBEAM, PBEAML, MAT1, CONM2.

What is read is read whole: a card that would change the frame and is not among these, or a field
that is not understood, is an error.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import dist, hypot
from pathlib import Path

from wheelhop.files import read_text
from wheelhop.frame.bdf_cards import Card, read_cards
from wheelhop.frame.error import FrameError
from wheelhop.frame.model import Point, PointMass, Tube
from wheelhop.frame.section import Material, Section, bar, box, round_tube

UNITS: Mapping[str, tuple[float, float]] = {"m-kg-s": (1.0, 1.0), "mm-t-s": (1e-3, 1e3)}
"""Metres of the unit of length and kilograms of the unit of mass, by the name in the frame's file;
the second is always the unit of time."""
IGNORED = (
    *("PARAM", "EIGR", "EIGRL", "SPC", "SPC1", "SPCADD", "SUPORT", "FORCE", "MOMENT", "LOAD"),
    *("GRAV", "PLOAD1", "MDLPRM", "ENDDATA", "ASET", "ASET1", "TABDMP1", "FREQ", "FREQ1"),
)
"""Supports, loads and orders to the solver: they are no part of the frame."""
RIGID_SHEAR = 1e6
"""κ where Nastran's shear factors are blank: no shear flexibility."""
LEAST_LENGTH_M = 1e-4


@dataclass(frozen=True)
class Bulk:
    """What a file holds of a frame, in SI; names are Nastran's numbers."""

    material: Material
    sections: Mapping[str, Section]
    nodes: Mapping[str, Point]
    tubes: tuple[Tube, ...]
    masses: tuple[PointMass, ...]


def read_bdf(path: Path, units: str) -> Bulk:
    """Read the beams of a file whose numbers are in one of `UNITS`.

    Raises `FrameError`, one line with file, line and card, for everything that is not understood:
    other elements, coordinate systems, offsets, pins, tapered beams, products of inertia.
    """
    cards = list(read_cards(path, read_text(path, FrameError)))
    found: dict[str, list[Card]] = {}
    for card in cards:
        if card.name not in READ and card.name not in IGNORED:
            raise card.error(f"is not read: only {', '.join(READ)} are")
        found.setdefault(card.name, []).append(card)
    return _Bulk(path, found, *UNITS[units]).read()


def read_grids(path: Path, units: str) -> dict[str, Point]:
    """The grid points of a file, m, whatever else is in it. Raises `FrameError`."""
    cards = [card for card in read_cards(path, read_text(path, FrameError)) if card.name == "GRID"]
    return _Bulk(path, {"GRID": cards}, *UNITS[units]).points()


class _Bulk:
    def __init__(
        self, path: Path, cards: Mapping[str, Sequence[Card]], metre: float, kilogram: float
    ) -> None:
        self.path, self.cards, self.metre, self.kilogram = path, cards, metre, kilogram

    def read(self) -> Bulk:
        beams = [*self._all("CBAR"), *self._all("CBEAM")]
        if not beams:
            raise FrameError(f"{self.path}: holds no CBAR or CBEAM: there is no frame in it")
        points = {name: (card, self._point(card)) for name, card in self._by_id("GRID").items()}
        properties = self._by_id("PBAR", "PBARL", "PBEAM", "PBEAML")
        tubes = tuple(self._tube(card, points, properties) for card in beams)
        used = {tube.section for tube in tubes}
        material = self._material([properties[name] for name in properties if name in used])
        poisson = material.poisson
        ends = {name for tube in tubes for name in (tube.start, tube.end)}
        aims = {str(int(card.text(6))) for card in beams if card.text(6).isdigit()}
        return Bulk(
            material,
            {name: self._section(properties[name], poisson) for name in sorted(used)},
            {name: at for name, (_, at) in points.items() if name in ends or name not in aims},
            tubes,
            tuple(self._mass(card, points) for card in self._all("CONM2")),
        )

    def points(self) -> dict[str, Point]:
        return {name: self._point(card) for name, card in self._by_id("GRID").items()}

    def _all(self, name: str) -> Sequence[Card]:
        return self.cards.get(name, ())

    def _by_id(self, *names: str) -> dict[str, Card]:
        found: dict[str, Card] = {}
        for card in (card for name in names for card in self._all(name)):
            if found.setdefault(card.id(2), card) is not card:
                raise card.error(f"number {card.id(2)} is used twice")
        return found

    def _point(self, card: Card) -> Point:
        for place in (3, 7):
            if card.number(place, 0.0) != 0.0:
                raise card.error("only the basic coordinate system is read: leave CP and CD blank")
        x, y, z = (self.metre * card.number(place, 0.0) for place in (4, 5, 6))
        return x, y, z

    def _tube(
        self,
        card: Card,
        points: Mapping[str, tuple[Card, Point]],
        properties: Mapping[str, Card],
    ) -> Tube:
        section, start, end = card.id(3) if card.text(3) else card.id(2), card.id(4), card.id(5)
        for name in (start, end):
            if name not in points:
                raise card.error(f"there is no GRID {name}")
        if section not in properties:
            raise card.error(f"there is no property {section}")
        if properties[section].name[1:4] != card.name[1:4]:
            raise card.error(f"property {section} is a {properties[section].name}")
        (_, a), (_, b) = points[start], points[end]
        if dist(a, b) < LEAST_LENGTH_M:
            raise card.error(f"{card.id(2)} from {start} to {end} has no length")
        if any(card.text(place) not in ("", "0", "0.0", "0.") for place in range(10, 20)):
            raise card.error("pins and offsets (PA, PB, W) are not read: join beams at their nodes")
        if card.text(9) not in ("", "GGG"):
            raise card.error(f"field 9 = '{card.text(9)}': offsets are not read")
        along = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        aim = self._aim(card, a, points)
        up = _cross(along, aim)  # Nastran's y axis is nearest to the aim, our z is its z
        size = hypot(*up)
        if size <= 1e-6 * hypot(*along) * hypot(*aim):
            raise card.error("its orientation vector points along it")
        return Tube(start, end, section, (up[0] / size, up[1] / size, up[2] / size))

    def _aim(self, card: Card, start: Point, points: Mapping[str, tuple[Card, Point]]) -> Point:
        if card.text(7) or card.text(8) or "." in card.text(6):
            return card.number(6, 0.0), card.number(7, 0.0), card.number(8, 0.0)
        if card.id(6) not in points:
            raise card.error(f"there is no GRID {card.id(6)} to point at")
        x, y, z = points[card.id(6)][1]
        return x - start[0], y - start[1], z - start[2]

    def _material(self, properties: Sequence[Card]) -> Material:
        by_id = self._by_id("MAT1")
        found: dict[Material, Card] = {}
        for user in properties:
            if user.id(3) not in by_id:
                raise user.error(f"there is no MAT1 {user.id(3)}")
            card = by_id[user.id(3)]
            pascal = self.kilogram / self.metre
            young = card.positive(3) * pascal
            given = card.text(4) != ""
            shear = card.positive(4) * pascal if given else young / 2 / (1 + card.number(5))
            if not young / 3 < shear <= young / 2:
                raise card.error("G must lie between E/3 and E/2")
            density = card.positive(6) * self.kilogram / self.metre**3
            found.setdefault(Material(young, shear, density), card)
        material, *others = found
        if others:
            raise found[others[0]].error("is another material: a frame has one for all its tubes")
        return material

    def _section(self, card: Card, poisson: float) -> Section:
        if card.name in ("PBARL", "PBEAML"):
            return self._shape(card, poisson)
        beam = card.name == "PBEAM"
        area, first, second = (card.positive(place) for place in (4, 5, 6))
        product, torsion, extra = (7, 8, 9) if beam else (20, 7, 8)
        place = self._shear_place(card) if beam else 18
        shear = [card.number(p, 1.0 if beam else RIGID_SHEAR) for p in (place, place + 1)]
        if beam and any(card.number(p, 0.0) != 0.0 for p in range(place + 2, place + 16)):
            raise card.error("warping and offsets of its axes are not read")
        if card.number(product, 0.0) != 0.0:
            raise card.error("I12 is not 0: turn the orientation vector to the principal axes")
        self._no_extra_mass(card, extra)
        if shear[0] != shear[1] or shear[0] <= 0.0:
            raise card.error("K1 and K2 must be alike and above 0")
        m2, m4 = self.metre**2, self.metre**4
        return Section(area * m2, second * m4, first * m4, card.positive(torsion) * m4, shear[0])

    def _shear_place(self, card: Card) -> int:
        """Field of a PBEAM's K1. Before it the section at the other end may stand: a word, where it
        is, and its numbers, which must not differ; and if the word is YES a line for stresses."""
        if card.text(18) not in STATIONS:
            return 18
        for here, first in zip(range(20, 26), range(4, 10), strict=True):
            if card.text(here) and card.number(here) != card.number(first, 0.0):
                raise card.error("tapered beams are not read: make short beams of it")
        place = 18 + STATIONS[card.text(18)]
        if card.text(place) in STATIONS:
            raise card.error("more than two sections are not read: make a beam of each part")
        return place

    def _shape(self, card: Card, poisson: float) -> Section:
        if card.text(4) not in ("", "MSCBML0", "NXBML0"):
            raise card.error(f"group {card.text(4)} is not read")
        shape = card.text(5)
        if shape not in SHAPES:
            raise card.error(f"shape '{shape}' is not read: only {', '.join(SHAPES)} are")
        count = SHAPES[shape]
        self._no_extra_mass(card, 10 + count)
        if any(card.fields[9 + count :]):
            raise card.error("more than one section is not read: make a beam of each part")
        size = [self.metre * card.positive(place) for place in range(10, 10 + count)]
        if shape in ("ROD", "TUBE", "TUBE2"):
            wall = {"ROD": size[0], "TUBE": size[0] - size[-1], "TUBE2": size[-1]}[shape]
            if not 0.0 < wall <= size[0]:
                raise card.error("its wall must be thicker than 0 and no thicker than its radius")
            return round_tube(2 * size[0], wall, poisson)
        if shape == "BAR":
            return bar(size[0], size[1])
        if not (2 * size[3] < size[0] and 2 * size[2] < size[1]):
            raise card.error("its walls are thicker than half of it")
        return box(*size)

    def _no_extra_mass(self, card: Card, place: int) -> None:
        if card.number(place, 0.0) != 0.0:
            raise card.error("NSM is not read: put masses at nodes with CONM2")

    def _mass(self, card: Card, points: Mapping[str, tuple[Card, Point]]) -> PointMass:
        node = card.id(3)
        if node not in points:
            raise card.error(f"there is no GRID {node}")
        if any(card.number(place, 0.0) != 0.0 for place in (4, 6, 7, 8)):
            raise card.error("coordinate system and offset are not read: put a node there")
        if any(card.number(place, 0.0) != 0.0 for place in (11, 13, 14)):
            raise card.error("products of inertia are not read")
        mass, *turning = (card.number(place, 0.0) for place in (5, 10, 12, 15))
        if min(mass, *turning) < 0.0:
            raise card.error("mass and inertia must not be negative")
        x, y, z = (self.kilogram * self.metre**2 * value for value in turning)
        return PointMass(node, self.kilogram * mass, (x, y, z))


STATIONS = {"YES": 16, "NO": 8, "YESA": 8}
"""Fields of a section of a PBEAM by the word it begins with."""
SHAPES = {"ROD": 1, "TUBE": 2, "TUBE2": 2, "BAR": 2, "BOX": 4}
"""Cross-sections of PBARL and PBEAML, and how many dimensions they have."""
READ = ("GRID", "CBAR", "CBEAM", "PBAR", "PBARL", "PBEAM", "PBEAML", "MAT1", "CONM2")


def _cross(a: Point, b: Point) -> Point:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
