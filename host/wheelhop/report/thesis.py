"""The thesis recomputed, as pictures in a folder and one page: ours beside the printed numbers."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from html import escape
from math import isnan
from pathlib import Path

from wheelhop.files import made_folder, write_picture
from wheelhop.files.words import significant
from wheelhop.identify.row import KINDS, Row
from wheelhop.report.page import bullets, figure, section, table, title, write_page
from wheelhop.report.thesis_figures import FIGURES, on_frame
from wheelhop.report.transfer_figures import draw_thesis

PAGE = "thesis.html"
TABLES_OF = {"2.21": "fig 2.21", "2.7": "2.1", "2.14": "2.8", "2.15": "fig 2.15", "2.20": "2.4"}
"""Rows that belong to a figure, by their table."""
STUDIES = {
    "2.15": "Figure 2.15. The generalized quarter car with other front springs.",
    "2.16": "Figure 2.16. The same with other front dampers.",
    "2.17": "Figure 2.17. The same with other rear dampers: they hardly reach the front.",
    "2.20": "Figure 2.20. The same with other front wheels.",
    "5.24": "Figure 5.24. Old suspensions, and those stiffened by 20 %.",
}
"""Captions of the parameter studies."""


def write_thesis(folder: Path, rows: Sequence[Row], frame: Path | None = None) -> list[Path]:
    """Draw every figure into a folder, which is made if need be, and write the page; the files.
    Figure 6.1 is drawn with the `frame` of a file, if there is one. Raises InputError."""
    figures = {**FIGURES, **(on_frame(frame) if frame else {})}
    captions = {**STUDIES, **{number: caption for number, (_, caption) in figures.items()}}
    with made_folder(folder):
        drawn = draw_thesis(folder)
        for number, (draw, _) in figures.items():
            drawn.append(folder / f"figure-{number}.png")
            write_picture(drawn[-1], draw(), dpi=130)
        write_page(folder / PAGE, "The thesis recomputed", _body(drawn, rows, captions))
    return [*drawn, folder / PAGE]


def _body(drawn: Sequence[Path], rows: Sequence[Row], captions: Mapping[str, str]) -> list[str]:
    tables = list(dict.fromkeys(row.table for row in rows))
    agree = sum(not row.reason for row in rows)
    head = [
        f"{agree} of {len(rows)} printed numbers agree with ours to 1 %; each of the others has its"
        " reason beside it.",
        *(f"{kind}: {what}." for kind, what in KINDS.items()),
    ]
    parts = [title("The thesis recomputed"), bullets(head)]
    for path in sorted(drawn, key=_order):
        number = _number(path)
        own = [row for row in rows if row.table == TABLES_OF.get(number)]
        parts.append(
            section(
                f"Figure {path.stem.removeprefix('figure-')}",
                _picture(path, captions[number]),
                _table(own) if own else "",
            )
        )
    for name in tables:
        if name in TABLES_OF.values():
            continue
        heading = name if name.startswith("fig") else f"Table or section {name}"
        parts.append(section(heading, _table([row for row in rows if row.table == name])))
    return parts


def _number(path: Path) -> str:
    return path.stem.removeprefix("figure-").partition("-")[0]


def _order(path: Path) -> tuple[int, ...]:
    return tuple(int(part) for part in _number(path).split("."))


def _picture(path: Path, caption: str) -> str:
    data = b64encode(path.read_bytes()).decode("ascii")
    return figure(
        f'<img style="max-width:100%" alt="{escape(caption)}" src="data:image/png;base64,{data}">',
        caption,
    )


def _table(rows: Sequence[Row]) -> str:
    cells = [
        [
            escape(row.what),
            significant(row.printed, 4),
            "none" if isnan(row.ours) else significant(row.ours, 4),
            _deviation(row),
            row.kind,
            escape(row.reason),
        ]
        for row in rows
    ]
    return table(("", "printed", "ours", "off", "kind", "why"), cells, "lrrrll")


def _deviation(row: Row) -> str:
    if isnan(row.ours):
        return ""
    return f"{100 * (row.ours - row.printed) / abs(row.printed):+.1f} %"
