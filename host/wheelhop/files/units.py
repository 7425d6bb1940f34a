"""The units that keys carry in their names, so that a wrong one can be recognised and converted."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Unit:
    """One unit: its dimension, its size in SI and its name in words."""

    dimension: str
    in_si: float
    words: str


UNITS = {
    "m": Unit("length", 1.0, "metres"),
    "cm": Unit("length", 1e-2, "centimetres"),
    "mm": Unit("length", 1e-3, "millimetres"),
    "km": Unit("length", 1e3, "kilometres"),
    "in": Unit("length", 0.0254, "inches"),
    "ft": Unit("length", 0.3048, "feet"),
    "kmph": Unit("speed", 1 / 3.6, "kilometres per hour"),
    "kmh": Unit("speed", 1 / 3.6, "kilometres per hour"),
    "kph": Unit("speed", 1 / 3.6, "kilometres per hour"),
    "km_h": Unit("speed", 1 / 3.6, "kilometres per hour"),
    "m_s": Unit("speed", 1.0, "metres per second"),
    "mps": Unit("speed", 1.0, "metres per second"),
    "mph": Unit("speed", 0.44704, "miles per hour"),
    "deg": Unit("angle", math.pi / 180, "degrees"),
    "rad": Unit("angle", 1.0, "radians"),
    "s": Unit("time", 1.0, "seconds"),
    "ms": Unit("time", 1e-3, "milliseconds"),
    "us": Unit("time", 1e-6, "microseconds"),
    "Hz": Unit("frequency", 1.0, "hertz"),
    "hz": Unit("frequency", 1.0, "hertz"),
    "kHz": Unit("frequency", 1e3, "kilohertz"),
    "khz": Unit("frequency", 1e3, "kilohertz"),
    "kg": Unit("mass", 1.0, "kilograms"),
    "g": Unit("mass", 1e-3, "grams"),
    "t": Unit("mass", 1e3, "tonnes"),
    "lb": Unit("mass", 0.45359237, "pounds"),
    "kg_m2": Unit("inertia", 1.0, "kilogram square metres"),
    "m_s2": Unit("acceleration", 1.0, "metres per second squared"),
    "mm_s2": Unit("acceleration", 1e-3, "millimetres per second squared"),
    "kg_m3": Unit("density", 1.0, "kilograms per cubic metre"),
    "g_cm3": Unit("density", 1e3, "grams per cubic centimetre"),
    "Pa": Unit("pressure", 1.0, "pascals"),
    "MPa": Unit("pressure", 1e6, "megapascals"),
    "GPa": Unit("pressure", 1e9, "gigapascals"),
    "m3": Unit("unevenness", 1.0, "cubic metres"),
    "cm3": Unit("unevenness", 1e-6, "cubic centimetres"),
    "N_m": Unit("stiffness", 1.0, "newtons per metre"),
    "N_mm": Unit("stiffness", 1e3, "newtons per millimetre"),
    "kN_m": Unit("stiffness", 1e3, "kilonewtons per metre"),
    "kN_mm": Unit("stiffness", 1e6, "kilonewtons per millimetre"),
    "N_s_m": Unit("damping", 1.0, "newton seconds per metre"),
    "Ns_m": Unit("damping", 1.0, "newton seconds per metre"),
    "N_s_mm": Unit("damping", 1e3, "newton seconds per millimetre"),
    "Ns_mm": Unit("damping", 1e3, "newton seconds per millimetre"),
    "kN_s_m": Unit("damping", 1e3, "kilonewton seconds per metre"),
}


SIZES = {
    "length": (1e-6, 1e5),
    "speed": (1e-4, 1e3),
    "angle": (1e-6, 10.0),
    "time": (1e-9, 1e9),
    "frequency": (1e-6, 1e7),
    "mass": (1e-4, 1e6),
    "inertia": (1e-6, 1e7),
    "acceleration": (1e-9, 1e6),
    "stiffness": (1e-3, 1e10),
    "damping": (1e-4, 1e8),
    "density": (1e-3, 1e5),
    "pressure": (1e3, 1e15),
}
"""The least and the largest number, in SI, that anything on wheels has of a dimension: beyond that
a file is broken, and powers of it overflow."""


def beyond(key: str, value: float) -> str:
    """What is too small or too large about a number with a unit in its name; empty if nothing is,
    as of 0."""
    _, name = split_unit(key)
    if name is None or value == 0.0 or (unit := UNITS[name]).dimension not in SIZES:
        return ""
    least, largest = (size / unit.in_si for size in SIZES[unit.dimension])
    if least <= abs(value) <= largest:
        return ""
    word = "small" if abs(value) < least else "large"
    return f"is too {word} to be believed: {least:.3g} to {largest:.3g} {unit.words} are"


def split_unit(key: str) -> tuple[str, str | None]:
    """Split "stiffness_N_mm" into ("stiffness", "N_mm"), keeping a trailing "_uncertainty" apart.

    The unit is None when the key ends in none that is known.
    """
    base = key.removesuffix("_uncertainty")
    tail = key[len(base) :]
    for parts in (3, 2, 1):  # the longest unit first: _N_s_m ends in _m too
        words = base.rsplit("_", parts)
        unit = "_".join(words[1:])
        if len(words) > parts and unit in UNITS:
            return words[0] + tail, unit
    return base + tail, None
