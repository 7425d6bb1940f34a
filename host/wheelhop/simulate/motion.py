"""All that moves in a run: displacements of every coordinate, and what the tyres carry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Averaging
from wheelhop.simulate.integrator import Task, integrate
from wheelhop.simulate.model import Model
from wheelhop.simulate.run import RunSimulator
from wheelhop.vehicle import System

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Motion:
    """A run from rest on, at every step of the integration.

    `time_s` (T,) counts from the record's first sample, and `recorded` (T,) tells the steps inside
    the record. `acceleration`, `velocity` and `displacement` are (T, n), m/s², m/s and m, about the
    static position, of the free coordinates: heave, pitch and roll (rad) of the body first, as far
    as it has them, then the others. `height` (T, wheels), m, is that of the ground under the
    wheels, and `tyre_force` (T, wheels), N, what each tyre carries beyond its static load.
    """

    time_s: Array
    recorded: NDArray[np.bool_]
    acceleration: Array
    velocity: Array
    displacement: Array
    height: Array
    tyre_force: Array


@dataclass(frozen=True, eq=False)
class Shown:
    """What a model's outputs show (T, c), `values`, at every step of the integration; `time_s`,
    `recorded` and `height` as those of `Motion`."""

    time_s: Array
    recorded: NDArray[np.bool_]
    height: Array
    values: Array


class MotionSimulator(RunSimulator):
    """A run's simulator that also gives displacements. Its vehicle stands on a track."""

    def motion(self, model: Model, system: System) -> Motion:
        """What moves, from rest on."""
        n = len(system.mass)
        (found,) = self.shown([(model, _showing_all(system))])
        acceleration, displacement, velocity, force = np.split(
            found.values, [n, 2 * n, 3 * n], axis=1
        )
        return Motion(
            found.time_s, found.recorded, acceleration, velocity, displacement, found.height, force
        )

    def shown(self, trials: Sequence[tuple[Model, System]]) -> list[Shown]:
        """What the outputs of several models show, each from rest on, at every step of its
        integration; side by side they cost little more than one."""
        found: dict[int, Shown] = {}
        groups: dict[object, list[tuple[int, int, Task]]] = {}
        for i, (model, system) in enumerate(trials):
            stride = self.stride(model, system)
            height, rate = self._motion(model, stride)
            forces = self._forces(model, system, self._times(2 * stride))
            task = Task(system, height, rate, forces, self._initial(model, system))
            groups.setdefault((stride, task.make), []).append((i, stride, task))
        for group in groups.values():
            stride = group[0][1]
            tasks = [task for *_, task in group]
            steps = slice(1, len(tasks[0].height) - 1)  # neither the first nor the last is sampled
            values = integrate(
                tasks,
                step_s=1.0 / (self.campaign.sample_rate_hz * stride),
                first=1,
                stride=1,
                averaging=Averaging(0.0),
                n_samples=steps.stop - steps.start,
            )
            time_s, record = self._times(stride)[steps], self.run.time_s
            inside = (time_s >= record[0] - 1e-9) & (time_s <= record[-1] + 1e-9)
            for (i, _, task), one in zip(group, values, strict=True):
                found[i] = Shown(time_s, inside, task.height[steps], one)
        return [found[i] for i in range(len(trials))]


def _showing_all(system: System) -> System:
    """The mechanism with outputs that show all that moves: accelerations, displacements, rates,
    and what the tyres carry."""
    n = len(system.mass)
    moved = np.eye(2 * n, system.reading_width)
    return watching(system, np.eye(n), np.vstack([moved, tyre_forces(system)]))


def watching(system: System, accelerated: Array, reading: Array) -> System:
    """The mechanism with outputs that show accelerations, rows (a, n) over its coordinates, and
    then readings, rows as those of `System.reading`."""
    a, n = accelerated.shape
    return replace(
        system,
        output=np.vstack([accelerated, np.zeros((len(reading), n))]),
        reads=tuple(range(a, a + len(reading))),
        reading=reading,
    )


def tyre_forces(system: System) -> Array:
    """What the ground must push with for it to move so, N, as a reading of each wheel.

    Raising all coordinates together strains nothing, hence the ground's own stiffness is the sum of
    those that couple it: F = Σ_i B_ij (u_j − q_i) + D_ij (u̇_j − q̇_i) + Σ_p R_pj f_p.
    """
    b, d = system.input_stiffness, system.input_damping
    own = [np.diag(matrix.sum(axis=0)) for matrix in (b, d)]
    return np.hstack([-b.T, -d.T, *own, system.port_input.T])
