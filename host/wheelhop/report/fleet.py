"""The overview of many campaigns: which verdicts there are, and every campaign in a line."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from wheelhop.files.words import percent
from wheelhop.report.page import facts, figure, paragraph, section, table, title, write_page

Rows = Sequence[Mapping[str, Any]]


def write_fleet_report(path: Path, rows: Rows) -> None:
    """Write the rows of a fleet as one self-contained HTML page."""
    judged = [row for row in rows if not row["problem"]]
    failed = [row for row in rows if row["problem"]]
    count = Counter(str(row["verdict"]) for row in judged)
    body = [
        paragraph("wheelhop diagnosis of a fleet", "kicker"),
        title(_headline(count, len(rows))),
        facts(_key_numbers(judged, failed), "key"),
        section("Verdicts", _verdicts(count, judged)),
        section("Campaigns", _campaigns(judged)),
        section("No verdict", _problems(failed)),
    ]
    write_page(path, f"{len(rows)} campaigns", body)


def _headline(count: Counter[str], total: int) -> str:
    if not count:
        return f"None of {total} campaigns has a verdict"
    (verdict, many), *_ = count.most_common(1)
    words = {"none": "nothing is missing", "unknown": "what is missing is unknown"}
    what = words.get(verdict, f"{verdict} is missing")
    return f"In {many} of {total} campaigns {what}"


def _key_numbers(judged: Rows, failed: Rows) -> list[tuple[str, str]]:
    warned = sum(bool(row["findings"]) for row in judged)
    hours = sum(row["seconds"] for row in (*judged, *failed)) / 3600
    return [
        ("campaigns", str(len(judged) + len(failed))),
        ("with a verdict", str(len(judged))),
        ("with warnings", str(warned)),
        ("processor time", f"{hours:.1f} h" if hours >= 1 else f"{60 * hours:.0f} min"),
    ]


def _verdicts(count: Counter[str], judged: Rows) -> str:
    rows = []
    for verdict, many in count.most_common():
        sure = [row["confidence"] for row in judged if row["verdict"] == verdict]
        mean = 100 * sum(sure) / len(sure)
        rows.append((escape(verdict), str(many), _bar(many / len(judged)), f"{mean:.0f} %"))
    caption = "How often each verdict was given, and its mean confidence."
    return figure(table(("verdict", "campaigns", "", "confidence"), rows, "lrlr"), caption)


def _bar(share: float) -> str:
    return (
        '<svg class="moved" viewBox="0 0 120 14" preserveAspectRatio="none" aria-hidden="true">'
        f'<rect width="{120 * share:.1f}" height="14" fill="var(--after)"/></svg>'
    )


def _campaigns(judged: Rows) -> str:
    """Those nearest to a change first: the least sure."""
    rows = [
        (
            _named(row),
            escape(str(row["verdict"])),
            f"{100 * row['confidence']:.0f} %",
            percent(row["error_baseline"]),
            percent(row["error"]),
            percent(row["floor"]),
        )
        for row in sorted(judged, key=lambda row: float(row["confidence"]))
    ]
    if not rows:
        return ""
    headings = ("campaign", "verdict", "confidence", "error before", "after", "noise floor")
    lines = table(headings, rows, "llrrrr")
    return figure(lines, "The least sure first. Errors are those on the runs that judge.")


def _named(row: Mapping[str, Any]) -> str:
    warning = f"<small>{escape(str(row['findings']))}</small>" if row["findings"] else ""
    where = f"<small>{escape(str(row['campaign']))}</small>"
    return f"{escape(str(row['title']))}{where}{warning}"


def _problems(failed: Rows) -> str:
    if not failed:
        return ""
    rows = [(escape(str(row["campaign"])), escape(str(row["problem"]))) for row in failed]
    return table(("campaign", "what is wrong"), rows, "ll")
