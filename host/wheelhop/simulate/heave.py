"""Heave of a vehicle's body over heave of the ground: what a rider feels first."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wheelhop.simulate.frequency import frequency_response
from wheelhop.vehicle import Body, baseline, body_inertia
from wheelhop.vehicle.layout import wheels


def heave_transmissibility(
    values: Mapping[str, float], frequency_hz: ArrayLike, speed_m_s: float | None = None
) -> NDArray[np.float64]:
    """Height of the body at its centre of mass per height of the ground (f,), of the linear vehicle
    with these numbers of vehicle.toml.

    Every wheel is lifted alike; at a speed the rear wheels are where the front ones were, wheelbase
    over speed later.
    """
    frequency = np.asarray(frequency_hz, np.float64)
    parts = baseline(values, (), "road")
    parts.add_output(((1.0, Body(0.0, 0.0)),))
    response = frequency_response(parts.system(body_inertia(values)), frequency)[:, 0, :]
    if speed_m_s is not None:
        late_s = values.get("geometry.wheelbase_m", 0.0) / speed_m_s
        behind = np.array([corner >= 2 for corner in wheels(values)])
        response = response * np.exp(-2j * np.pi * frequency[:, None] * late_s * behind)
    return np.asarray(np.abs(response.sum(axis=1)) / (2 * np.pi * frequency) ** 2)
