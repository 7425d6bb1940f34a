"""Sensors on a table, turned over by hand now and then: what the logger has of it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.files.units import STANDARD_GRAVITY_M_S2
from wheelhop.hil_sim.rig import SCAN_S, Rig, Sensor, Shaking
from wheelhop.hil_sim.signals import CODES
from wheelhop.logger.recording import Recording

MINUTE = (1, -1, 1, -1, 1)
"""Axis up, down, up, down, up: each for a minute."""


def flip_log(
    sensors: Sequence[Sensor],
    rng: np.random.Generator,
    orientations: Sequence[float | Sequence[float]] = MINUTE,
    rest_s: float = 60.0,
    turn_s: float = 12.0,
    gravity_m_s2: float = STANDARD_GRAVITY_M_S2,
) -> Recording:
    """A recording of rests of `rest_s` with handling of `turn_s` between them.

    Each orientation is the part of 1 g that acts along the axis, one for all sensors or one for
    each; where all sensors were really upright in use, the first is 1. A sensor's `rest_code` is
    that at +1 g.
    """
    pieces = []
    last = None
    for orientation in orientations:
        along = np.broadcast_to(np.asarray(orientation, dtype=float), (len(sensors),))
        if last is not None:
            pieces.append(_handling(last, along, rng, round(turn_s / SCAN_S)))
        pieces.append(np.tile(along, (round(rest_s / SCAN_S), 1)))
        last = along
    force = np.concatenate(pieces) * gravity_m_s2
    columns = []
    for k, sensor in enumerate(sensors):
        level = sensor.rest_code + (force[:, k] - gravity_m_s2) / sensor.gain_m_s2_per_code
        conversions = level[:, None] + sensor.noise_code * rng.standard_normal((len(level), 8))
        columns.append(np.clip(np.floor(conversions), 0, CODES - 1).mean(axis=1))
    empty = Rig(tuple(sensors), Shaking(((10.0, 0.0, 0.1),), pause_s=0.0)).log(rng)
    return replace(empty, values=np.column_stack(columns))


def _handling(
    before: NDArray[np.float64], after: NDArray[np.float64], rng: np.random.Generator, count: int
) -> NDArray[np.float64]:
    """From one orientation to another, one sensor after the other, in hands that shake."""
    part = np.linspace(0, 1, count)[:, None]
    turn = np.clip(part * (len(before) + 1) - np.arange(len(before)), 0, 1)
    moved = before + (after - before) * turn
    return np.asarray(moved + 0.2 * rng.standard_normal((count, len(before))))
