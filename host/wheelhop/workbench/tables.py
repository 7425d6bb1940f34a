"""Tables that sort, filter, and can be copied into a spreadsheet."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from nicegui import ui
from nicegui.events import GenericEventArguments

COPIED = "Copied: paste it into a spreadsheet."
FILTERED = 8
"""From so many rows on there is a field to find some."""


@dataclass(frozen=True)
class Column:
    """A column: its name in the rows, its heading, whether numbers stand in it, and what it
    holds."""

    name: str
    label: str
    is_number: bool = False
    tip: str = ""


class Sortable:
    """A table of texts. A click on a heading sorts it; one on a cell of the column `chosen` calls
    `choose` with the row's key."""

    def __init__(
        self,
        columns: Sequence[Column],
        key: str,
        kind: str = "",
        choose: Callable[[str], None] | None = None,
    ) -> None:
        with ui.element("div") as self.element:
            with ui.row().classes("bench-controls"):
                self._find: Any = ui.input("find").props("dense outlined clearable")
                copy = ui.button("Copy the table").props("flat dense no-caps")
                self._copied = ui.label().classes("soft").props('role="status"')
            with ui.element("div").classes("scroll").props("tabindex=0"):  # keys move it sideways
                self._table: Any = ui.table(
                    rows=[],
                    columns=[_column(column) for column in columns],
                    row_key=key,
                    pagination={"rowsPerPage": 0},
                )
        self._table.props("dense flat hide-pagination").classes(f"bench-table {kind}")
        self._table.bind_filter_from(self._find, "value")
        for column in columns:
            if column.tip:
                self._table.add_slot(f"header-cell-{column.name}", HEAD)
        if choose is not None:
            self._table.add_slot(f"body-cell-{key}", CHOSEN)
            self._table.on("chosen", lambda event: choose(_only(event)))
        script = f"() => wheelhop.copyTable(getHtmlElement({self._table.id})).then(emit)"
        copy.on("click", lambda: self._copied.set_text(COPIED), js_handler=script)

    def show(self, rows: Sequence[Mapping[str, str | bool]]) -> None:
        """Other rows; one that is `accepted` stands out."""
        self._table.rows[:] = [dict(row) for row in rows]
        self._table.update()
        self._find.set_visibility(len(rows) >= FILTERED)


HEAD = """<q-th :props="props" :title="props.col.tip">{{ props.col.label }}</q-th>"""
CHOSEN = """<q-td :props="props"><button class="link" :class="{accepted: props.row.accepted}"
  @click="$parent.$emit('chosen', props.value)">{{ props.value }}</button></q-td>"""


def _only(event: GenericEventArguments) -> str:
    found = event.args
    return str(found[0] if isinstance(found, list) else found)


def _column(column: Column) -> dict[str, Any]:
    return {
        "name": column.name,
        "label": column.label,
        "field": column.name,
        "sortable": True,
        "align": "right" if column.is_number else "left",
        "tip": column.tip,
        ":sort": "(a, b) => wheelhop.order(a, b)",
    }
