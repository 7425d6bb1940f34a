"""What the views have in common."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from html import escape
from typing import Protocol

from nicegui import ui
from nicegui.elements.mixins.text_element import TextElement
from nicegui.events import GenericEventArguments

from wheelhop.campaign.change import Proposal
from wheelhop.workbench.compared import Compared

ACTED = """(event) => {
  const target = event.target.closest("[data-act]");
  if (target) emit({...target.dataset});
}"""
"""Sends what the element clicked, or one around it, says it does."""
PRESSED = """(event) => {
  const target = event.target.closest("[role=button][data-act]");
  if (!target || (event.key !== "Enter" && event.key !== " ")) return;
  event.preventDefault();
  emit({...target.dataset});
}"""
"""Sends the same when Enter or Space is pressed on what the browser does not take for a button."""


def verbatim(text: str) -> str:
    """HTML of text as it is written. Where a line is longer than the page is wide, keys scroll it,
    too."""
    return f'<pre tabindex="0">{escape(text)}</pre>'


@dataclass
class Looking:
    """What one tab of the browser looks at: what is compared (None: nothing was chosen here), and
    an effect; `go` turns to another view, `moved` has the address tell where one is, `propose`
    shows a change of the campaign's files, to be made or left."""

    go: Callable[[str], None]
    moved: Callable[[], None]
    propose: Callable[[Proposal], Awaitable[None]]
    compared: Compared | None = None
    effect: str = ""


class View(Protocol):
    """A part of the page that can be brought up to date."""

    def show(self) -> None:
        """Make what is shown fit the desk, if anything it shows has changed."""


class Words(TextElement):
    """Text in an element of its own, such as a heading: no markup, whatever it holds."""

    def __init__(self, text: str, tag: str) -> None:
        super().__init__(tag=tag, text=text)


def html(content: str = "") -> ui.html:
    """HTML of ours. Names in it are escaped where it is put together, and the browser takes out
    whatever could run before it is shown."""
    return ui.html(content, sanitize=True)


def drawn(content: str = "") -> ui.html:
    """HTML with figures of the report's, whose parts that are used twice that would take out.
    Names are escaped in it, and the page's policy lets nothing in it run."""
    return ui.html(content, sanitize=False)


def acting(element: ui.html, handle: Callable[[dict[str, str]], Awaitable[None] | None]) -> ui.html:
    """HTML of ours whose elements with data-act call `handle` with their data-… values."""

    def handled(event: GenericEventArguments) -> Awaitable[None] | None:
        return handle({key: str(value) for key, value in dict(event.args).items()})

    element.on("click", handled, js_handler=ACTED)
    return element.on("keydown", handled, js_handler=PRESSED)


def fix_buttons(fixes: Sequence[Proposal], **data: int) -> str:
    """A button for each change that is proposed."""
    values = "".join(f' data-{key}="{value}"' for key, value in data.items())
    return "".join(
        f'<button class="fix" data-act="fix" data-fix="{i}"{values}>{escape(fix.title)} …</button>'
        for i, fix in enumerate(fixes)
    )
