"""The campaign's files as forms: every number that the campaign and the vehicle state, the channels
and the runs. What was typed becomes a change that is looked at before it is made."""

from __future__ import annotations

from functools import partial
from typing import Any

from nicegui import ui
from nicegui.events import GenericEventArguments

from wheelhop.campaign import CampaignError, ComponentCampaign
from wheelhop.campaign.change import Proposal
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.forms import (
    UNCERTAINTY,
    Field,
    RunTable,
    filled,
    of_campaign,
    of_channels,
    of_runs,
    of_vehicle,
)
from wheelhop.workbench.view import Looking, Words

PAGE = 25  # runs at a time
RUNS = (
    "Select runs and change a cell of one: all selected change. A column copied from a spreadsheet"
    " can be pasted into a cell, too: its rows go down, its columns to the right. Empty: not said."
)
NUMBERS = "± is one standard deviation. Empty: not said, and the file’s relative_uncertainty holds."
CELL = r"""<q-td :props="props">
  <strong v-if="props.col.name === 'id'">{{ props.value }}</strong>
  <input v-else class="cell" :value="props.value"
    :aria-label="props.row.id + ', ' + props.col.label"
    :class="{changed: (props.row.changed || []).includes(props.col.name)}"
    @change="event => {
      event.target.classList.add('changed');
      $parent.$emit('cell', [props.row.id, props.col.name, event.target.value]);
    }"
    @paste="event => {
      const text = event.clipboardData.getData('text');
      if (!/[\t\n]/.test(text.trimEnd())) return;
      event.preventDefault();
      $parent.$emit('pasted', [props.row.id, props.col.name, text]);
    }">
</q-td>"""

CHOOSE = '<q-checkbox v-model="props.selected" dense :aria-label="\'select \' + {name}"/>'


class FilesView:
    """One form for each file; nothing is written before the change was seen."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk, self._looking = desk, looking
        self._typed: dict[tuple[str, tuple[str, ...]], tuple[Field, str]] = {}
        self._runs = RunTable((), (), {})
        with ui.row().classes("bench-controls bench-changes"):
            self._save = ui.button("Look at the change", on_click=self._propose)
            self._save.props("no-caps unelevated")
            self._count = ui.label().classes("soft").props('role="status"')
        try:
            self._lay_out()
        except CampaignError as error:
            ui.label(str(error))
        self._tell()

    def show(self) -> None:
        """The files are read when the campaign is opened; a change opens it anew."""

    def _lay_out(self) -> None:
        campaign = self._desk.campaign
        Words("The campaign", "h2")
        self._grid(of_campaign(campaign))
        channels = of_channels(campaign)
        if channels:
            Words("Channels", "h2")
            with ui.element("div").classes("bench-numbers"):
                for row in channels:
                    for label, field in row.items():
                        name = field.keys[1]
                        self._input(field, f"{name} {label}")
        Words("Runs", "h2")
        self._runs = of_runs(campaign)
        self._table = self._run_table()
        if not isinstance(campaign, ComponentCampaign):
            Words("The vehicle", "h2")
            ui.label(NUMBERS).classes("soft")
            self._grid(of_vehicle(campaign))

    def _grid(self, fields: list[Field]) -> None:
        """A field for each number, its standard deviation beside it."""
        own = {field.name: field for field in fields}
        with ui.element("div").classes("bench-numbers pairs"):
            for name, field in own.items():
                if name.removesuffix(UNCERTAINTY) in own and name.endswith(UNCERTAINTY):
                    continue
                with ui.element("div").classes("bench-pair"):
                    self._input(field, name)
                    beside = own.get(name + UNCERTAINTY)
                    if beside is not None:
                        self._input(beside, "±", spoken=beside.name)

    def _input(self, field: Field, label: str, spoken: str = "") -> None:
        entry: Any = ui.input(label, value=field.text).props("dense outlined stack-label")
        entry.props["aria-label"] = spoken or label
        if field.meaning:
            entry.tooltip(field.meaning)
        entry.on("blur", partial(self._type, field, entry))
        entry.on("keydown.enter", partial(self._type, field, entry))

    def _type(self, field: Field, entry: Any) -> None:
        self._take(field, str(entry.value or ""))

    def _take(self, field: Field, text: str) -> None:
        key = field.file, field.keys
        self._typed.pop(key, None)
        if text.strip() != field.text:
            self._typed[key] = field, text
        self._tell()

    def _tell(self) -> None:
        count = len(self._typed)
        self._save.set_enabled(bool(count))
        words = f"{count} changed, nothing written yet" if count else "Nothing is changed."
        self._count.set_text(words)

    def _run_table(self) -> Any:
        ui.label(RUNS).classes("soft")
        columns = [{"name": "id", "label": "run", "field": "id", "sortable": True, "align": "left"}]
        columns += [
            {"name": name, "label": name, "field": name, "sortable": True, "align": "left"}
            for name in self._runs.names
        ]
        search = ui.input("find runs").props("dense outlined clearable")
        table = ui.table(
            rows=self._rows(),
            columns=columns,
            row_key="id",
            selection="multiple",
            pagination={"rowsPerPage": PAGE},
        )
        table.props("dense flat").classes("bench-table").bind_filter_from(search, "value")
        table.add_slot("body-cell", CELL)
        table.add_slot("header-selection", CHOOSE.format(name="'all runs'"))
        table.add_slot("body-selection", CHOOSE.format(name="props.row.id"))
        table.on("cell", self._cell)
        table.on("pasted", self._pasted)
        chosen = ui.label().classes("soft").props('role="status"')
        table.on_select(lambda: chosen.set_text(self._choice()))
        return table

    def _choice(self) -> str:
        count = len(self._table.selected)
        return f"{count} runs chosen: what is typed goes into all of them." if count > 1 else ""

    def _rows(self) -> list[dict[str, Any]]:
        rows = []
        for run in self._runs.ids:
            row: dict[str, Any] = {"id": run, "changed": []}
            for name in self._runs.names:
                field = self._runs.field(run, name)
                typed = self._typed.get((field.file, field.keys))
                row[name] = field.text if typed is None else typed[1]
                if typed is not None:
                    row["changed"].append(name)
            rows.append(row)
        return rows

    def _cell(self, event: GenericEventArguments) -> None:
        run, name, text = map(str, event.args)
        chosen = [str(row["id"]) for row in self._table.selected]
        several = chosen if run in chosen else [run]
        for each in several:
            self._take(self._runs.field(each, name), text)
        if len(several) > 1:  # drawn anew, all cells are other ones: what is being typed would go
            self._redraw()

    def _pasted(self, event: GenericEventArguments) -> None:
        run, name, text = map(str, event.args)
        cells = filled((run, name), self._runs.ids, self._runs.names, text)
        for (each, column), word in cells.items():
            self._take(self._runs.field(each, column), word)
        self._redraw()

    def _redraw(self) -> None:
        self._table.rows[:] = self._rows()
        self._table.update()

    async def _propose(self) -> None:
        changes = tuple(field.change(text) for field, text in self._typed.values())
        names = list(dict.fromkeys(change.file for change in changes))
        await self._looking.propose(Proposal(f"Change {' and '.join(names)}", changes))
