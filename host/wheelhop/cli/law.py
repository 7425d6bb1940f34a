"""`wheelhop law`: the force a model is missing, as a curve and as a formula."""

from __future__ import annotations

from argparse import Namespace
from typing import Any

from rich.console import Console

from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.cli.console import open_console
from wheelhop.cli.exchange import pick, write_json
from wheelhop.cli.progress import stages
from wheelhop.effects import load_effects
from wheelhop.files import write_text
from wheelhop.law import Formula, Found, Rival, find_law, source_of
from wheelhop.report.law_figure import write_law_figure
from wheelhop.vehicle import read_nominal

SAVED_ID = "found-law"


def run(arguments: Namespace) -> int:
    """Find, print, write JSON, figure and effect file; raises CampaignError."""
    library = load_effects(arguments.effects)
    accepted = pick(arguments.accepted, library)
    if arguments.save and arguments.save.suffix != ".py":
        raise CampaignError(f"{arguments.save}: an effect is a Python file; end its name in .py")
    campaign = read_campaign(arguments.campaign)
    vehicle = read_nominal(campaign)
    with stages() as progress:
        found = find_law(campaign, vehicle, accepted, list(library.values()), progress)
    console = open_console()
    print_law(found, console)
    if arguments.json:
        write_json(arguments.json, to_json(found))
    if found.free is not None and arguments.figure:
        if found.moved is None:
            console.print("no figure: nothing recorded tells how that place moved", markup=False)
        else:
            write_law_figure(found, arguments.figure)
            console.print(f"figure: {arguments.figure}", markup=False)
    if found.formula is not None and arguments.save:
        model = found.formula.rung.model
        formula = next(e for e in model.effects if isinstance(e, Formula))
        text = source_of(formula, model.theta(formula), campaign.title, SAVED_ID)
        write_text(arguments.save, text)
        console.print(f"formula kept in {arguments.save}", markup=False)
    elif arguments.save:
        console.print(f"{arguments.save} not written: there is no formula", markup=False)
    return 0


def print_law(found: Found, console: Console) -> None:
    """Where, what, and how well, laws with the lowest held-out error first."""
    free, where = found.free, found.where
    if free is None or where is None:
        console.print("Nothing to find: no force at any place explains what these runs leave.")
        return
    lines = [f"A force is missing at the {where.name}."]
    lines.append(f"{'law':22} {'fitted':>8} {'held out':>9}")
    lines.append(_line("without it", found.base.error_fit, found.base.error))
    for rival in sorted(_rivals(found), key=lambda r: r.rung.error):
        lines.append(_line(rival.name, rival.rung.error_fit, rival.rung.error))
    lines.append(f"free: {free.words}")
    if found.formula is not None:
        lines.append("formula, force at the end of the motion recorded ± standard deviation:")
        for name, (value, spread) in amplitudes(found.formula).items():
            lines.append(f"  {name:44} {value:10.4g} ± {spread:.2g} N")
    preferred = found.preferred
    assert preferred is not None
    lines.append(f"The simplest law that does as well as any: {preferred.name}.")
    for line in lines:
        console.print(line, markup=False, highlight=False)


def amplitudes(rival: Rival) -> dict[str, tuple[float, float]]:
    """The fitted forces of a formula with their standard deviations, N, grown by what is left."""
    fit = rival.rung.fit
    formula = next(e for e in fit.model.effects if isinstance(e, Formula))
    grown = max(fit.rss / (fit.size * fit.sigma**2), 1.0) ** 0.5
    return {
        term.words: (fit.model.values[key], fit.uncertainty(key) * grown)
        for term in formula.terms
        for key in (f"{formula.id}.{term.name}_N",)
    }


def to_json(found: Found) -> dict[str, Any]:
    """Plain dictionaries, strings and numbers, as `law` in the result of a diagnosis."""
    free, preferred = found.free, found.preferred
    return {
        "format": 1,
        "found": free is not None,
        "place": None if found.where is None else found.where.name,
        "preferred": None if preferred is None else preferred.name,
        "share_by_place": {k: round(v, 5) for k, v in found.screened.items()},
        "without": {"error_fit": found.base.error_fit, "error": found.base.error},
        "candidates": [
            {
                "name": rival.name,
                "formula": rival.words,
                "error_fit": rival.rung.error_fit,
                "error": rival.rung.error,
            }
            for rival in _rivals(found)
        ],
        "terms": {}
        if found.formula is None
        else {
            words: {"force_N": value, "sd_N": spread}
            for words, (value, spread) in amplitudes(found.formula).items()
        },
    }


def _rivals(found: Found) -> list[Rival]:
    return [r for r in (found.free, found.formula, *found.named) if r is not None]


def _line(name: str, fitted: float, held_out: float) -> str:
    return f"{name:22} {100 * fitted:7.2f}% {100 * held_out:8.2f}%"
