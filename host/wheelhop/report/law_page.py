"""The page on a law that was found: what it is, how it looks, how well each law does, and where."""

from __future__ import annotations

from html import escape
from math import isfinite
from pathlib import Path

from wheelhop.campaign import Campaign
from wheelhop.files.words import percent
from wheelhop.law import Found, LastRungs, look
from wheelhop.report.law import (
    RUNS_AWAY,
    amplitudes,
    beyond_names,
    by_error,
    law_figure,
    parts,
    shapes,
    simplest,
    suspects,
    verdict,
)
from wheelhop.report.page import (
    bullets,
    facts,
    figure,
    paragraph,
    section,
    table,
    title,
    write_page,
)
from wheelhop.report.svg import equation, inline

CAPTION = (
    "Force along the motion recorded: of the free law first, with two standard deviations as a"
    " band, then of the formula and of the named laws that come nearest. Grey ground: little was"
    " recorded there. Below, the free law as a surface and two standard deviations of it; the lines"
    " enclose half and nine tenths of the motion."
)


def write_law_report(path: Path, campaign: Campaign, found: Found) -> None:
    """Write the result of a search for a law as one self-contained HTML page."""
    *joined, said = verdict(found)
    body = [
        paragraph(f"wheelhop law · {campaign.title}", "kicker"),
        title(said),
        _key_numbers(found),
        *map(paragraph, [*joined, *suspects(found)]),
        _picture(found),
        _laws(found),
        _formula(found),
        _places(found),
    ]
    write_page(path, f"{campaign.title}: law", body)


def law_section(rungs: LastRungs) -> str:
    """The last rungs of a diagnosis: what laws without names leave, and where that is less than
    names do their picture and the formula."""
    found = rungs.found
    parts = [section("Beyond names", *map(paragraph, beyond_names(rungs)))]
    if rungs.names_do:
        return "".join(parts)
    return "".join((*parts, _picture(found), _laws(found), _formula(found)))


def _key_numbers(found: Found) -> str:
    without = found.base.error
    if found.preferred is None:
        return facts([("error E", percent(without))], "key")
    fall = f"{percent(without)} → {percent(found.preferred.rung.error)}"
    return facts([("simplest law", found.preferred.name), ("error E, runs held out", fall)], "key")


def _picture(found: Found) -> str:
    if found.free is None:
        return ""
    if found.moved is None:
        return section("How it looks", paragraph("Nothing recorded tells how that place moved."))
    drawing = inline(law_figure(found), "law", "the force that is missing")
    return section("How it looks", bullets(look(found)), figure(drawing, CAPTION))


def _laws(found: Found) -> str:
    if found.free is None:
        return ""
    rows = [
        ("without it", "", percent(found.base.error_fit), percent(found.base.error)),
        *(
            (
                f"<strong>{escape(r.name)}</strong>" if r is found.preferred else escape(r.name),
                escape(r.words),
                percent(r.rung.error_fit),
                percent(r.rung.error) if isfinite(r.rung.error) else RUNS_AWAY,
            )
            for r in by_error(found)
        ),
    ]
    grid = table(("law", "what it is", "fitted E", "held-out E"), rows, "llrr")
    return section("Every law that was fitted", paragraph(simplest(found)), grid)


def _formula(found: Found) -> str:
    if found.formula is None:
        return ""
    forces, gaps = amplitudes(found.formula), shapes(found.formula)
    rows = []
    for part in parts(found.formula):
        force, spread = forces[part.words]
        value, doubt, unit = gaps.get(f"gap or width of the {part.words}", (0.0, 0.0, ""))
        rows.append(
            (
                escape(part.words),
                equation(part.term.equation),
                f"{force:.4g} ± {spread:.2g} N",
                f"{1e3 * value:.4g} ± {1e3 * doubt:.2g} m{unit}" if unit else "",
            )
        )
    grid = table(("term", "force", "F", "gap or width"), rows, "llrr")
    note = (
        "A sum of terms. F is the force of each at the end of the motion recorded, ± standard"
        " deviation. Keep the formula with wheelhop law --save."
    )
    return section("The formula", paragraph(note), grid)


def _places(found: Found) -> str:
    shares = sorted(found.screened.items(), key=lambda item: -item[1])
    rows = [(escape(name), percent(max(share, 0.0), 2)) for name, share in shares]
    if len(rows) < 2:
        return ""
    note = "What a free law there explains of the residual's power, to first order."
    return section("Where", paragraph(note), table(("place", "share"), rows, "lr"))
