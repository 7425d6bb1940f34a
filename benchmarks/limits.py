"""Detection limits, put to the test: python -m benchmarks.limits [--seed N]

A clean campaign of 8 runs says from what strength on it would have shown each effect. The same
drives with an effect hidden at 0.4, 0.7, 1, 1.5 and 2.5 times that (tests/truth, MuJoCo) have to
be called "none" well below and named well above.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

from tests import truth
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import Diagnosis, diagnose
from wheelhop.effects import load_effects
from wheelhop.vehicle import read_vehicle

FACTORS = (0.4, 0.7, 1.0, 1.5, 2.5)

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


def asked(hidden: Mapping[str, Mapping[str, float]], seed: int) -> Diagnosis:
    """The diagnosis of a campaign that hides this."""
    with tempfile.TemporaryDirectory() as folder:
        made = truth.make_campaign(Path(folder), seed=seed, effects=hidden, short=True)
        campaign = read_campaign(made)
        return diagnose(campaign, read_vehicle(campaign.vehicle_file), load_effects())


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=101)
    seed = parser.parse_args().seed
    least = {limit.effect: limit.amplitudes for limit in asked({}, seed).limits}
    print(f"{'times the limit':16s}" + "".join(f"{factor:>16g}" for factor in FACTORS))
    for effect, told in HIDDEN.items():
        print(f"{effect:16s}", end="")
        for factor in FACTORS:
            verdict = asked({effect: told(least[effect], factor)}, seed).verdict
            print(f"{', '.join(verdict):>16s}", end="", flush=True)
        print()


if __name__ == "__main__":
    main()
