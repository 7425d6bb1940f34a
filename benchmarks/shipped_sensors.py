"""Cars with the sensors that people have, on roads nobody surveyed, from the independent simulator.

python -m benchmarks.shipped_sensors examples [NAME …]  those that are shipped
python -m benchmarks.shipped_sensors table SEEDS [SET …]  what each set of sensors tells, diagnosed
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from tests import truth
from tests.truth.campaign import BAND_HZ, _vehicle_toml
from tests.truth.presets import draw_vehicles
from tests.truth.sensors import Sensor, sense
from tests.truth.tracks import Track

EXAMPLES = Path(__file__).parents[1] / "examples"
Array = NDArray[np.float64]
SECONDS, AVERAGING_S = 10.24, 0.0066
ORDER, CORNER_HZ, FINER, SETTLED_S = 4, 60.0, 5, 1.0
"""A recorder's Butterworth filter, works on so many samples for one that is kept; what it makes of
its start is left out."""


@dataclass(frozen=True)
class SensorSet:
    """Sensors of a car, by what `[channels]` says of each: those of the simulator, `on_body` as
    (x, y) of vertical accelerometers, and whether a GPS tells the speed; the road's class as its
    unevenness, m³, and how fast it was driven; samples a second, each a mean, or `filtered`."""

    title: str
    preset: str
    sensors: tuple[Sensor, ...]
    on_body: Mapping[str, tuple[float, float]]
    gps: bool
    unevenness_m3: float
    speeds_kmph: tuple[float, ...]
    rate_hz: float = 100.0
    filtered: bool = False

    @property
    def recorder(self) -> list[str]:
        """What campaign.toml says of it."""
        said = f"averaging_ms = {1e3 * AVERAGING_S:g}"
        if self.filtered:
            said = f'filter = {{ kind = "butterworth", order = {ORDER}, corner_hz = {CORNER_HZ} }}'
        return [f"sample_rate_hz = {self.rate_hz}", said]


def pots(noise_rms: float) -> tuple[Sensor, ...]:
    """One along each damper: 0.65 of the wheel's travel, resting at 31 mm."""
    ends = ("fl", "fr", "rl", "rr")
    return tuple(
        Sensor(f"pot_{end}", "travel", str(i), noise_rms, 0.65, 0.031)
        for i, end in enumerate(ends, start=1)
    )


GYROS = (
    Sensor("pitch_rate", "rate", "pitch", 0.004, 1.0, 0.01),
    Sensor("roll_rate", "rate", "roll", 0.004, 1.0, -0.02),
)
HUBS = tuple(Sensor(f"A{i}", "acceleration", f"A{i}", 0.1, 1.0, 0.05) for i in (1, 2, 3, 4))
FIELD, ROAD = 64e-6, 16e-6  # ISO 8608: class D, class C
STUDENT_KMPH = (12.0, 16.0, 20.0, 24.0, 28.0, 32.0, 18.0, 26.0)
RIDE_KMPH = (40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 55.0, 75.0)
SETS: Mapping[str, SensorSet] = {
    "pots-gyro-gps": SensorSet(
        "A student car with potentiometers, a gyro and GPS on a field",
        "formula-student",
        (*pots(3e-5), *GYROS),
        {"imu": (0.10, 0.0)},
        True,
        FIELD,
        STUDENT_KMPH,
    ),
    "seat-and-hubs": SensorSet(
        "A car with accelerometers on seat rail and hubs on a country road",
        "passenger-car",
        HUBS,
        {"seat_rail": (-0.25, 0.37), "tunnel": (0.30, 0.0), "boot": (-1.30, -0.30)},
        False,
        ROAD,
        RIDE_KMPH,
        rate_hz=200.0,
        filtered=True,
    ),
}
SHIPPED = {
    "pots-gyro-gps": ({"asymmetric-damper": {"asymmetry": 0.35}}, 11),
    "seat-and-hubs": ({"dry-friction": {"coulomb_front_N": 90.0, "coulomb_rear_N": 80.0}}, 12),
}
"""What is hidden in the examples, and the seed of each."""


def write_set(
    folder: Path, name: str, effects: Mapping[str, Mapping[str, float]], seed: int
) -> None:
    """Write a campaign of eight runs, with its truth beside it in words."""
    given, rng = SETS[name], np.random.default_rng(seed)
    true, nominal = draw_vehicles(truth.PRESETS[given.preset], rng)
    physics = truth.make_effects(effects)
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    head = [
        "format = 1",
        f'title = "{given.title}"',
        'vehicle = "vehicle.toml"',
        *given.recorder,
        f"band_hz = [{BAND_HZ[0]}, {BAND_HZ[1]}]",
        "noise_rms_m_s2 = 0.1",
    ]
    quantities = {sensor.quantity: sensor.noise_rms for sensor in given.sensors}
    keys = {"travel": "noise_rms_m", "rate": "noise_rms_rad_s"}
    head += [f"{keys[q]} = {rms:g}" for q, rms in quantities.items() if q in keys]
    head += ["", "[channels]", *(sensor.in_campaign for sensor in given.sensors)]
    head += [f"{name} = [{x}, {y}]" for name, (x, y) in given.on_body.items()]
    head += ['gps = { quantity = "speed" }'] if given.gps else []
    for number, speed in enumerate(given.speeds_kmph):
        run_id = f"{speed:g}-kmph"
        role = "validate" if number >= len(given.speeds_kmph) - 2 else "fit"
        track = Track(
            "iso8608",
            {"unevenness_m3": given.unevenness_m3, "waviness": 2.0, "seed": 100 * seed + number},
        )
        _write_run(folder / "runs" / f"{run_id}.csv", given, true, physics, (track, speed), rng)
        head += ["", "[[run]]", f'id = "{run_id}"', f'file = "runs/{run_id}.csv"']
        head += [f'role = "{role}"', f"speed_kmph = {speed}", 'track.kind = "unknown"']
    (folder / "campaign.toml").write_text("\n".join(head) + "\n")
    (folder / "vehicle.toml").write_text(_vehicle_toml(given.title, nominal))


def _write_run(
    file: Path,
    given: SensorSet,
    vehicle: Mapping[str, float],
    physics: list[truth.effect.Effect],
    driven: tuple[Track, float],
    rng: np.random.Generator,
) -> None:
    track, kmph = driven
    time_s = np.arange(round(SECONDS * given.rate_hz)) / given.rate_hz
    speed = kmph / 3.6 * (1.0 + rng.uniform(-0.05, 0.05))
    run = truth.Run(track, speed, float(rng.uniform(33.0, 41.0)), time_s, AVERAGING_S, int(kmph))
    corners = [Sensor(f"B{i}", "acceleration", f"B{i}", 0.0) for i in (1, 2, 3, 4)]
    seen = (*given.sensors, *corners)
    if given.filtered:
        fine = np.arange(round(SECONDS * given.rate_hz) * FINER) / (given.rate_hz * FINER)
        shown = sense(vehicle, replace(run, time_s=fine, averaging_s=0.0), seen, physics)
        low_pass = signal.butter(ORDER, CORNER_HZ, fs=given.rate_hz * FINER)
        settled = time_s >= SETTLED_S
        shown = np.asarray(signal.lfilter(*low_pass, shown, axis=0)[::FINER][settled], float)
        time_s = time_s[settled] - SETTLED_S
    else:
        shown = sense(vehicle, run, seen, physics)
    own, body = shown[:, : len(given.sensors)], shown[:, len(given.sensors) :]
    columns = [own, *(_at(vehicle, body, place)[:, None] for place in given.on_body.values())]
    noise = [s.noise_rms for s in given.sensors] + [0.1] * len(given.on_body)
    offset = [s.offset for s in given.sensors] + [0.05] * len(given.on_body)
    names = [s.name for s in given.sensors] + list(given.on_body)
    record = np.hstack(columns)
    share = (BAND_HZ[1] - BAND_HZ[0]) / (given.rate_hz / 2)  # of white noise that is in band
    record += np.array(offset) + np.array(noise) / np.sqrt(share) * rng.normal(size=record.shape)
    if given.gps:
        record = np.column_stack([record, speed + 0.03 * rng.normal(size=len(record))])
        names.append("gps")
    rows = [
        ",".join((f"{t:.9g}", *(f"{value:.5g}" for value in row)))
        for t, row in zip(time_s, record, strict=True)
    ]
    file.write_text("\n".join([",".join(("time_s", *names)), *rows]) + "\n")


def _at(
    vehicle: Mapping[str, float], body: NDArray[np.floating], place: tuple[float, float]
) -> Array:
    """Vertical acceleration of a rigid body at (x, y), of those at its four corners (n, 4)."""
    front = vehicle["geometry.cg_to_front_axle_m"]
    rear, half = front - vehicle["geometry.wheelbase_m"], vehicle["geometry.track_width_m"] / 2
    corners = np.array([[1, front, half], [1, front, -half], [1, rear, half], [1, rear, -half]])
    return np.asarray(body @ np.linalg.pinv(corners).T @ np.array([1.0, *place]))


def examples(names: Sequence[str] = ()) -> None:
    """Write what is shipped, or those named of it."""
    for name in names or SHIPPED:
        effects, seed = SHIPPED[name]
        write_set(EXAMPLES / name, name, effects, seed)


HIDDEN: Mapping[str, Mapping[str, Mapping[str, float]]] = {
    "none": {},
    "dry-friction": {"dry-friction": {"coulomb_front_N": 60.0, "coulomb_rear_N": 60.0}},
    "asymmetric-damper": {"asymmetric-damper": {"asymmetry": 0.35}},
    "anti-roll-bar": {"anti-roll-bar": {"stiffness_front_N_m": 8000.0}},
}


def table(seeds: int, names: Sequence[str] = ()) -> None:
    """Diagnose each set of sensors with each thing hidden, and print what came out."""
    import wheelhop as wh

    for name in names or SETS:
        for hidden, effects in HIDDEN.items():
            for seed in range(seeds):
                with tempfile.TemporaryDirectory() as folder:
                    write_set(Path(folder), name, effects, 1000 + seed)
                    found = wh.diagnose(folder)
                said = ", ".join(found.verdict)
                sure = f"{100 * found.confidence:.0f} %"
                print(f"{name:16} {hidden:18} {seed}: {said} ({sure})", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["examples"]:
        examples(sys.argv[2:])
    elif sys.argv[1:2] == ["table"] and len(sys.argv) > 2:
        table(int(sys.argv[2]), sys.argv[3:])
    else:
        print(__doc__)
