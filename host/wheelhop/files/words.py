"""Numbers and their units in words, as every page and the terminal write them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import floor, isfinite, log10
from pathlib import Path

from wheelhop.files.units import ENDINGS

NARROW_SPACE = "\u202f"


def listed(names: Sequence[str]) -> str:
    """a, b and c."""
    *most, last = names or [""]
    return f"{', '.join(most)} and {last}" if most else last


def percent(share: float, digits: int = 3) -> str:
    """A share in per cent with so many significant digits; a dash if there is none."""
    return f"{significant(100 * share, digits)} %" if isfinite(share) else "–"


def significant(value: float, digits: int = 3) -> str:
    """So many significant digits, thousands apart; no exponent unless it is very small."""
    if not isfinite(value):
        return "–"
    if value == 0:
        return "0"
    size = floor(log10(abs(value)))
    if not -5 <= size <= 8:
        return f"{value:.{digits - 1}e}"
    return _grouped(value, digits - 1 - size)


def interval(value: float, deviation: float) -> str:
    """value ± 2 standard deviations, the latter to two significant digits."""
    if not (isfinite(deviation) and deviation > 0):
        return significant(value)
    decimals = 1 - floor(log10(2 * deviation))
    if decimals > 6:
        return f"{value:.3g} ± {2 * deviation:.2g}"
    return f"{_grouped(value, decimals)} ± {_grouped(2 * deviation, decimals)}"


def signed(value: float) -> str:
    """A whole number with its sign."""
    return ("+" if value >= 0 else "") + _grouped(value, 0)


def chance(p: float) -> str:
    """A probability to one digit, as far down as it means anything."""
    return "< 10⁻⁶" if p < 1e-6 else f"{p:.1g}"


def _grouped(value: float, decimals: int) -> str:
    rounded = round(value, decimals) + 0.0  # no minus zero
    return f"{rounded:,.{max(0, decimals)}f}".replace(",", NARROW_SPACE).replace("-", "−")


def unit_of(name: str) -> str:
    """The unit a name ends in; empty for a pure number."""
    return next((unit for ending, unit in ENDINGS.items() if name.endswith(ending)), "")


def ending_of(unit: str) -> str:
    """What the name of a number in this unit ends in: "m/s²" gives "_m_s2"; empty for none."""
    spelt = unit.replace("²", "2").replace("³", "3").replace("°", "deg")
    return "_" + "_".join(re.findall(r"\w+", spelt)) if spelt.strip() else ""


def squared(unit: str) -> str:
    """The square of a unit."""
    return f"({unit})²" if "/" in unit else f"{unit}²"


def label_of(name: str) -> str:
    """A number's name without its unit, in plain words: "front suspension stiffness"."""
    ending = next((ending for ending in ENDINGS if name.endswith(ending)), "")
    group, _, rest = name.removesuffix(ending).partition(".")
    end, _, quantity = rest.rpartition(".")
    if group == "geometry":
        group = ""
    if group == "wheel" and quantity != "radius":
        group = ""
    words = (end, group, quantity) if end in ("front", "rear") else (group, end, quantity)
    return " ".join(word.replace("_", " ") for word in words if word)


def titles(names: Sequence[str], files: Sequence[Path]) -> list[str]:
    """What several vehicles are called: by their files where names are alike."""
    if len(set(names)) == len(names):
        return list(names)
    stems = [file.stem for file in files]
    return stems if len(set(stems)) == len(stems) else [str(file) for file in files]
