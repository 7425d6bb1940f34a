"""The table: targets, reliability, confusion and every failure, as text and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from math import isfinite, isnan
from typing import Any

from benchmarks.blind.score import Outcome
from benchmarks.blind.statistics import (
    Decile,
    Figure,
    Rate,
    confusion,
    figures,
    rates,
    reliability,
    wilson,
)

MET = {True: "pass", False: "FAIL", None: "-"}


def text(outcomes: Sequence[Outcome], *, title: str, short: bool, unreachable: int) -> str:
    """All of it, to read."""
    lines = [title, f"{len(outcomes)} answers", ""]
    if unreachable:
        lines.insert(2, f"{unreachable} cases could not be made: the effect does not show enough")
    lines += [_rate_line(r) for r in rates(outcomes)]
    lines += [_figure_line(f) for f in figures(outcomes, short)]
    lines += ["", "reliability: confidence that the first entry is right, and how often it was"]
    lines += [_decile_line(d) for d in reliability(outcomes)]
    lines += ["", "first entry of the verdict by what was hidden"]
    for truth, said in confusion(outcomes).items():
        answers = ", ".join(f"{name} {count}" for name, count in said.most_common())
        lines.append(f"  {truth:32s} {answers}")
    lines += ["", "failures"]
    lines += [_failure_line(o) for o in outcomes if not o.passed]
    return "\n".join(lines) + "\n"


def document(outcomes: Sequence[Outcome], *, title: str, short: bool) -> dict[str, Any]:
    """The same as plain dictionaries and lists."""
    return {
        "title": title,
        "rates": [
            asdict(r) | {"rate": _plain(r.rate), "interval": r.interval, "met": r.met}
            for r in rates(outcomes)
        ],
        "figures": [
            {"label": f.label, "value": _plain(f.value), "target": _plain(f.target), "met": f.met}
            for f in figures(outcomes, short)
        ],
        "reliability": [
            asdict(d) | {"interval": wilson(d.right, d.of), "met": d.met}
            for d in reliability(outcomes)
        ],
        "confusion": {truth: dict(said) for truth, said in confusion(outcomes).items()},
        "outcomes": [{k: _plain(v) for k, v in o.to_json().items()} for o in outcomes],
    }


def _rate_line(rate: Rate) -> str:
    low, high = rate.interval
    wanted = f"{'>=' if rate.at_least else '<='} {100 * rate.target:3.0f} %"
    met = MET[rate.met]
    if rate.target == 0.0 and rate.at_least:
        wanted, met = "", ""
    if not rate.of:
        return f"{rate.label:40s}    -                           {wanted}"
    return (
        f"{rate.label:40s} {100 * rate.rate:5.1f} %  {rate.right:3d}/{rate.of:<3d}"
        f" [{100 * low:3.0f}, {100 * high:3.0f}]   {wanted:8s} {met}"
    ).rstrip()


def _figure_line(figure: Figure) -> str:
    wanted, met = f"<= {figure.target:g}", MET[figure.met]
    if not isfinite(figure.target):
        wanted, met = "", ""
    value = "    -  " if isnan(figure.value) else f"{figure.value:7.{figure.digits}f}"
    return f"{figure.label:40s} {value}{'':18s}   {wanted:8s} {met}".rstrip()


def _decile_line(decile: Decile) -> str:
    low, high = wilson(decile.right, decile.of)
    said = "within 10 points" if decile.within else "too few to tell"
    return (
        f"  {decile.low:.1f}-{decile.high:.1f}  claimed {100 * decile.claimed:3.0f} %"
        f"  observed {100 * decile.right / decile.of:3.0f} %  {decile.right:3d}/{decile.of:<3d}"
        f" [{100 * low:3.0f}, {100 * high:3.0f}]   {said if decile.met else 'FAIL'}"
    )


def _failure_line(o: Outcome) -> str:
    if not o.verdict:
        return f"  {o.name}: no answer: {o.complaint.splitlines()[-1] if o.complaint else ''}"
    return (
        f"  {o.name}: baseline {o.baseline_over_floor:.2f} x floor; said {', '.join(o.verdict)}"
        f" ({o.confidence:.2f}), error {o.error_over_floor:.2f} x floor;"
        f" ranking {', '.join(o.ranking[:3])}"
    )


def _plain(value: Any) -> Any:
    return None if isinstance(value, float) and not isfinite(value) else value
