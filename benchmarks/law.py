"""Free laws, formulas and named laws beside plain least squares: python -m benchmarks.law CAMPAIGN…

For component campaigns whose displacement is imposed. Plain least squares fits the runs of role
"fit" with the recorded motion, and no band: k x + c v, with one and two Jenkins elements (their
ways on a grid, the best on the fitted runs), and with tanh(v / w) likewise. Errors are of
the runs held out, in band for the laws of wheelhop.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from wheelhop.campaign import ComponentCampaign, RigRun, read_campaign
from wheelhop.effects import load_effects
from wheelhop.law import find_law
from wheelhop.vehicle import Motion, read_nominal

Term = Callable[[np.ndarray, np.ndarray], np.ndarray]


def slider(way: float) -> Term:
    """Stretch of a spring that slips after a way, over that way."""

    def along(x: np.ndarray, v: np.ndarray) -> np.ndarray:
        out, stretch = np.zeros(len(x)), 0.0
        for t, dx in enumerate(np.diff(x, prepend=x[0])):
            stretch = min(max(stretch + dx, -way), way)
            out[t] = stretch / way
        return out

    return along


def both(a: Term, b: Term) -> Term:
    """Two terms, each with a number of its own."""
    return lambda x, v: np.column_stack([a(x, v), b(x, v)])


def plain(campaign: ComponentCampaign, term: Term | None) -> tuple[float, float]:
    """Errors of least squares on the runs fitted and held out."""

    def stacked(role: str) -> tuple[np.ndarray, np.ndarray]:
        rows, force = [], []
        for run in of_rig(campaign):
            if run.role == role:
                x, v, _ = Motion(campaign, run).at(run.time_s)
                own = term(x, v) if term else np.zeros((len(x), 0))
                rows.append(np.column_stack([np.ones_like(x), x, v, own]))
                force.append(run.force)
        return np.concatenate(rows), np.concatenate(force)

    matrix, force = stacked("fit")
    numbers = np.linalg.lstsq(matrix, force, rcond=None)[0]
    held, truth = stacked("validate")
    fitted, judged = (
        float(np.linalg.norm(y - a @ numbers) / np.linalg.norm(y))
        for a, y in ((matrix, force), (held, truth))
    )
    return fitted, judged


def of_rig(campaign: ComponentCampaign) -> list[RigRun]:
    """The runs of a component."""
    return [run for run in campaign.runs if isinstance(run, RigRun)]


def main() -> None:
    """Print the table of every campaign named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("campaigns", nargs="+", type=Path)
    for folder in parser.parse_args().campaigns:
        campaign = read_campaign(folder)
        if not isinstance(campaign, ComponentCampaign) or campaign.drive != "displacement":
            parser.error(f"{folder}: not a component with imposed displacement")
        print(f"{folder.name}: held-out error")
        travel = max(float(np.abs(run.displacement).max()) for run in of_rig(campaign))
        ways = [slider(w * travel) for w in np.geomspace(0.005, 0.8, 8)]
        pairs = [both(a, b) for i, a in enumerate(ways) for b in ways[:i]]
        widths = [lambda x, v, w=w: np.tanh(v / w) for w in np.geomspace(0.002, 0.5, 12)]
        for name, terms in (
            ("least squares: linear", [None]),
            ("least squares: Jenkins", ways),
            ("least squares: two Jenkins", pairs),
            ("least squares: tanh", widths),
        ):
            best = min(plain(campaign, term) for term in terms)
            print(f"  {name:26} {100 * best[1]:6.2f} %")
        begin = time.process_time()
        library = list(load_effects().values())
        found = find_law(campaign, read_nominal(campaign), [], library, lambda text: None)
        took = time.process_time() - begin
        for rival in (found.free, found.formula, *found.named):
            if rival is not None:
                print(f"  {rival.name:26} {100 * rival.rung.error:6.2f} %   {rival.words}")
        print(f"  {took:.1f} s of processor time")


if __name__ == "__main__":
    main()
