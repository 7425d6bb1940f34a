"""What people carry, and what it can show: python -m benchmarks.sensor_sets

Sets of sensors, each as one kind of user has them. Prints for each, on surveyed tracks and on
roads that nobody described, from where on `wheelhop check` says that dry friction is seen, and told
from a damper, at several noises of the potentiometers. With `--diagnose N` it makes N campaigns of
a set with friction of `--friction` newtons at every strut, and N clean ones, and counts the
verdicts. With `--table` it hides each of ten causes at clear strength in one campaign of the set,
and prints the verdicts as a row each, on roads that nobody described, or with `--surveyed`.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

from tests.diagnose.cases import CASES
from tests.truth import Sensor, forget_tracks, make_campaign
from wheelhop.api import detectable, diagnose

POT_NOISE_M, RATIO = 5e-5, 0.65
HUBS = tuple(Sensor(f"A{i}", "acceleration", f"A{i}", 0.1) for i in (1, 2, 3, 4))


def pots(noise_m: float = POT_NOISE_M, ratio: float = RATIO) -> tuple[Sensor, ...]:
    """Four potentiometers on the dampers."""
    return tuple(Sensor(f"pot{i}", "travel", str(i), noise_m, ratio, 0.031) for i in (1, 2, 3, 4))


IMU = (
    Sensor("imu_z", "acceleration", "cg", 0.1, 1.0, 0.05),
    Sensor("pitch_rate", "rate", "pitch", 0.004, 1.0, 0.01),
    Sensor("roll_rate", "rate", "roll", 0.004, 1.0, -0.02),
)
SETS: Mapping[str, Sequence[Sensor]] = {
    "baja": (*pots(), *IMU),
    "formula-student": (*pots(), *IMU, *HUBS[:2]),
    "ride-engineer": (*HUBS, *(Sensor(f"B{i}", "acceleration", f"B{i}", 0.1) for i in (1, 4))),
    "all": (
        *pots(),
        *HUBS,
        *(Sensor(f"B{i}", "acceleration", f"B{i}", 0.1, 1.0, 0.05) for i in (1, 2, 3, 4)),
        *IMU[1:],
    ),
}
"""A Baja team: damper pots and one IMU. A Formula Student team: accelerometers on the front hubs,
too. A ride engineer: hubs and two places on the body. All of it together."""

NOISES_MM = (0.2, 0.1, 0.05, 0.02)


def with_noise(name: str, noise_mm: float) -> tuple[Sensor, ...]:
    """A set with potentiometers of this noise in band."""
    others = tuple(s for s in SETS[name] if s.quantity != "travel")
    has_pots = len(others) < len(SETS[name])
    return (*pots(noise_mm / 1e3), *others) if has_pots else others


def driven(
    folder: Path, sensors: Sequence[Sensor], friction_N: float, seed: int, *, surveyed: bool
) -> Path:
    """Eight runs of an ATV of about 300 kg."""
    friction = {"coulomb_front_N": friction_N, "coulomb_rear_N": friction_N}
    hidden = {"dry-friction": friction} if friction_N else {}
    make_campaign(folder, seed=seed, effects=hidden, short=True, draft=True, sensors=sensors)
    if not surveyed:
        forget_tracks(folder)
    return folder


TABLE = (
    "clean",
    "dry-friction",
    "progressive-spring cubic",
    "bump-stop",
    "digressive-damper",
    "asymmetric-damper",
    "mount-bushing",
    "anti-roll-bar",
    "driver-seat",
    "engine-vibration",
)
"""What is hidden, by the names of `tests.diagnose.cases`."""


def told(name: str, noise_mm: float, seed: int, *, surveyed: bool) -> None:
    """Print a row for each cause: what a diagnosis says, how sure, what is left over the floor and
    what it took."""
    for cause in TABLE:
        with tempfile.TemporaryDirectory() as folder:
            where, sensors = Path(folder), with_noise(name, noise_mm)
            hidden = CASES[cause].hidden
            make_campaign(where, seed=seed, effects=hidden, short=True, draft=True, sensors=sensors)
            if not surveyed:
                forget_tracks(where)
            begun = time.process_time()
            found = diagnose(where, jobs=1).diagnosis
            spent = time.process_time() - begun
        right = set(found.verdict) == set(CASES[cause].verdict)
        print(
            f"| {name} | {'surveyed' if surveyed else 'any road'} | {cause} |"
            f" {'' if right else '**not** '}{', '.join(found.verdict)}"
            f" | {100 * found.confidence:.0f} % | {spent:.0f} |",
            flush=True,
        )


def foretold(name: str, noise_mm: float, seed: int, *, surveyed: bool) -> str:
    """From where on friction is seen, and told, at the front, N; or why nothing can be compared."""
    with tempfile.TemporaryDirectory() as folder:
        sensors = with_noise(name, noise_mm)
        found = detectable(driven(Path(folder), sensors, 0.0, seed, surveyed=surveyed))
    if found.refused:
        return "refused"
    one = next(told for told in found.told if told.limit.effect == "dry-friction")
    seen = next(limit for limit in found.limits if limit.effect == "dry-friction")
    return f"{_front(seen.amplitudes)} {_front(one.limit.amplitudes)} ({one.rival})"


def _front(amplitudes: Mapping[str, float]) -> str:
    return f"{amplitudes['front_N']:.1f}" if amplitudes else "never"


def main() -> None:
    """Print the table, or count the verdicts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=0, help="of the first campaign")
    parser.add_argument("--set", default="baja", choices=SETS, help="to diagnose")
    parser.add_argument("--pot-noise-mm", type=float, default=0.05, help="to diagnose")
    parser.add_argument("--friction", type=float, default=60.0, help="N at the wheel, to diagnose")
    parser.add_argument("--diagnose", type=int, default=0, metavar="N", help="so many of each")
    parser.add_argument("--table", action="store_true", help="one campaign of each cause")
    parser.add_argument("--surveyed", action="store_true", help="with the tracks described")
    given = parser.parse_args()
    if given.table:
        told(given.set, given.pot_noise_mm, given.seed, surveyed=given.surveyed)
        return
    if not given.diagnose:
        for name in SETS:
            for surveyed in (True, False):
                road = "surveyed" if surveyed else "unsurveyed"
                noises = NOISES_MM if with_noise(name, 1.0) != with_noise(name, 2.0) else (0.0,)
                for noise in noises:
                    said = foretold(name, noise, given.seed, surveyed=surveyed)
                    print(f"{name:16s} {road:11s} {noise:5g} mm  {said}", flush=True)
        return
    sensors = with_noise(given.set, given.pot_noise_mm)
    for friction in (given.friction, 0.0):
        counts: Counter[str] = Counter()
        for seed in range(given.seed, given.seed + given.diagnose):
            with tempfile.TemporaryDirectory() as folder:
                made = driven(Path(folder), sensors, friction, seed, surveyed=False)
                counts[", ".join(diagnose(made).diagnosis.verdict)] += 1
            print(f"friction {friction:g} N: {dict(counts)}", flush=True)


if __name__ == "__main__":
    main()
