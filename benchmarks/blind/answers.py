"""Every answer of a table, a line each: what was asked once can be counted again, elsewhere."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from math import isnan, nan
from pathlib import Path

from benchmarks.blind.plan import Case
from benchmarks.blind.score import Outcome

NUMBERS = ("confidence", "baseline_over_floor", "error_over_floor", "seconds")
LISTS = ("verdict", "ranking")
LATER = ("mass_off", "cpu_seconds", "held", "intervals")
"""Numbers that older tables do not say, and some answers have not."""
COLUMNS = ("name", "asked", *LISTS, *NUMBERS, "complaint", *LATER)
RANKED = 3
"""So many effects of a ranking are kept; no figure of the table needs more."""


def write_answers(file: Path, outcomes: Sequence[Outcome], unmade: Iterable[str]) -> None:
    """Answers, and the names of campaigns that could not be made, as a table of text."""
    with file.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, COLUMNS, restval="", lineterminator="\n")
        writer.writeheader()
        for o in outcomes:
            row = {name: f"{getattr(o, name):.6g}" for name in NUMBERS}
            later = {name: getattr(o, name) for name in LATER}
            row |= {k: "" if isnan(value) else f"{value:.6g}" for k, value in later.items()}
            row |= {"verdict": "+".join(o.verdict), "ranking": "+".join(o.ranking[:RANKED])}
            writer.writerow({"name": o.name, "asked": "yes", **row, "complaint": o.complaint})
        writer.writerows({"name": name, "asked": "no"} for name in unmade)


def read_answers(file: Path, cases: Sequence[Case]) -> tuple[dict[str, Outcome], set[str]]:
    """Those of the cases' answers that a file of `write_answers` holds, by name, and the names of
    the campaigns among them that could not be made."""
    with file.open(newline="") as stream:
        rows = {row["name"]: row for row in csv.DictReader(stream)}
    known = [case for case in cases if case.name in rows]
    asked = [case for case in known if rows[case.name]["asked"] == "yes"]
    outcomes = {case.name: _outcome(case, rows[case.name]) for case in asked}
    return outcomes, {case.name for case in known if case.name not in outcomes}


def _outcome(case: Case, row: dict[str, str]) -> Outcome:
    verdict, ranking = (tuple(filter(None, row[name].split("+"))) for name in LISTS)
    confidence, baseline, error, seconds = (float(row[name]) for name in NUMBERS)
    return Outcome(
        name=case.name,
        kind=case.kind,
        hidden=case.hidden,
        preset=case.preset,
        verdict=verdict,
        confidence=confidence,
        ranking=ranking,
        baseline_over_floor=baseline,
        error_over_floor=error,
        seconds=seconds,
        complaint=row["complaint"],
        **{name: float(row.get(name) or nan) for name in LATER},
    )
