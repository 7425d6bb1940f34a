"""Does a plan hold? python -m benchmarks.plan [--seeds N] [--runs N] [--third]

From what its owner believes of a vehicle `wheelhop plan` advises some of 50 runs, 10 tracks at 5
speeds. Naive campaigns have as many: every track once, at the speeds one after the other. All are
driven by the independent simulator (tests/truth, MuJoCo), each run at a speed up to 5 % off.
Without a hidden effect the fitted numbers are held against the true vehicle's, as shares of its
body's mass where they are masses, forces or stiffnesses, as no run tells the scale of these. With
a weak one hidden the screening says how much likelier it is than each other effect of the library,
to first order; the table has the logarithm of the odds against its best rival. `--third` lets
MuJoCo's simplest car drive (`plan_car.py`), which has two of the effects.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks import plan_car
from tests.truth import CHANNELS, PRESETS, Run, Track, make_effects
from tests.truth.model import sense_run
from tests.truth.presets import Preset, draw_vehicles
from wheelhop.api.planning import plan
from wheelhop.campaign import Campaign, Channel
from wheelhop.campaign import Run as Recorded
from wheelhop.diagnose.baseline import Baseline, fit_baseline
from wheelhop.diagnose.screen.first_order import screen
from wheelhop.effects import load_effects
from wheelhop.predict.drives import Drive, read_drives
from wheelhop.vehicle import Vehicle

Array = NDArray[np.float64]
SPEEDS_KMPH = (6.0, 9.0, 12.0, 16.0, 20.0)
SECONDS, RATE_HZ, AVERAGING_S, NOISE = 10.24, 100.0, 0.0066, 0.1
HIDDEN: Mapping[str, Mapping[str, float]] = {
    "dry-friction": {"coulomb_front_N": 12.0, "coulomb_rear_N": 9.0},
    "digressive-damper": {"knee_m_s": 0.25, "slope_ratio": 0.9},
    "asymmetric-damper": {"asymmetry": 0.03},
    "progressive-spring": {"polytropic_exponent": 10.0},
    "anti-roll-bar": {"stiffness_front_N_m": 150.0},
    "driver-seat": {"mass_kg": 3.0, "freq_hz": 3.2, "zeta": 0.28, "x_m": -0.1},
}
"""What is hidden: weakly."""
FORCES = ("mass_kg", "inertia_kg_m2", "stiffness_N_m", "damping_N_s_m")


@dataclass(frozen=True)
class Driven:
    """Runs of a vehicle that are still to be recorded: its true and its believed numbers."""

    true: Mapping[str, float]
    believed: Vehicle
    drives: Sequence[Drive]
    seed: int
    third: bool = False

    def recorded(self, hidden: Mapping[str, Mapping[str, float]]) -> Campaign:
        """What the independent simulator records of it, or the third."""
        rng = np.random.default_rng(self.seed)
        time_s = np.arange(round(SECONDS * RATE_HZ)) / RATE_HZ
        sigma = NOISE / np.sqrt(29.5 / (RATE_HZ / 2))
        runs = []
        for number, drive in enumerate(self.drives):
            keys = dict(drive.keys)
            truly = Run(
                Track(str(keys.pop("kind")), keys),
                drive.speed_kmph / 3.6 * (1.0 + rng.uniform(-0.05, 0.05)),
                float(rng.uniform(33.0, 41.0)),
                time_s,
                AVERAGING_S,
                self.seed * 1000 + number,
            )
            if self.third:
                samples = plan_car.record(self.true, truly, next(iter(hidden), ""))
            else:
                samples = np.asarray(sense_run(self.true, truly, make_effects(hidden)))
            samples = samples + sigma * rng.normal(size=samples.shape)
            id_, speed = drive.id, drive.speed_kmph / 3.6
            runs.append(Recorded(id_, Path(id_), "fit", speed, drive.track, time_s, samples))
        return Campaign(
            Path("planned"),
            self.believed.name,
            Path("vehicle.toml"),
            RATE_HZ,
            (0.5, 30.0),
            AVERAGING_S,
            NOISE,
            tuple(Channel(name, name) for name in CHANNELS),
            tuple(runs),
        )


def candidates(preset: Preset, speeds: Iterable[float] = SPEEDS_KMPH) -> list[Drive]:
    """Every surface of a preset at every speed."""
    words = []
    for surface in preset.surfaces:
        word = f"{surface.kind}:amplitude_mm={surface.amplitude_mm}:pitch_mm={surface.pitch_mm}"
        word += ":angle_deg=20" if surface.kind == "herringbone" else ""
        word += ":width_mm=4000" if surface.kind == "chassis-twist" else ""
        words.append(word)
    return list(read_drives(words, list(speeds)))


def words_of(drives: Sequence[Drive]) -> list[str]:
    """Their tracks, as a plan takes them, each once."""
    words = [
        ":".join([str(d.keys["kind"]), *(f"{k}={v}" for k, v in d.keys.items() if k != "kind")])
        for d in drives
    ]
    return list(dict.fromkeys(words))


def naive(drives: Sequence[Drive], runs: int, first: int) -> list[Drive]:
    """One track after the other, evenly over them, at one speed after the other."""
    speeds = len(SPEEDS_KMPH)
    tracks = len(drives) // speeds
    chosen = [round(i * tracks / runs) % tracks for i in range(runs)]
    return [drives[t * speeds + (first + i) % speeds] for i, t in enumerate(chosen)]


def vehicles(preset: Preset, seed: int) -> tuple[dict[str, float], Vehicle]:
    """A true vehicle and what is believed of it."""
    true, nominal = draw_vehicles(preset, np.random.default_rng(seed))
    uncertain = {key: 0.1 * abs(value) for key, value in nominal.items()}
    for key in nominal:
        if key.endswith((".x_m", ".y_m")):
            uncertain[key] = max(uncertain[key], 0.02)
    return true, Vehicle(preset.name, nominal, uncertain)


def fitted(driven: Driven, hidden: Mapping[str, Mapping[str, float]]) -> Baseline:
    """The baseline of what is recorded of it."""
    return fit_baseline(driven.recorded(hidden), driven.believed, progress=lambda text: None)


def error_of(base: Baseline, true: Mapping[str, float]) -> float:
    """Root mean square, over the vehicle's numbers, of their relative errors; forces and masses per
    mass of the body."""
    names = [free.name for free in base.vehicle if free.name in true]
    found = base.rung.model.values
    logs = []
    for name in names:
        ratio = found[name] / true[name]
        if name.endswith(FORCES):
            ratio /= found["body.mass_kg"] / true["body.mass_kg"]
        logs.append(ratio - 1.0)
    return float(np.sqrt(np.mean(np.square(logs))))


def log_odds(driven: Driven, hidden: str, values: Mapping[str, float]) -> tuple[float, str]:
    """How much likelier what is hidden is than the best other effect of the library, and this."""
    base = fitted(driven, {hidden: values})
    library = [effect for effect in load_effects().values() if effect.place != "sensor"]
    scores = {
        item.variant.effect.id: item.score for item in screen(base.workshop, base.rung.fit, library)
    }
    right = scores.pop(hidden)
    rival = max(scores, key=lambda name: scores[name])
    return right - scores[rival], rival


def main() -> None:
    """Print a table for every vehicle."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--runs", type=int, default=4)
    parser.add_argument("--preset", default="atv", choices=sorted(PRESETS))
    parser.add_argument("--third", action="store_true", help="driven by benchmarks/plan_car.py")
    given = parser.parse_args()
    hideable = {k: v for k, v in HIDDEN.items() if not given.third or k in plan_car.STRUTS}
    preset, columns = PRESETS[given.preset], ("advised", "naive 1", "naive 2")
    drives = candidates(preset)
    for seed in range(1, given.seeds + 1):
        true, believed = vehicles(preset, seed)
        advised = plan(believed, words_of(drives), SPEEDS_KMPH, runs=given.runs)
        campaigns = [advised.drives, *(naive(drives, given.runs, first) for first in (0, 3))]
        print(f"\n{preset.name}, vehicle {seed}: {', '.join(d.id for d in advised.drives)}")
        print(f"{'':30s}" + "".join(f"{name:>10s}{'':19s}" for name in columns))
        cars = [Driven(true, believed, chosen, seed, given.third) for chosen in campaigns]
        print(f"{'rms error of the numbers, %':30s}", end="")
        for car in cars:
            print(f"{100 * error_of(fitted(car, {}), true):10.3f}{'':19s}", end="", flush=True)
        print()
        logs = np.zeros(len(cars))
        for hidden, values in hideable.items():
            print(f"{f'ln odds for {hidden}':30s}", end="")
            for i, car in enumerate(cars):
                odds, rival = log_odds(car, hidden, values)
                logs[i] += np.log(max(odds, 1.0)) / len(hideable)
                print(f"{odds:10.1f} {rival:18s}", end="", flush=True)
            print(flush=True)
        means = "".join(f"{mean:10.1f}{'':19s}" for mean in np.exp(logs))
        print(f"{'their geometric mean':30s}{means}", flush=True)


if __name__ == "__main__":
    main()
