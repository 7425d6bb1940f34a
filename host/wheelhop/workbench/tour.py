"""A guided tour on an example: what to look at, view by view, in some three minutes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from nicegui import ui

from wheelhop.workbench.view import Words

EXAMPLE = "open-dry-friction"


@dataclass(frozen=True)
class Stop:
    """One stop: the view it is on, its heading, and what to see."""

    view: str
    title: str
    words: str


STOPS = (
    Stop(
        "overview",
        "A campaign",
        "One vehicle, eight sensors, eighteen drives over known tracks. A number says how many"
        " times the sensors’ noise the fitted model leaves in that channel of that run: 1 is as"
        " good as it gets. Here it is 20: something is missing.",
    ),
    Stop(
        "compare",
        "Measured and modelled",
        "Where it fails worst. Thick and grey is what was measured, orange what the model makes of"
        " the same track, below them what is left. Turn the wheel to zoom, drag to move.",
    ),
    Stop(
        "where",
        "Where it fails",
        "The same residual by run and channel, by frequency and by motion. Its pattern says which"
        " part of the vehicle to suspect.",
    ),
    Stop(
        "missing",
        "What is missing",
        "Press Find out what is missing. Every effect of the library is tried; the ranking fills in"
        " within a minute or two. The verdict then says what is missing in newtons, how sure that"
        " is, and what to do next.",
    ),
    Stop(
        "missing",
        "Add it",
        "Press Add … to the model on the verdict. The error above falls, to the noise floor if"
        " nothing else is missing. Undo takes it back.",
    ),
    Stop(
        "model",
        "The model",
        "The ladder: the error of the baseline and of the model with what was added, down to the"
        " floor. Below it every number, with its interval and how far the fit moved it.",
    ),
    Stop(
        "out",
        "Take away",
        "The report, a summary on one page, tables, signals and a script that comes to the same."
        " That is all: Close, and drop your own recordings.",
    ),
)


class Tour:
    """A card that leads from stop to stop; `go` turns to a view."""

    def __init__(self, go: Callable[[str], None], ended: Callable[[], None]) -> None:
        self._go, self._ended, self._at = go, ended, 0
        self._card = ui.element("aside").classes("bench-tour").props('aria-label="guided tour"')
        self._show()

    def _show(self) -> None:
        stop = STOPS[self._at]
        self._card.clear()
        with self._card:
            ui.label(f"{self._at + 1} of {len(STOPS)}").classes("soft")
            Words(stop.title, "h3")
            Words(stop.words, "p").props('role="status"')
            with ui.row():
                back = ui.button("Back", on_click=lambda: self._step(-1)).props("flat no-caps")
                back.set_enabled(self._at > 0)
                if self._at + 1 < len(STOPS):
                    following = ui.button("Next", on_click=lambda: self._step(1))
                    following.props("no-caps unelevated")
                ui.button("End the tour", on_click=self._end).props("flat no-caps")
        self._go(stop.view)

    def _step(self, by: int) -> None:
        self._at += by
        self._show()

    def _end(self) -> None:
        self._card.delete()
        self._ended()
