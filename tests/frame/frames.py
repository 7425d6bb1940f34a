"""Frames whose answers are known."""

import numpy as np

from wheelhop.frame import Frame, Material, Section, Tube, assemble, round_tube

STEEL = Material(young_Pa=200e9, shear_Pa=77e9, density_kg_m3=7800.0)
TUBE = round_tube(0.030, 0.002, STEEL.poisson)
CORNERS = {name: name for name in ("FL", "FR", "RL", "RR")}


def rigid_in_shear(section: Section) -> Section:
    """The section of an Euler–Bernoulli beam."""
    return Section(section.area_m2, section.Iy_m4, section.Iz_m4, section.J_m4, 1e6)


def chain(points, section=TUBE, material=STEEL, element_m=0.1, closed=False, up=None):
    """The finite elements of tubes from point to point."""
    names = [f"n{i}" for i in range(len(points))]
    nodes = {name: tuple(map(float, p)) for name, p in zip(names, points, strict=True)}
    ends = list(zip(names, names[1:] + names[:1], strict=True))
    tubes = tuple(Tube(a, b, "s", up) for a, b in (ends if closed else ends[:-1]))
    corners = dict(zip(CORNERS, (names * 4)[:4], strict=True))
    return assemble(Frame("chain", material, {"s": section}, nodes, tubes, (), corners, element_m))


def ladder(material=STEEL, section=TUBE, masses=(), element_m=0.1, length=1.4, width=0.6):
    """Two rails along x and three cross members, the corners its ends."""
    half = width / 2
    nodes = {}
    for i, x in enumerate((length / 2, 0.0, -length / 2)):
        for side, y in (("L", half), ("R", -half)):
            nodes[("F", "M", "R")[i] + side] = (x, y, 0.0)
        nodes[("F", "M", "R")[i] + "C"] = (x, 0.0, 0.0)
    tubes = [Tube(a + s, b + s, "s") for s in "LR" for a, b in (("F", "M"), ("M", "R"))]
    tubes += [Tube(a + "L", a + "C", "s") for a in "FMR"]
    tubes += [Tube(a + "C", a + "R", "s") for a in "FMR"]
    return Frame(
        "ladder", material, {"s": section}, nodes, tuple(tubes), tuple(masses), CORNERS, element_m
    )


def random_frame(seed, element_m=10.0, section=TUBE, nodes=8, extra=10):
    """A tree of tubes between random points, and some more between any two."""
    random = np.random.default_rng(seed)
    points = {f"n{i}": tuple(p) for i, p in enumerate(random.uniform(-1, 1, (nodes, 3)).tolist())}
    names = list(points)
    pairs = {(names[random.integers(i)], names[i]) for i in range(1, nodes)}
    while len(pairs) < nodes - 1 + extra:
        a, b = sorted(random.choice(nodes, 2, replace=False))
        pairs.add((names[a], names[b]))
    corners = dict(zip(CORNERS, names, strict=False))
    tubes = tuple(Tube(a, b, "s") for a, b in sorted(pairs))
    return Frame("random", STEEL, {"s": section}, points, tubes, (), corners, element_m)
