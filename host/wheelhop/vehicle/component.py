"""A component on a rig: one strut, damper or mount, m ẍ + c ẋ + k x = f.

Displacement and force are positive in extension and tension. Which of the two the rig imposes
makes no difference to the equation: a force is integrated, along a displacement the equation is
read from the left.
"""

from __future__ import annotations

from collections.abc import Mapping

from wheelhop.vehicle.assembly import Assembly, Coordinate

EXTENSION = Coordinate("extension")
"""The component's extension x, its one degree of freedom."""


def is_component(values: Mapping[str, float]) -> bool:
    """Whether these are the numbers of a component, not of a vehicle."""
    return "component.mass_kg" in values


def inputs_of(values: Mapping[str, float]) -> dict[str, float]:
    """The inputs recorded beside a component's motion, by their columns, with their usual size."""
    return {k.removeprefix("rig."): v for k, v in values.items() if k.startswith("rig.input_")}


def component(values: Mapping[str, float]) -> Assembly:
    """The parts of the baseline component; its output is the displacement, the force the input.

    Parameters
    ----------
    values
        Numbers of [component] under their dotted keys, SI.
    """
    parts = Assembly(prescribed=(), body=())
    row = ((1.0, parts.add_coordinate(EXTENSION.name)),)
    parts.add_mass(row, values["component.mass_kg"])
    parts.add_spring(row, values["component.stiffness_N_m"], values["component.damping_N_s_m"])
    parts.add_force(row)
    parts.add_output(row)
    return parts
