"""Compare: measured and modelled, in time and frequency, what is left of it beneath."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from nicegui import ui
from nicegui.events import GenericEventArguments

from wheelhop.campaign import ComponentCampaign
from wheelhop.workbench.charts import WHOLE, Options, Window
from wheelhop.workbench.compared import (
    ALL_RUNS,
    Compared,
    Curves,
    curves,
    model_name,
    runs_offered,
    spectrum,
    time_chart,
    words_of,
)
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.playback import SIDES, Playback
from wheelhop.workbench.view import Looking, html

RESTED = """(event) => {{
  const {{start, end}} = (event.batch || [event])[0];
  const seen = {{start, end, run: getHtmlElement({id}).dataset.run}};
  clearTimeout(window.wheelhopResting);
  window.wheelhopResting = setTimeout(() => emit(seen), 150);
}}"""
"""Sends what is looked at once it stays: to draw anew while it moves would make it stutter."""


class CompareView:
    """One channel of one run, or of all runs one after the other: `Looking.compared` drawn."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk, self._looking = desk, looking
        self._content: object = None
        self._window = WHOLE
        self._curves: Curves | None = None
        self._on_track = not isinstance(desk.campaign, ComponentCampaign)
        channels = {i: channel.name for i, channel in enumerate(desk.campaign.channels)}
        with ui.row().classes("bench-controls"):
            self._run: Any = ui.select({}, label="run").props("dense options-dense")
            self._channel: Any = ui.select(channels, label="channel").props("dense")
            self._models: Any = ui.select({}, label="models", multiple=True).props("dense")
            ui.button("Earlier run", on_click=lambda: self._step(-1)).props("flat dense no-caps")
            ui.button("Next run", on_click=lambda: self._step(1)).props("flat dense no-caps")
            self._play = ui.button("Play it back", on_click=self._toggle_playback)
            self._play.props("flat dense no-caps")
            self._side: Any = ui.select(list(SIDES), label="side", value="left").props("dense")
            self._side.on_value_change(self._show_playback)
            self._side.set_visibility(False)
        self._words = ui.label().classes("soft")
        self._playback = Playback()
        self._playback.section.set_visibility(False)
        self._time = ui.echart({}).classes("bench-chart").props('aria-label="against time"')
        rested = RESTED.format(id=self._time.id)
        self._time.on("chart:datazoom", self._zoomed, js_handler=rested)
        self._time.props("tabindex=0").on("keydown", self._pressed, args=["key"])
        self._spectrum = ui.echart({}).classes("bench-spectrum").props('aria-label="spectrum"')
        html(
            "<p class='soft'>In band. Scroll to zoom, drag to move, or + − and the arrow keys, 0"
            " for all; both panels go together. Grey band: ±2 standard deviations of the noise."
            " Dashed in grey: the noise floor.</p>",
        )
        self._run.on_value_change(lambda event: self._take(self._state.at(run=event.value)))
        self._channel.on_value_change(lambda event: self._take(self._state.at(channel=event.value)))
        self._models.on_value_change(lambda event: self._take(self._state.beside(event.value)))

    @property
    def _state(self) -> Compared:
        return self._looking.compared

    def _take(self, state: Compared, *, in_browser: bool = False) -> None:
        """An event has made another state; `in_browser`: its window is on the screen already."""
        if state != self._state:
            self._looking.compared = state
            self.show(in_browser=in_browser)

    def show(self, *, in_browser: bool = False) -> None:
        """Draw the state, as far as it is not drawn."""
        desk = self._desk
        state = self._state.on(tuple(rung.added for rung in desk.rungs))
        self._looking.compared = state
        self._fill_fields(state)
        content = (replace(state, window=WHOLE), desk.rungs, desk.choice.without_runs)
        if content != self._content:
            self._content = content
            self._curves = curves(state, desk.campaign, desk.rungs, desk.choice.without_runs)
            self._words.set_text(words_of(self._curves))
            self._time.props(f"data-run={state.run}")
            _draw(self._time, time_chart(self._curves, state.window))
            _draw(self._spectrum, spectrum(self._curves, desk.campaign.band_hz))
            self._show_playback()
        elif state.window != self._window and self._curves is not None:
            self._move(state.window, in_browser)
        self._window = state.window

    def _fill_fields(self, state: Compared) -> None:
        campaign = self._desk.campaign
        offered = runs_offered(state, campaign, self._desk.choice.without_runs)
        runs = {i: campaign.runs[i].id for i in offered}
        _fill(self._run, runs | {ALL_RUNS: "all runs, one after the other"}, state.run)
        self._channel.set_value(state.channel)
        _fill(self._models, dict(enumerate(map(model_name, state.ladder))), list(state.models))
        self._models.set_visibility(len(state.ladder) > 1)
        self._play.set_visibility(self._on_track and state.run != ALL_RUNS)

    def _move(self, window: Window, in_browser: bool) -> None:
        """Show another part of what is drawn, and all the detail there is of it."""
        options = time_chart(self._curves, window)
        self._time.options.update(options)
        change: Options = {"series": [{"data": series["data"]} for series in options["series"]]}
        if not in_browser:
            change["dataZoom"] = [{"start": window[0], "end": window[1]}]
        self._time.run_chart_method("setOption", change)

    def _zoomed(self, event: GenericEventArguments) -> None:
        """The wheel or a finger has moved what is looked at."""
        seen = event.args
        window = float(seen["start"]), float(seen["end"])
        self._take(self._state.zoomed(int(seen["run"]), window), in_browser=True)

    def _pressed(self, event: GenericEventArguments) -> None:
        """The keyboard's way to zoom and to move."""
        self._take(self._state.pressed(str(event.args["key"])))

    def _step(self, by: int) -> None:
        taken = self._desk.choice.without_runs
        self._take(self._state.stepped(by, runs_offered(self._state, self._desk.campaign, taken)))

    def _toggle_playback(self) -> None:
        open_ = not self._playback.section.visible
        self._playback.section.set_visibility(open_)
        self._side.set_visibility(open_)
        self._play.set_text("Close the playback" if open_ else "Play it back")
        self._show_playback()

    def _show_playback(self) -> None:
        """Of the run that is looked at, as the last model chosen has it."""
        if not self._playback.section.visible:
            return
        run, models = self._state.run, self._state.models
        model = self._desk.rungs[models[-1]] if models and run != ALL_RUNS else None
        self._playback.show(self._desk.campaign.runs[run], model, self._side.value)


def _fill(field: Any, options: dict[int, str], value: object) -> None:
    """Offer these, and show which was chosen."""
    if options != field.options:
        field.set_options(options, value=value)
    else:
        field.set_value(value)


def _draw(chart: ui.echart, options: Options) -> None:
    """These options, and none of those before."""
    chart.options.clear()
    chart.options.update(options)
    chart.update()
