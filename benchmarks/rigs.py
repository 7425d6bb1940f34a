"""Which law a diagnosis names on a rig: python -m benchmarks.rigs [NAME…] [--seeds N]

Every law of `tests/component/cases.py`, its component's and its own numbers drawn anew by each
seed within 1.4 times either way, moved by imposed displacements in the independent rig; a clean
component; and one law of no library. Laws that vehicles have, too, are also shown to a library
without the effects that only rigs have: what the larger library costs them.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.component import rig
from tests.component.cases import CASES, DAMPER, RIG_ONLY
from wheelhop.api import DiagnosisResult, diagnose
from wheelhop.campaign import read_campaign
from wheelhop.effects import Effect, load_effects

SPREAD = 1.4
LIBRARY = load_effects()
OF_VEHICLES = {name: effect for name, effect in LIBRARY.items() if effect.on_vehicle}
EXPECTED = {
    **{name: case.effect for name, case in {**CASES, **RIG_ONLY}.items()},
    "strong-friction": "dry-friction",
    "slow-creep": "dry-friction",
    "seal": "dry-friction",
    "clean": "none",
    "bypass-damper": "unknown",
}


def component(name: str, rng: np.random.Generator) -> rig.Component:
    """What is on the rig."""

    def drawn(value: float) -> float:
        return float(value * SPREAD ** rng.uniform(-1.0, 1.0))

    base = replace(
        DAMPER,
        stiffness_N_m=drawn(DAMPER.stiffness_N_m),
        damping_N_s_m=drawn(DAMPER.damping_N_s_m),
    )
    if name == "clean":
        return base
    if name == "strong-friction":
        numbers = {"coulomb_N": drawn(250.0), "joint_N_m": drawn(4e5)}
        return replace(base, hidden="dry-friction", numbers=numbers)
    if name == "slow-creep":
        numbers = {"coulomb_N": drawn(60.0), "sticking": 1.0, "stribeck_m_s": 1.0}
        numbers["creep_m_s"] = drawn(2e-4)
        return replace(base, hidden="stribeck", numbers=numbers)
    if name == "seal":
        return replace(base, hidden=name, numbers={"drag_N": drawn(60.0), "lip_m": drawn(1e-3)})
    if name == "bypass-damper":
        numbers = {"share": drawn(1.0), "travel_m": 0.02}
        return replace(base, hidden=name, numbers=numbers)
    case = {**CASES, **RIG_ONLY}[name]
    # What has no unit is a shape, and stays.
    numbers = {
        k: drawn(v) if k.endswith(("_N", "_m", "_s", "_m2", "_m3")) else v
        for k, v in case.numbers["displacement"].items()
    }
    return replace(base, hidden=case.hidden, numbers=numbers)


def diagnosed(folder: Path, library: Mapping[str, Effect]) -> tuple[DiagnosisResult, float]:
    """The diagnosis, laws without names included, and its processor seconds."""
    campaign = read_campaign(folder)
    begin = time.process_time()
    found = diagnose(campaign, effects=library, jobs=1, progress=False)
    return found, time.process_time() - begin


def main() -> None:
    """A line for each law and seed, and how many were right."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="of the laws; all by default")
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--noise", type=float, default=0.01, help="over the force, r.m.s.")
    chosen = parser.parse_args()
    right = dict.fromkeys(("all", "vehicles'"), 0)
    asked, seconds = dict(right), dict.fromkeys(right, 0.0)
    for name, expected in EXPECTED.items():
        if chosen.names and name not in chosen.names:
            continue
        for seed in range(chosen.seeds):
            rng = np.random.default_rng([seed, *name.encode()])
            with tempfile.TemporaryDirectory() as temporary:
                folder = rig.make_campaign(
                    Path(temporary) / "c",
                    "displacement",
                    component(name, rng),
                    seed=seed,
                    noise=chosen.noise,
                )
                line = f"{name:20} {seed:2}"
                for which, library in (("all", LIBRARY), ("vehicles'", OF_VEHICLES)):
                    if which != "all" and expected not in {*OF_VEHICLES, "none"}:
                        continue
                    found, took = diagnosed(folder, library)
                    verdict = "+".join(found.verdict)
                    right[which] += verdict == expected
                    asked[which] += 1
                    seconds[which] += took
                    last = found.steps[-1].over_floor
                    line += f" | {verdict:28} {found.confidence:4.2f} {last:6.2f} {took:5.1f} s"
                print(line, flush=True)
    for which in right:
        print(f"library of {which}: {right[which]} of {asked[which]}, {seconds[which]:.0f} s")


if __name__ == "__main__":
    main()
