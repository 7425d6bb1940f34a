"""Does tuning hold in another simulator? python -m benchmarks.tune [--cars N] [--first N] [--time]

Each car is drawn near the independent simulator's ATV (tests/truth, MuJoCo) with dry friction in
its struts; its short campaign is recorded there, with noise. wheelhop fits the model, stores it,
and tunes springs and dampers on two tracks from what it stored. What the proposed setting changes
is added to the true car's own numbers, and the independent simulator drives both settings. A car
counts as better where the mean of its objectives over now is less than 1, each objective as held
where the gain there lies in the interval that was stated.

`--time` tunes 18 variables on three tracks instead, and says what that took.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import wheelhop as wh
from tests.truth import Run, Track, make_campaign, make_effects, read_truth
from tests.truth.model import integrate
from wheelhop.predict.comfort import comfort, weighted
from wheelhop.tune.tuning import Tuning
from wheelhop.vehicle import corner_position, static_tyre_load

Array = NDArray[np.float64]
SECONDS = 10.24
TRACKS: Mapping[str, tuple[Track, float]] = {
    "washboard:amplitude_mm=15:pitch_mm=900": (
        Track("washboard", {"amplitude_mm": 15.0, "pitch_mm": 900.0}),
        12.0,
    ),
    "herringbone:amplitude_mm=12:pitch_mm=1300:angle_deg=20": (
        Track("herringbone", {"amplitude_mm": 12.0, "pitch_mm": 1300.0, "angle_deg": 20.0}),
        12.0,
    ),
}
"""Words for wheelhop; the independent simulator's track and the speed, km/h."""
VARIED = (
    *("front.damping=±50%", "rear.damping=±50%"),
    *("front.stiffness=±30%", "rear.stiffness=±30%"),
)
KEYS = {
    f"{end}.{short}": f"suspension.{end}.{full}"
    for end in ("front", "rear")
    for short, full in (("damping", "damping_N_s_m"), ("stiffness", "stiffness_N_m"))
}
OBJECTIVES = ("comfort", "road-holding", "travel")
MANY = (
    *VARIED,
    *(
        f"{end}.{what}=±20%"
        for end in ("front", "rear")
        for what in ("tyre_stiffness", "unsprung_mass")
    ),
    *("front.friction=0:80", "rear.friction=0:80", "dry-friction.presliding_N_m=±50%"),
    *("wheel.front.tyre_damping_N_s_m=±50%", "wheel.rear.tyre_damping_N_s_m=±50%"),
    *("body.mass_kg=±10%", "body.pitch_inertia_kg_m2=±20%", "body.roll_inertia_kg_m2=±20%"),
    *("driver.x_m=-0.3:0.2", "geometry.cg_to_front_axle_m=0.7:0.9"),
)


def score(values: Mapping[str, float], effects: Mapping[str, Mapping[str, float]]) -> Array:
    """Comfort, road-holding and travel (3,) in the independent simulator."""
    felt_rms, loads, travel = list[float](), list[float](), 0.0
    for track, speed_kmph in TRACKS.values():
        at = np.arange(round(100 * SECONDS)) / 100.0
        run = Run(track, speed_kmph / 3.6, 30.0, at)
        motion = integrate(dict(values), run, make_effects(effects))
        inside = (motion.time >= 0.0) & (motion.time <= at[-1])
        rate_hz = 1.0 / float(motion.time[1] - motion.time[0])
        acceleration = np.gradient(motion.velocity[:, :4], axis=0) * rate_hz
        felt = acceleration @ driver_row(values)
        felt_rms.append(comfort(weighted(felt, rate_hz)[inside], rate_hz).rms_m_s2)
        extension = motion.position[inside, :4] - motion.position[inside, 4:]
        travel = max(travel, float(np.abs(extension).max()))
        static = np.array([static_tyre_load(values, corner) for corner in range(4)])
        load = (motion.tyre_force / static)[inside[1:]]
        loads += [float(np.sqrt(np.mean(load[:, i : i + 2] ** 2))) for i in (0, 2)]
    rms = [float(np.sqrt(np.mean(np.square(part)))) for part in (felt_rms, loads)]
    return np.array([*rms, travel])


def driver_row(values: Mapping[str, float]) -> Array:
    """The driver's place as a sum of the four body points (4,): the body is rigid."""
    corners = np.array([corner_position(values, corner) for corner in range(4)])
    plane = np.column_stack([np.ones(4), corners])
    place = np.array([1.0, values["driver.x_m"], values["driver.y_m"]])
    return np.asarray(place @ np.linalg.pinv(plane))


def campaign(folder: Path, seed: int) -> dict[str, dict[str, float]]:
    """Record a car's campaign; returns its effects."""
    rng = np.random.default_rng([seed, 7])
    front, rear = rng.uniform(20.0, 80.0, 2).round(1).tolist()
    effects = {"dry-friction": {"coulomb_front_N": front, "coulomb_rear_N": rear}}
    make_campaign(folder, seed=seed, effects=effects, short=True, draft=True)
    return effects


def tuned(folder: Path, settings: int) -> Tuning:
    """Tune the car of a campaign, of which model.toml is known."""
    speed = next(iter(TRACKS.values()))[1]
    return wh.tune(folder, VARIED, tuple(TRACKS), speed, OBJECTIVES, settings=settings)


def holds(seed: int, settings: int) -> tuple[bool, Array, str]:
    """Whether the setting is better there, which gains (3,) lie in their intervals, and a line."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "car"
        effects = campaign(folder, seed)
        wh.add(folder, "dry-friction")
        found = tuned(folder, settings)
        true = dict(read_truth(folder).vehicle)
    first = found.front[0]
    changes = {KEYS[v.name]: first.values[v.name] - v.now for v in found.variables}
    there = score({**true, **{k: true[k] + more for k, more in changes.items()}}, effects)
    now = score(true, effects)
    gains, stated = now - there, first.gains
    held = np.array([abs(g.value - gain) <= g.half for g, gain in zip(stated, gains, strict=True)])
    better = bool(np.mean(there / now) < 1.0)
    cells = " ".join(
        f"{o} {100 * g.value / n:+.1f} ± {100 * g.half / n:.1f} % there {100 * gain / t:+.1f} %"
        for o, g, n, gain, t in zip(OBJECTIVES, stated, found.now.scores, gains, now, strict=True)
    )
    room = "proposed" if found.proposed else "no room"
    return better, held, f"{seed:4d} {room}: {cells} {'better' if better else 'WORSE'}"


def take_time() -> None:
    """18 variables on three tracks."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "car"
        campaign(folder, 0)
        wh.add(folder, "dry-friction")
        tracks = (
            "washboard/low",
            "herringbone/high",
            "iso8608:unevenness_m3=4e-6:waviness=2:seed=1",
        )
        begun, worked = time.perf_counter(), time.process_time()
        found = wh.tune(folder, MANY, tracks, 15.0)
        took = time.perf_counter() - begun
        print(
            f"{len(MANY)} variables, {len(tracks)} tracks, {found.count} settings: {took:.0f} s,"
            f" {time.process_time() - worked:.0f} s of processors"
        )


def main() -> None:
    """Print a line for each car, and how many hold."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cars", type=int, default=40)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--settings", type=int, default=200)
    parser.add_argument("--time", action="store_true")
    arguments = parser.parse_args()
    if arguments.time:
        take_time()
        return
    better, held = list[bool](), list[Array]()
    for seed in range(arguments.first, arguments.first + arguments.cars):
        one, inside, line = holds(seed, arguments.settings)
        better.append(one)
        held.append(inside)
        print(line, flush=True)
    print(
        f"{sum(better)} of {len(better)} better there;"
        f" {int(np.sum(held))} of {np.size(held)} gains in their intervals"
    )


if __name__ == "__main__":
    main()
