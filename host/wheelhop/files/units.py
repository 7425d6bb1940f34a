"""Units: as keys of our files end in them, as pages write them, as recorders spell them.

One table serves all three; another unit is one line in it.
"""

import math
import re
from dataclasses import dataclass
from unicodedata import normalize

STANDARD_GRAVITY_M_S2 = 9.80665
"""By definition: 3rd CGPM, 1901."""


@dataclass(frozen=True)
class Unit:
    """One unit: its dimension, its size in SI, its name in words, what keys of files end in where
    they are given in it, and how recorders spell it; the first spelling is what pages write."""

    dimension: str
    in_si: float
    words: str
    keys: tuple[str, ...] = ()
    spelt: tuple[str, ...] = ()


M_S2 = ("m/s²", "m.s-2", "ms-2")
KMPH = ("kmph", "kmh", "kph", "km_h")
G = STANDARD_GRAVITY_M_S2
TABLE = (
    Unit("length", 1.0, "metres", ("m",), ("m", "metre", "meter", "metres", "meters")),
    Unit("length", 1e-2, "centimetres", ("cm",), ("cm",)),
    Unit("length", 1e-3, "millimetres", ("mm",), ("mm",)),
    Unit("length", 1e-6, "micrometres", (), ("µm", "um", "micron", "microns")),
    Unit("length", 1e3, "kilometres", ("km",), ("km",)),
    Unit("length", 1609.344, "miles", (), ("mile", "miles")),
    Unit("length", 0.0254, "inches", ("in",), ("in", "inch", "inches")),
    Unit("length", 0.3048, "feet", ("ft",), ("ft", "feet")),
    Unit("speed", 1.0, "metres per second", ("m_s", "mps"), ("m/s", "m.s-1", "mps")),
    Unit("speed", 1e-3, "millimetres per second", (), ("mm/s",)),
    Unit("speed", 1 / 3.6, "kilometres per hour", KMPH, ("km/h", "kph", "kmh", "kmph", "km/hr")),
    Unit("speed", 0.44704, "miles per hour", ("mph",), ("mph", "mi/h")),
    Unit("speed", 0.0254, "inches per second", (), ("in/s", "inch/s", "ips")),
    Unit("speed", 0.3048, "feet per second", (), ("ft/s",)),
    Unit("speed", 1e-2, "centimetres per second", (), ("cm/s",)),
    Unit("speed", 1852 / 3600, "knots", (), ("kn", "kt", "kts", "knot", "knots")),
    Unit("acceleration", 1.0, "metres per second squared", ("m_s2",), M_S2),
    Unit("acceleration", 1e-2, "centimetres per second squared", (), ("cm/s²", "Gal")),
    Unit("acceleration", 1e-3, "millimetres per second squared", ("mm_s2",), ("mm/s²",)),
    Unit("acceleration", 0.3048, "feet per second squared", (), ("ft/s²",)),
    Unit("acceleration", 0.0254, "inches per second squared", (), ("in/s²",)),
    Unit("acceleration", G, "g", (), ("g", "G", "gn", "g_n", "g0")),
    Unit("acceleration", G / 1e3, "thousandths of g", (), ("mg", "mgn", "mg_n")),
    Unit("angle", math.pi / 180, "degrees", ("deg",), ("°", "deg", "degree", "degrees")),
    Unit("angle", 1.0, "radians", ("rad",), ("rad", "radian", "radians")),
    Unit("angular rate", 1.0, "radians per second", ("rad_s",), ("rad/s", "rad.s-1")),
    Unit("angular rate", math.pi / 180, "degrees per second", ("deg_s",), ("deg/s", "°/s", "dps")),
    Unit("angular rate", math.pi / 30, "turns per minute", ("rpm",), ("rpm",)),
    Unit("time", 1.0, "seconds", ("s",), ("s", "sec", "secs", "second", "seconds", "sek")),
    Unit(
        "time",
        1e-3,
        "milliseconds",
        ("ms",),
        ("ms", "msec", "millis", "millisecond", "milliseconds"),
    ),
    Unit(
        "time",
        1e-6,
        "microseconds",
        ("us",),
        ("us", "µs", "μs", "usec", "micros", "microsecond", "microseconds"),
    ),
    Unit("time", 1e-9, "nanoseconds", (), ("ns", "nsec", "nanos", "nanosecond", "nanoseconds")),
    Unit("time", 60.0, "minutes", (), ("min", "minute", "minutes")),
    Unit("time", 3600.0, "hours", (), ("h", "hour", "hours")),
    Unit("time", 86400.0, "days", (), ("day", "days")),
    Unit("frequency", 1.0, "hertz", ("hz", "Hz"), ("Hz",)),
    Unit("frequency", 1e3, "kilohertz", ("khz", "kHz"), ("kHz",)),
    Unit("mass", 1.0, "kilograms", ("kg",), ("kg",)),
    Unit("mass", 1e-3, "grams", ("g",)),
    Unit("mass", 1e3, "tonnes", ("t",)),
    Unit("mass", 0.45359237, "pounds", ("lb",)),
    Unit("mass per mass²", 1.0, "per kilogram", ("1_kg",), ("1/kg",)),
    Unit("imbalance", 1.0, "kilogram metres", ("kg_m",), ("kg m",)),
    Unit("inertia", 1.0, "kilogram square metres", ("kg_m2",), ("kg m²",)),
    Unit("density", 1.0, "kilograms per cubic metre", ("kg_m3",)),
    Unit("density", 1e3, "grams per cubic centimetre", ("g_cm3",)),
    Unit("pressure", 1.0, "pascals", ("Pa",), ("Pa",)),
    Unit("pressure", 1e6, "megapascals", ("MPa",), ("MPa",)),
    Unit("pressure", 1e3, "kilopascals", (), ("kPa",)),
    Unit("pressure", 1e5, "bar", (), ("bar",)),
    Unit("pressure", 1e2, "millibar", (), ("mbar", "hPa")),
    Unit("pressure", 6894.757293168, "pounds per square inch", (), ("psi",)),
    Unit("pressure", 1e9, "gigapascals", ("GPa",)),
    Unit("unevenness", 1.0, "cubic metres", ("m3",)),
    Unit("unevenness", 1e-6, "cubic centimetres", ("cm3",)),
    Unit("curvature", 1.0, "per metre", ("1_m",), ("1/m",)),
    Unit("growth", 1.0, "per square metre", ("1_m2",), ("1/m²",)),
    Unit("force", 1.0, "newtons", ("N",), ("N", "Newton", "Newtons")),
    Unit("force", 1e3, "kilonewtons", (), ("kN",)),
    Unit("force", 10.0, "decanewtons", (), ("daN",)),
    Unit("force", G, "kilograms of force", (), ("kgf", "kp")),
    Unit("force", 4.4482216152605, "pounds of force", (), ("lbf", "lbs")),
    Unit("torque", 1.0, "newton metres", (), ("N m", "N.m", "N-m", "Newton metre")),
    Unit("torque", 1e3, "kilonewton metres", (), ("kN m", "kN.m")),
    Unit("torque", 1.3558179483314, "foot pounds", (), ("ft-lb", "ft-lbs", "lb-ft", "lbf-ft")),
    Unit("temperature", 1.0, "degrees Celsius", (), ("°C", "C", "degC")),
    Unit("share", 1.0, "per cent", (), ("%", "pct", "percent")),
    Unit("current", 1.0, "amperes", (), ("A",)),
    Unit("current", 1e-3, "milliamperes", (), ("mA",)),
    Unit("voltage", 1.0, "volts", (), ("V", "Volt", "Volts")),
    Unit("voltage", 1e-3, "millivolts", (), ("mV",)),
    Unit("voltage", 1e-6, "microvolts", (), ("µV", "uV")),
    Unit("compliance", 1.0, "metres per newton", ("m_N",), ("m/N",)),
    Unit("stiffness", 1.0, "newtons per metre", ("N_m",), ("N/m",)),
    Unit("stiffness", 1e3, "newtons per millimetre", ("N_mm",)),
    Unit("stiffness", 1e3, "kilonewtons per metre", ("kN_m",)),
    Unit("stiffness", 1e6, "kilonewtons per millimetre", ("kN_mm",)),
    Unit("stiffness's growth", 1.0, "newtons per cubic metre", ("N_m3",), ("N/m³",)),
    Unit("damping", 1.0, "newton seconds per metre", ("N_s_m", "Ns_m"), ("N s/m",)),
    Unit("damping", 1e3, "newton seconds per millimetre", ("N_s_mm", "Ns_mm")),
    Unit("damping", 1e3, "kilonewton seconds per metre", ("kN_s_m",)),
)

UNITS = {key: unit for unit in TABLE for key in unit.keys}
"""By what keys end in, so that a wrong one can be recognised and converted."""

MEASURED = {
    "acceleration": "m/s²",
    "speed": "m/s",
    "length": "m",
    "force": "N",
    "voltage": "V",
    "angle": "rad",
    "angular rate": "rad/s",
    "torque": "N m",
    "pressure": "Pa",
    "current": "A",
    "frequency": "Hz",
    "mass": "kg",
    "temperature": "°C",
    "share": "%",
}
"""What recordings are of, and in which unit each quantity is kept: SI, but for temperatures in °C,
which a factor does not convert, and per cent."""

SPELT = {
    name: (MEASURED[unit.dimension], unit.in_si)
    for unit in TABLE
    if unit.dimension in MEASURED
    for name in unit.spelt
}
"""By a recorder's spelling: the unit it is kept in, and the factor into that."""

SECONDS = {name: unit.in_si for unit in TABLE if unit.dimension == "time" for name in unit.spelt}
"""By a recorder's spelling of a unit of time, how long it is."""

CAPITALS_MATTER = frozenset(("mV", "mA", "mbar", "MPa", "hPa", "Gal", "Nm"))
"""Spellings that are another unit, or none, in other capitals."""


def _plain(unit: str) -> str:
    """A unit without what writers do differently: blanks, signs of powers and of products, and
    what stands for seconds."""
    text = normalize("NFKC", unit).strip().rstrip(".").replace("−", "-")  # ² is 2, both µ are one
    for written, plain in ((" ", ""), ("**", ""), ("^", ""), ("·", "."), ("⋅", "."), ("*", ".")):
        text = text.replace(written, plain)
    return re.sub(r"/s/s$", "/s2", re.sub(r"(?<![A-Za-z])(?i:sec)(?![A-Za-z])", "s", text))


_PLAIN = {_plain(name): kept for name, kept in SPELT.items()}
_FOLDED = [name.lower() for name in _PLAIN]
_LOWER = {
    name.lower(): kept
    for name, kept in _PLAIN.items()
    if len(name) > 1 and name not in CAPITALS_MATTER and _FOLDED.count(name.lower()) == 1
}


def seconds_in(unit: str) -> float | None:
    """How long a unit of an axis of time is, None for one that is not known. Capitals are the
    writer's taste: no recording counts megaseconds."""
    plain = _plain(unit)
    names = (unit.strip(), plain, plain.lower(), plain.replace("μ", "u").lower())
    return next((SECONDS[name] for name in names if name in SECONDS), None)


ENDINGS = {
    f"_{key}": unit.spelt[0]
    for key, unit in sorted(UNITS.items(), key=lambda item: -len(item[0]))
    if unit.in_si == 1.0 and unit.spelt
} | {"_N_s2_m2": "N s²/m²", "_kg_m3": "kg/m³", "_m3": "m³"}
"""Endings of names, longer ones first, and the SI units they stand for."""


def to_si(unit: str) -> tuple[str, float]:
    """The unit that a quantity is kept in, mostly SI, and the factor into it; a unit that is not
    known stays, with factor 1."""
    plain = _plain(unit)
    return _PLAIN.get(plain) or _LOWER.get(plain.lower()) or (unit.strip(), 1.0)


def is_measured(unit: str) -> bool:
    """Whether `to_si` knows a unit."""
    plain = _plain(unit)
    return plain in _PLAIN or plain.lower() in _LOWER


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
    if abs(value) < least:
        word = "small"
    elif abs(value) > largest:
        word = "large"
    else:
        return ""
    return f"is too {word} to be believed: {least:.3g} to {largest:.3g} {unit.words} are"


def split_unit(key: str) -> tuple[str, str | None]:
    """Split "stiffness_N_mm" into ("stiffness", "N_mm"), keeping a trailing "_uncertainty" apart.

    The unit is None when the key ends in none that is known.
    """
    base = key.removesuffix("_uncertainty")
    tail = key[len(base) :]
    for parts in (3, 2, 1):  # the longest unit first: _N_s_m ends in _m too
        name, *ending = base.rsplit("_", parts)
        unit = "_".join(ending)
        if unit in UNITS:
            return name + tail, unit
    return base + tail, None
