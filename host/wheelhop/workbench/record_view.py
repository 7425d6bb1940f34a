"""Record: the logger live in the page, what was recorded, and what its card has."""

from __future__ import annotations

import json
from collections.abc import Callable
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from nicegui import run, ui
from numpy.typing import NDArray

from wheelhop.files import InputError
from wheelhop.logger.live import CLIPPED, CODES, Live
from wheelhop.workbench.charts import AFTER, INK, points
from wheelhop.workbench.recorder import FOLDER, Made, Recorder
from wheelhop.workbench.sessions import Kind, kinds
from wheelhop.workbench.view import acting, drawn, html

LOOK_S = 0.25
SHOWN_S = 10.0
DRAWN = 400  # points of each channel
LEAST_SPAN = 48.0  # codes: less would show noise as if it were motion
NO_PORT = "the only one there is"


class RecordView:
    """Start, watch, stop; then evaluate a recording, or take its stretches as runs (`take`)."""

    def __init__(self, recorder: Recorder, folder: Path, take: Callable[[Path, Path], Any]) -> None:
        self._recorder, self._take = recorder, take
        self._seen = -1
        self._scans: object = None
        self._kinds = kinds()
        with ui.row().classes("bench-controls"):
            names = {key: kind.name for key, kind in self._kinds.items()}
            self._kind: Any = ui.select(names, label="what for", value="drive").props("dense")
            self._kind.on_value_change(self._show_steps)
            self._port: Any = ui.select({"": NO_PORT}, label="logger", value="").props("dense")
            self._folder = ui.input("folder for recordings", value=str(folder / FOLDER))
            self._folder.props("dense outlined").classes("bench-path")
        self._steps = html()
        with ui.row().classes("bench-controls"):
            self._start = ui.button("Start recording", on_click=self._begin)
            self._start.props("no-caps unelevated")
            self._stop = ui.button("Stop", on_click=recorder.stop).props("no-caps unelevated")
            self._card_button = ui.button(
                "What is on its card",
                on_click=lambda: recorder.look_at_card(self._port.value or None),
            ).props("no-caps outline")
            self._emulate = ui.button("Use an emulated logger", on_click=recorder.emulate)
            self._emulate.props("no-caps outline").tooltip("to try this page without a logger")
            self._busy = ui.label().classes("soft").props('role="status"')
        self._notice = ui.label().classes("bench-notice").props('role="status"')
        with ui.element("div").classes("bench-split wide") as self._live:
            self._chart = (
                ui.echart({}).classes("bench-live").props('aria-label="all channels, live"')
            )
            self._health = html()
        self._made = acting(html(), self._act)
        self._result = drawn()
        self._show_steps()
        self.show()
        ui.timer(LOOK_S, self.show)

    def show(self) -> None:
        """Bring it up to date."""
        recorder = self._recorder
        self._show_live(recorder.live)
        if recorder.version == self._seen:
            return
        self._seen = recorder.version
        recording = recorder.busy == "recording"
        self._busy.set_text("" if recording else recorder.busy)
        for button in (self._start, self._card_button, self._emulate):
            button.set_enabled(not recorder.busy)
        self._stop.set_visibility(recording)
        self._start.set_visibility(not recording)
        self._notice.set_text(recorder.notice)
        self._notice.set_visibility(bool(recorder.notice))
        self._live.set_visibility(recorder.live is not None)
        self._made.set_content(self._made_html())
        ports = {"": NO_PORT, **{port: port for port in recorder.ports()}}
        if ports != self._port.options:
            still = self._port.value if self._port.value in ports else ""
            self._port.set_options(ports, value=still)

    @property
    def _where(self) -> Path:
        return Path(self._folder.value.strip()).expanduser()

    def _begin(self) -> None:
        self._scans = None
        self._recorder.start(self._where, self._port.value or None)

    def _look_at_card(self) -> None:
        self._recorder.look_at_card(self._port.value or None)

    def _show_steps(self) -> None:
        steps = "".join(f"<li>{escape(step)}.</li>" for step in self._chosen.steps)
        self._steps.set_content(f"<ol class='steps'>{steps}</ol>")
        self._made.set_content(self._made_html())

    @property
    def _chosen(self) -> Kind:
        return self._kinds[str(self._kind.value)]

    def _show_live(self, live: Live | None) -> None:
        if live is None:
            return
        while live.messages:
            self._recorder.say(live.messages.popleft())
        scans = (live.written, live.lost, live.connected)
        if scans == self._scans:
            return
        self._scans = scans
        codes = live.window(SHOWN_S)
        self._health.set_content(_health(live, codes))
        if len(codes):
            self._chart.options.update(_lanes(live, codes))
            self._chart.update()

    def _made_html(self) -> str:
        recorder = self._recorder
        rows = "".join(self._row(i, made) for i, made in enumerate(recorder.made))
        parts = []
        if rows:
            parts.append(f"<h3>Recorded</h3><ul class='made'>{rows}</ul>")
        if recorder.card:
            items = "".join(
                f"<li><strong>{escape(name)}</strong> {size / 1000:.0f} kB"
                f' <button data-act="fetch" data-name="{escape(name)}">fetch it</button></li>'
                for name, size in sorted(recorder.card.items(), reverse=True)
            )
            parts.append(f"<h3>On the card</h3><ul class='made'>{items}</ul>")
        return "".join(parts)

    def _row(self, number: int, made: Made) -> str:
        missing = f", {made.missing} scans missing" if made.missing else ", none missing"
        words = self._chosen.evaluate_words or "Take its stretches as runs"
        found = "".join(f"<li>{escape(line)}</li>" for line in made.findings)
        return (
            f"<li><strong>{escape(made.path.name)}</strong> {made.seconds:.1f} s{missing}"
            f' <button class="primary" data-act="use" data-number="{number}">{words}</button>'
            f' <button data-act="save" data-number="{number}">download</button>'
            f"{f'<ul>{found}</ul>' if found else ''}</li>"
        )

    async def _act(self, data: dict[str, str]) -> None:
        if data["act"] == "fetch":
            self._recorder.fetch(data["name"], self._where, self._port.value or None)
            return
        made = self._recorder.made[int(data["number"])]
        if data["act"] == "save":
            ui.download.file(made.path)
        elif self._chosen.evaluate is None:
            await self._take(made.path, made.path.parent)
        else:
            try:
                found = await run.io_bound(self._chosen.evaluate, made.path, made.path.parent)
            except InputError as error:
                found = f"<p>{escape(str(error))}</p>"
            name = escape(f"{self._chosen.name}: {made.path.name}")
            self._result.set_content(f"<section><h3>{name}</h3>{found}</section>")


def _health(live: Live, codes: NDArray[np.float64]) -> str:
    """Every channel, the file and the line, in words."""
    rows = "".join(_channel(name, codes[:, k]) for k, name in enumerate(live.channels))
    told = live.told
    card = f"{told.written} scans safe, {told.lost} lost" if told else live.card or "not heard of"
    sound = live.clock is not None and live.clock.is_sound
    clock = f"{live.clock.ppm:+.0f} ppm" if live.clock and sound else "not known yet"
    facts = (
        ("file", live.file.name if live.file else "none yet"),
        ("recorded", f"{live.written / live.rate_hz:.1f} s, {live.lost} scans missing"),
        ("rate", f"{live.measured_rate_hz():.1f} of {live.rate_hz} scans/s"),
        ("line", "connected" if live.connected else "no connection: waiting for it"),
        ("card", card),
        ("clock", clock),
        ("supply", f"{live.supply_mv / 1000:.2f} V" if live.supply_mv else "unknown"),
    )
    items = "".join(f"<div><dt>{a}</dt><dd>{escape(b)}</dd></div>" for a, b in facts)
    heads = "<th>channel</th><th class='r'>mean, code</th><th class='r'>sd, code</th><th></th>"
    return (
        f"<table><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>"
        f'<dl class="facts">{items}</dl>'
    )


def _channel(name: str, codes: NDArray[np.float64]) -> str:
    if not len(codes):
        return f"<tr><td>{escape(name)}</td><td></td><td></td><td>nothing yet</td></tr>"
    clipped = codes.min() < CLIPPED[0] or codes.max() > CLIPPED[1]
    words = "at the end of its range" if clipped else "stands still" if not codes.std() else ""
    return (
        f"<tr><td>{escape(name)}</td><td class='r'>{codes.mean():.1f}</td>"
        f"<td class='r'>{codes.std():.1f}</td><td><strong>{words}</strong></td></tr>"
    )


def _lanes(live: Live, codes: NDArray[np.float64]) -> dict[str, Any]:
    """All channels below each other over the last seconds, on one scale."""
    step = max(len(codes) // DRAWN, 1)
    shown = codes[::step]
    span = max(float(np.ptp(shown, axis=0).max()), LEAST_SPAN)
    time = (np.arange(len(shown)) - len(shown)) * step / live.rate_hz
    count = len(live.channels)
    series = []
    for k in range(count):
        lane = count - 1 - k + 0.5 + 0.9 * (shown[:, k] - shown[:, k].mean()) / span
        style = {"type": "line", "symbol": "none", "lineStyle": {"color": AFTER, "width": 1.1}}
        series.append({**style, "data": points(time, lane)})
    names = list(reversed(live.channels))
    return {
        "animation": False,
        "grid": {"left": 64, "right": 16, "top": 12, "bottom": 44},
        "xAxis": {
            **{"type": "value", "name": "time before now, s", "nameLocation": "middle"},
            **{"nameGap": 26, "min": -SHOWN_S, "max": 0, "axisLabel": {"color": INK}},
        },
        "yAxis": {
            **{"type": "value", "min": 0, "max": count, "interval": 1},
            **{"name": f"one lane is {span / 0.9:.0f} of {CODES} codes", "nameLocation": "middle"},
            **{"nameGap": 44, "splitLine": {"lineStyle": {"color": INK, "opacity": 0.18}}},
            "axisLabel": {
                "color": INK,
                "verticalAlign": "bottom",
                ":formatter": f"value => {json.dumps(names)}[value] ?? ''",
            },
        },
        "series": series,
    }
