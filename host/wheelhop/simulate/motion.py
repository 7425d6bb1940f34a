"""All that moves in a run: displacements of every coordinate, and what the tyres carry."""

from __future__ import annotations

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


class MotionSimulator(RunSimulator):
    """A run's simulator that also gives displacements. Its vehicle stands on a track."""

    def motion(self, model: Model, system: System) -> Motion:
        """What moves, from rest on."""
        stride = self.stride(model, system)
        height, rate = self._motion(model, stride)
        n = len(system.mass)
        forces = self._forces(model, system, self._times(2 * stride))
        initial = self._initial(model, system)
        task = Task(_showing_all(system), height, rate, forces, initial)
        step_s = 1.0 / (self.campaign.sample_rate_hz * stride)
        steps = slice(1, len(height) - 1)  # the integrator samples neither the first nor the last
        count = steps.stop - steps.start
        (found,) = integrate(
            [task], step_s=step_s, first=1, stride=1, averaging=Averaging(0.0), n_samples=count
        )
        acceleration, displacement, velocity = found[:, :n], found[:, n : 2 * n], found[:, 2 * n :]
        time_s, record = self._times(stride)[steps], self.run.time_s
        ground = height[steps], rate[steps]
        return Motion(
            time_s,
            (time_s >= record[0] - 1e-9) & (time_s <= record[-1] + 1e-9),
            acceleration,
            velocity,
            displacement,
            ground[0],
            _tyre_force(system, step_s, (displacement, velocity), ground),
        )


def _showing_all(system: System) -> System:
    """The mechanism with outputs that show all that moves: accelerations, displacements, rates."""
    n, others = len(system.mass), 2 * system.input_stiffness.shape[1] + len(system.port)
    return replace(
        system,
        output=np.vstack([np.eye(n), np.zeros((2 * n, n))]),
        reads=tuple(range(n, 3 * n)),
        reading=np.eye(2 * n, 2 * n + others),
    )


def _tyre_force(
    system: System, step_s: float, moved: tuple[Array, Array], ground: tuple[Array, Array]
) -> Array:
    """What the ground must push with, (T, wheels), N, for it to move so.

    Raising all coordinates together strains nothing, hence the ground's own stiffness is the sum of
    those that couple it: F = Σ_i B_ij (u_j − q_i) + D_ij (u̇_j − q̇_i) + Σ_p R_pj f_p.
    """
    (q, q_rate), (u, u_rate) = moved, ground
    b, d = system.input_stiffness, system.input_damping
    force = u * b.sum(axis=0) - q @ b + u_rate * d.sum(axis=0) - q_rate @ d
    for p in np.flatnonzero(system.port_input.any(axis=1)):
        row, row_input = system.port[p], system.port_input[p]
        x, v = q @ row + u @ row_input, q_rate @ row + u_rate @ row_input
        law, numbers = system.laws[system.port_law[p]], system.law_parameters[p]
        memory, given = 0.0, list[float]()
        steps = (array.tolist() for array in (x, v, np.diff(x, prepend=x[0])))
        for extension, speed, change in zip(*steps, strict=True):
            now, memory = law(extension, speed, change, step_s, memory, numbers)
            given.append(now)
        force += np.array(given)[:, None] * row_input
    return np.asarray(force)
