"""What a rig's data may hide from a diagnosis: python -m benchmarks.rig_data [NAME…] [--seeds N]

Each campaign comes from the independent rig (`tests/component/rig.py`), its numbers drawn anew by
each seed, and has one thing that real rigs have: a load cell that is not zeroed under an imposed
force; a rack without a spring, declared so and not; a display that shows steps; cycles that a servo
repeats, one recording each; a reversed load cell; noise of a tenth of the force that is slow, so
that what is quietest is far below it, with friction or a law of no library; that law alone. A line
says what was named, what is left of the runs held out by the names and by the laws that follow, and
what was said before the fit.
"""

from __future__ import annotations

import argparse
import re
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from tests.component import rig
from tests.component.cases import DAMPER, OSCILLATOR
from wheelhop.api import diagnose
from wheelhop.campaign import ComponentCampaign, RigRun, read_campaign

FRICTION = {"coulomb_N": 60.0, "joint_N_m": 4e5}
NAMES = (
    *("offset", "rack", "rack-unknown", "display", "cycles", "reversed"),
    *("coloured", "coloured-outside", "outside"),
)
BELIEVED = "mass_kg = {}\nstiffness_N_m = {}\ndamping_N_s_m = {}"
NO_SPRING = 1e-300


def campaign(name: str, folder: Path, rng: np.random.Generator, seed: int) -> ComponentCampaign:
    """A campaign with friction hidden in it, and the thing of that name in its data."""
    friction = {k: v * 1.4 ** rng.uniform(-1.0, 1.0) for k, v in FRICTION.items()}
    component = replace(DAMPER, hidden="dry-friction", numbers=friction)
    drive, nominal = "displacement", ""
    if name == "offset":
        drive = "force"
        component = replace(OSCILLATOR, stiffness_N_m=NO_SPRING, damping_N_s_m=200.0)
        component = replace(component, mass_kg=90.0, hidden="dry-friction", numbers=friction)
        nominal = BELIEVED.format(80.0, '"unknown"', 250.0)
    if name.endswith("outside"):
        component = replace(
            DAMPER, hidden="bypass-damper", numbers={"share": 1.0, "travel_m": 0.02}
        )
    if name.startswith("rack"):
        component = replace(component, stiffness_N_m=NO_SPRING, damping_N_s_m=250.0)
        spring = '"none"' if name == "rack" else "0.0"
        nominal = BELIEVED.format('"none"', spring, 200.0)
    rig.make_campaign(
        folder, drive, component, seed=seed, noise=0.01, nominal=nominal, only=only_of(name)
    )
    made = read_campaign(folder)
    assert isinstance(made, ComponentCampaign)
    runs = tuple(spoilt(name, run, rng) for run in made.runs if isinstance(run, RigRun))
    return replace(made, runs=runs, noise_rms=None)


def only_of(name: str) -> str:
    """Of which runs the campaign is: without a spring, free decays show nothing; of random motion
    nothing repeats."""
    return "random" if name in ("offset", *NAMES[-3:]) else ""


def spoilt(name: str, run: RigRun, rng: np.random.Generator) -> RigRun:
    """A run with what its data have."""
    force, x = run.force, run.displacement
    if name == "offset":
        force = force + 12.0
    elif name == "reversed":
        force = -force
    elif name == "display":
        force = 20.0 * np.round(force / 20.0)
    elif name == "cycles" and run.id.startswith("sine-1.7hz"):
        # The same cycles once more, with noise of their own.
        force = force + rng.normal(0.0, 1e-3 * np.std(force), len(force))
    elif name.startswith("coloured"):
        slow = lfilter([0.06], [1.0, -0.94], rng.normal(size=len(force)))
        force = force + 0.1 * np.std(force) / np.std(slow) * slow
    record = x if run.drive == "force" else force
    return replace(run, force=force, displacement=x, record=record[:, None])


def main() -> None:
    """A line for each and seed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help=f"of {', '.join(NAMES)}; all by default")
    parser.add_argument("--seeds", type=int, default=2)
    chosen = parser.parse_args()
    for name in chosen.names or NAMES:
        for seed in range(chosen.seeds):
            rng = np.random.default_rng([seed, *name.encode()])
            with tempfile.TemporaryDirectory() as temporary:
                made = campaign(name, Path(temporary) / "c", rng, seed)
                begin = time.process_time()
                found = diagnose(made, jobs=1)
                took = time.process_time() - begin
            steps = [] if found.law is None else found.law.steps
            laws = " ".join(f"{s.added[0]} {100 * s.rung.error:.2f} %" for s in steps)
            said = ", ".join(f.kind for f in found.findings if f.when == "before")
            basis = re.sub("^estimated from ", "", found.comparison.floor.origin)
            print(
                f"{name:13} {seed} {'+'.join(found.verdict):30} {found.confidence:4.2f}"
                f" {100 * found.error:6.2f} % floor {100 * found.floor:5.2f} % ({basis})"
                f" | {laws} | {said} | {took:5.1f} s",
                flush=True,
            )


if __name__ == "__main__":
    main()
