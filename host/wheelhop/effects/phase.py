"""Following the phase: where along the track the vehicle really was."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from wheelhop.effects.base import Array, Probe, RunSetting

WINDOW_S = 1.0

EXPECTED = 0.04
"""Relative size of the wander believed of a driver who holds the speed by hand."""

QUIET = 1e-12
"""A window with less than this share of the power of the loudest one holds rounding alone."""


SHIFTS_S = np.linspace(-0.13, 0.13, 35)
"""Shifts in time that are tried: a third of a second's drive is more than drivers wander."""

TOGETHER = 5
"""So many neighbours of them are told from one simulation: a vehicle ahead by what it drives in
15 ms answers as it does anyhow, 15 ms earlier."""


def shift_along(
    probe: Probe, run: RunSetting, *sides: Collection[int]
) -> tuple[Array, list[Array]]:
    """Times (w,), s, and the distances (w,), m, that the channels of some corners are ahead of the
    model, for every set of corners given: in short windows the record agrees with the model shifted
    along the track; the cheapest smooth path through these shifts counts."""
    time, record = probe.time_s(run.run_id), probe.measured(run.run_id)
    centres = np.arange(time[0] + WINDOW_S / 2, time[-1] - WINDOW_S / 2, WINDOW_S / 4)
    inside = np.abs(time - centres[:, None]) <= WINDOW_S / 2
    squares = [(record - shifted) ** 2 for shifted in _shifted(probe, run, time)]
    paths = []
    for corners in sides:
        columns = [
            i for i, c in enumerate(probe.channels) if c.corner is None or c.corner in corners
        ]
        energy = inside @ (record[:, columns] ** 2).sum(axis=1)
        # A window in which nothing moves tells no shift: all fit it alike.
        energy = np.where(energy > QUIET * energy.max(initial=0.0), energy, np.inf)
        left = np.stack([square[:, columns].sum(axis=1) for square in squares], axis=1)
        mismatch = (inside @ left) / energy[:, None]
        paths.append(run.speed_m_s * SHIFTS_S[_cheapest_path(mismatch, SHIFTS_S, centres)])
    return centres, paths


def _shifted(probe: Probe, run: RunSetting, time_s: Array) -> Iterator[Array]:
    """The model's answer in band (n, c), shifted along the track by what the run drives in each of
    `SHIFTS_S` at its nominal speed."""
    groups = SHIFTS_S.reshape(-1, TOGETHER)
    middles = [{"start_m": float(run.speed_m_s * group[TOGETHER // 2])} for group in groups]
    for group, signal in zip(groups, probe.all_modelled(run.run_id, middles), strict=True):
        answer = CubicSpline(time_s, np.nan_to_num(signal))  # zero where a model runs away
        for shift_s in group - group[TOGETHER // 2]:
            yield answer(time_s + shift_s)


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
