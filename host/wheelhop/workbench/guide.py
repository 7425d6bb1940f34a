"""From recordings to a campaign, step by step on one page: nothing has to be typed that can be
guessed, and every guess can be seen and changed."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable
from math import isfinite
from pathlib import Path

import numpy as np
from nicegui import run, ui
from nicegui.events import UploadEventArguments

from wheelhop.files import InputError
from wheelhop.files.words import label_of, unit_of
from wheelhop.logger.recording import Recording
from wheelhop.workbench.charts import AFTER, Line, Panel, chart
from wheelhop.workbench.draft import PLACES, TRACKS, UNITS, Draft, Piece

LEVEL_S = 0.25
FIELD = "dense outlined"
CORNERS = ("front left", "front right", "rear left", "rear right")
PLACE_WORDS = {
    **{f"A{i}": f"A{i}: axle, {corner}" for i, corner in enumerate(CORNERS, start=1)},
    **{f"B{i}": f"B{i}: body, {corner}" for i, corner in enumerate(CORNERS, start=1)},
    "body": "body, place not known",
}
FIELD_WORDS = {
    "amplitude_mm": "amplitude, mm (half of trough to crest)",
    "pitch_mm": "wavelength, mm",
    "pitch_start_mm": "wavelength at the start, mm",
    "pitch_end_mm": "wavelength at the end, mm",
    "length_mm": "length, mm",
    "height_mm": "height, mm",
    "width_mm": "width, mm",
    "angle_deg": "angle, °",
    "lateral_offset_mm": "offset to the left, mm",
}


class Guide:
    """The steps; the next one shows when the one before is done."""

    def __init__(self, done: Callable[[Path], None], say: Callable[[str], None]) -> None:
        self._done, self._say = done, say
        self._draft = Draft()
        self._uploads = tempfile.TemporaryDirectory(prefix="wheelhop-")
        ui.html(
            "<p>Drop the recordings here: CSV or text of any layout, MDF4, TDMS, UFF, LVM, or the"
            " logger's .HOP. They must hold vertical accelerations.</p>",
            sanitize=False,
        )
        ui.upload(multiple=True, auto_upload=True, on_upload=self._take, label="recordings").props(
            'accept=".csv,.txt,.tsv,.dat,.asc,.mf4,.tdms,.uff,.unv,.lvm,.hop,.parquet"'
        )
        self._columns = ui.element("div")
        self._runs = ui.element("div")
        self._vehicle = ui.element("div")
        self._end = ui.element("div")

    async def _take(self, event: UploadEventArguments) -> None:
        name = re.sub(r"[^\w.()-]+", "_", Path(event.file.name).name)[-100:] or "recording.csv"
        target = Path(self._uploads.name) / name
        await event.file.save(target)
        try:
            await run.io_bound(self._draft.add, target)
        except InputError as error:
            self._say(str(error))
            return
        self._say("")
        self._show_columns()

    def _show_columns(self) -> None:
        self._columns.clear()
        with self._columns:
            names = ", ".join(file.name for file in self._draft.files)
            ui.html("What the columns are", sanitize=False, tag="h3")
            ui.label(f"Of {names}.").classes("soft")
            for column in self._draft.columns:
                with ui.row().classes("bench-controls"):
                    ui.label(column.name).classes("bench-name")
                    ui.select(list(UNITS), label="unit").bind_value(column, "unit").props(FIELD)
                    words = {place: PLACE_WORDS.get(place, place) for place in PLACES}
                    ui.select(words, label="place").bind_value(column, "place").props(FIELD)
            ui.button("Read them", on_click=self._read).props("no-caps unelevated")

    async def _read(self) -> None:
        try:
            await run.io_bound(self._draft.read)
        except InputError as error:
            self._say(str(error))
            return
        self._say("" if self._draft.pieces else "no stretch of 5 s or more was driven")
        self._show_runs()
        self._show_vehicle()
        self._show_end()

    def _show_runs(self) -> None:
        self._runs.clear()
        with self._runs:
            ui.html("Which stretches were driven, and over what", sanitize=False, tag="h3")
            ui.html(
                "<p class='soft'>The level of all channels; shaded: the stretches found. Runs that"
                " are held out judge the model that was fitted to the others.</p>",
                sanitize=False,
            )
            for file, recording in self._draft.recordings.items():
                pieces = [piece for piece in self._draft.pieces if piece.file == file]
                ui.label(file.name).classes("bench-name")
                ui.echart(_level_chart(recording, pieces)).classes("bench-level")
                for piece in pieces:
                    self._show_piece(piece)

    def _show_piece(self, piece: Piece) -> None:
        with ui.row().classes("bench-controls"):
            ui.checkbox("take").bind_value(piece, "taken")
            ui.input("name").bind_value(piece, "id").props(FIELD)
            for key, words in (("from_s", "from, s"), ("to_s", "to, s")):
                ui.number(words, step=0.5, format="%.2f").bind_value(piece, key).props(FIELD)
            ui.number("speed, km/h", min=0.1).bind_value(piece, "speed_kmph").props(FIELD)
            roles = {"fit": "fitted", "validate": "held out"}
            ui.select(roles, label="role").bind_value(piece, "role").props(FIELD)
            kind = ui.select(list(TRACKS), label="track", value=piece.kind).props(FIELD)
            fields = ui.row()

        def chosen() -> None:
            piece.choose(str(kind.value))
            fields.clear()
            with fields:
                for key in piece.track:
                    words = FIELD_WORDS.get(key, key)
                    ui.number(words).bind_value(piece.track, key).props(FIELD)

        kind.on_value_change(chosen)

    def _show_vehicle(self) -> None:
        self._vehicle.clear()
        draft = self._draft
        with self._vehicle:
            ui.html("What the vehicle is believed to be", sanitize=False, tag="h3")
            ui.html(
                "<p class='soft'>The numbers below are those of a student-built ATV: replace what"
                " you know. What you do not know may stay, if the uncertainty says so; the fit"
                " moves every number as far as it is uncertain.</p>",
                sanitize=False,
            )
            ui.number(
                "uncertainty of all numbers, one standard deviation (0.3 is 30 %)"
            ).bind_value(draft, "relative_uncertainty").props(FIELD).classes("bench-path")
            with ui.element("div").classes("bench-numbers"):
                for key in draft.vehicle:
                    words = f"{label_of(key)}, {unit_of(key)}"
                    ui.number(words).bind_value(draft.vehicle, key).props(FIELD)

    def _show_end(self) -> None:
        self._end.clear()
        with self._end:
            ui.html("Where to keep it", sanitize=False, tag="h3")
            with ui.row().classes("bench-controls"):
                title = ui.input("title", value="My campaign").props(FIELD)
                folder = ui.input("new folder", value=str(Path.home() / "wheelhop-campaign"))
                folder.props(FIELD).classes("bench-path")

                async def make() -> None:
                    target = Path(folder.value.strip()).expanduser()
                    try:
                        await run.io_bound(self._make, target, title.value.strip())
                    except InputError as error:
                        self._say(str(error))
                        return
                    self._done(target)

                ui.button("Make the campaign", on_click=make).props("no-caps unelevated")

    def _make(self, folder: Path, title: str) -> None:
        values = [*self._draft.vehicle.values(), self._draft.relative_uncertainty]
        values += [n for p in self._draft.pieces for n in (p.speed_kmph, p.from_s, p.to_s)]
        values += [n for p in self._draft.pieces for n in p.track.values()]
        if any(value is None or not isfinite(value) for value in values):
            raise InputError("a field for a number is empty: fill it in")
        self._draft.make(folder, title)


def _level_chart(recording: Recording, pieces: list[Piece]) -> dict[str, object]:
    """The rms of all channels in steps of `LEVEL_S`, the pieces shaded."""
    step = max(round(LEVEL_S * recording.rate_hz), 1)
    count = len(recording.values) // step
    blocks = recording.values[: count * step].reshape(count, step, -1)
    level = np.sqrt(blocks.var(axis=1).mean(axis=1))
    time = recording.time_s[: count * step : step]
    panel = Panel("time, s", recording.channels[0].unit, [Line("rms level", time, level, AFTER)])
    options = chart([panel], (100,), (0,))
    options["series"][0]["markArea"] = {
        "silent": True,
        "itemStyle": {"opacity": 0.12},
        "data": [[{"xAxis": p.from_s, "name": p.id}, {"xAxis": p.to_s}] for p in pieces],
    }
    return options
