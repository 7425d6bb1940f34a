"""Is it said rightly whether what is missing is linear?

    python -m benchmarks.linear_or_not [SEED [FOLDER]]

Campaigns of 18 runs from the independent simulator (tests/truth), each with one effect between axle
and body. "cannot tell" is allowed, a wrong answer is not. MuJoCo takes about a minute for each;
those that are in FOLDER already are taken from there.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from tests.truth import make_campaign
from wheelhop.campaign import read_campaign
from wheelhop.identify import linearity
from wheelhop.vehicle import read_vehicle

ENGINE = {"force_N": 60.0, "freq_hz": 22.0, "run_spread_hz": 1.0, "wander_hz": 0.5, "x_m": -0.5}
CASES: Sequence[tuple[str, str, Mapping[str, float]]] = (
    ("linear", "mount-bushing", {"stiffness_N_m": 1e5, "damping_N_s_m": 200.0}),
    ("linear", "mount-bushing", {"stiffness_N_m": 6e5, "damping_N_s_m": 400.0}),
    ("linear", "frame-twist", {"freq_hz": 12.0, "zeta": 0.05}),
    ("linear", "frame-twist", {"freq_hz": 22.0, "zeta": 0.05}),
    ("linear", "driver-seat", {"mass_kg": 68.0, "freq_hz": 3.2, "zeta": 0.28, "x_m": -0.1}),
    ("linear", "driver-seat", {"mass_kg": 30.0, "freq_hz": 5.0, "zeta": 0.3, "x_m": -0.1}),
    ("not linear", "dry-friction", {"coulomb_front_N": 75.0, "coulomb_rear_N": 55.0}),
    ("not linear", "dry-friction", {"coulomb_front_N": 12.0, "coulomb_rear_N": 9.0}),
    ("not linear", "digressive-damper", {"knee_m_s": 0.15, "slope_ratio": 0.4}),
    ("not linear", "digressive-damper", {"knee_m_s": 0.4, "slope_ratio": 0.8}),
    ("not linear", "bump-stop", {"clearance_m": 0.02, "stiffness_N_m": 3e4}),
    ("not linear", "bump-stop", {"clearance_m": 0.03, "stiffness_N_m": 1.5e4}),
    # Other laws by the same names (tests/truth/other_laws.py): creep, bristles, a measured damper,
    # foam; and an engine whose speed wanders, of which nothing may be called not linear.
    ("not linear", "dry-friction", {"tanh_front_N": 40.0, "tanh_rear_N": 30.0, "creep_m_s": 0.01}),
    ("not linear", "dry-friction", {"sliding_front_N": 40.0, "sliding_rear_N": 30.0}),
    ("not linear", "digressive-damper", {"knee_m_s": 0.2, "slope_ratio": 0.5, "lead": 0.15}),
    ("not linear", "bump-stop", {"clearance_m": 0.02, "stiffness_N_m": 4e4, "onset_m": 0.01}),
    ("linear", "engine-vibration", ENGINE),
)


def main(arguments: Sequence[str]) -> None:
    """Print one line a campaign, then the counts."""
    first = int(arguments[0]) if arguments else 501
    wrong = silent = 0
    for number, (truth, effect, numbers) in enumerate(CASES):
        with tempfile.TemporaryDirectory() as scratch:
            made = Path(arguments[1] if len(arguments) > 1 else scratch) / f"{first + number}"
            if not made.exists():
                make_campaign(made, seed=first + number, effects={effect: numbers})
            campaign = read_campaign(made)
            found = linearity(campaign, read_vehicle(campaign.vehicle_file))
        silent += found.answer == "cannot tell"
        wrong += found.answer not in (truth, "cannot tell")
        print(
            f"{effect:18s} {truth:11s} -> {found.answer:11s} {found.over_floor:6.2f} x noise,"
            f" peaks {found.peakedness:6.2f}, a law explains {found.share:.0%}",
            flush=True,
        )
    print(f"{len(CASES)} campaigns: {wrong} wrong, {silent} without an answer")


if __name__ == "__main__":
    main(sys.argv[1:])
