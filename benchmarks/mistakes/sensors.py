"""What people do wrong with potentiometers, gyros and loggers that recorded apart:
python -m benchmarks.mistakes.sensors

Plants each mistake into `--base` good campaigns of the independent simulator for every set of
sensors (`benchmarks/sensor_sets.py`), on surveyed tracks and on roads that nobody described, and
asks the gate alone; then asks it about `--good` good ones. A third of the campaigns have an effect
hidden in the physics. Seeds follow on `--seed`.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.mistakes.planted import GRAVITY, recorded
from benchmarks.sensor_sets import IMU, SETS
from tests.diagnose.cases import CASES
from tests.truth import PRESETS, Sensor, forget_tracks
from tests.truth.campaign import write_campaign
from tests.truth.effects import make_effects
from wheelhop.campaign import Campaign, read_campaign
from wheelhop.gate import Finding, gate
from wheelhop.vehicle import read_nominal

Array = NDArray[np.float64]
Change = Callable[[Campaign, np.random.Generator], Campaign]
HIDDEN = [
    name
    for name, case in CASES.items()
    if case.hidden and not name.startswith("sensor-") and "driver-seat" not in case.hidden
]
ROADS = ("surveyed", "unsurveyed")
CARS = ("baja", "formula-student", "all")


def of(campaign: Campaign, quantity: str) -> list[int]:
    """The columns of a quantity."""
    return [i for i, c in enumerate(campaign.channels) if c.quantity == quantity]


def one(campaign: Campaign, quantity: str, rng: np.random.Generator) -> list[int]:
    """One of them."""
    return [int(rng.choice(of(campaign, quantity)))]


def times(campaign: Campaign, columns: list[int], factor: float) -> Campaign:
    """Some columns multiplied."""
    gain = np.ones(len(campaign.channels))
    gain[columns] = factor
    return recorded(campaign, lambda y: y * gain)


def at_its_end(campaign: Campaign, rng: np.random.Generator) -> Campaign:
    """A potentiometer whose travel ends at 0.6 of the largest peak on one side."""
    (column,) = one(campaign, "travel", rng)
    peaks = [run.record[:, column] - run.record[:, column].mean() for run in campaign.runs]
    end = 0.6 * max(float(peak.max()) for peak in peaks)

    def change(y: Array) -> Array:
        found = y.copy()
        found[:, column] = np.minimum(found[:, column], y[:, column].mean() + end)
        return found

    return recorded(campaign, change)


def late(campaign: Campaign, columns: list[int], seconds: float) -> Campaign:
    """Some columns by a logger whose clock is behind."""
    samples = round(seconds * campaign.sample_rate_hz)

    def change(y: Array) -> Array:
        found = y.copy()
        found[:, columns] = np.roll(y[:, columns], samples, axis=0)
        return found

    return recorded(campaign, change)


def ratio(campaign: Campaign, columns: list[int], factor: float) -> Campaign:
    """A ratio that campaign.toml states wrong."""
    channels = tuple(
        replace(c, per_wheel=c.per_wheel * factor) if i in columns else c
        for i, c in enumerate(campaign.channels)
    )
    return replace(campaign, channels=channels)


def imu(campaign: Campaign) -> list[int]:
    """The columns of the IMU, a logger of its own."""
    names = {sensor.name for sensor in IMU}
    return [i for i, c in enumerate(campaign.channels) if c.name in names]


def exchanged(campaign: Campaign, rng: np.random.Generator) -> Campaign:
    """Two potentiometers exchanged."""
    i, j = (int(k) for k in rng.choice(of(campaign, "travel"), 2, replace=False))
    order = np.arange(len(campaign.channels))
    order[[i, j]] = order[[j, i]]
    return recorded(campaign, lambda y: y[:, order])


MISTAKES: Mapping[str, tuple[str, Change]] = {
    "a pot reversed": ("polarity", lambda c, r: times(c, one(c, "travel", r), -1.0)),
    "all pots reversed": ("polarity", lambda c, r: times(c, of(c, "travel"), -1.0)),
    "ratio forgotten": ("ratio", lambda c, r: ratio(c, of(c, "travel"), 1 / 0.65)),
    "ratio upside down": ("ratio units", lambda c, r: ratio(c, of(c, "travel"), 0.65**-2)),
    "ratio of one end": ("ratio", lambda c, r: ratio(c, of(c, "travel")[2:], 1 / 0.65)),
    "a pot at its end": ("clipping", at_its_end),
    "pots in mm": ("units", lambda c, r: times(c, of(c, "travel"), 1e3)),
    "gyros in rad/s, said deg/s": ("units", lambda c, r: times(c, of(c, "rate"), np.pi / 180)),
    "gyros in deg/s, said rad/s": ("units", lambda c, r: times(c, of(c, "rate"), 180 / np.pi)),
    "a gyro reversed": ("polarity", lambda c, r: times(c, one(c, "rate", r), -1.0)),
    "pots 0.3 s late": ("out-of-step", lambda c, r: late(c, of(c, "travel"), 0.3)),
    "IMU 0.3 s late": ("out-of-step", lambda c, r: late(c, imu(c), 0.3)),
    "accelerations in g": ("units", lambda c, r: times(c, of(c, "acceleration"), 1 / GRAVITY)),
    "two pots exchanged": ("swapped misplaced exchanged", exchanged),
}
"""What is planted: the kinds of findings that name it, and how it is done."""


def good(folder: Path, seed: int, sensors: tuple[Sensor, ...], *, surveyed: bool) -> Campaign:
    """A good campaign of any vehicle, every third with an effect of physics."""
    preset = PRESETS[list(PRESETS)[seed % len(PRESETS)]]
    hidden = CASES[HIDDEN[seed // 3 % len(HIDDEN)]].hidden if preset is PRESETS["atv"] else {}
    where = folder / f"{seed}-{surveyed}-{len(sensors)}"
    physics = make_effects(hidden)
    write_campaign(
        where,
        preset,
        physics,
        seed=seed,
        short=True,
        draft=True,
        seconds=6.0,
        sensors=sensors,
    )
    if not surveyed:
        forget_tracks(where)
    return read_campaign(where)


def asked(campaign: Campaign) -> tuple[Finding, ...]:
    """What the gate finds."""
    return gate(campaign, read_nominal(campaign)).findings


def main() -> int:
    """Print what was found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--base", type=int, default=3, help="campaigns to plant each mistake in")
    parser.add_argument("--good", type=int, default=10, help="good campaigns of each set and road")
    parser.add_argument("--seed", type=int, default=0, help="of the first campaign")
    parser.add_argument("--sets", nargs="+", default=CARS, choices=SETS)
    parser.add_argument("--roads", nargs="+", default=ROADS, choices=ROADS)
    given = parser.parse_args()
    total = tried = false = count = 0
    with tempfile.TemporaryDirectory() as work:
        for name, road in product(given.sets, given.roads):
            sensors, surveyed = tuple(SETS[name]), road == "surveyed"
            seeds = range(given.seed, given.seed + given.base + given.good)
            bases = [good(Path(work), s, sensors, surveyed=surveyed) for s in seeds[: given.base]]
            for mistake, (kinds, change) in MISTAKES.items():
                said = []
                for number, campaign in enumerate(bases):
                    rng = np.random.default_rng([given.seed, number])
                    found = asked(change(campaign, rng))
                    if not any(finding.kind in kinds.split() for finding in found):
                        said.append(", ".join(f.kind for f in found) or "nothing")
                named = len(bases) - len(said)
                total, tried = total + named, tried + len(bases)
                line = f"{name:16s} {road:11s} {mistake:28s} {named:2d} of {len(bases)}"
                print(f"{line}  {'; '.join(said)}", flush=True)
            for seed in seeds[given.base :]:
                found = asked(good(Path(work), seed, sensors, surveyed=surveyed))
                count += 1
                false += bool(found)
                for finding in found:
                    print(f"  {name}, {road}, seed {seed}: {finding.about}: {finding.text}")
    print(f"named {total} of {tried}: {100 * total / max(tried, 1):.1f} %")
    print(f"good campaigns: {false} of {count} with a finding")
    return 0


if __name__ == "__main__":
    sys.exit(main())
