"""From recordings to runs, step by step on one page: nothing has to be typed that can be guessed,
and every guess can be seen and changed."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from nicegui import run, ui
from nicegui.events import GenericEventArguments, UploadEventArguments

from wheelhop.campaign.read import CONSTANTS_FILE
from wheelhop.files import InputError
from wheelhop.files.words import label_of, unit_of
from wheelhop.vehicle.estimate import estimate
from wheelhop.workbench.draft import PLACES, TRACKS, UNITS, Draft, Piece
from wheelhop.workbench.questions import QUESTIONS, known
from wheelhop.workbench.stretches import stretches_html

FIELD = "dense outlined"
ENDINGS = (
    *(".csv", ".txt", ".tsv", ".dat", ".asc", ".mf4", ".tdms", ".uff", ".unv", ".lvm", ".hop"),
    ".parquet",
)
TAKEN = (
    "CSV or text of any layout, MDF4, TDMS, UFF, LVM, Parquet, or the logger's .HOP. They must hold"
    " vertical accelerations of axles or body."
)
DROPPED = "(event) => runMethod(ID, 'addFiles', [event.dataTransfer.files])"
CORNERS = ("front left", "front right", "rear left", "rear right")
PLACE_WORDS = {
    **{f"A{i}": f"A{i}: axle, {corner}" for i, corner in enumerate(CORNERS, start=1)},
    **{f"B{i}": f"B{i}: body, {corner}" for i, corner in enumerate(CORNERS, start=1)},
    "body": "body, place not known",
}
TRACK_WORDS = {
    "washboard": "washboard: waves across the track",
    "one-sided-washboard": "washboard under the left wheels only",
    "herringbone": "herringbone: waves at an angle",
    "chassis-twist": "chassis twist: left and right in antiphase",
    "sine-sweep": "sine sweep: waves that grow shorter",
    "half-sine-bump": "one bump, half a sine",
    "step-bump": "one bump, a step",
    "flat": "flat ground",
    "unknown": "not surveyed: a lawn, a trail",
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
    """The steps of a draft; the next one shows when the one before is done. `done` is called with
    the folder of the campaign that was made, or joined."""

    def __init__(
        self, draft: Draft, done: Callable[[Path], None], say: Callable[[str], None]
    ) -> None:
        self._draft, self._done, self._say = draft, done, say
        self._uploads = tempfile.TemporaryDirectory(prefix="wheelhop-", ignore_cleanup_errors=True)
        self._drawn: dict[Path, tuple[object, ...]] = {}
        upload = ui.upload(multiple=True, auto_upload=True, on_upload=self._upload)
        upload.props(f'accept="{",".join(ENDINGS)}"').classes("hidden")
        button = ui.element("button").classes("bench-drop")
        button.on("click", js_handler=f"() => runMethod({upload.id}, 'pickFiles', [])")
        button.on("dragover.prevent", js_handler="() => {}")
        button.on("drop.prevent", js_handler=DROPPED.replace("ID", str(upload.id)))
        with button:
            ui.html(
                "<strong>Drop recordings here, or press to choose them</strong>", sanitize=False
            )
            ui.label(TAKEN)
        self._columns = ui.element("div")
        self._runs = ui.element("div")
        self._vehicle = ui.element("div")
        self._end = ui.element("div")
        if draft.files:
            self._show_columns()
        if draft.recordings:
            self._show_rest()

    async def take(self, file: Path, folder: Path) -> None:
        """One more recording; constants of the logger's sensors are looked for in `folder`."""
        draft = self._draft
        beside = [place / CONSTANTS_FILE for place in (draft.into, folder) if place is not None]
        draft.constants = next((path for path in beside if path.is_file()), draft.constants)
        try:
            await run.io_bound(draft.add, file)
        except InputError as error:
            self._say(str(error))
            return
        self._say("")
        self._show_columns()
        if draft.all_placed:
            await self._read()

    async def _upload(self, event: UploadEventArguments) -> None:
        name = re.sub(r"[^\w.()-]+", "_", Path(event.file.name).name)[-100:] or "recording.csv"
        target = Path(self._uploads.name) / name
        await event.file.save(target)
        await self.take(target, target.parent)

    def _show_columns(self) -> None:
        self._columns.clear()
        draft = self._draft
        if not draft.columns:
            return
        with self._columns:
            names = ", ".join(file.name for file in draft.files)
            ui.html("What the columns are", sanitize=False, tag="h3")
            ui.label(f"As guessed from the names in {names}: change what is wrong.").classes("soft")
            with ui.element("div").classes("bench-columns"):
                for column in draft.columns:
                    with ui.row().classes("bench-controls"):
                        ui.label(column.name).classes("bench-name")
                        words = {place: PLACE_WORDS.get(place, place) for place in PLACES}
                        ui.select(words, label="sits at").bind_value(column, "place").props(FIELD)
                        ui.select(list(UNITS), label="unit").bind_value(column, "unit").props(FIELD)
            ui.button("Read them", on_click=self._read).props("no-caps unelevated")

    async def _read(self) -> None:
        try:
            await run.io_bound(self._draft.read)
        except InputError as error:
            self._say(str(error))
            return
        self._say("" if self._draft.pieces else "no stretch of 5 s or more was driven: add one")
        self._show_rest()

    def _show_rest(self) -> None:
        self._show_runs()
        if self._draft.into is None:
            self._show_vehicle()
        self._show_end()
        self._runs.run_method("scrollIntoView", {"behavior": "smooth", "block": "nearest"})

    def _show_runs(self) -> None:
        self._runs.clear()
        self._drawn = {}
        with self._runs:
            ui.html("Which stretches were driven, and over what", sanitize=False, tag="h3")
            ui.html(
                "<p class='soft'>Drag the ends to where the speed was steady (arrow keys move them,"
                " too). Runs that are held out judge the model that was fitted to the others.</p>",
                sanitize=False,
            )
            for file in self._draft.recordings:
                self._show_file(file)

    def _show_file(self, file: Path) -> None:
        recording = self._draft.recordings[file]
        about = f"{len(recording.channels)} channels, {recording.rate_hz:g} Hz"
        ui.label(f"{file.name}: {about}").classes("bench-name")
        drawing = ui.html("", sanitize=False)

        def moved(event: GenericEventArguments) -> None:
            found = event.args["detail"]
            piece = self._draft.pieces[int(found["piece"])]
            piece.from_s, piece.to_s = float(found["from_s"]), float(found["to_s"])
            self._drawn[file] = self._state(file)

        def draw() -> None:
            if self._drawn.get(file) != self._state(file):
                self._drawn[file] = self._state(file)
                drawing.set_content(stretches_html(recording, self._pieces(file)))

        def more() -> None:
            self._draft.new_piece(file)
            self._show_runs()

        drawing.on("stretch", moved, args=["detail"])
        draw()
        for number, piece in self._pieces(file):
            self._show_piece(number, piece, draw)
        ui.button("Add a stretch", on_click=more).props("flat dense no-caps")

    def _pieces(self, file: Path) -> list[tuple[int, Piece]]:
        return [(i, piece) for i, piece in enumerate(self._draft.pieces) if piece.file == file]

    def _state(self, file: Path) -> tuple[object, ...]:
        return tuple((p.from_s, p.to_s, p.id, p.taken) for _, p in self._pieces(file))

    def _show_piece(self, number: int, piece: Piece, draw: Callable[[], None]) -> None:
        with ui.row().classes("bench-controls bench-piece"):
            bound: list[Any] = [
                ui.checkbox(f"{number + 1}").tooltip("take it, or not").bind_value(piece, "taken"),
                ui.input("name").bind_value(piece, "id").props(FIELD),
            ]
            for key, words in (("from_s", "from, s"), ("to_s", "to, s")):
                end = ui.number(words, step=0.5, format="%.2f").bind_value(piece, key)
                bound.append(end.props(FIELD).classes("short"))
            for element in bound:
                element.on_value_change(draw)
            speed = ui.number("speed, km/h", min=0.1).bind_value(piece, "speed_kmph")
            speed.props(FIELD).classes("short")
            roles = {"fit": "fitted", "validate": "held out"}
            ui.select(roles, label="role").bind_value(piece, "role").props(FIELD).classes("short")
            tracks = {kind: TRACK_WORDS.get(kind, kind) for kind in TRACKS}
            kind = ui.select(tracks, label="track", value=piece.kind).props(FIELD)
            fields = ui.row().classes("bench-controls")

        def show_fields() -> None:
            fields.clear()
            with fields:
                for key in piece.track:
                    _number(FIELD_WORDS.get(key, key), piece.track, key)

        def chosen() -> None:
            piece.choose(str(kind.value))
            show_fields()

        show_fields()
        kind.on_value_change(chosen)

    def _show_vehicle(self) -> None:
        self._vehicle.clear()
        draft = self._draft
        with self._vehicle:
            ui.html("What you know of the vehicle", sanitize=False, tag="h3")
            ui.html(
                "<p class='soft'>Four numbers are needed; leave empty what you do not know. The"
                " rest is estimated, with a wide uncertainty, and the fit finds it.</p>",
                sanitize=False,
            )
            with ui.element("div").classes("bench-numbers"):
                for question in QUESTIONS:
                    unit = f", {question.unit}" if question.unit else ""
                    need = " (needed)" if question.needed else ""
                    _number(f"{question.words}{unit}{need}", draft.answers, question.name)
            more = ui.expansion("Numbers you know better than an estimate").classes("bench-better")
            with more, ui.element("div").classes("bench-numbers"):
                for key in estimate(known("any", TYPICAL)):
                    draft.better.setdefault(key, None)
                    _number(f"{label_of(key)}, {unit_of(key)}", draft.better, key)

    def _show_end(self) -> None:
        self._end.clear()
        into = self._draft.into
        with self._end:
            if into is not None:
                ui.html("Take them", sanitize=False, tag="h3")
                button = ui.button("Add these runs to the campaign", on_click=self._join)
                button.props("no-caps unelevated")
                return
            ui.html("Where to keep it", sanitize=False, tag="h3")
            with ui.row().classes("bench-controls"):
                title = ui.input("title", value="My campaign").props(FIELD)
                folder = ui.input("new folder", value=str(_free(Path.home())))
                folder.props(FIELD).classes("bench-path")

                async def make() -> None:
                    target = Path(folder.value.strip()).expanduser()
                    try:
                        await run.io_bound(self._draft.make, target, title.value.strip())
                    except InputError as error:
                        self._say(str(error))
                        return
                    self._done(target)

                ui.button("Make the campaign", on_click=make).props("no-caps unelevated")

    async def _join(self) -> None:
        into = self._draft.into
        assert into is not None
        try:
            await run.io_bound(self._draft.join, into)
        except InputError as error:
            self._say(str(error))
            return
        self._done(into)


TYPICAL = {q.name: None for q in QUESTIONS} | {
    **{"front_kg": 130.0, "rear_kg": 160.0, "wheelbase_m": 1.4, "track_width_m": 1.2}
}
"""Only to know which numbers a vehicle has."""


def _number(words: str, numbers: dict[str, float | None], key: str) -> None:
    """A field with its words above it, so that none is cut off."""
    with ui.element("div").classes("bench-asked"):
        ui.label(words)
        ui.number().bind_value(numbers, key).props(FIELD).props["aria-label"] = words


def _free(folder: Path) -> Path:
    """A folder that is not there yet."""
    names = ("wheelhop-campaign", *(f"wheelhop-campaign-{i}" for i in range(2, 1000)))
    return next(folder / name for name in names if not (folder / name).exists())
