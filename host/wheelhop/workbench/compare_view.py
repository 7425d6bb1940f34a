"""Compare: measured and modelled, in time and frequency, what is left of it beneath."""

from __future__ import annotations

from typing import Any

import numpy as np
from nicegui import ui
from nicegui.events import GenericEventArguments
from numpy.typing import NDArray

from wheelhop.campaign import ComponentCampaign
from wheelhop.workbench.charts import (
    AFTER,
    BEFORE,
    FLOOR,
    MEASURED,
    MORE,
    MOST,
    Line,
    Panel,
    chart,
    power_density,
)
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.playback import SIDES, Playback
from wheelhop.workbench.shown import Rung
from wheelhop.workbench.view import Looking, html

Array = NDArray[np.float64]

ALL_RUNS = -1
WHOLE = (0.0, 100.0)
STEP = 0.2  # of what is shown, for one press of a key
CLOSEST = 0.5  # per cent of a record
RESTED = """(event) => {
  clearTimeout(window.wheelhopResting);
  window.wheelhopResting = setTimeout(() => emit(event), 150);
}"""
"""Sends what is looked at once it stays: to draw anew while it moves would make it stutter."""


class CompareView:
    """One channel of one run, or of all runs one after the other."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk, self._looking = desk, looking
        self._seen: object = None
        channels = {i: channel.name for i, channel in enumerate(desk.campaign.channels)}
        with ui.row().classes("bench-controls"):
            self._run: Any = ui.select({}, label="run").props("dense options-dense")
            self._channel: Any = ui.select(channels, label="channel", value=0).props("dense")
            self._rungs: Any = ui.select({}, label="models", multiple=True).props("dense")
            self._rungs.on_value_change(self._chosen)
            ui.button("Earlier run", on_click=lambda: self._step(-1)).props("flat dense no-caps")
            ui.button("Next run", on_click=lambda: self._step(1)).props("flat dense no-caps")
            self._play = ui.button("Play it back", on_click=self._toggle_playback)
            self._play.props("flat dense no-caps")
            self._side: Any = ui.select(list(SIDES), label="side", value="left").props("dense")
            self._side.on_value_change(self._show_playback)
            self._side.set_visibility(False)
            self._play.set_visibility(not isinstance(desk.campaign, ComponentCampaign))
        self._words = ui.label().classes("soft")
        self._playback = Playback()
        self._playback.section.set_visibility(False)
        self._time = ui.echart({}).classes("bench-chart").props('aria-label="against time"')
        self._lines: list[Line] = []
        self._time.on("chart:datazoom", self._zoomed, js_handler=RESTED)
        self._time.props("tabindex=0").on("keydown", self._pressed, args=["key"])
        self._window = WHOLE
        self._spectrum = ui.echart({}).classes("bench-spectrum").props('aria-label="spectrum"')
        html(
            "<p class='soft'>In band. Scroll to zoom, drag to move, or + − and the arrow keys, 0"
            " for all; both panels go together. Grey band: ±2 standard deviations of the noise."
            " Dashed in grey: the noise floor.</p>",
        )
        self._run.on_value_change(self._chosen)
        self._channel.on_value_change(self._chosen)

    def show(self) -> None:
        """Bring it up to date."""
        looking = self._looking
        self._offer_runs()
        if looking.channel is not None:
            self._channel.set_value(looking.channel)
        self._offer_models()
        seen = (self._run.value, self._channel.value, self._desk.rungs, tuple(self._rungs.value))
        if seen == self._seen:
            return
        same_place = self._seen is not None and seen[:2] == self._seen[:2]  # type: ignore[index]
        self._seen = seen
        self._draw(keep_zoom=same_place)
        self._show_playback()

    def _chosen(self) -> None:
        self._looking.run, self._looking.channel = self._run.value, self._channel.value
        self.show()

    def _offer_runs(self) -> None:
        """Those that are taken, and the one that is looked at."""
        left_out, looked_at = frozenset(self._desk.choice.without_runs), self._looking.run
        runs = enumerate(self._desk.campaign.runs)
        names = {i: run.id for i, run in runs if i == looked_at or run.id not in left_out}
        names[ALL_RUNS] = "all runs, one after the other"
        value = self._run.value if looked_at is None else looked_at
        if names != self._run.options:
            self._run.set_options(names, value=value if value in names else next(iter(names)))
        else:
            self._run.set_value(value)

    def _offer_models(self) -> None:
        """Every rung of the ladder may be looked at; first it is the baseline and the last one."""
        names = {i: _model_name(rung) for i, rung in enumerate(self._desk.rungs)}
        if names != self._rungs.options:
            self._rungs.set_options(names, value=sorted({0, len(names) - 1} & set(names)))
        self._rungs.set_visibility(len(names) > 1)

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
        models = self._models()
        run = self._desk.campaign.runs[max(self._run.value, 0)]
        self._playback.show(run, models[-1][1] if models else None, self._side.value)

    def _step(self, by: int) -> None:
        *runs, _ = self._run.options
        at = runs.index(self._run.value) if self._run.value in runs else 0
        self._run.set_value(runs[(at + by) % len(runs)])

    def _draw(self, keep_zoom: bool) -> None:
        models = self._models()
        channel = self._desk.campaign.channels[self._channel.value]
        time, rate_hz, curves = self._curves(channel.name, models)
        if not len(time):
            self._words.set_text("left out, or not predicted by the model: nothing to compare")
            self._time.options.clear()
            self._time.update()
            return
        measured = curves[0][1]
        noise = self._noise(channel.name, models)
        upper = [
            Line(name, time, y, colour, 2.2 if i == 0 else 1.0, colour in MORE)
            for i, (name, y, colour) in enumerate(curves)
        ]
        lower = [
            Line(name, time, measured - y, colour, dashed=colour in MORE)
            for name, y, colour in curves[1:]
        ]
        panels = [
            Panel("" if lower else "time, s", f"{channel.quantity}, {channel.unit}", upper),
            *(
                [Panel("time, s", f"residual, {channel.unit}", lower, band=2 * noise)]
                if lower
                else []
            ),
        ]
        self._lines = [*upper, *lower]
        options = chart(panels, (66, 34)[: len(panels)], range(len(panels)))
        if keep_zoom:
            options.pop("dataZoom")
        else:
            self._window = WHOLE
        self._time.options.update(options)
        self._time.update()
        self._draw_spectrum(curves, rate_hz, noise, channel.unit)
        rms = " · ".join(f"{n} {np.sqrt(np.mean(y**2)):.3g}" for n, y, _ in curves)
        self._words.set_text(f"rms, {channel.unit}: {rms}")

    def _zoomed(self, event: GenericEventArguments) -> None:
        """Fetch the detail of what is looked at, where not every sample was drawn."""
        zoom = dict(event.args)
        zoom = zoom.get("batch", [zoom])[0]
        self._window = float(zoom["start"]), float(zoom["end"])
        count = len(np.asarray(self._lines[0].y)) if self._lines else 0
        if count <= MOST:
            return
        first, last = (int(count * percent / 100) for percent in self._window)
        series = [{"data": line.points(first, last)} for line in self._lines]
        self._time.run_chart_method("setOption", {"series": series})

    def _pressed(self, event: GenericEventArguments) -> None:
        """The keyboard's way to zoom and to move."""
        window = moved(self._window, str(event.args["key"]))
        if window != self._window:
            self._window = window
            zoom = {"type": "dataZoom", "start": window[0], "end": window[1]}
            self._time.run_chart_method("dispatchAction", zoom)

    def _draw_spectrum(
        self, curves: list[tuple[str, Array, str]], rate_hz: float, noise: float, unit: str
    ) -> None:
        low, high = self._desk.campaign.band_hz
        lines = []
        for name, y, colour in curves:
            frequency, power = power_density(y, rate_hz)
            inside = (frequency >= low) & (frequency <= high) & (power > 0)
            lines.append(
                Line(name, frequency[inside], power[inside], colour, dashed=colour in MORE)
            )
        if noise > 0:
            level = noise**2 / (high - low)
            ends = np.array([low, high])
            lines.append(Line("noise floor", ends, np.full(2, level), FLOOR, dashed=True))
        label = f"power density, ({unit})²/Hz" if "/" in unit else f"power density, {unit}²/Hz"
        options = chart([Panel("frequency, Hz", label, lines, log=True)], (100,), (0,))
        self._spectrum.options.update(options)
        self._spectrum.update()

    def _models(self) -> list[tuple[str, Rung, str]]:
        """Name, rung and colour of what was chosen."""
        rungs = self._desk.rungs
        last = len(rungs) - 1
        colours = {i: MORE[i % len(MORE)] for i in range(1, last)}
        colours |= {last: AFTER, 0: BEFORE}
        chosen = [i for i in sorted(self._rungs.value) if i <= last]
        return [(_model_name(rungs[i]), rungs[i], colours[i]) for i in chosen]

    def _curves(
        self, channel: str, models: list[tuple[str, Rung, str]]
    ) -> tuple[Array, float, list[tuple[str, Array, str]]]:
        """Time, sample rate, and named curves, the measured one first."""
        campaign = self._desk.campaign
        chosen = self._run.value
        listed = list(self._run.options)[:-1]
        runs = [campaign.runs[i] for i in (listed if chosen == ALL_RUNS else [chosen])]
        if not models:
            column = [c.name for c in campaign.channels].index(channel)
            records = [run.record[:, column] for run in runs if len(run.time_s)]
            measured = np.concatenate([np.zeros(0), *(r - r.mean() for r in records)])
            rate = campaign.sample_rate_hz
            return np.arange(len(measured)) / rate, rate, [("measured", measured, MEASURED)]
        first = models[0][1]
        ids = [run.id for run in runs if run.id in first.signals]
        if channel not in first.channels or not ids:
            return np.zeros(0), campaign.sample_rate_hz, []
        k = first.channels.index(channel)
        rate = first.signals[ids[0]].rate_hz
        measured = np.concatenate([first.signals[i].measured[:, k] for i in ids])
        curves = [("measured", measured.astype(np.float64), MEASURED)]
        for name, rung, colour in models:
            modelled = np.concatenate([rung.signals[i].modelled[:, k] for i in ids])
            curves.append((name, modelled.astype(np.float64), colour))
        return np.arange(len(measured)) / rate, rate, curves

    def _noise(self, channel: str, models: list[tuple[str, Rung, str]]) -> float:
        if not models or channel not in models[0][1].channels:
            return 0.0
        return float(np.nan_to_num(models[0][1].noise_rms[models[0][1].channels.index(channel)]))


def _model_name(rung: Rung) -> str:
    """What is added to the baseline, or the baseline itself."""
    return f"with {' + '.join(rung.added)}" if rung.added else "baseline"


def moved(window: tuple[float, float], key: str) -> tuple[float, float]:
    """What of a record is looked at, per cent, after a key: + − zoom, arrows move, 0 shows all."""
    first, last = window
    width = last - first
    if key == "0":
        return WHOLE
    if key in ("+", "="):
        width = max(width * (1 - 2 * STEP), CLOSEST)
    elif key in ("-", "−"):
        width = min(width / (1 - 2 * STEP), 100.0)
    by = {"ArrowLeft": -STEP, "ArrowRight": STEP}.get(key, 0.0) * width
    middle = min(max((first + last) / 2 + by, width / 2), 100.0 - width / 2)
    return middle - width / 2, middle + width / 2
