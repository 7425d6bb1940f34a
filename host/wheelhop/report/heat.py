"""Residual over floor as a colour and a number, wherever runs × channels are drawn."""

from __future__ import annotations

from math import isfinite

HEAT = (1.3, 2.0, 5.0, 10.0)
"""Residual over floor at which a cell takes the next colour."""


def heat_class(ratio: float) -> str:
    """The style sheet's class for a cell; "" where there is nothing to show."""
    return f"h{sum(ratio >= limit for limit in HEAT)}" if isfinite(ratio) else ""


def heat_words(ratio: float) -> str:
    """What stands in a cell."""
    if not isfinite(ratio):
        return "–"
    return f"{ratio:.1f}" if ratio < 9.95 else f"{ratio:.0f}"


def heat_legend() -> str:
    """What the colours mean."""
    limits = [f"{limit:g}" for limit in HEAT]
    names = [f"below {limits[0]}", *(f"from {limit}" for limit in limits)]
    spans = "".join(f'<span class="h{i}">{name}</span>' for i, name in enumerate(names))
    return f'<p class="legend">{spans}</p>'
