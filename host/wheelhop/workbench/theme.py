"""Light, dark, or as the system has it: the report's colours, chosen on the page."""

from __future__ import annotations

import re
from importlib.resources import files

from nicegui import ui

CHOICES = {"auto": "As the system", "light": "Light", "dark": "Dark"}
ACCENT = "--q-primary: #5fb0ea;"


def theme_css() -> str:
    """The report's colours for whoever has chosen, whatever the system prefers."""
    style = (files("wheelhop.report") / "style.css").read_text(encoding="utf-8")
    light, dark = re.findall(r":root \{(.*?)\}", style, re.S)[:2]
    return (
        f':root[data-theme="light"] {{ color-scheme: light; {light} }}\n'
        f':root[data-theme="dark"] {{ {dark} }}\n'
        f':root[data-theme="dark"] :is({TINTED}) {{ {ACCENT} }}\n'
        f':root[data-theme="light"] :is({TINTED}) {{ --q-primary: #0b66a8; }}\n'
    )


TINTED = ".q-btn--outline, .q-btn--flat, .q-slider, .q-field, .q-checkbox"


def theme_menu() -> None:
    """A button with the three; the browser keeps what was chosen, for all campaigns."""
    with ui.button("Theme").props("flat dense no-caps"), ui.menu():
        for key, words in CHOICES.items():
            item = ui.menu_item(words)
            item.on("click", js_handler=f"() => wheelhop.theme({key!r})")
