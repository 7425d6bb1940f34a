"""`wheelhop frame`: mass, torsional stiffness and modes of a tubular space frame."""

from __future__ import annotations

from argparse import Namespace
from dataclasses import dataclass
from math import pi
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from wheelhop.cli.output import open_console, write_json
from wheelhop.files.words import significant
from wheelhop.frame import (
    FiniteElements,
    Frame,
    FrameError,
    FrameTwist,
    MassProperties,
    Modes,
    assemble,
    frame_twist,
    free_modes,
    mass_properties,
    read_frame,
    torsional_stiffness,
)

MOST_MODES = 200
DEGREE = pi / 180


@dataclass(frozen=True, eq=False)
class FrameResult:
    """What was found of a frame."""

    frame: Frame
    elements: FiniteElements
    mass: MassProperties
    stiffness_N_m_rad: float
    modes: Modes
    twist: FrameTwist


def run(arguments: Namespace) -> int:
    """Compute, print, write JSON and figure."""
    if not 1 <= arguments.modes <= MOST_MODES:
        raise FrameError(f"--modes {arguments.modes}: give a number from 1 to {MOST_MODES}")
    result = examine(read_frame(arguments.frame), arguments.modes)
    console = open_console()
    _show(console, result)
    if arguments.json is not None:
        write_json(arguments.json, as_json(result))
    if arguments.figure is not None:
        from wheelhop.report.frame import write_frame_figure

        write_frame_figure(
            result.frame.name, result.elements, result.modes, result.twist, arguments.figure
        )
        console.print(f"figure: {arguments.figure}", markup=False)
    return 0


def examine(frame: Frame, modes: int) -> FrameResult:
    """Everything the command tells of a frame."""
    elements = assemble(frame)
    found = free_modes(elements, modes)
    return FrameResult(
        frame,
        elements,
        mass_properties(elements),
        torsional_stiffness(elements),
        found,
        frame_twist(elements, found),
    )


def as_json(result: FrameResult) -> dict[str, Any]:
    """The result for programs."""
    mass, twist, first = result.mass, result.twist, result.twist.first
    return {
        "format": 1,
        "name": result.frame.name,
        "elements": sum(len(line) - 1 for line in result.elements.lines),
        "mass_kg": mass.mass_kg,
        "carried_kg": _carried(result.frame),
        "centre_m": mass.centre_m.tolist(),
        "inertia_kg_m2": mass.inertia_kg_m2.tolist(),
        "torsional_stiffness_N_m_deg": DEGREE * result.stiffness_N_m_rad,
        "first_torsional_mode": None if first is None else first + 1,
        "frame_twist": [
            {"freq_hz": hz, "participation_1_kg": participation, "share": share}
            for hz, participation, share in zip(
                twist.freq_hz.tolist(),
                twist.participation_1_kg.tolist(),
                twist.share.tolist(),
                strict=True,
            )
        ],
    }


def _carried(frame: Frame) -> float:
    return sum(mass.mass_kg for mass in frame.masses)


def _show(console: Console, result: FrameResult) -> None:
    frame, mass, twist = result.frame, result.mass, result.twist
    carried = _carried(frame)
    x, y, z = (significant(1e3 * value, 4) for value in mass.centre_m)
    ixx, iyy, izz = (significant(value) for value in mass.inertia_kg_m2.diagonal())
    count = sum(len(line) - 1 for line in result.elements.lines)
    stiffness = significant(DEGREE * result.stiffness_N_m_rad)
    for line in (
        f"{frame.name}: {len(frame.tubes)} tubes, {count} beam elements",
        f"mass {significant(mass.mass_kg)} kg: tubes {significant(mass.mass_kg - carried)} kg,"
        f" carried {significant(carried)} kg",
        f"centre of gravity at x {x}, y {y}, z {z} mm",
        f"inertia about it: roll {ixx}, pitch {iyy}, yaw {izz} kg m²",
        f"torsional stiffness between the axles {stiffness} N m/deg",
    ):
        console.print(line, markup=False)
    table = Table(box=box.SIMPLE_HEAD)
    for heading in ("mode", "Hz", "participation, 1/kg", "share of twist"):
        table.add_column(heading, justify="right")
    table.add_column("")
    for i, frequency in enumerate(twist.freq_hz):
        table.add_row(
            str(i + 1),
            significant(float(frequency), 4),
            significant(float(twist.participation_1_kg[i])),
            f"{100 * twist.share[i]:.1f} %",
            "first torsional mode" if i == twist.first else "",
        )
    console.print(table)
    if twist.first is None:
        console.print("None of these modes makes a tenth of the twist: try more --modes")
        return
    frequency, participation = (
        significant(float(values[twist.first]), 4)
        for values in (twist.freq_hz, twist.participation_1_kg)
    )
    console.print(
        f"As the effect frame-twist: freq_hz = {frequency}, participation_1_kg = {participation}",
        markup=False,
    )
