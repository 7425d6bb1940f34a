"""How long a frame takes, beside PyNite's static solve: python -m benchmarks.frame

A lattice of tubes with 2 000 beam elements: assembly, 20 free modes, reduction to eight interface
points with 20 modes. Then one static load case of smaller lattices in wheelhop and in PyNite
(`pip install PyNiteFEA`), whose answers are compared. Seconds of the clock, median of repeats.
"""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from wheelhop.frame import (
    CORNERS,
    Frame,
    Material,
    Section,
    Tube,
    assemble,
    dofs_of,
    free_modes,
    reduce,
    round_tube,
    solve_static,
)

STEEL = Material(205e9, 79.5e9, 7850.0)
DIRECTIONS = ("DX", "DY", "DZ", "RX", "RY", "RZ")


def main() -> None:
    """Print both tables."""
    frame = lattice(bays=25, element_m=0.0535)
    seconds, elements = timed(lambda: assemble(frame))
    count = sum(len(line) - 1 for line in elements.lines)
    print(f"{len(frame.tubes)} tubes, {count} beam elements, {elements.mass.shape[0]} coordinates")
    parts = [seconds]
    print(f"assembly              {seconds:7.3f} s")
    seconds, modes = timed(lambda: free_modes(elements, 20))
    parts.append(seconds)
    low, high = modes.frequency_hz[[0, -1]]
    print(f"20 free modes         {seconds:7.3f} s   {low:.1f} to {high:.1f} Hz")
    seconds, reduced = timed(lambda: reduce(elements, 20))
    parts.append(seconds)
    off = np.abs(reduced.free_modes()[0][:10] / modes.frequency_hz[:10] - 1).max()
    print(f"Craig–Bampton         {seconds:7.3f} s   first ten modes within {100 * off:.2g} %")
    print(f"together              {sum(parts):7.3f} s   (5 s asked)")
    peer()


def lattice(bays: int, element_m: float, shear_coefficient: float | None = None) -> Frame:
    """A box girder of square bays, 0.3 m, with diagonals on all four sides."""
    nodes = {
        f"{i}{j}{k}": (0.3 * i, 0.3 * j, 0.3 * k)
        for i in range(bays + 1)
        for j in (0, 1)
        for k in (0, 1)
    }
    around = [(0, 0), (1, 0), (1, 1), (0, 1)]
    tubes = []
    for i in range(bays + 1):
        for (j, k), (p, q) in zip(around, around[1:] + around[:1], strict=True):
            tubes.append(Tube(f"{i}{j}{k}", f"{i}{p}{q}", "s"))
            if i < bays:
                tubes.append(Tube(f"{i}{j}{k}", f"{i + 1}{j}{k}", "s"))
                tubes.append(Tube(f"{i}{j}{k}", f"{i + 1}{p}{q}", "s"))
    section = round_tube(0.03, 0.002, STEEL.poisson)
    if shear_coefficient is not None:
        round_one = (section.area_m2, section.Iy_m4, section.Iz_m4, section.J_m4)
        section = Section(*round_one, shear_coefficient)
    at = (f"{bays}10", f"{bays}00", "010", "000")
    half = bays // 2
    interface = dict(zip(CORNERS, at, strict=True))
    interface |= {f"inner {j}{k}": f"{half}{j}{k}" for j, k in around}
    return Frame("lattice", STEEL, {"s": section}, nodes, tuple(tubes), (), interface, element_m)


def peer() -> None:
    """One load case, assembly and all: wheelhop and PyNite, both with Euler–Bernoulli's beams."""
    try:
        from Pynite import FEModel3D
    except ImportError:
        print("PyNite is not installed: pip install PyNiteFEA")
        return
    print("one static load case    wheelhop    PyNite   ratio   largest difference")
    for bays in (5, 20):
        frame = lattice(bays, 9.0, shear_coefficient=1e6)

        def ours(frame: Frame = frame) -> Any:
            elements = assemble(frame)
            load = np.zeros(elements.mass.shape[0])
            load[dofs_of(elements.corners[:1], (2,))] = 1000.0
            return solve_static(elements, load, dofs_of(elements.corners[2:])).displacement

        def theirs(frame: Frame = frame) -> Any:
            model = FEModel3D()
            model.add_material("m", STEEL.young_Pa, STEEL.shear_Pa, STEEL.poisson, 0.0)
            s = frame.sections["s"]
            model.add_section("s", s.area_m2, s.Iy_m4, s.Iz_m4, s.J_m4)
            for name, place in frame.nodes.items():
                model.add_node(name, *place)
            for i, tube in enumerate(frame.tubes):
                model.add_member(str(i), tube.start, tube.end, "m", "s")
            for corner in ("RL", "RR"):
                model.def_support(frame.interface[corner], *(True,) * 6)
            model.add_node_load(frame.interface["FL"], "FZ", 1000.0)
            model.analyze_linear()
            return np.array(
                [[getattr(model.nodes[n], d)["Combo 1"] for d in DIRECTIONS] for n in frame.nodes]
            ).ravel()

        (fast, mine), (slow, other) = timed(ours), timed(theirs)
        off = np.abs(mine - other).max() / np.abs(other).max()
        label = f"{len(frame.tubes)} beams"
        print(f"{label:20s} {fast:9.3f} s {slow:7.3f} s {slow / fast:7.1f}   {off:.1e}")


def timed(job: Callable[[], Any], repeats: int = 3) -> tuple[float, Any]:
    """Median seconds, and what came out."""
    taken = []
    for _ in range(repeats):
        begin = time.perf_counter()
        result = job()
        taken.append(time.perf_counter() - begin)
    return statistics.median(taken), result


if __name__ == "__main__":
    main()
