"""wheelhop, MuJoCo and Exudyn side by side: python -m benchmarks.peers

Do they answer alike, and at equal accuracy, 0.5 % of a converged solution, how long do they take?
MuJoCo and Exudyn come with the extra `test`.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco import rollout
from numpy.typing import NDArray

from benchmarks import exudyn_car
from benchmarks.peers_model import (
    BEGINS_M,
    CAR,
    CHANNELS,
    LENGTH_M,
    Mechanism,
    bump,
    flexible,
    with_laws,
)
from wheelhop.campaign import Averaging
from wheelhop.simulate import Model
from wheelhop.simulate.integrator import Task, integrate
from wheelhop.simulate.lanes import LANES
from wheelhop.vehicle import System

Array = NDArray[np.float64]
SECONDS, RATE_HZ = 5.0, 100.0
EVERY_S = 0.5 / RATE_HZ  # a sample is the mean acceleration over its period
SPEEDS_M_S = tuple(np.linspace(1.5, 5.0, LANES).tolist())
STEPS_S = tuple(EVERY_S / n for n in (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96))
ALIKE, REPEATS = 0.005, 3
FINE_S = EVERY_S / 64


def ours(
    system: System, speeds: tuple[float, ...], step_s: float, seconds: float = SECONDS
) -> list[Array]:
    """Mean accelerations (n, 8) of every run, side by side in one thread."""
    tasks = []
    for speed in speeds:
        steps = round((seconds + 4 * EVERY_S) / step_s)
        height, rate = bump(speed, np.arange(steps + 1) * step_s)
        start = np.zeros(2 * len(system.mass))
        tasks.append(Task(system, height, rate, np.zeros((2 * steps + 1, 0)), start))
    return integrate(
        tasks,
        step_s=step_s,
        first=round(2 * EVERY_S / step_s),
        stride=round(2 * EVERY_S / step_s),
        averaging=Averaging(2 * EVERY_S),
        n_samples=round(seconds * RATE_HZ) - 1,
    )


def averaged(velocity: Array, output: Array) -> Array:
    """The same from velocities (T, n) every `EVERY_S`, the first at time 0."""
    seen = velocity[: round(SECONDS / EVERY_S) + 1] @ output.T
    found = (seen[2:] - seen[:-2]) / (2 * EVERY_S)
    return np.asarray(found[1::2])


class MujocoCar:
    """Slide joints and tendons; the road is an applied force, made before the clock runs."""

    def __init__(self, mechanism: Mechanism, integrator: mujoco.mjtIntegrator) -> None:
        self._mechanism = mechanism
        spec = mujoco.MjSpec()
        spec.option.gravity = [0.0, 0.0, 0.0]
        spec.option.integrator = integrator
        spec.option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_CONTACT) | int(
            mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        )
        names = [f"q{i}" for i in range(len(mechanism.mass))]
        joints = {}
        for name, mass in zip(names, mechanism.mass, strict=True):
            body = spec.worldbody.add_body(
                name=name, mass=mass, inertia=[1.0] * 3, ipos=[0.0] * 3, explicitinertial=True
            )
            joints[name] = body.add_joint(
                name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1]
            )
        for i in range(4):
            joints[names[3 + i]].stiffness = [mechanism.tyre[i, 0], 0.0, 0.0]
            joints[names[3 + i]].damping = [mechanism.tyre[i, 1], 0.0, 0.0]
        for number, (row, stiffness, damping) in enumerate(mechanism.springs):
            if np.count_nonzero(row) == 1 and stiffness and not np.any(row[3:7]):
                only = joints[names[int(np.flatnonzero(row)[0])]]
                only.stiffness, only.damping = [stiffness, 0.0, 0.0], [damping, 0.0, 0.0]
                continue
            tendon = spec.add_tendon(name=f"t{number}")
            for name, factor in zip(names, row, strict=True):
                if factor:
                    tendon.wrap_joint(name, factor)
            tendon.springlength = [0.0, 0.0]
            tendon.stiffness, tendon.damping = [stiffness, 0.0, 0.0], [damping, 0.0, 0.0]
        self.model = spec.compile()

    def run(self, speed_m_s: float, step_s: float) -> Callable[[], Array]:
        """What gives velocities (T, n) every `EVERY_S`; the laws, if any, in the callback for
        passive forces."""
        self.model.opt.timestep = step_s
        steps, every = round((SECONDS + EVERY_S) / step_s), round(EVERY_S / step_s)
        height, rate = bump(speed_m_s, (np.arange(steps) + 0.5) * step_s)
        force = np.zeros((1, steps, len(self._mechanism.mass)))
        tyre = self._mechanism.tyre
        force[0, :, 3:7] = height * tyre[:, 0] + rate * tyre[:, 1]

        def native() -> Array:
            data = mujoco.MjData(self.model)
            start = np.zeros((1, mujoco.mj_stateSize(self.model, FULL)))
            state, _ = rollout.rollout(self.model, [data], start, force, control_spec=APPLIED)
            n = self.model.nv
            return np.vstack([np.zeros(n), state[0, every - 1 :: every, 1 + n : 1 + 2 * n]])

        def stepped() -> Array:
            laws, rows = _laws(self._mechanism), self._mechanism.struts

            def passive(_: mujoco.MjModel, data: mujoco.MjData) -> None:
                data.qfrc_passive -= laws(rows @ data.qpos, rows @ data.qvel) @ rows

            mujoco.set_mjcb_passive(passive)
            try:
                return native()
            finally:
                mujoco.set_mjcb_passive(None)

        return stepped if self._mechanism.laws else native


FULL = mujoco.mjtState.mjSTATE_FULLPHYSICS
APPLIED = mujoco.mjtState.mjSTATE_QFRC_APPLIED


def _laws(mechanism: Mechanism) -> Callable[[Array, Array], Array]:
    every = mechanism.strut_numbers
    p = {key: np.array([numbers[key] for numbers in every]) for key in every[0]}

    def force(x: Array, v: Array) -> Array:
        beyond = np.maximum(np.abs(v) - p["knee"], 0.0)
        return np.asarray(
            p["cubic"] * x**3
            + p["stop"] * np.minimum(x + p["clearance"], 0.0)
            + p["one_sided"] * np.abs(v)
            - p["lost"] * beyond * np.sign(v)
            + p["slip"] * np.tanh(v / p["creep"])
        )

    return force


@dataclass(frozen=True)
class Timed:
    """A program in one configuration: step, processor seconds per simulated second, error."""

    name: str
    step_s: float
    cost: float
    error: float


def off(found: list[Array], wanted: list[Array]) -> float:
    """Rms of the difference over the rms."""
    missed = sum(float(np.sum((a - b) ** 2)) for a, b in zip(found, wanted, strict=True))
    return float(np.sqrt(missed / sum(float(np.sum(b**2)) for b in wanted)))


def coarsest(
    name: str, prepare: Callable[[float], Callable[[], list[Array]]], wanted: list[Array]
) -> Timed | None:
    """The configuration at the longest step that is accurate enough."""
    for step_s in STEPS_S:
        work = prepare(step_s)
        with np.errstate(all="ignore"):
            error = off(work(), wanted)
        if error < ALIKE:
            times = []
            for _ in range(REPEATS):
                begin = time.process_time()
                work()
                times.append(time.process_time() - begin)
            return Timed(name, step_s, min(times) / SECONDS / len(wanted), error)
    return None


def compare(title: str, mechanism: Mechanism) -> None:
    """Print how far the programs are apart, and how long they take."""
    system, output = mechanism.system, mechanism.output
    reference = ours(system, SPEEDS_M_S, STEPS_S[-1])
    slow, converged = reference[:1], dict[str, float]()
    print(f"\n{title}: {len(mechanism.mass)} degrees of freedom, one thread")
    found = [
        coarsest(
            f"wheelhop, {LANES} runs side by side",
            lambda step_s: lambda: ours(system, SPEEDS_M_S, step_s),
            reference,
        ),
        coarsest(
            "wheelhop, one run", lambda step_s: lambda: ours(system, SPEEDS_M_S[:1], step_s), slow
        ),
    ]
    for label, kind in (
        ("Euler", mujoco.mjtIntegrator.mjINT_EULER),
        ("implicitfast", mujoco.mjtIntegrator.mjINT_IMPLICITFAST),
        ("RK4", mujoco.mjtIntegrator.mjINT_RK4),
    ):
        car = MujocoCar(mechanism, kind)

        def in_mujoco(step_s: float, car: MujocoCar = car) -> Callable[[], list[Array]]:
            run = car.run(SPEEDS_M_S[0], step_s)
            return lambda: [averaged(run(), output)]

        found.append(coarsest(f"MuJoCo, {label}", in_mujoco, slow))
        if label == "RK4":
            converged["MuJoCo"] = off(in_mujoco(FINE_S)(), slow)
    for label, solver in (
        ("RK44", exudyn_car.EXPLICIT),
        ("generalised α", exudyn_car.IMPLICIT),
    ):
        exudyn = exudyn_car.Car(mechanism, SPEEDS_M_S[0], EVERY_S)

        def in_exudyn(
            step_s: float, car: exudyn_car.Car = exudyn, solver: object = solver
        ) -> Callable[[], list[Array]]:
            return lambda: [averaged(car.run(SECONDS + EVERY_S, step_s, solver), output)]

        found.append(coarsest(f"Exudyn, {label}", in_exudyn, slow))
        if label == "RK44":
            converged["Exudyn"] = off(in_exudyn(FINE_S)(), slow)
    print(f"{'':34s}{'step, ms':>9s}{'× real time':>13s}{'off':>9s}")
    for row in filter(None, found):
        print(f"{row.name:34s}{row.step_s * 1e3:9.3f}{1 / row.cost:13.0f}{row.error:9.2%}")
    mine, alone, *others = found
    for name in ("MuJoCo", "Exudyn"):
        theirs = [t.cost for t in others if t is not None and t.name.startswith(name)]
        if theirs and mine is not None and alone is not None:
            ratio, single = min(theirs) / mine.cost, min(theirs) / alone.cost
            print(
                f"{ratio:.0f} times as fast as {name}, {single:.1f} times with one run alone;"
                f" converged, they are {converged[name]:.2%} apart"
            )


def quarter_cars(count: int = 10_000, seconds: float = 60.0) -> None:
    """Print what as many different quarter cars take, made and driven, on all processors."""
    from concurrent.futures import ThreadPoolExecutor

    from wheelhop.campaign import Channel
    from wheelhop.fit.bench import processors

    rng, step_s = np.random.default_rng(1), 0.0025
    kept = ("front", "body.mass_kg")
    base = {k: v for k, v in CAR.items() if any(word in k for word in kept) and "cg_to" not in k}
    base["body.mass_kg"] /= 4
    points = [Channel("B1", "B1"), Channel("A1", "A1")]
    steps = round(seconds / step_s) + 8
    t = np.arange(steps + 1) * step_s
    height = (0.01 * np.sin(10 * t) + 0.004 * np.sin(40 * t))[:, None]
    rate = (0.1 * np.cos(10 * t) + 0.16 * np.cos(40 * t))[:, None]
    none, still = np.zeros((2 * steps + 1, 0)), np.zeros(4)

    def some(number: int) -> None:
        values = [{k: v * rng.uniform(0.8, 1.2) for k, v in base.items()} for _ in range(number)]
        cars = [Model(one).system(points, "road") for one in values]
        integrate(
            [Task(car, height, rate, none, still) for car in cars],
            step_s=step_s, first=4, stride=4, averaging=Averaging(0.01),
            n_samples=round(seconds * RATE_HZ) - 2,
        )  # fmt: skip

    some(LANES)
    wall, used = time.perf_counter(), time.process_time()
    with ThreadPoolExecutor(processors()) as pool:
        list(pool.map(some, [100] * (count // 100)))
    wall, used = time.perf_counter() - wall, time.process_time() - used
    print(
        f"\n{count} quarter cars, {seconds:g} s each at {RATE_HZ:g} Hz: {used:.1f} s of processor"
        f" time, {used / processors():.1f} s on {processors()} processors of its own"
        f" ({wall:.1f} s by the clock)"
    )


def linearity() -> None:
    """Print the processor time with twice the cases, twice the time and more degrees of freedom."""
    rigid, bending = Model(CAR).system(CHANNELS, "road"), flexible().system
    for system, runs, seconds in (
        (rigid, LANES, SECONDS),
        (rigid, 2 * LANES, SECONDS),
        (rigid, LANES, 2 * SECONDS),
        (bending, LANES, SECONDS),
    ):
        times = []
        for _ in range(REPEATS):
            begin = time.process_time()
            ours(system, tuple(np.linspace(1.5, 5.0, runs)), 0.0025, seconds)
            times.append(time.process_time() - begin)
        per_case = 1e6 * min(times) / runs / seconds
        print(
            f"{len(system.mass):3d} degrees of freedom, {runs:2d} cases of {seconds:2.0f} s:"
            f" {per_case:6.0f} µs of processor time per simulated second and case"
        )


def main() -> None:
    """All of it."""
    last = (BEGINS_M + CAR["geometry.wheelbase_m"] + LENGTH_M) / min(SPEEDS_M_S)
    assert last < SECONDS, "the slowest car has not crossed the bump"
    compare("Full car, driver, flexible frame, half-sine bump", flexible())
    compare("Full car with six suspension effects, half-sine bump", with_laws())
    quarter_cars()
    linearity()


if __name__ == "__main__":
    main()
