"""Compare: what was measured and modelled, of any runs and channels, in one of several kinds."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from nicegui import ui
from nicegui.events import GenericEventArguments

from wheelhop.campaign import ComponentCampaign
from wheelhop.report.page import table
from wheelhop.workbench.charts import WHOLE, Options, Window, zoomed
from wheelhop.workbench.compared import (
    DISTANCE,
    KINDS,
    PAIRED,
    TIME,
    XY,
    Compared,
    offered_channels,
    offered_runs,
    opened,
)
from wheelhop.workbench.curves import Row, at_first, model_name, rows_of
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.kinds import Look, picture, readings, words
from wheelhop.workbench.playback import SIDES, Playback
from wheelhop.workbench.view import Looking, html

RESTED = """(event) => {{
  const {{start, end}} = (event.batch || [event])[0];
  if (start === undefined) return;
  const seen = {{start, end, drawing: getHtmlElement({id}).dataset.drawing}};
  clearTimeout(window.wheelhopResting);
  window.wheelhopResting = setTimeout(() => emit(seen), 150);
}}"""
"""Sends what is looked at once it stays: to draw anew while it moves would make it stutter."""
DRAGGED = """(event) => {{
  const range = wheelhop.dragged({id}, event);
  if (range) emit(range);
}}"""
NOTHING = "Left out, or not predicted by the model: nothing to compare."
HINTS = {
    "time": "In band. Scroll to zoom, drag to move, or + − and the arrow keys, 0 for all. Grey"
    " band: ±2 standard deviations of the noise.",
    "overlay": "The runs chosen over one another against time, each from its beginning.",
    "distance": "The runs chosen over one another by where the front axle was: what a track does"
    " lies together, whatever the speed.",
    "spectrogram": "Power density over time and frequency, decibels below the strongest.",
    "spectrum": "Power densities of whole runs, the mean of those chosen, by length. Dashed in"
    " grey: the noise floor.",
    "response": "The first channel over each of the others (H1), of all runs chosen; only where"
    " their coherence is more than chance makes it.",
    "coherence": "The share of the first channel’s power that goes with another one. Below the"
    " dashed line it would be by chance in 95 %: more runs lower it.",
    "xy": "The first channel over each of the others, in the stretch chosen in Time, else some"
    " waves about the farthest point.",
    "histogram": "How much of the time each value has, in all runs chosen.",
}
HEADS = ["", "", "at 1", "at 2", "difference", "rms between", "range between", "unit"]


class CompareView:
    """`Looking.compared` drawn, or what matters most where nothing was chosen yet."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk, self._looking = desk, looking
        self._content: object = None
        self._drawing = 0
        self._look: Look | None = None
        self._rows: tuple[Row, ...] = ()
        self._on_track = not isinstance(desk.campaign, ComponentCampaign)
        self._channels_offered = offered_channels(desk.campaign)
        kinds = {k: words for k, words in KINDS.items() if self._on_track or k != DISTANCE}
        self._kind: Any = ui.toggle(kinds).props("no-caps unelevated dense").classes("bench-kinds")
        with ui.row().classes("bench-controls"):
            self._runs: Any = _many([], "runs")
            self._channels: Any = _many(list(self._channels_offered), "channels")
            self._models: Any = _many({}, "models")
            _button("Earlier run", lambda: self._step(-1))
            _button("Next run", lambda: self._step(1))
            self._worst = _button("Where it fails worst", lambda: self._look_at(None))
            self._whole = _button("The whole run", lambda: self._look_at(WHOLE))
            self._cursors = _button("Set cursors", self._toggle_cursors)
            self._play = _button("Play it back", self._toggle_playback)
            self._side: Any = ui.select(list(SIDES), label="side", value="left").props("dense")
            self._side.on_value_change(self._show_playback)
            self._side.set_visibility(False)
        self._playback = Playback()
        self._playback.section.set_visibility(False)
        self._words = ui.label().classes("soft")
        self._frame = ui.element("div")
        self._chart, self._parts = self._new_chart(), ("", 0, 0)
        self._readings = html()
        self._hint = ui.label().classes("soft")
        take = self._take
        self._kind.on_value_change(
            lambda event: take(self._state.drawn_as(event.value, self._channels_offered))
        )
        self._runs.on_value_change(lambda event: take(self._state.of_runs(event.value)))
        self._channels.on_value_change(lambda event: take(self._state.of_channels(event.value)))
        self._models.on_value_change(lambda event: take(self._state.beside(event.value)))

    def _new_chart(self) -> ui.echart:
        self._frame.clear()
        with self._frame:
            made = ui.echart({}).classes("bench-chart").props('aria-label="measured, modelled"')
        made.on("chart:datazoom", self._zoomed, js_handler=RESTED.format(id=made.id))
        made.on("chart:brushEnd", self._dragged, js_handler=DRAGGED.format(id=made.id))
        return made.props("tabindex=0").on("keydown", self._pressed, args=["key"])

    @property
    def _state(self) -> Compared:
        desk = self._desk
        state = self._looking.compared or desk.looked_at
        if state is None:
            roles = {run.id: desk.choice.role_of(run) for run in desk.campaign.runs}
            state = opened(desk.campaign, desk.rungs, roles)
        return state.on(tuple(rung.added for rung in desk.rungs))

    def _take(self, state: Compared, *, in_browser: bool = False) -> None:
        """An event has made another state; `in_browser`: its window is on the screen already."""
        if state != self._state:
            self._looking.compared = state
            self._desk.look_at(state)
            self._looking.moved()
            self.show(in_browser=in_browser)

    def show(self, *, in_browser: bool = False) -> None:
        """Draw the state, as far as it is not drawn."""
        desk, state = self._desk, self._state
        self._fill_fields(state)
        content = (replace(state, window=None, cursors=None), desk.rungs)
        fresh = content != self._content
        if fresh:
            self._content, self._rows = content, rows_of(state, desk.campaign, desk.rungs)
        before, look = self._look, self._look_of(state)
        self._look = look
        if fresh or (state.kind == XY and look != before):
            self._draw(state, look)
            self._show_playback()
        elif look != before:
            self._move(state, look, in_browser=in_browser)
        dragging = state.kind == TIME and look.cursors is not None
        if fresh or before is None or dragging != (before.cursors is not None):
            self._chart.client.run_javascript(
                f"wheelhop.setCursors({self._chart.id}, {str(dragging).lower()})"
            )
        found = readings(self._rows, look.cursors) if dragging and look.cursors else []
        self._readings.set_content(
            f'<div class="scroll" tabindex="0">{table(HEADS, found, "llrrrrrl")}</div>'
            if found
            else ""
        )

    def _look_of(self, state: Compared) -> Look:
        window = state.window
        if window is None:
            window = at_first(self._rows, loops=state.kind == XY) if self._rows else WHOLE
        return Look(window, state.cursors, self._desk.campaign.band_hz)

    @property
    def _length_s(self) -> float:
        return max((row.length_s for row in self._rows), default=0.0)

    def _fill_fields(self, state: Compared) -> None:
        desk = self._desk
        offered = offered_runs(desk.campaign, desk.choice.without_runs, state.runs)
        self._kind.set_value(state.kind if state.kind in self._kind.options else TIME)
        _fill(self._runs, offered, list(state.runs))
        _fill(self._channels, list(self._channels_offered), list(state.channels))
        self._channels.props(
            f'label="{"first over others" if state.kind in PAIRED else "channels"}"'
        )
        _fill(self._models, dict(enumerate(map(model_name, state.ladder))), list(state.models))
        self._models.set_visibility(len(state.ladder) > 1)
        self._play.set_visibility(self._on_track and bool(state.models) and state.kind == TIME)
        for button in (self._worst, self._whole):
            button.set_visibility(state.kind in (TIME, XY))
        self._cursors.set_visibility(state.kind == TIME)
        self._cursors.set_text("Set cursors" if state.cursors is None else "Take the cursors away")
        self._hint.set_text(HINTS[state.kind])

    def _draw(self, state: Compared, look: Look) -> None:
        self._words.set_text(words(self._rows) if self._rows else NOTHING)
        self._frame.set_visibility(bool(self._rows))
        if not self._rows:
            return
        made = picture(state.kind, self._rows, look)
        parts = state.kind, len(made.options["grid"]), len(made.options["series"])
        if parts != self._parts:  # a chart that is there would keep axes of before
            self._parts, self._chart = parts, self._new_chart()
        self._drawing += 1
        self._chart.props(f"data-drawing={self._drawing}").style(f"height: {made.height_px}px")
        self._chart.classes(**{"add" if state.kind == XY else "remove": "loops"})
        self._chart.options.clear()
        self._chart.options.update(made.options)
        self._chart.update()

    def _move(self, state: Compared, look: Look, *, in_browser: bool) -> None:
        """Show another part of what is drawn, with all the detail there is, or the cursors."""
        if state.kind != TIME or not self._rows:
            return
        options = picture(state.kind, self._rows, look).options
        self._chart.options.update(options)
        kept = ("data", "lineStyle", "markLine", "markArea")
        change: Options = {"series": [{k: s[k] for k in kept if k in s} for s in options["series"]]}
        zoom = {"moveOnMouseMove": look.cursors is None}
        change["dataZoom"] = [zoom if in_browser else zoom | zoomed(look.window)]
        self._chart.run_chart_method("setOption", change)

    def _zoomed(self, event: GenericEventArguments) -> None:
        """The wheel or a finger has moved what is looked at; of a drawing before that is old."""
        seen = event.args
        if self._state.kind != TIME or int(seen["drawing"]) != self._drawing:
            return
        first, last = (float(seen[end]) / 100 for end in ("start", "end"))
        ends = round(first * self._length_s, 4), round(last * self._length_s, 4)
        window = WHOLE if first <= 0.0 and last >= 1.0 else ends
        self._take(replace(self._state, window=window), in_browser=True)

    def _pressed(self, event: GenericEventArguments) -> None:
        """The keyboard's way to zoom and to move."""
        if self._look and self._state.kind == TIME:
            key = str(event.args["key"])
            self._take(self._state.pressed(key, self._look.window, self._length_s))

    def _look_at(self, window: Window | None) -> None:
        self._take(replace(self._state, window=window))

    def _step(self, by: int) -> None:
        desk = self._desk
        runs = offered_runs(desk.campaign, desk.choice.without_runs, self._state.runs)
        self._take(self._state.stepped(by, runs))

    def _toggle_cursors(self) -> None:
        """Set two cursors within what is shown, to be dragged anew; or take them away."""
        cursors = None
        if self._state.cursors is None and self._look is not None:
            first, last = max(self._look.window[0], 0.0), min(self._look.window[1], self._length_s)
            cursors = (2 * first + last) / 3, (first + 2 * last) / 3
        self._take(replace(self._state, cursors=cursors))

    def _dragged(self, event: GenericEventArguments) -> None:
        first, last = (float(end) for end in event.args)
        self._take(replace(self._state, cursors=(round(first, 4), round(last, 4))))

    def _toggle_playback(self) -> None:
        open_ = not self._playback.section.visible
        self._playback.section.set_visibility(open_)
        self._side.set_visibility(open_)
        self._play.set_text("Close the playback" if open_ else "Play it back")
        self._show_playback()

    def _show_playback(self) -> None:
        """Of the first run that is looked at, as the last model chosen has it."""
        if not self._playback.section.visible:
            return
        state, campaign = self._state, self._desk.campaign
        model = self._desk.rungs[state.models[-1]] if state.models else None
        run = next(run for run in campaign.runs if run.id == state.runs[0])
        self._playback.show(run, model, self._side.value)


def _many(options: Any, label: str) -> Any:
    return ui.select(options, label=label, multiple=True).props("dense options-dense")


def _button(text: str, act: Any) -> ui.button:
    return ui.button(text, on_click=act).props("flat dense no-caps")


def _fill(field: Any, options: Any, value: object) -> None:
    """Offer these, and show which was chosen."""
    if options != field.options:
        field.set_options(options, value=value)
    else:
        field.set_value(value)
