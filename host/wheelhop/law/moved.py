"""How one place moved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Moved:
    """How a place moved in the runs fitted: extension (T,), m, and rate (T,), m/s, one stretch
    after the other; `stretches` holds the length of each, and `inputs` what else was recorded. A
    vehicle had driven for `before_s` when a stretch begins."""

    extension: Array
    rate: Array
    stretches: tuple[int, ...]
    inputs: Mapping[str, Array] = field(default_factory=dict)
    before_s: float = 0.0
