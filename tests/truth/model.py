"""The car as MuJoCo bodies, and one run of it over a track.

Points count 0..3: front left, front right, rear left, rear right. All motion is about static
equilibrium, hence no gravity; effects that need a static load bring it themselves.

The reference is a car of small angles. MuJoCo's rigid bodies turn by finite ones, so they are
moved by SMALL times the displacements asked for and everything read from them is divided by it:
what is left of finite rotation is of relative order SMALL.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import ceil
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from scipy.interpolate import CubicSpline

from .tracks import Array, Track, Wheel
from .vehicle import Vehicle, axle, corner_positions

if TYPE_CHECKING:
    from .effect import Effect

CHANNELS = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")

SMALL = 1e-4
STEP_S = 5e-4
WARM_UP_S = 4.0  # on the track before time_s = 0
FADE_IN_S = 1.0  # in which the track rises from flat, so that no transient survives the warm-up
LEAD_OUT_S = 0.05  # simulated after the last sample: averaging windows and late channels end in it


@dataclass(frozen=True)
class Run:
    """One drive over a track, as it truly was."""

    track: Track
    speed_m_s: float
    start_m: float  # x of the front axle at time_s = 0
    time_s: Array  # (n,) sample times, any spacing
    averaging_s: float = 0.0066  # window centred on each sample time; 0: instantaneous
    seed: int = 0  # of everything random within the run


class Car:
    """A MuJoCo specification under construction: sprung body, four wheels, and named lengths.

    A *length* is a linear combination of joint coordinates (a MuJoCo fixed tendon). "B1".."B4" are
    the heights of the body points, "A1".."A4" those of the axles (along which the tyres' own
    springs act, the road's part of the tyre force is applied) and "S1".."S4" the compressions of
    the suspensions.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        self.vehicle = vehicle
        self.spec = mujoco.MjSpec()
        self.body = self.spec.worldbody.add_body(name="body")
        self.mass = vehicle["body.mass_kg"]
        self.first_moment = np.zeros(2)  # of mass taken from the body, about its centre of mass
        self.roll_inertia = vehicle["body.roll_inertia_kg_m2"]
        self.pitch_inertia = vehicle["body.pitch_inertia_kg_m2"]
        self.product_xy = 0.0  # integral of x y dm
        self.has_friction = False  # in a joint, which MuJoCo treats as a constraint
        slide, hinge = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
        self.body.add_joint(name="heave", type=slide, axis=[0, 0, 1])
        self.body.add_joint(name="pitch", type=hinge, axis=[0, 1, 0])  # positive nose down
        self.body.add_joint(name="roll", type=hinge, axis=[1, 0, 0])  # positive left side up
        self.lengths: dict[str, dict[str, float]] = {}
        for i, (x, y) in enumerate(corner_positions(vehicle)):
            self._add_corner(i, x, y)

    def _add_corner(self, i: int, x: float, y: float) -> None:
        where, number = axle(i), i + 1
        wheel = self.spec.worldbody.add_body(
            name=f"wheel{number}",
            mass=self.vehicle[f"wheel.{where}.unsprung_mass_kg"],
            ipos=[0.0, 0.0, 0.0],
            inertia=[1.0, 1.0, 1.0],
            explicitinertial=True,
        )
        wheel.add_joint(name=f"A{number}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1])
        self.add_body_point(f"B{number}", x, y)
        self.add_length(
            f"A{number}",
            {f"A{number}": 1.0},
            self.vehicle[f"wheel.{where}.tyre_stiffness_N_m"],
            self.vehicle[f"wheel.{where}.tyre_damping_N_s_m"],
        )
        self.add_length(
            f"S{number}",
            {f"A{number}": 1.0} | {joint: -c for joint, c in self.lengths[f"B{number}"].items()},
            self.vehicle[f"suspension.{where}.stiffness_N_m"],
            self.vehicle[f"suspension.{where}.damping_N_s_m"],
        )

    def add_body_point(self, name: str, x: float, y: float) -> None:
        """The height of a point of the sprung body as a length."""
        self.add_length(name, {"heave": 1.0, "pitch": -x, "roll": y})

    def add_length(
        self, name: str, joints: Mapping[str, float], stiffness: float = 0.0, damping: float = 0.0
    ) -> None:
        """A combination of joint coordinates, with a spring and a damper along it."""
        self.lengths[name] = dict(joints)
        tendon = self.spec.add_tendon(name=name)
        tendon.stiffness = [stiffness, 0.0, 0.0]
        tendon.damping = [damping, 0.0, 0.0]

    def compile(self) -> mujoco.MjModel:
        """The finished MuJoCo model, integrated by the classical Runge-Kutta method."""
        for name, joints in self.lengths.items():
            for joint, coefficient in joints.items():
                self.spec.tendon(name).wrap_joint(joint, coefficient)
        self._set_body_inertia()
        option = self.spec.option
        option.gravity = [0.0, 0.0, 0.0]
        option.integrator = mujoco.mjtIntegrator.mjINT_RK4
        disable = mujoco.mjtDisableBit  # without reset, a motion that runs away ends in NaN
        flags = disable.mjDSBL_CONTACT | disable.mjDSBL_AUTORESET
        option.disableflags = int(flags if self.has_friction else flags | disable.mjDSBL_CONSTRAINT)
        return self.spec.compile()

    def take_from_body(self, mass: float, x: float, y: float) -> None:
        """Remove a point mass at (x, y) from the sprung body, whose joints stay where they are."""
        self.mass -= mass
        self.first_moment -= mass * np.array([x, y])
        self.roll_inertia -= mass * y**2
        self.pitch_inertia -= mass * x**2
        self.product_xy -= mass * x * y

    def _set_body_inertia(self) -> None:
        cx, cy = self.first_moment / self.mass
        ixx = self.roll_inertia - self.mass * cy**2
        iyy = self.pitch_inertia - self.mass * cx**2
        ixy = -(self.product_xy - self.mass * cx * cy)
        self.body.explicitinertial = True
        self.body.mass = self.mass
        self.body.ipos = [cx, cy, 0.0]
        # yaw never moves, so its inertia only has to be admissible: nearly that of a flat body
        self.body.fullinertia = [ixx, iyy, 0.999 * (ixx + iyy), ixy, 0.0, 0.0]


@dataclass
class Drive:
    """One run about to be integrated: what the effects see of it and may still change."""

    vehicle: Vehicle
    time: Array  # (m + 1,) integration grid, seconds
    path: Array  # (m + 1, 2) x of the left and right front wheels on the grid, metres
    speed_m_s: float  # nominal
    rng: np.random.Generator
    suspension_stiffness: Array  # (4,) N/m
    suspension_damping: Array  # (4,) N s/m
    tyre_stiffness: Array  # (4,) N/m
    tyre_damping: Array  # (4,) N s/m
    forces: dict[str, Array] = field(default_factory=dict)

    @property
    def step_s(self) -> float:
        """The integration step."""
        return float(self.time[1] - self.time[0])

    def push(self, length: str, force: Array) -> None:
        """Add a force (m + 1,), newtons, that lengthens the named length."""
        self.forces[length] = self.forces.get(length, 0.0) + force


def simulate_run(
    vehicle: Vehicle, run: Run, effects: Sequence[Effect] = (), *, step_s: float | None = None
) -> tuple[Array, Array]:
    """Drive over the run's track; returns run.time_s (n,) and accelerations (n, 8), no noise.

    Columns are CHANNELS, in m/s^2; a sample is the mean over run.averaging_s centred on its time.
    The integration step is the smallest that one of the effects wants, unless it is given.
    """
    return run.time_s, record(sense_run(vehicle, run, effects, step_s=step_s), effects)


def sense_run(
    vehicle: Vehicle, run: Run, effects: Sequence[Effect] = (), *, step_s: float | None = None
) -> Array:
    """Accelerations (n, 8) as the sensors give them, before noise and offset join."""
    motion = integrate(vehicle, run, effects, step_s=step_s)
    velocity = motion.velocity
    for effect in effects:
        velocity = effect.feel(motion.time, velocity)
    delay = sum((effect.delay_s() for effect in effects), np.zeros(len(CHANNELS)))
    samples = np.column_stack(
        [
            _mean_rate(motion.time, velocity[:, k], run.time_s + delay[k], run.averaging_s)
            for k in range(len(CHANNELS))
        ]
    )
    for effect in effects:
        samples = effect.sense(samples)
    return samples


def record(samples: Array, effects: Sequence[Effect]) -> Array:
    """What is stored of samples (n, 8) that carry their noise and offset."""
    for effect in effects:
        samples = effect.record(samples)
    return samples


@dataclass(frozen=True)
class Motion:
    """The integrated run; forces are deviations from static load, compression positive."""

    time: Array  # (m + 1,) s
    position: Array  # (m + 1, 8) of CHANNELS, m
    velocity: Array  # (m + 1, 8) of CHANNELS, m/s
    road: Array  # (m + 1, 4) height of the wheel envelope under each wheel, m
    suspension_force: Array  # (m, 4) N, at mid-step
    tyre_force: Array  # (m, 4) N, at mid-step
    joints: dict[str, tuple[Array, Array]]  # of effects: displacement and rate (m + 1,)


def integrate(
    vehicle: Vehicle, run: Run, effects: Sequence[Effect] = (), *, step_s: float | None = None
) -> Motion:
    """The car's motion from WARM_UP_S before the run to just after its last sample."""
    step_s = step_s or min([STEP_S, *(effect.step_s for effect in effects)])
    car = Car(vehicle)
    for effect in effects:
        effect.build(car)
    model = car.compile()
    model.opt.timestep = step_s
    drive = _prepare(vehicle, run, model, step_s)
    for effect in effects:
        effect.steer(drive)
    for effect in effects:
        effect.start(drive)
    track = run.track
    for effect in effects:
        track = effect.pave(track, drive)
    return _march(car, model, drive, _road(vehicle, track, drive, effects), effects)


def _prepare(vehicle: Vehicle, run: Run, model: mujoco.MjModel, step_s: float) -> Drive:
    begin = min(0.0, float(run.time_s.min())) - WARM_UP_S
    steps = ceil((float(run.time_s.max()) + LEAD_OUT_S - begin) / step_s)
    time = begin + step_s * np.arange(steps + 1)
    path = run.start_m + run.speed_m_s * time

    def of(prefix: str, values: Array) -> Array:
        return np.array([values[model.tendon(f"{prefix}{i}").id] for i in range(1, 5)])

    return Drive(
        vehicle=vehicle,
        time=time,
        path=np.column_stack([path, path]),
        speed_m_s=run.speed_m_s,
        rng=np.random.default_rng(run.seed),
        suspension_stiffness=of("S", model.tendon_stiffness),
        suspension_damping=of("S", model.tendon_damping),
        tyre_stiffness=of("A", model.tendon_stiffness),
        tyre_damping=of("A", model.tendon_damping),
    )


def _road(vehicle: Vehicle, track: Track, drive: Drive, effects: Sequence[Effect]) -> Array:
    """Height of the wheel envelope under each wheel on the integration grid (m + 1, 4)."""
    columns = []
    for i, (_, y) in enumerate(corner_positions(vehicle)):
        x = drive.path[:, i % 2] - (0.0 if i < 2 else vehicle["geometry.wheelbase_m"])
        radius = vehicle[f"wheel.{axle(i)}.radius_m"]
        wheel = Wheel(track, i, y, radius, x)
        heights = [h for effect in effects if (h := effect.roll(wheel)) is not None]
        columns.append(heights[-1] if heights else wheel.rigid())
    rise = np.clip((drive.time - drive.time[0]) / FADE_IN_S, 0.0, 1.0)
    fade: Array = 0.5 - 0.5 * np.cos(np.pi * rise)
    return np.column_stack(columns) * fade[:, None]


def _march(
    car: Car, model: mujoco.MjModel, drive: Drive, road: Array, effects: Sequence[Effect]
) -> Motion:
    """Step through the grid. Linear springs and dampers are MuJoCo's own; every other force is
    held over a step at its mean (road, harmonic forces) or its predicted mid-step value (laws)."""
    step, steps = drive.step_s, len(drive.time) - 1

    def matrix(names: Sequence[str]) -> Array:
        rows = np.zeros((len(names), model.nv))
        for row, name in zip(rows, names, strict=True):
            for joint, coefficient in car.lengths[name].items():
                row[model.joint(joint).dofadr[0]] = coefficient
        return rows

    # eight elements, four struts and then four tyres: each is shortened by x = given + shape q,
    # given being the road's part of it, and pushes back with a force f on the joints -shape^T f
    shape = np.vstack([matrix(["S1", "S2", "S3", "S4"]), -matrix(["A1", "A2", "A3", "A4"])])
    given, given_rate = np.zeros((steps, 8)), np.zeros((steps, 8))
    given[:, 4:] = 0.5 * (road[1:] + road[:-1])
    given_rate[:, 4:] = np.diff(road, axis=0) / step
    stiffness = np.concatenate([drive.suspension_stiffness, drive.tyre_stiffness])
    damping = np.concatenate([drive.suspension_damping, drive.tyre_damping])
    given_force = given * stiffness + given_rate * damping

    applied = -given_force @ shape
    for name, force in drive.forces.items():
        applied += 0.5 * np.outer(force[1:] + force[:-1], matrix([name])[0])
    applied *= SMALL

    # shortening, its rate and the linear force of every element half a step on: the road's part,
    # and what q, q' and the q' of a step before make of it
    of_road = np.hstack([given, given_rate, given_force])
    shortened = np.hstack([shape, 0.625 * step * shape, -0.125 * step * shape])
    rate = np.hstack([np.zeros_like(shape), 1.5 * shape, -0.5 * shape])
    linear = stiffness[:, None] * shortened + damping[:, None] * rate
    of_motion = np.vstack([shortened, rate, linear]) / SMALL

    laws = [effect.suspension for effect in effects if effect.has_law("suspension")]
    tyre_laws = [effect.tyre for effect in effects if effect.has_law("tyre")]
    data, nv = mujoco.MjData(model), model.nv
    q, dq, push = data.qpos, data.qvel, data.qfrc_applied
    motion = np.zeros((steps + 1, 3 * nv))  # q, q' and the q' of a step before
    extra = np.zeros((steps, 8))  # what the laws add to the linear forces
    for n in range(steps):
        push[:] = applied[n]
        if laws or tyre_laws:
            x, v, force = (of_road[n] + of_motion @ motion[n]).reshape(3, 8)
            strut, tyre = force[:4], force[4:]
            for law in laws:
                strut = law(strut, x[:4], v[:4])
            for tyre_law in tyre_laws:
                tyre = tyre_law(tyre, x[4:], v[4:])
            extra[n, :4], extra[n, 4:] = strut - force[:4], tyre - force[4:]
            push -= SMALL * (extra[n] @ shape)
        mujoco.mj_step(model, data)
        motion[n + 1, :nv], motion[n + 1, nv : 2 * nv] = q, dq
        motion[n + 1, 2 * nv :] = motion[n, nv : 2 * nv]

    force = (of_road + motion[:-1] @ of_motion.T)[:, 16:] + extra
    position, velocity = motion[:, :nv] / SMALL, motion[:, nv : 2 * nv] / SMALL
    points = matrix(CHANNELS)
    return Motion(
        time=drive.time,
        position=position @ points.T,
        velocity=velocity @ points.T,
        road=road,
        suspension_force=force[:, :4],
        tyre_force=force[:, 4:],
        joints={
            model.joint(i).name: (position[:, at], velocity[:, at])
            for i, at in enumerate(model.jnt_dofadr)
        },
    )


def _mean_rate(time: Array, velocity: Array, at: Array, window: float) -> Array:
    """Mean acceleration over `window` seconds centred on `at`; the derivative when it is zero."""
    spline = CubicSpline(time, velocity)
    if window == 0.0:
        return np.asarray(spline(at, 1))
    return np.asarray(spline(at + window / 2.0) - spline(at - window / 2.0)) / window
