"""The mount of the struts as a specimen measured on a rig: its elements among a vehicle's numbers.

They are known, not estimated: an effect says how many times over they are there.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from wheelhop.material import Elements, approximate, read_specimen

PREFIX = "mount."
TOLERANCE = 2e-3
"""What the elements may be off, below the noise of most records."""


def mount_values(file: Path) -> dict[str, float]:
    """The elements of a specimen's file under dotted keys, SI.

    Raises `MaterialError` for a file that is wrong, or a modulus that is no passive specimen's.
    """
    elements = approximate(read_specimen(file).modulus, tolerance=TOLERANCE)
    values = {
        f"{PREFIX}stiffness_N_m": elements.stiffness_N_m,
        f"{PREFIX}damping_N_s_m": elements.damping_N_s_m,
    }
    for i, pair in enumerate(zip(elements.strengths_N_m, elements.times_s, strict=True), start=1):
        values[f"{PREFIX}{i}.stiffness_N_m"], values[f"{PREFIX}{i}.relaxation_s"] = map(float, pair)
    return values


def mounted(values: Mapping[str, float]) -> Elements | None:
    """The elements among these numbers; None if no specimen is given."""
    if f"{PREFIX}stiffness_N_m" not in values:
        return None
    count = sum(key.startswith(PREFIX) and key.endswith(".relaxation_s") for key in values)
    keys = [f"{PREFIX}{i}." for i in range(1, count + 1)]
    return Elements(
        values[f"{PREFIX}stiffness_N_m"],
        values[f"{PREFIX}damping_N_s_m"],
        np.array([values[f"{key}stiffness_N_m"] for key in keys]),
        np.array([values[f"{key}relaxation_s"] for key in keys]),
    )
