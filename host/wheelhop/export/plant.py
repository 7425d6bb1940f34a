"""A car between signals: what goes in and comes out, each with its unit in its name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import CampaignError
from wheelhop.files import replacing
from wheelhop.predict.drives import CHANNELS
from wheelhop.predict.ride import watched
from wheelhop.simulate import Model
from wheelhop.simulate.motion import watching
from wheelhop.simulate.run import STEP_S
from wheelhop.simulate.runge_kutta import STABLE
from wheelhop.vehicle import System, wheels
from wheelhop.vehicle.frame_modes import longest_step_s

if TYPE_CHECKING:
    import control

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Plant:
    """The equations of motion of a car on the road.

    Inputs are the heights of the ground under the wheels and their rates, forces of actuators in
    the struts, positive where they push body and axle apart, and what effects apply from outside.
    Outputs are accelerations of body points, axles and driver, travel of the struts and its rate,
    what the tyres carry beyond their static load, and motions of the body. `laws` are the names of
    the force laws, one for each port.
    """

    system: System
    corners: tuple[int, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    laws: tuple[str, ...]

    @property
    def states(self) -> tuple[str, ...]:
        """Displacements of the coordinates, then their rates."""
        names = [name.replace(" ", "_") for name in self.system.coordinates]
        turned = ("pitch", "roll")
        return tuple(
            f"{name}{ending}_{'rad' if name in turned else 'm'}{per}"
            for ending, per in (("", ""), ("_rate", "_s"))
            for name in names
        )

    @cached_property
    def linear(self) -> Linear:
        """The linear part, its force laws cut open: their forces are inputs, and the extensions of
        their ports and the rates of these outputs."""
        s, n = self.system, len(self.system.mass)
        motion, extension, shown = s.explicit
        wide, kept = n + len(s.reads), len(self.outputs)
        rest = 2 * wide
        columns = np.r_[:n, wide : wide + n, rest : motion.shape[1]]
        accelerated = motion[:n][:, columns]
        a = np.zeros((2 * n, 2 * n))
        a[:n, n:] = np.eye(n)
        a[n:] = accelerated[:, : 2 * n]
        b = np.vstack([np.zeros((n, accelerated.shape[1] - 2 * n)), accelerated[:, 2 * n :]])
        out = shown @ motion[:, columns]
        rows = np.vstack([out, extension[:, columns]])
        ports = [f"{law}_{what}" for what in ("extension_m", "rate_m_s") for law in self.laws]
        assert len(out) == kept
        return Linear(
            a,
            b,
            rows[:, : 2 * n],
            rows[:, 2 * n :],
            self.states,
            (*self.inputs, *(f"{law}_force_N" for law in self.laws)),
            (*self.outputs, *ports),
            tuple((name, self.system.law_parameters[i]) for i, name in enumerate(self.laws)),
        )


@dataclass(frozen=True, eq=False)
class Linear:
    """ẋ = A x + B u, y = C x + D u, SI. Each of `laws`, by its name and numbers, takes the outputs
    NAME_extension_m and NAME_rate_m_s to the input NAME_force_N, which opposes the extension."""

    a: Array
    b: Array
    c: Array
    d: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    laws: tuple[tuple[str, Array], ...]

    def to_control(self) -> control.StateSpace:
        """The linear part for python-control.

        Returns
        -------
        control.StateSpace
            In SI, with the names of states, inputs and outputs.

        Raises
        ------
        CampaignError
            python-control is not installed.
        """
        try:
            import control
        except ImportError:
            raise CampaignError("a state space needs python-control: pip install control") from None
        names = {"states": self.states, "inputs": self.inputs, "outputs": self.outputs}
        return control.ss(self.a, self.b, self.c, self.d, **{k: list(v) for k, v in names.items()})

    def write_mat(self, file: Path) -> None:
        """Write A, B, C, D, all names, and the laws' names and numbers for MATLAB.

        Parameters
        ----------
        file
            Such as "car.mat"; what stood there is replaced.

        Raises
        ------
        CampaignError
            The file cannot be written.
        """
        from scipy.io import savemat

        names = {k: np.array(getattr(self, k), object) for k in ("states", "inputs", "outputs")}
        width = max((len(numbers) for _, numbers in self.laws), default=0)
        numbers = np.array([row for _, row in self.laws]).reshape(len(self.laws), width)
        laws = {"laws": np.array([name for name, _ in self.laws], object), "law_numbers": numbers}
        matrices: Mapping[str, Any] = {"A": self.a, "B": self.b, "C": self.c, "D": self.d}
        with replacing(file, CampaignError) as draft:
            savemat(draft, {**matrices, **names, **laws}, appendmat=False)


def plant_of(model: Model) -> Plant:
    """The plant of a model. Raises CampaignError for one with masses that stand upright: what they
    do is no law of a port."""
    corners = wheels(model.values)
    channels = [channel for channel in CHANNELS if channel.corner in corners]
    system = model.system(channels, "road")
    if len(system.upright):
        raise CampaignError(
            "export: the model has a mass that stands upright and leans, as driver-rocking has:"
            " leave that effect out"
        )
    seen = watched(model, system)
    count, n = len(corners), len(system.mass)
    travel = seen.reading[:count]
    rate = np.zeros_like(travel)
    rate[:, n : 2 * n] = travel[:, :n]
    body = [name for name in ("heave", "pitch", "roll") if name in system.coordinates]
    motions = np.zeros((len(body), system.reading_width))
    for row, name in zip(motions, body, strict=True):
        row[system.coordinates.index(name)] = 1.0
    reading = np.vstack([travel, rate, seen.reading[count : 2 * count], motions])
    accelerated = np.vstack([system.output, seen.output[:1]])
    struts = travel[:, :n].T
    forced = np.hstack([system.force, struts])
    of_wheel = [corner + 1 for corner in corners]
    outputs = [
        *(f"{channel.point}_acceleration_m_s2" for channel in channels),
        "driver_acceleration_m_s2",
        *(f"strut_{i}_travel_m" for i in of_wheel),
        *(f"strut_{i}_travel_rate_m_s" for i in of_wheel),
        *(f"tyre_{i}_force_N" for i in of_wheel),
        *(f"body_{name}_{'m' if name == 'heave' else 'rad'}" for name in body),
    ]
    inputs = [
        *(f"ground_{i}_height_m" for i in of_wheel),
        *(f"ground_{i}_rate_m_s" for i in of_wheel),
        *(f"applied_{i + 1}_force_N" for i in range(system.force.shape[1])),
        *(f"actuator_{i}_force_N" for i in of_wheel),
    ]
    whole = replace(watching(system, accelerated, reading), force=forced)
    return Plant(whole, corners, tuple(inputs), tuple(outputs), _law_names(system))


def longest_step(model: Model) -> float:
    """The step, s, at which the model is integrated: as its effects and its fastest pole ask."""
    fastest = model.system((), "road").fastest_1_s
    asked = [effect.longest_step_s for effect in model.effects]
    return float(min(STEP_S, longest_step_s(model.values), STABLE / fastest, *asked))


def _law_names(system: System) -> tuple[str, ...]:
    """The laws of all ports by the names of their functions, numbered from 1 each."""
    names: Sequence[str] = [system.laws[i].__name__ for i in system.port_law]
    return tuple(f"{name}_{1 + names[:i].count(name)}" for i, name in enumerate(names))
