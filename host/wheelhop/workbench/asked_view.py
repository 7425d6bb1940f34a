"""What a recording does not say, asked on the page in the words of `wheelhop import`."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui import ui

from wheelhop.formats.mapping import ASKED
from wheelhop.workbench.draft import Draft
from wheelhop.workbench.view import Words


def show_asked(draft: Draft, answered: Callable[[dict[str, str]], Awaitable[None]]) -> None:
    """A field for each question of the file that waits; `answered` takes what was filled in, by the
    questions' keys."""
    assert draft.waiting is not None
    filled: dict[str, ui.input] = {}

    async def read() -> None:
        await answered({key: field.value.strip() for key, field in filled.items()})

    Words(f"What {draft.waiting.name} does not say", "h3")
    for question in draft.asked:
        ui.label(question.words)
        field = ui.input(ASKED[question.key]).props("dense outlined").classes("w-96")
        field.on("keydown.enter", read)
        field.props["aria-label"] = f"{question.key}: {ASKED[question.key]}"
        filled[question.key] = field
    ui.button("Read it so", on_click=read).props("no-caps")
