"""Numbers that front and rear have in common until the runs say otherwise.

Stops are met and gaps open on loud roads only, and often on one axle more than on the other. A
number of its own for each axle would then take any value on the axle that shows little of it.
"""

from __future__ import annotations

from wheelhop.effects.base import Values
from wheelhop.effects.parameters import Shape


def balance(
    name: str, what: str, sigma: float, starts: tuple[float, ...] = (0.0,), most: float = 1.0
) -> Shape:
    """The parameter by which front and rear differ.

    Parameters
    ----------
    name, what
        Its name and what is balanced, in words.
    sigma
        How unlike front and rear are believed to be.
    starts, most
        Where screening begins, and the largest size allowed: 1 leaves nothing to one of the axles.
    """
    meaning = f"half the difference of front and rear {what} over their mean"
    return Shape(name, "1", meaning, sigma, lower=-most, upper=most, starts=starts, believed=0.0)


def share(theta: Values, mean: str, balance: str, end: str) -> float:
    """What one end ("front", "rear", or a component's) has of the number named `mean`."""
    uneven = theta.get(balance, 0.0)
    return theta[mean] * (1.0 - uneven if end == "rear" else 1.0 + uneven)
