"""Detection limits, put to the test: python -m benchmarks.limits [--seed N]

A clean campaign of 8 runs says from what strength on it would have shown each effect. The same
drives with an effect hidden at 0.4, 0.7, 1, 1.5 and 2.5 times that (tests/truth, MuJoCo) have to
be called "none" well below and named well above.

With `--before` it is `wheelhop check` that says so, before any diagnosis, and effects are hidden at
0.1, 0.5, 1 and 2 times that: by the logger's eight accelerometers, or by `--sensors pots`, four
potentiometers, four accelerometers on the body and two gyros; on surveyed tracks, or on
`--unsurveyed` ones.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from tests import truth
from wheelhop.api import detectable
from wheelhop.campaign import Campaign, read_campaign
from wheelhop.diagnose import Diagnosis, diagnose
from wheelhop.effects import load_effects
from wheelhop.vehicle import read_vehicle

FACTORS = (0.4, 0.7, 1.0, 1.5, 2.5)
FACTORS_BEFORE = (0.1, 0.5, 1.0, 2.0)

Amplitudes = Mapping[str, float]

HIDDEN: Mapping[str, Callable[[Amplitudes, float], Mapping[str, float]]] = {
    "dry-friction": lambda least, f: {
        "coulomb_front_N": f * least["front_N"],
        "coulomb_rear_N": f * least["rear_N"],
    },
    "driver-seat": lambda least, f: {
        "mass_kg": f * least["mass_kg"],
        "freq_hz": 3.2,
        "zeta": 0.28,
        "x_m": -0.1,
    },
    "anti-roll-bar": lambda least, f: {
        "stiffness_front_N_m": f * least["front_N_m"],
        "stiffness_rear_N_m": f * least["rear_N_m"],
    },
}
"""What the truth is told, from the least amplitudes and how many times as strong."""
HIDDEN_BEFORE: Mapping[str, Callable[[Amplitudes, float], Mapping[str, float]]] = {
    **HIDDEN,
    "digressive-damper": lambda least, f: {
        "slope_ratio": max(1.0 - f * least["front_loss"], 0.0),
        "knee_m_s": least["knee_m_s"],
    },
}


@dataclass(frozen=True)
class Car:
    """How the car is measured: its sensors, instead of the eight accelerometers, and whether its
    tracks are described."""

    seed: int
    sensors: Sequence[truth.Sensor]
    surveyed: bool

    def driven(self, hidden: Mapping[str, Mapping[str, float]], folder: str) -> Campaign:
        """A campaign that hides this."""
        made = truth.make_campaign(
            Path(folder), seed=self.seed, effects=hidden, short=True, sensors=self.sensors
        )
        if not self.surveyed:
            truth.forget_tracks(made)
        return read_campaign(made)

    def asked(self, hidden: Mapping[str, Mapping[str, float]]) -> Diagnosis:
        """The diagnosis of a campaign that hides this."""
        with tempfile.TemporaryDirectory() as folder:
            campaign = self.driven(hidden, folder)
            return diagnose(campaign, read_vehicle(campaign.vehicle_file), load_effects())

    def least(self, *, before: bool) -> dict[str, Amplitudes]:
        """The limits of the clean car, and the shapes they hold for where they are known before."""
        if not before:
            return {limit.effect: limit.amplitudes for limit in self.asked({}).limits}
        with tempfile.TemporaryDirectory() as folder:
            found = detectable(self.driven({}, folder))
        return {one.effect: {**found.shapes[one.effect], **one.amplitudes} for one in found.limits}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=101)
    parser.add_argument("--before", action="store_true", help="the limits of `wheelhop check`")
    parser.add_argument("--sensors", choices=("accelerometers", "pots"), default="accelerometers")
    parser.add_argument("--pot-noise-mm", type=float, default=0.05, help="in band")
    parser.add_argument("--unsurveyed", action="store_true", help="no track is described")
    asked = parser.parse_args()
    pots = [
        replace(s, noise_rms=asked.pot_noise_mm / 1e3) if s.quantity == "travel" else s
        for s in truth.SENSORS
    ]
    car = Car(asked.seed, pots if asked.sensors == "pots" else (), not asked.unsurveyed)
    least = car.least(before=asked.before)
    factors = FACTORS_BEFORE if asked.before else FACTORS
    print(f"{'times the limit':18s}" + "".join(f"{factor:>20g}" for factor in factors))
    print(f"{'nothing':18s}{', '.join(car.asked({}).verdict):>20s}", flush=True)
    for effect, told in (HIDDEN_BEFORE if asked.before else HIDDEN).items():
        print(f"{effect:18s}", end="")
        for factor in factors:
            verdict = car.asked({effect: told(least[effect], factor)}).verdict
            print(f"{', '.join(verdict):>20s}", end="", flush=True)
        print()


if __name__ == "__main__":
    main()
