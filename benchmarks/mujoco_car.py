"""The same car for MuJoCo's stepper, in the form that MuJoCo is fastest at.

Small angles make the car linear in seven coordinates, so each is a body of its own on one slide
joint, with the generalised mass as its mass; struts are fixed tendons, the tyres' springs and
dampers joint springs and dampers, the road an applied force. Nothing of this needs contacts,
constraints or finite rotations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco import rollout
from numpy.typing import NDArray

Array = NDArray[np.float64]
Values = Mapping[str, float]
Law = Callable[[Array, Array], Array]

ENDS = ("front", "front", "rear", "rear")
EULER = mujoco.mjtIntegrator.mjINT_EULER
IMPLICIT = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
RUNGE_KUTTA = mujoco.mjtIntegrator.mjINT_RK4


@dataclass(frozen=True)
class Strut:
    """What a strut has beside spring and damper, by axle: a cubic rate (N/m³); a slip force (N)
    behind a joint stiffness (N/m), or as a constraint without one."""

    cubic_N_m3: tuple[float, float] = (0.0, 0.0)
    slip_N: tuple[float, float] = (0.0, 0.0)
    joint_N_m: float = 0.0


def travel_rows(values: Values) -> Array:
    """Extension of the four struts from heave, pitch, roll and four axles, (4, 7)."""
    ahead, half = values["geometry.cg_to_front_axle_m"], values["geometry.track_width_m"] / 2
    behind = values["geometry.wheelbase_m"] - ahead
    places = ((ahead, half), (ahead, -half), (-behind, half), (-behind, -half))
    body = np.array([[1.0, -x, y] for x, y in places])
    return np.hstack([body, -np.eye(4)])


def build(values: Values, strut: Strut, integrator: mujoco.mjtIntegrator) -> mujoco.MjModel:
    """The compiled model; `strut` in MuJoCo's own terms."""
    spec = mujoco.MjSpec()
    spec.option.gravity = [0.0, 0.0, 0.0]
    spec.option.integrator = integrator
    disabled = int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    if strut.joint_N_m or not any(strut.slip_N):
        disabled |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    spec.option.disableflags = disabled
    body = ("mass_kg", "pitch_inertia_kg_m2", "roll_inertia_kg_m2")
    masses = [values[f"body.{key}"] for key in body]
    masses += [values[f"wheel.{end}.unsprung_mass_kg"] for end in ENDS]
    names = ["heave", "pitch", "roll", "A1", "A2", "A3", "A4"]
    for name, mass in zip(names, masses, strict=True):
        part = spec.worldbody.add_body(
            name=name, mass=mass, inertia=[1.0] * 3, ipos=[0.0] * 3, explicitinertial=True
        )
        joint = part.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1])
        if name.startswith("A"):
            end = ENDS[int(name[1]) - 1]
            joint.stiffness = [values[f"wheel.{end}.tyre_stiffness_N_m"], 0.0, 0.0]
            joint.damping = [values[f"wheel.{end}.tyre_damping_N_s_m"], 0.0, 0.0]
    for i, row in enumerate(travel_rows(values)):
        end, axle = ENDS[i], 0 if i < 2 else 1
        spring = _tendon(spec, f"S{i + 1}", names, row)
        rate = values[f"suspension.{end}.stiffness_N_m"]
        spring.stiffness = [rate, 0.0, strut.cubic_N_m3[axle]]
        spring.damping = [values[f"suspension.{end}.damping_N_s_m"], 0.0, 0.0]
        if strut.slip_N[axle] and strut.joint_N_m:
            friction = _tendon(spec, f"F{i + 1}", names, row)
            friction.stiffness = [strut.joint_N_m, 0.0, 0.0]
            friction.springyield = strut.slip_N[axle] / strut.joint_N_m
        elif strut.slip_N[axle]:
            spring.frictionloss = strut.slip_N[axle]
    return spec.compile()


def _tendon(spec: mujoco.MjSpec, name: str, joints: list[str], row: Array) -> mujoco.MjsTendon:
    tendon = spec.add_tendon(name=name)
    for joint, coefficient in zip(joints, row, strict=True):
        if coefficient:
            tendon.wrap_joint(joint, coefficient)
    tendon.springlength = [0.0, 0.0]
    return tendon


def road_force(values: Values, height: Array, rate: Array) -> Array:
    """Force (T, 7) of the road through the tyres, from heights and rates in mid-step (T, 4)."""
    force = np.zeros((len(height), 7))
    for i, end in enumerate(ENDS):
        force[:, 3 + i] = (
            values[f"wheel.{end}.tyre_stiffness_N_m"] * height[:, i]
            + values[f"wheel.{end}.tyre_damping_N_s_m"] * rate[:, i]
        )
    return force


class Rollout:
    """All runs under precomputed forces (runs, T, 7), in C++ threads; memory is set up once."""

    def __init__(self, model: mujoco.MjModel, forces: Array, threads: int) -> None:
        self._model, self._forces = model, forces
        self._data = [mujoco.MjData(model) for _ in range(threads)]
        size = mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        self._start = np.zeros((1, size))
        self._states = np.zeros((*forces.shape[:2], size))

    def __call__(self) -> Array:
        """Velocities (runs, T, 7) after each step."""
        rollout.rollout(
            self._model,
            self._data,
            self._start,
            self._forces,
            control_spec=mujoco.mjtState.mjSTATE_QFRC_APPLIED,
            state=self._states,
            chunk_size=1,
            persistent_pool=True,
        )
        first = 1 + self._model.nq  # time, positions, velocities
        return self._states[:, :, first : first + self._model.nv]


def step_in_python(model: mujoco.MjModel, force: Array, rows: Array, law: Law) -> Array:
    """Velocities (T, 7) of one run; the law's force joins the road's before every step."""
    data, velocity = mujoco.MjData(model), np.empty_like(force)
    for n in range(len(force)):
        data.qfrc_applied = force[n] - law(rows @ data.qpos, rows @ data.qvel) @ rows
        mujoco.mj_step(model, data)
        velocity[n] = data.qvel
    return velocity


def step_with_callback(model: mujoco.MjModel, force: Array, rows: Array, law: Law) -> Array:
    """The same with the law in MuJoCo's passive-force callback, called at every stage."""

    def passive(_: mujoco.MjModel, data: mujoco.MjData) -> None:
        data.qfrc_passive -= law(rows @ data.qpos, rows @ data.qvel) @ rows

    data, velocity = mujoco.MjData(model), np.empty_like(force)
    mujoco.set_mjcb_passive(passive)
    try:
        for n in range(len(force)):
            data.qfrc_applied = force[n]
            mujoco.mj_step(model, data)
            velocity[n] = data.qvel
    finally:
        mujoco.set_mjcb_passive(None)
    return velocity
