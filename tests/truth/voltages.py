"""What eight real sensors would put out during the drives of a campaign with hidden effects.

    python -m tests.truth.voltages OUT --seed 11 --effect dry-friction coulomb_front_N=75 …

writes voltages.npz, drives.toml (how each drive was driven), vehicle.toml and truth.toml. The npz
holds an array (n, 8) of each drive, and of `flip-up` and `flip-down`: all sensors at rest, upright
and turned over; int16, tenths of a millivolt, `RATE_HZ` rows a second.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import lfilter, resample_poly

from .__main__ import assignment
from .campaign import _toml, _vehicle_toml
from .effects import make_effects
from .model import CHANNELS, Run, sense_run
from .presets import PRESETS, draw_vehicles, planned_runs
from .tracks import Array

RATE_HZ = 400.0
FINE = 8  # rows simulated for one that is kept
SECONDS = 10.6  # a logger wants a moment to start and stop
REST_S = 12.0
STEP_V = 1e-4
SUPPLY_V = 3.3
G_M_S2 = 9.80665


@dataclass(frozen=True)
class Sensors:
    """Eight ADXL326 as their data sheet has them: ratiometric, each a little different."""

    volts_per_g: Array  # (8,)
    zero_g_volts: Array  # (8,)
    cross_axis: Array  # (8, 8) share of each channel's motion in another
    corner_hz: float  # of the output filter
    noise_rms: float  # in 0 … RATE_HZ / 2, m/s^2

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Sensors:
        """57 mV/g at 3 V (4 % apart), mid-supply (0.6 g), 1 % cross-axis, 50 Hz."""
        per_g = 0.057 * SUPPLY_V / 3.0 * rng.normal(1.0, 0.04, 8)
        cross = 0.01 * rng.uniform(-1, 1, (8, 8)) * (1 - np.eye(8)) / np.sqrt(7)
        zero = SUPPLY_V / 2 + 0.6 * per_g * rng.normal(size=8)
        return cls(per_g, zero, cross, corner_hz=50.0, noise_rms=0.15)

    def volts(self, acceleration: Array, upright: float, rng: np.random.Generator) -> Array:
        """Output (n, 8) for vertical accelerations (FINE n, 8), gravity added."""
        sensed = acceleration @ (np.eye(8) + self.cross_axis).T
        # First-order lag, exact for straight lines between rows to the second order.
        warped = np.tan(np.pi * self.corner_hz / (RATE_HZ * FINE))
        b, a = [warped / (1 + warped)] * 2, [1.0, (warped - 1) / (warped + 1)]
        kept = resample_poly(lfilter(b, a, sensed, axis=0), 1, FINE, padtype="line")
        kept += rng.normal(0, self.noise_rms, kept.shape)
        return np.asarray(self.zero_g_volts + self.volts_per_g * (kept / G_M_S2 + upright))


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.truth.voltages")
    parser.add_argument("out", metavar="OUT", type=Path, help="folder to write")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--effect", nargs="+", action="append", default=[], metavar="ID KEY=VALUE")
    given = parser.parse_args()
    write_voltages(
        given.out,
        seed=given.seed,
        effects={name: dict(map(assignment, values)) for name, *values in given.effect},
    )


def write_voltages(folder: Path, *, seed: int, effects: dict[str, dict[str, float | str]]) -> None:
    """Drive the eight runs of a short campaign with the student-built ATV."""
    rng = np.random.default_rng(seed)
    preset = PRESETS["atv"]
    true, nominal = draw_vehicles(preset, rng)
    sensors = Sensors.draw(rng)
    physics = make_effects(effects)
    time_s = np.arange(int(SECONDS * RATE_HZ) * FINE) / (RATE_HZ * FINE)
    rest = np.zeros((int(REST_S * RATE_HZ) * FINE, 8))
    volts = {f"flip-{side}": sensors.volts(rest, up, rng) for side, up in (("up", 1), ("down", -1))}
    drives: list[str] = ["format = 1", f'title = "Simulated: {preset.name}"']
    for number, plan in enumerate(planned_runs(preset, short=True, lateral_offset_mm=100.0)):
        speed = plan.speed_kmph / 3.6 * (1.0 + rng.uniform(-0.05, 0.05))
        start = float(rng.uniform(33.0, 41.0))
        run = Run(plan.track, speed, start, time_s, averaging_s=0.0, seed=seed * 1000 + number)
        volts[plan.id] = sensors.volts(sense_run(true, run, physics), 1.0, rng)
        drives += ["", "[[drive]]", f'id = "{plan.id}"', f'role = "{plan.role}"']
        drives += [f"speed_kmph = {plan.speed_kmph}", f'track.kind = "{plan.track.kind}"']
        drives += [f"track.{key} = {_toml(value)}" for key, value in plan.track.keys.items()]
    folder.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(
        folder / "voltages.npz",
        **{name: np.round(rows / STEP_V).astype(np.int16) for name, rows in volts.items()},
    )
    (folder / "drives.toml").write_text("\n".join(drives) + "\n")
    (folder / "vehicle.toml").write_text(_vehicle_toml(preset.name, nominal))
    truth = ["format = 1", "effects = [" + ", ".join(f'"{name}"' for name in effects) + "]"]
    for name, parameters in effects.items():
        truth += ["", f"[effect.{name}]", *(f"{k} = {_toml(v)}" for k, v in parameters.items())]
    truth += ["", "[sensors]"]
    truth += [f"volts_per_g = {sensors.volts_per_g.round(6).tolist()}"]
    truth += [f"zero_g_volts = {sensors.zero_g_volts.round(5).tolist()}"]
    truth += [f"channels = {list(CHANNELS)}".replace("'", '"')]
    (folder / "truth.toml").write_text("\n".join(truth) + "\n")


if __name__ == "__main__":
    main()
