"""How many times faster wheelhop simulates than MuJoCo: python -m benchmarks.simulator

Eight runs of a campaign, one car, one force law in its struts. Both get the road's motion
ready-made, both use the same number of threads. MuJoCo is tried in several configurations, at the
finest step (halving) at which its error in band is not below wheelhop's.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from benchmarks import mujoco_car as other
from tests import truth
from tests.simulate.setup import CHANNELS, EFFECTS, model_of, track_spec
from wheelhop.campaign import Averaging, TrackSpec
from wheelhop.simulate.integrator import Task, integrate
from wheelhop.simulate.run import STEP_S
from wheelhop.track import Envelope, make_track, wheel_envelope
from wheelhop.vehicle import System, corner_position

Array = NDArray[np.float64]

THREADS = min(2, os.cpu_count() or 1)
REPEATS = 3
RUN_UP_S, RECORD_S, LEAD_OUT_S, RATE_HZ, WINDOW_S = 4.0, 10.24, 0.05, 100.0, 0.0066
DURATION_S = RUN_UP_S + RECORD_S
STEPS_S = tuple(0.005 / 2**n for n in range(7))
VEHICLE = dict(truth.PRESETS["atv"].vehicle)


@dataclass(frozen=True)
class Case:
    """One law in both programs' terms; `in_python` makes it anew for stepping from Python."""

    name: str
    effect: str
    choice: str
    theta: dict[str, float]
    strut: other.Strut
    in_python: Callable[[], other.Law]


def friction_law() -> other.Law:
    """An elastic, perfectly plastic element that remembers its force."""
    slip, joint = np.array([75.0, 75.0, 55.0, 55.0]), 1.5e6
    force, last = np.zeros(4), np.zeros(4)

    def law(x: Array, v: Array) -> Array:
        nonlocal force, last
        force, last = np.clip(force + joint * (x - last), -slip, slip), x
        return force

    return law


def cubic_law() -> other.Law:
    """A cubic rate on both axles."""
    rate = np.array([4e6, 4e6, 2e6, 2e6])
    return lambda x, v: rate * x**3


CASES = (
    Case(
        "dry friction 75/55 N",
        "dry-friction",
        "",
        {"front_N": 75.0, "rear_N": 55.0, "presliding_N_m": 1.5e6},
        other.Strut(slip_N=(75.0, 55.0), joint_N_m=1.5e6),
        friction_law,
    ),
    Case(
        "cubic spring 4e6/2e6 N/m³",
        "progressive-spring",
        "cubic",
        {"front_N_m3": 4e6, "rear_N_m3": 2e6},
        other.Strut(cubic_N_m3=(4e6, 2e6)),
        cubic_law,
    ),
)


class Road:
    """Heights and rates under the wheels of every run, at any step."""

    def __init__(self) -> None:
        rng = np.random.default_rng(1)
        planned = truth.presets.planned_runs(
            truth.PRESETS["atv"], short=True, lateral_offset_mm=100.0
        )
        self.seconds = len(planned) * DURATION_S
        self._wheels = [
            self._wheels_of(track_spec(run.track), run.speed_kmph / 3.6, rng.uniform(33.0, 41.0))
            for run in planned
        ]

    def _wheels_of(
        self, spec: TrackSpec, speed: float, start: float
    ) -> list[tuple[Envelope, float, float]]:
        """Envelope, x at time 0 (m) and speed (m/s) of the four wheels."""
        track, wheels = make_track(spec), []
        for i in range(4):
            x0 = start - (VEHICLE["geometry.wheelbase_m"] if i >= 2 else 0.0)
            low, high = x0 - speed * (RUN_UP_S + 0.1), x0 + speed * DURATION_S
            side = corner_position(VEHICLE, i)[1]
            wheels.append((wheel_envelope(track, side, 0.279, low, high), x0, speed))
        return wheels

    def motions(self, step_s: float, shift: float = 0.0) -> list[tuple[Array, Array]]:
        """(T + 1, 4) heights (m) and rates (m/s) of each run, at steps moved by `shift` steps."""
        steps = round((DURATION_S + LEAD_OUT_S) / step_s)
        t = (np.arange(steps + 1) + shift) * step_s - RUN_UP_S
        ramp = np.clip(t + RUN_UP_S, 0.0, 1.0)
        fade, fade_rate = ramp**2 * (3 - 2 * ramp), 6 * ramp * (1 - ramp)
        found = []
        for wheels in self._wheels:
            height, rate = np.empty((len(t), 4)), np.empty((len(t), 4))
            for i, (envelope, x0, speed) in enumerate(wheels):
                h, slope = envelope.height(x0 + speed * t), envelope.slope(x0 + speed * t)
                height[:, i], rate[:, i] = h * fade, slope * speed * fade + h * fade_rate
            found.append((height, rate))
        return found


def ours(system: System, motions: list[tuple[Array, Array]], step_s: float) -> list[Array]:
    """Accelerations (n, 8) of every run, side by side in a few threads."""
    stride = round(1 / RATE_HZ / step_s)

    tasks = [
        Task(system, h, r, np.zeros((2 * len(h) - 1, 0)), np.zeros(2 * len(system.mass)))
        for h, r in motions
    ]

    def some(first: int) -> list[Array]:
        return integrate(
            tasks[first : first + share],
            step_s=step_s,
            first=round(RUN_UP_S / step_s),
            stride=stride,
            averaging=Averaging(WINDOW_S),
            n_samples=round(RECORD_S * RATE_HZ),
        )

    share = -(-len(tasks) // THREADS)
    with ThreadPoolExecutor(THREADS) as pool:
        parts = pool.map(some, range(0, len(tasks), share))
    return [record for part in parts for record in part]


def sampled(velocity: Array, step_s: float, rows: Array) -> Array:
    """Mean accelerations (n, 8) over the sensors' window from velocities (T, 7) after each step."""
    spline = CubicSpline(step_s * (1 + np.arange(len(velocity))) - RUN_UP_S, velocity @ rows.T)
    at = np.arange(round(RECORD_S * RATE_HZ)) / RATE_HZ
    return np.asarray(spline(at + WINDOW_S / 2) - spline(at - WINDOW_S / 2)) / WINDOW_S


def error(found: list[Array], reference: list[Array]) -> float:
    """Rms of the difference over the rms of the reference, in band, over the runs in `found`."""
    missed = present = 0.0
    for one, other_one in zip(found, reference, strict=False):
        missed += float(np.sum(truth.in_band(one - other_one) ** 2))
        present += float(np.sum(truth.in_band(other_one) ** 2))
    return float(np.sqrt(missed / present))


def fastest(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """Least wall-clock time of some repeats, s."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times)


@dataclass(frozen=True)
class Timed:
    """One configuration: seconds of `THREADS` threads per simulated second, and error in band."""

    name: str
    step_s: float
    cost: float
    error: float


def native(
    name: str, strut: other.Strut, kind: int, road: Road, reference: list[Array], least: float
) -> Timed:
    """All in C++: `rollout` with the road's force as control. The step is halved as long as the
    error stays above `least`."""
    model, rows, chosen = other.build(VEHICLE, strut, kind), _output_rows(), None
    for step_s in STEPS_S:
        model.opt.timestep = step_s
        forces = _road_forces(road, step_s)
        velocity = other.Rollout(model, forces, THREADS)()
        missed = error([sampled(v, step_s, rows) for v in velocity], reference)
        if missed < least:  # False for a blown-up run's NaN: a finer step is tried
            break
        chosen = (step_s, missed)
    assert chosen is not None, "the coarsest step is already too fine"
    model.opt.timestep = chosen[0]
    run = other.Rollout(model, _road_forces(road, chosen[0]), THREADS)
    return Timed(name, chosen[0], fastest(run) / road.seconds, chosen[1])


def _road_forces(road: Road, step_s: float) -> Array:
    """Force of the road (runs, T, 7), in the middle of each step."""
    return np.stack(
        [other.road_force(VEHICLE, h[:-1], r[:-1]) for h, r in road.motions(step_s, 0.5)]
    )


def from_python(
    name: str, step: Callable[..., Array], case: Case, road: Road, reference: list[Array],
    step_s: float, kind: int,
) -> Timed:  # fmt: skip
    """The law in Python, one run on one thread; counted as if `THREADS` processes shared the work
    without loss."""
    model = other.build(VEHICLE, other.Strut(), kind)
    model.opt.timestep = step_s
    height, rate = road.motions(step_s, 0.5)[0]
    force, rows = other.road_force(VEHICLE, height[:-1], rate[:-1]), other.travel_rows(VEHICLE)
    velocity = step(model, force, rows, case.in_python())
    seconds = fastest(lambda: step(model, force, rows, case.in_python()), 1)
    missed = error([sampled(velocity, step_s, _output_rows())], reference)
    return Timed(name, step_s, seconds / THREADS / DURATION_S, missed)


def _output_rows() -> Array:
    """B1..B4, A1..A4 from the seven coordinates, (8, 7)."""
    axles = np.hstack([np.zeros((4, 3)), np.eye(4)])
    return np.vstack([other.travel_rows(VEHICLE) + axles, axles])


def compare(case: Case, road: Road) -> None:
    """Print every configuration's time and error, and the ratio to the fastest."""
    effect = EFFECTS[case.effect]
    system = model_of(VEHICLE, {}, case.effect, case.theta, choice=case.choice).system(
        CHANNELS, "road"
    )
    step_s = min(STEP_S, effect.longest_step_s)
    reference = ours(system, road.motions(step_s / 8), step_s / 8)
    motions = road.motions(step_s)
    missed = error(ours(system, motions, step_s), reference)
    cost = fastest(lambda: ours(system, motions, step_s)) / road.seconds
    mine = Timed("wheelhop: Runge-Kutta, law compiled", step_s, cost, missed)

    tried = [
        native(f"MuJoCo: native, rollout, {label}", case.strut, kind, road, reference, missed)
        for label, kind in (
            ("Euler", other.EULER),
            ("implicitfast", other.IMPLICIT),
            ("RK4", other.RUNGE_KUTTA),
        )
    ]
    if case.strut.joint_N_m:
        rigid = other.Strut(slip_N=case.strut.slip_N)
        tried.append(
            native("MuJoCo: frictionloss constraint, rollout, Euler", rigid, other.EULER, road,
                   reference, max(missed, 0.03))
        )  # fmt: skip
    step_python = next(t.step_s for t in tried if "RK4" in t.name)
    for name, step in (
        ("MuJoCo: law in a Python loop, qfrc_applied, RK4", other.step_in_python),
        ("MuJoCo: law in the passive callback, Euler", other.step_with_callback),
    ):
        kind = other.RUNGE_KUTTA if "RK4" in name else other.EULER
        tried.append(from_python(name, step, case, road, reference, step_python, kind))

    print(f"\n{case.name}: {road.seconds:.0f} s of driving, {THREADS} threads")
    print(f"{'':52s} {'step, ms':>9s} {'µs per simulated s':>19s} {'error in band':>14s}")
    for row in (mine, *sorted(tried, key=lambda t: t.cost)):
        print(f"{row.name:52s} {1e3 * row.step_s:9.4f} {1e6 * row.cost:19.0f} {row.error:14.1e}")
    best = min(tried, key=lambda t: t.cost)
    print(f"wheelhop is {best.cost / mine.cost:.1f} times as fast as the fastest of MuJoCo's")


def main() -> None:
    """Both laws."""
    road = Road()
    for case in CASES:
        compare(case, road)


if __name__ == "__main__":
    main()
