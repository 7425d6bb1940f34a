"""A law that was found: its picture, force over extension and over rate, with what is not known in
grey, and its words."""

from __future__ import annotations

from dataclasses import asdict
from math import isfinite
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from wheelhop.compare import NEIGHBOURS
from wheelhop.diagnose.score import at_noise
from wheelhop.files import write_picture
from wheelhop.files.words import percent
from wheelhop.law import Formula, Found, LastRungs, Rival, look
from wheelhop.law.formula import Part
from wheelhop.law.shape import forces, spread
from wheelhop.report.figures import AFTER, INK, SOFT, WIDTH
from wheelhop.report.law_surface import draw_surface
from wheelhop.report.svg import STYLE
from wheelhop.vehicle import is_component

Array = NDArray[np.float64]
SHOWN = 4000  # points of the motion, at most

RUNS_AWAY = "runs away"
"""What is said of a law of which a vehicle runs away in runs held out."""

ELSEWHERE = {
    "rig": "It may follow time or temperature (record it as an input), or the sensors.",
    "vehicle": "It may follow time or temperature, as a damper that fades, act where no sensor is,"
    " as under a seat or an engine, or lie in the road, the speed or the sensors.",
}
"""What is left to suspect where no place has the missing force."""


def law_figure(found: Found) -> Figure:
    """Force–extension and force–rate of the free law with two standard deviations, grey
    where little was recorded; below it each other law with the error it leaves of held-out runs,
    and last the free law as a surface."""
    assert found.free is not None and found.moved is not None
    rivals = [r for r in (found.formula, *found.named) if r is not None][:3]
    with mpl.rc_context(STYLE):
        rows = 1 + len(rivals)
        figure = Figure(figsize=(WIDTH, 1.9 * rows + 3.0), layout="constrained")
        ratios = (1.9 * rows + 0.6, 2.4)
        halves = figure.subfigures(2, 1, height_ratios=ratios)
        assert isinstance(halves, np.ndarray)
        along, over = halves
        panels = along.subplots(rows, 2, sharex="col", sharey=True, squeeze=False)
        for row, rival in zip(panels, [found.free, *rivals], strict=True):
            _draw(row, found, rival)
        panels[-1, 0].set_xlabel("extension, mm")
        panels[-1, 1].set_xlabel("rate, m/s")
        draw_surface(tuple(over.subplots(1, 2)), found, found.free)
    return figure


def write_law_figure(found: Found, file: Path) -> None:
    """Write it, in the form its name says."""
    write_picture(file, law_figure(found))


def _draw(row: NDArray[np.object_], found: Found, rival: Rival) -> None:
    moved = found.moved
    assert moved is not None and found.free is not None
    free = rival is found.free
    force = forces(found, rival)
    step = max(len(force) // SHOWN, 1)
    panels: tuple[Axes, Axes] = row[0], row[1]
    for panel, along in zip(panels, (1e3 * moved.extension, moved.rate), strict=True):
        panel.plot(along[::step], force[::step], ".", ms=1.2, color=AFTER if free else INK,
                   alpha=0.35, rasterized=True)  # fmt: skip
        if free:
            doubt = 2 * spread(found, rival)
            order = np.argsort(along)[::step]
            panel.fill_between(along[order], (force - doubt)[order], (force + doubt)[order],
                               color=SOFT, alpha=0.15, linewidth=0)  # fmt: skip
        low, high = np.quantile(along, (0.005, 0.995))
        for a, b in ((-1e9, low), (high, 1e9)):
            panel.axvspan(a, b, color="0.5", alpha=0.12, linewidth=0)
        margin = 0.05 * float(np.ptp(along))
        panel.set_xlim(along.min() - margin, along.max() + margin)
        panel.axhline(0.0, color=SOFT, linewidth=0.6)
    panels[0].set_ylabel("force, N")
    error = rival.rung.error
    held_out = f"error {100 * error:.1f} %" if isfinite(error) else f"it {RUNS_AWAY}"
    panels[0].set_title(f"{rival.name}: held out, {held_out}", loc="left")


def verdict(found: Found) -> list[str]:
    """Whether a force is missing and where, the last sentence; what joined the model before."""
    sentences = [
        f"No force alone is missing but a part: {name} explains more than a law at any place, and"
        f" belongs to the model from here on (--with {name})."
        for name in found.joined
    ]
    if found.where is not None:
        return [*sentences, f"A force is missing at {found.where.in_words}."]
    if at_noise(found.base, found.workshop.noise):
        then = "Nothing more to find" if sentences else "Nothing to find"
        return [*sentences, f"{then}: the model explains these runs down to the noise."]
    missing = "Nothing found: more than noise is left, but no force at any place explains it."
    return [*sentences, missing]


def suspects(found: Found) -> list[str]:
    """What is left to suspect where more than noise is left and no place has the missing force."""
    if found.where is not None or at_noise(found.base, found.workshop.noise):
        return []
    return [ELSEWHERE["rig" if is_component(found.base.model.values) else "vehicle"]]


def law_lines(found: Found) -> list[str]:
    """Where a force is missing, what it is, and how well each law does, the lowest held-out error
    first; a table in a fixed pitch."""
    free, lines = found.free, [*verdict(found), *suspects(found)]
    if free is None:
        return lines
    lines.append(f"{'law':22} {'fitted':>8} {'held out':>9}")
    lines.append(_line("without it", found.base.error_fit, found.base.error))
    for rival in by_error(found):
        lines.append(_line(rival.name, rival.rung.error_fit, rival.rung.error))
    lines.append(f"free: {free.words}")
    if found.formula is not None:
        lines.append("formula, force at the end of the motion recorded ± standard deviation:")
        for name, (value, deviation) in amplitudes(found.formula).items():
            lines.append(f"  {name:44} {value:10.4g} ± {deviation:.2g} N")
        for name, (value, deviation, unit) in shapes(found.formula).items():
            lines.append(f"  {name}: {1e3 * value:.4g} ± {1e3 * deviation:.2g} m{unit}")
    return [*lines, simplest(found), *look(found)]


def simplest(found: Found) -> str:
    """Which law to take, in a sentence."""
    preferred = found.preferred
    assert preferred is not None
    return f"The simplest law that does as well as any: {preferred.name}."


def beyond_names(rungs: LastRungs) -> list[str]:
    """What follows where the names of a ladder end, in sentences: what laws without a name leave of
    all the baseline lacks, and which names come nearest and why they do not do."""
    found, nearest = rungs.found, rungs.nearest
    if found.free is None:
        return ["No law without a name explains it either.", *suspects(found)]
    laws = sorted((r for r in (found.formula, found.free) if r), key=lambda r: r.rung.error)
    each = " and ".join(
        f"a {'free law' if r is found.free else r.name} leaves {_left(r.rung.error)}" for r in laws
    )
    lines = [f"In place of names {each} of the runs held out."]
    if found.formula is not None:
        forces = amplitudes(found.formula).items()
        terms = "; ".join(f"{name}, {value:.4g} ± {2 * sd:.2g} N" for name, (value, sd) in forces)
        lines.append(f"The formula, forces at the end of the motion recorded (2 sd): {terms}.")
    if nearest is None:
        return [*lines, "No name of the library comes near it."]
    best = min(laws[0].rung.error, nearest.error)
    share = (found.base.error**2 - nearest.error**2) / max(found.base.error**2 - best**2, 1e-12)
    said = f"{nearest.name} comes nearest of all names: it leaves {percent(nearest.error)},"
    if rungs.names_do:
        lines.append(f"{said} as little. What is left is no force of extension, rate or history.")
        if rungs.steps[-1].comparison.floor.basis == NEIGHBOURS:
            lines.append("Impose one motion twice: what of it does not repeat is noise.")
    else:
        told = percent(min(max(share, 0.0), 1.0), 2)
        lines.append(f"{said} {told} of what that law explains, and the rest has no name here.")
    return [*lines, *([f"It was not accepted: {nearest.why}."] if nearest.why else [])]


def _left(error: float) -> str:
    return percent(error) if isfinite(error) else "nothing it can foresee"


def rivals(found: Found) -> list[Rival]:
    """Every law that was fitted."""
    return [r for r in (found.free, found.formula, *found.named) if r is not None]


def by_error(found: Found) -> list[Rival]:
    """Every law that was fitted, the lowest held-out error first."""
    return sorted(rivals(found), key=lambda rival: rival.rung.error)


def amplitudes(rival: Rival) -> dict[str, tuple[float, float]]:
    """The fitted forces of a formula with their standard deviations, N."""
    fit = rival.rung.fit
    values = fit.model.values
    return {part.words: (values[part.force], fit.uncertainty(part.force)) for part in parts(rival)}


def shapes(rival: Rival) -> dict[str, tuple[float, float, str]]:
    """The fitted gaps and widths of a formula with their standard deviations, and their unit."""
    fit = rival.rung.fit
    return {
        f"gap or width of the {part.words}": (
            fit.model.values[part.shape],
            fit.uncertainty(part.shape),
            "m/s" if part.shape.endswith("_m_s") else "m",
        )
        for part in parts(rival)
        if part.shape
    }


def parts(rival: Rival) -> list[Part]:
    """The terms of a formula as they were fitted."""
    model = rival.rung.fit.model
    formula = next(e for e in model.effects if isinstance(e, Formula))
    return formula.parts(model.values)


def _line(name: str, fitted: float, held_out: float) -> str:
    foreseen = f"{100 * held_out:8.2f}%" if isfinite(held_out) else f"{RUNS_AWAY:>9}"
    return f"{name:22} {100 * fitted:7.2f}% {foreseen}"


def rungs_to_json(rungs: LastRungs | None) -> dict[str, Any] | None:
    """`law` in the result of a diagnosis: the same, and the names that come nearest."""
    if rungs is None:
        return None
    nearest = rungs.nearest and asdict(rungs.nearest)
    return {**law_to_json(rungs.found), "nearest": nearest, "words": beyond_names(rungs)}


def law_to_json(found: Found) -> dict[str, Any]:
    """Plain dictionaries, strings and numbers, as `wheelhop law --json` writes them."""
    free, preferred = found.free, found.preferred
    return {
        "format": 1,
        "found": free is not None,
        "joined": list(found.joined),
        "place": None if found.where is None else found.where.name,
        "preferred": None if preferred is None else preferred.name,
        "look": look(found),
        "share_by_place": {k: round(v, 5) for k, v in found.screened.items()},
        "without": {"error_fit": found.base.error_fit, "error": found.base.error},
        "candidates": [
            {
                "name": rival.name,
                "formula": rival.words,
                "error_fit": rival.rung.error_fit,
                # Of runs held out a law may foresee that the vehicle runs away.
                "error": rival.rung.error if isfinite(rival.rung.error) else None,
            }
            for rival in rivals(found)
        ],
        "terms": {}
        if found.formula is None
        else {
            words: {"force_N": value, "sd_N": spread}
            for words, (value, spread) in amplitudes(found.formula).items()
        },
        "shapes": {}
        if found.formula is None
        else {
            words: {"value": value, "sd": spread, "unit": unit}
            for words, (value, spread, unit) in shapes(found.formula).items()
        },
    }
