"""Units as recorders write them, and what they are in SI."""

from __future__ import annotations

from wheelhop.logger.recording import ACCELERATION

STANDARD_GRAVITY = 9.80665  # m/s², exact: 3rd CGPM, 1901

SI: dict[str, tuple[str, float]] = {
    **dict.fromkeys(("m/s²", "m/s^2", "m/s2", "m/s**2", "m/sec^2", "m.s-2"), (ACCELERATION, 1.0)),
    **dict.fromkeys(("g", "gn", "g_n", "g0"), (ACCELERATION, STANDARD_GRAVITY)),
    **dict.fromkeys(("mg", "mgn", "mg_n"), (ACCELERATION, STANDARD_GRAVITY / 1e3)),
    **dict.fromkeys(("mm/s²", "mm/s^2", "mm/s2"), (ACCELERATION, 1e-3)),
    **dict.fromkeys(("cm/s²", "cm/s^2", "cm/s2", "Gal"), (ACCELERATION, 1e-2)),
    **dict.fromkeys(("ft/s²", "ft/s^2", "ft/s2"), (ACCELERATION, 0.3048)),
    **dict.fromkeys(("in/s²", "in/s^2", "in/s2"), (ACCELERATION, 0.0254)),
    **dict.fromkeys(("m/s", "m.s-1"), ("m/s", 1.0)),
    "mm/s": ("m/s", 1e-3),
    **dict.fromkeys(("km/h", "kph", "kmh"), ("m/s", 1 / 3.6)),
    "mph": ("m/s", 0.44704),
    **dict.fromkeys(("m", "metre", "meter"), ("m", 1.0)),
    "cm": ("m", 1e-2),
    "mm": ("m", 1e-3),
    **dict.fromkeys(("µm", "μm", "um"), ("m", 1e-6)),
    **dict.fromkeys(("in", "inch"), ("m", 0.0254)),
    **dict.fromkeys(("N", "Newton", "Newtons"), ("N", 1.0)),
    "kN": ("N", 1e3),
    "lbf": ("N", 4.4482216152605),
    **dict.fromkeys(("V", "Volt", "Volts"), ("V", 1.0)),
    "mV": ("V", 1e-3),
    **dict.fromkeys(("µV", "μV", "uV"), ("V", 1e-6)),
}
"""Spelling → SI unit and its size; of two kinds of µ both occur."""

SECONDS = {
    **dict.fromkeys(("s", "sec", "second", "seconds"), 1.0),
    **dict.fromkeys(("ms", "msec"), 1e-3),
    **dict.fromkeys(("us", "µs", "μs"), 1e-6),
    "ns": 1e-9,
    "min": 60.0,
    "h": 3600.0,
}


def to_si(unit: str) -> tuple[str, float]:
    """The SI unit and the factor into it; a unit that is not known stays, with factor 1."""
    return SI.get(unit.strip(), (unit.strip(), 1.0))
