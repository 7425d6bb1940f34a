"""Following the phase: where along the track the vehicle really was."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from wheelhop.effects.base import Array, Probe, RunSetting

WINDOW_S = 1.0

EXPECTED = 0.04
"""Relative size of the wander believed of a driver who holds the speed by hand."""

QUIET = 1e-12
"""A window with less than this share of the power of the loudest one holds rounding alone."""


def shift_along(
    probe: Probe, run: RunSetting, corners: Collection[int] = range(4)
) -> tuple[Array, Array]:
    """Times (w,), s, and the distance (w,), m, that the channels of these corners are ahead of the
    model: in short windows the record agrees with the model shifted along the track; the cheapest
    smooth path through these shifts counts."""
    columns = [i for i, c in enumerate(probe.channels) if c.corner is None or c.corner in corners]
    centres, shifts, mismatch = _local_mismatch(probe, run, columns)
    path = shifts[_cheapest_path(mismatch, shifts / run.speed_m_s, centres)]
    return centres, path


def _local_mismatch(
    probe: Probe, run: RunSetting, columns: list[int]
) -> tuple[Array, Array, Array]:
    """Window centres (w,), s, shifts (s,), m, and Σ residual² / Σ record² (w, s) of each window
    when the model is shifted along the track."""
    time, record = probe.time_s(run.run_id), probe.measured(run.run_id)[:, columns]
    centres = np.arange(time[0] + WINDOW_S / 2, time[-1] - WINDOW_S / 2, WINDOW_S / 4)
    # The distance gained in 0.13 s: ± a third of a second's drive is more than drivers wander.
    shifts = run.speed_m_s * np.linspace(-0.13, 0.13, 35)
    inside = np.abs(time - centres[:, None]) <= WINDOW_S / 2
    energy = inside @ (record**2).sum(axis=1)
    # A window in which nothing moves tells no shift: all fit it alike.
    energy = np.where(energy > QUIET * energy.max(initial=0.0), energy, np.inf)
    mismatch = np.empty((len(centres), len(shifts)))
    modelled = probe.all_modelled(run.run_id, [{"start_m": float(shift)} for shift in shifts])
    for i, signal in enumerate(modelled):
        mismatch[:, i] = inside @ ((record - signal[:, columns]) ** 2).sum(axis=1) / energy
    return centres, shifts, mismatch


def _cheapest_path(mismatch: Array, shift_s: Array, centres: Array) -> NDArray[np.intp]:
    """Dynamic programming: mismatch along the path plus what changes of speed it asks for."""
    rate = (shift_s[:, None] - shift_s[None, :]) / (centres[1] - centres[0])
    change = 0.02 * (rate / EXPECTED) ** 2
    cost, came_from = mismatch[0], []
    for row in mismatch[1:]:
        total = cost[None, :] + change
        came_from.append(total.argmin(axis=1))
        cost = row + total.min(axis=1)
    path = [int(cost.argmin())]
    for back in reversed(came_from):
        path.append(int(back[path[-1]]))
    return np.array(path[::-1])
