"""The model: the ladder, the effects in it, and every number that the fit has moved."""

from __future__ import annotations

from html import escape

import numpy as np
from nicegui import ui

from wheelhop.workbench.charts import AFTER, FLOOR, Line, Panel, chart
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.glossary import term
from wheelhop.workbench.view import Looking, Words, acting, drawn, html

WAITING = "<p class='soft'>The model is being fitted; its numbers stand here after that.</p>"
CONVERGES = (
    "Adding an effect begins at several strengths and forms, each of which falls by itself; the"
    " best is then fitted in full."
)


class ModelView:
    """What was added, in order, to be taken out or exchanged; the error it leaves; the numbers."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk, self._looking = desk, looking
        self._seen: object = None
        self._drawn: object = None
        self._chips = acting(html(), self._act)
        with ui.element("div") as self._fit:
            Words("How the fit converges", "h3")
            self._chart = ui.echart({}).classes("bench-trace")
            self._chart.props('aria-label="error against iteration"')
            html(f"<p class='soft'>{CONVERGES}</p>")
        self._body = drawn(WAITING)

    def show(self) -> None:
        """Bring it up to date."""
        desk = self._desk
        rung = desk.rungs[-1] if desk.rungs else None
        seen = (rung, desk.choice)
        if seen != self._seen:
            self._seen = seen
            self._chips.set_content(self._added())
            body = rung.html["ladder"] + rung.html["model"] if rung else WAITING
            self._body.set_content(body)
        self._show_fit()

    def _show_fit(self) -> None:
        """Every iteration of the last fits, live."""
        desk = self._desk
        floor = desk.rungs[0].floor_fit if desk.rungs else 0.0
        if (desk.errors, floor) == self._drawn:
            return
        self._drawn = desk.errors, floor
        self._fit.set_visibility(bool(desk.errors))
        count = np.arange(1, len(desk.errors) + 1)
        lines = [Line("error E, runs fitted", count, 100 * np.array(desk.errors), AFTER, 2.0)]
        if floor > 0:
            level = np.full(len(count), 100 * floor)
            lines.append(Line("noise floor", count, level, FLOOR, dashed=True))
        panel = Panel("iteration", "error E, runs fitted, %", lines, log=True)
        options = chart([panel], (100,), (0,))
        options["xAxis"][0] |= {"type": "value", "minInterval": 1}
        self._chart.options.update(options)
        self._chart.update()

    def _added(self) -> str:
        added = self._desk.choice.added
        if not added:
            words = "Nothing has been added to the baseline. What is missing says what to add."
            return f'<p class="soft">{words} <button data-act="missing">Look there</button></p>'
        chips = []
        for i, name in enumerate(added):
            earlier = f'<button data-act="up" data-effect="{escape(name)}">earlier</button>'
            chips.append(
                f'<li class="chip"><strong>{escape(name)}</strong> {earlier if i else ""}'
                f'<button data-act="out" data-effect="{escape(name)}">take out</button></li>'
            )
        head = f'<p class="soft">Added to the {term("baseline")}:</p>'
        return f'{head}<ol class="chips">{"".join(chips)}</ol>'

    def _act(self, data: dict[str, str]) -> None:
        match data["act"]:
            case "missing":
                self._looking.go("missing")
            case "up":
                self._desk.move_up(data["effect"])
            case "out":
                self._desk.take_out(data["effect"])
