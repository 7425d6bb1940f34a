"""From recordings to runs, step by step on one page: nothing has to be typed that can be guessed,
and every guess can be seen and changed."""

from __future__ import annotations

import re
from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import run, ui
from nicegui.events import GenericEventArguments, UploadEventArguments

from wheelhop.campaign.read import CONSTANTS_FILE
from wheelhop.files import InputError, make_folder
from wheelhop.files.words import label_of, unit_of
from wheelhop.vehicle.estimate import estimate
from wheelhop.workbench.asked_view import show_asked
from wheelhop.workbench.draft import PER_WHEEL, PLACES, TRACKS, Column, Draft, Piece
from wheelhop.workbench.drop_view import drop_area
from wheelhop.workbench.kept import drop, keep
from wheelhop.workbench.questions import (
    FIELD_WORDS,
    PLACE_WORDS,
    QUESTIONS,
    RECORDER_WORDS,
    TRACK_WORDS,
    known,
)
from wheelhop.workbench.stretches import stretches_html
from wheelhop.workbench.view import Words, html

FIELD = "dense outlined"
LOOK_S = 0.5
"""What was filled in longer ago is kept."""


class Guide:
    """The steps of a draft; the next one shows when the one before is done. `done` is called with
    the folder of the campaign that was made, or joined."""

    def __init__(
        self, draft: Draft, done: Callable[[Path], Awaitable[None]], say: Callable[[str], None]
    ) -> None:
        self._draft, self._done, self._say = draft, done, say
        self._shown: dict[object, object] = {}
        self._reading = False
        self._drawn: dict[Path, tuple[object, ...]] = {}
        drop_area(self._upload, say)
        self._busy = ui.label("Reading the recordings.").classes("soft").props('role="status"')
        self._anew = ui.button("Begin anew", on_click=self._forget)
        self._anew.props("flat dense no-caps").tooltip("forget these recordings and begin anew")
        self._asked = ui.element("div")
        self._columns = ui.element("div")
        self._runs = ui.element("div")
        self._vehicle = ui.element("div")
        self._end = ui.element("div")
        self._show()
        if draft.files and not draft.recordings:
            ui.timer(0.01, self._read, once=True)
        ui.timer(LOOK_S, self._look)

    async def take(self, file: Path, folder: Path) -> None:
        """One more recording; constants of the logger's sensors are looked for in `folder`."""
        draft = self._draft
        beside = [place / CONSTANTS_FILE for place in (draft.into, folder) if place is not None]
        draft.constants = next((path for path in beside if path.is_file()), draft.constants)
        begun = bool(draft.files)
        try:
            await run.io_bound(draft.add, file)
        except InputError as error:
            self._say(str(error))
            return
        if draft.asked:
            self._say("")
            self._show()
            return
        await self._read()
        if not begun:
            self._columns.run_method("scrollIntoView", {"behavior": "smooth", "block": "start"})

    async def _answer(self, said: dict[str, str]) -> None:
        """What the recording that waits does not say."""
        try:
            await run.io_bound(self._draft.answer, said)
        except InputError as error:
            self._say(str(error))
            return
        self._say("")
        if self._draft.asked:
            self._show()
        else:
            await self._read()

    async def _upload(self, event: UploadEventArguments) -> None:
        name = re.sub(r"[^\w.,() -]+", "_", Path(event.file.name).name)[-100:] or "recording.csv"
        target = self._draft.folder / name
        try:
            await run.io_bound(make_folder, target.parent)
            await event.file.save(target)
        except InputError as error:
            self._say(str(error))
            return
        except OSError as error:
            self._say(f"{target}: cannot be written: {error.strerror}")
            return
        await self.take(target, target.parent)

    async def _read(self) -> None:
        """Read what was dropped as its columns are named now; once more if they were named anew
        meanwhile."""
        if self._reading:
            return
        self._reading, named = True, None
        draft, line = self._draft, ""
        self._show()
        while named != _named(draft):
            named, line = _named(draft), ""
            try:
                await run.io_bound(draft.read)
            except InputError as error:
                line = str(error)
        if not line and not draft.pieces and draft.files:
            line = "no stretch of 5 s or more was driven: add one"
        self._reading = False
        self._say(line)
        self._show()

    def _look(self) -> None:
        """Keep what was filled in, and show what another tab has added."""
        try:
            keep(self._draft)
        except InputError as error:
            self._say(f"what is filled in here is not kept: {error}")
        self._show()

    def _show(self) -> None:
        """Every step that is due, those made anew of which there is something else to fill in."""
        draft = self._draft
        self._busy.set_visibility(self._reading)
        self._anew.set_visibility(bool(draft.files) and not self._reading)
        if self._reading:
            return
        columns = tuple((column.key, column.name) for column in draft.columns)
        pieces = tuple(id(piece) for piece in draft.pieces)
        there = bool(draft.recordings)
        due = {self._asked: bool(draft.asked), self._columns: bool(draft.columns)}
        for part, state, show in (
            (self._asked, (draft.waiting, draft.asked), self._show_asked),
            (self._columns, columns, self._show_columns),
            (self._runs, (id(draft.recordings), pieces, there), self._show_runs),
            (self._vehicle, there and draft.into is None, self._show_vehicle),
            (self._end, there, self._show_end),
        ):
            if self._shown.get(part, False) != state:
                self._shown[part] = state
                part.clear()
                if due.get(part, there):
                    show()

    async def _forget(self) -> None:
        await run.io_bound(drop, self._draft)
        self._say("")
        self._show()

    def _show_asked(self) -> None:
        with self._asked:
            show_asked(self._draft, self._answer)

    def _show_columns(self) -> None:
        draft = self._draft
        with self._columns:
            Words("What the columns are", "h3")
            ui.label(
                "As guessed from the names and units in your files: change what is wrong. Besides"
                " vertical accelerations there are travel (potentiometers), rates (gyros), forces"
                " and speeds; what is neither is not used."
            ).classes("soft")
            with ui.element("div").classes("bench-columns"):
                for column in draft.columns:
                    self._show_column(column)

    def _show_column(self, column: Column) -> None:
        with ui.row().classes("bench-controls"):
            ui.label(column.name).classes("bench-name")
            words = {place: PLACE_WORDS.get(place, place) for place in PLACES}
            place = ui.select(words, label="sits at").bind_value(column, "place")
            unit = ui.select(self._units(column), label="unit").bind_value(column, "unit")
            ratio = ui.number("per wheel travel or force").bind_value(column, "per_wheel")
            ratio.tooltip("what the sensor shows per what the wheel does: a motion ratio")
            ratio.bind_visibility_from(column, "place", lambda at: at in PER_WHEEL)
        place.on_value_change(lambda: unit.set_options(self._units(column), value=column.unit))
        for element in (place, unit, ratio):
            element.props(FIELD).on_value_change(self._read)

    def _units(self, column: Column) -> dict[str, str]:
        return {unit: unit or "not said" for unit in self._draft.units(column)}

    def _show_runs(self) -> None:
        self._drawn = {}
        with self._runs:
            Words("Which stretches were driven, and over what", "h3")
            html(
                "<p class='soft'>A bar below marks the steady part of each drive, between the ways"
                " onto the track and off it: on a track that goes on alike it becomes the run. Drag"
                " the ends to change that (arrow keys move them, too). Runs that are held out judge"
                " the model that was fitted to the others.</p>",
            )
            for file in self._draft.recordings:
                self._show_file(file)

    def _show_file(self, file: Path) -> None:
        recording = self._draft.recordings[file]
        about = f"{len(recording.channels)} channels, {recording.rate_hz:g} Hz"
        ui.label(f"{file.name}: {about}").classes("bench-name")
        drawing = html()

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
            self._show()

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
            for words, ends in (("steady part", piece.steady), ("whole drive", piece.whole)):
                if piece.steady != piece.whole:
                    button = ui.button(words, on_click=partial(_take, piece, ends))
                    button.props("flat dense no-caps")
            speed = ui.number("speed, km/h", min=0.1).bind_value(piece, "speed_kmph")
            if self._draft.tells_speed(piece):
                speed.props('placeholder="as measured" stack-label')
            speed.props(FIELD).classes("short")
            roles = {"fit": "fitted", "validate": "held out"}
            ui.select(roles, label="role").bind_value(piece, "role").props(FIELD).classes("short")
            tracks = {kind: TRACK_WORDS.get(kind, kind) for kind in TRACKS}
            kind = ui.select(tracks, label="track").bind_value(piece, "kind").props(FIELD)
            fields = ui.row().classes("bench-controls")
            if number + 1 < len(self._draft.pieces):
                down = ui.button("Fill down", on_click=partial(self._fill_down, number))
                down.props("flat dense no-caps").tooltip("this track for all stretches below")

        def show_fields() -> None:
            fields.clear()
            with fields:
                for key in piece.track:
                    _number(FIELD_WORDS.get(key, key), piece.track, key)

        def chosen() -> None:
            piece.choose(piece.kind)
            show_fields()

        show_fields()
        kind.on_value_change(chosen)

    def _fill_down(self, number: int) -> None:
        """Give every stretch below the track of this one."""
        first, *below = self._draft.pieces[number:]
        for piece in below:
            piece.choose(first.kind)
            piece.track.update(first.track)
        self._shown.pop(self._runs, None)
        self._show()

    def _show_vehicle(self) -> None:
        draft = self._draft
        with self._vehicle:
            if any(not recording.averaging_s for recording in draft.recordings.values()):
                self._show_recorder()
            Words("What you know of the vehicle", "h3")
            html(
                "<p class='soft'>Four numbers are needed; leave empty what you do not know. The"
                " rest is estimated, with a wide uncertainty, and the fit finds it.</p>",
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

    def _show_recorder(self) -> None:
        """What the files do not say of the instrument."""
        Words("What you know of the recorder", "h3")
        html(
            "<p class='soft'>Its data sheet tells; leave empty what you do not know. A recorder"
            " that averages between two samples weakens the top of the band, and the model does the"
            " same if it is told. Accelerations count upwards.</p>",
        )
        with ui.element("div").classes("bench-numbers"):
            for key, words in RECORDER_WORDS.items():
                _number(words, self._draft.recorder, key)

    def _show_end(self) -> None:
        draft = self._draft
        draft.target = draft.target or str(_free(Path.home()))
        with self._end:
            if draft.into is not None:
                Words("Take them", "h3")
                button = ui.button("Add these runs to the campaign", on_click=self._finish)
                button.props("no-caps unelevated")
                return
            Words("Where to keep it", "h3")
            with ui.row().classes("bench-controls"):
                ui.input("title").bind_value(draft, "title").props(FIELD)
                folder = ui.input("new folder").bind_value(draft, "target")
                folder.props(FIELD).classes("bench-path")
                button = ui.button("Make the campaign", on_click=self._finish)
                button.props("no-caps unelevated")

    async def _finish(self) -> None:
        draft = self._draft
        folder = draft.into or Path(draft.target.strip()).expanduser()
        try:
            if draft.into is None:
                await run.io_bound(draft.make, folder, draft.title.strip())
            else:
                await run.io_bound(draft.join, folder)
        except InputError as error:
            self._say(str(error))
            return
        await run.io_bound(drop, draft)
        await self._done(folder)


def _take(piece: Piece, ends: list[float]) -> None:
    piece.from_s, piece.to_s = ends


TYPICAL = {q.name: None for q in QUESTIONS} | {
    **{"front_kg": 130.0, "rear_kg": 160.0, "wheelbase_m": 1.4, "track_width_m": 1.2}
}
"""Only to know which numbers a vehicle has."""


def _named(draft: Draft) -> object:
    """What the columns are said to be."""
    columns = [(column.place, column.unit, column.per_wheel) for column in draft.columns]
    return columns, tuple(draft.files)


def _number(words: str, numbers: dict[str, float | None], key: str) -> None:
    """A field with its words above it, so that none is cut off."""
    with ui.element("div").classes("bench-asked"):
        ui.label(words)
        ui.number().bind_value(numbers, key).props(FIELD).props["aria-label"] = words


def _free(folder: Path) -> Path:
    """A folder that is not there yet."""
    names = ("wheelhop-campaign", *(f"wheelhop-campaign-{i}" for i in range(2, 1000)))
    return next(folder / name for name in names if not (folder / name).exists())
