"""The page: what stands above all views, and the views. It holds no state of its own but what is
looked at; whenever the desk has changed, what is shown is made anew."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from html import escape
from math import isfinite

from nicegui import ui

from wheelhop.campaign import Campaign, ComponentCampaign
from wheelhop.files.words import percent, significant
from wheelhop.workbench.bench import Workbench
from wheelhop.workbench.between_view import BetweenView
from wheelhop.workbench.change_view import Changing
from wheelhop.workbench.charts import AFTER
from wheelhop.workbench.compare_view import CompareView
from wheelhop.workbench.compared import address_of, of_address
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.files_view import FilesView
from wheelhop.workbench.glossary import term
from wheelhop.workbench.missing_view import MissingView
from wheelhop.workbench.model_view import ModelView
from wheelhop.workbench.out_view import OutView
from wheelhop.workbench.overview import Overview
from wheelhop.workbench.settings_view import SettingsView
from wheelhop.workbench.struts_view import StrutsView
from wheelhop.workbench.theme import theme_menu
from wheelhop.workbench.tour import Tour
from wheelhop.workbench.vehicle_view import VehicleView
from wheelhop.workbench.view import Looking, View, Words, html
from wheelhop.workbench.where_view import WhereView

LOOK_S = 0.25
"""So often a page asks whether the desk has changed."""

SETTLED_S = 1.0
"""After that the page is on the screen, and the process that computes may take its share."""

VIEWS: tuple[tuple[str, str, Callable[[Desk, Looking], View]], ...] = (
    ("overview", "Overview", Overview),
    ("compare", "Compare", CompareView),
    ("where", "Where it fails", WhereView),
    ("struts", "Struts", StrutsView),
    ("missing", "What is missing", MissingView),
    ("settings", "Settings", SettingsView),
    ("between", "Axle to body", BetweenView),
    ("model", "The model", ModelView),
    ("vehicle", "Vehicle", VehicleView),
    ("files", "Files", FilesView),
    ("out", "Take away", OutView),
)
OWN = "/own"
THEME = "theme.css"
OWN_FILES = {
    "style.css": ("wheelhop.report", "text/css"),
    "workbench.css": ("wheelhop.workbench", "text/css"),
    THEME: ("wheelhop.workbench", "text/css"),
    "charts.js": ("wheelhop.workbench", "text/javascript"),
    "folders.js": ("wheelhop.workbench", "text/javascript"),
    "playback.js": ("wheelhop.workbench", "text/javascript"),
    "theme.js": ("wheelhop.workbench", "text/javascript"),
    "tables.js": ("wheelhop.workbench", "text/javascript"),
    "stretches.js": ("wheelhop.workbench", "text/javascript"),
}
"""The page's styles and scripts: the package they are in, and their kind."""
ASLEEP = "asleep"
"""Of panels that are not looked at. They keep their size: a chart that is shown again would else be
laid out and drawn anew."""
LOG_IN = "record"
ON_WHEELS = ("between", "vehicle")
"""Views that a component on a rig has no use for."""


def lay_out(bench: Workbench) -> None:
    """Build the page for one tab of a browser: the campaign on the bench, or how to get one."""
    for name, (_, kind) in OWN_FILES.items():
        style = f'<link rel="stylesheet" href="{OWN}/{name}">'
        ui.add_head_html(style if kind == "text/css" else f'<script src="{OWN}/{name}"></script>')
    ui.colors(primary=AFTER)
    if bench.desk is None:
        from wheelhop.workbench.start import Start  # it knows every format of recordings

        Start(bench)
    else:
        Page(bench, bench.desk)


class Page:
    """One browser tab's view of the desk."""

    def __init__(self, bench: Workbench, desk: Desk) -> None:
        self._bench, self._desk = bench, desk
        ui.page_title(f"wheelhop: {desk.campaign.title}")
        self._seen = -1
        self._fresh: set[str] = set()
        self._arriving, self._has_moved, self._client = True, False, ui.context.client
        self._changing = Changing(bench, desk)
        self._looking = Looking(self._go, self._moved, self._changing.propose)
        with ui.element("header").classes("bench-head"):
            self._top()
        self._notice = ui.element("div").classes("bench-notice").props('role="status"')
        with ui.tabs().classes("bench-tabs").props("align=left no-caps dense") as self._tabs:
            views = [view for view in VIEWS if view[0] not in useless(desk.campaign)]
            tabs = {LOG_IN: "Record", **{key: label for key, label, _ in views}}
            for key, label in tabs.items():  # in the order of the work
                ui.tab(key, label=label)
        self._tabs.on_value_change(self._turned)
        self._views: dict[str, View] = {}
        self._panels = {}
        with ui.element("div").classes("bench-main"):
            for key in tabs:
                self._panels[key] = ui.element("div").props(f"data-view={key}").classes(ASLEEP)
        self._tabs.set_value("overview")
        self._look()
        if bench.touring:
            Tour(self._go, self._end_tour)
        self._arriving = False  # from now on a view is turned to by the user
        ui.on("opened", lambda event: self._opened(str(event.args)))
        ui.on("place", lambda event: self._came(str(event.args)))
        self._client.run_javascript('emitEvent("opened", location.hash.slice(1))')
        ui.timer(SETTLED_S, desk.begin, once=True)
        ui.timer(LOOK_S, self._look)

    def _top(self) -> None:
        desk = self._desk
        with ui.element("div"):
            Words(desk.campaign.title, "h1")
            self._figures = html()
        with ui.element("div").classes("bench-work"):
            self._work = ui.label().props('role="status" aria-live="polite"')
            self._cancel = ui.button("Stop", on_click=self._give_up).props("outline dense no-caps")
            self._undo = ui.button("Undo", on_click=desk.undo).props("flat dense no-caps")
            self._redo = ui.button("Redo", on_click=desk.redo).props("flat dense no-caps")
            theme_menu()
            ui.button("Close", on_click=self._bench.clear).props("flat dense no-caps").tooltip(
                "put this campaign away and open another"
            )

    def _end_tour(self) -> None:
        self._bench.touring = False

    def _give_up(self) -> None:
        self._desk.cancel()
        self._look()

    def _go(self, view: str) -> None:
        self._tabs.set_value(view)

    def _turned(self) -> None:
        """Show the view whose tab was chosen."""
        chosen = str(self._tabs.value)
        for key, panel in self._panels.items():
            panel.classes(remove=ASLEEP) if key == chosen else panel.classes(ASLEEP)
        self._refresh(chosen)
        self._moved(turned=True)

    def _moved(self, *, turned: bool = False) -> None:
        """Have the page's address tell what is looked at; another view is a step for Back."""
        if self._arriving:
            return
        self._has_moved = True
        place = str(self._tabs.value)
        if place == "compare" and self._looking.compared is not None:
            place += f"/{address_of(self._looking.compared)}"
        self._client.run_javascript(f"wheelhop.place({json.dumps(place)}, {json.dumps(turned)})")

    def _opened(self, place: str) -> None:
        """The browser says where it was opened. A user may have clicked before that arrived."""
        if place and not self._has_moved:
            self._came(place)

    def _came(self, place: str) -> None:
        """An address was opened, or Back was pressed; the first one may name no view."""
        view, _, rest = (place or "overview").partition("/")
        if view not in self._panels:
            return
        self._arriving = True
        if view == "compare" and (state := of_address(rest, self._desk.campaign)) is not None:
            self._looking.compared = state
            self._refresh(view)
        self._tabs.set_value(view)
        self._arriving = False

    def _refresh(self, key: str) -> None:
        """Build a view, or bring it up to date."""
        self._fresh.add(key)
        if key not in self._views:
            with self._panels[key]:
                self._views[key] = self._made(key)
        self._views[key].show()

    def _made(self, chosen: str) -> View:
        if chosen == LOG_IN:
            from wheelhop.workbench.log_in_view import LogInView  # it knows every format

            return LogInView(self._bench, self._desk)
        make = next(make for key, _, make in VIEWS if key == chosen)
        return make(self._desk, self._looking)

    def _look(self) -> None:
        desk = self._desk
        if desk is not self._bench.desk:  # another campaign, or more runs: its overview comes first
            self._client.run_javascript("wheelhop.anew()")
            return
        if desk.job is not None:
            self._work.set_text(_job_words(desk))
        if desk.version == self._seen:
            self._prepare()
            return
        self._seen = desk.version
        self._fresh.clear()
        self._figures.set_content(_figures(desk))
        self._cancel.set_visibility(desk.job is not None)
        for button, can in zip((self._undo, self._redo), desk.can_go, strict=True):
            button.set_enabled(can)
        if desk.job is None:
            self._work.set_text("")
        self._notice.set_visibility(bool(desk.notice))
        self._notice.clear()
        with self._notice:
            ui.label(desk.notice)
            if desk.can_take_back:
                back = ui.button("Take it back", on_click=self._changing.take_back)
                back.props("flat dense no-caps")
        self._refresh(str(self._tabs.value))

    def _prepare(self) -> None:
        """While there is nothing else to do, one view more is made ready, so that a click finds it
        so."""
        waiting = [key for key in self._panels if key not in self._fresh and key != LOG_IN]
        if waiting:
            self._refresh(waiting[0])


def useless(campaign: Campaign) -> tuple[str, ...]:
    """The views that a campaign has no use for."""
    settings = {run.setting for run in campaign.runs if run.setting}
    alone = () if len(settings) > 1 else ("settings",)
    return (*alone, *(ON_WHEELS if isinstance(campaign, ComponentCampaign) else ()))


def _job_words(desk: Desk) -> str:
    """What is being done, for how long, and how long it may take."""
    job = desk.job
    if job is None:
        return ""
    took = time.monotonic() - job.since_s
    words = f"{job.title}: {job.line} · {took:.0f} s"
    if isfinite(job.error) and "error" not in job.line:
        words = f"{job.title}: {job.line} · E {percent(job.error)} · {took:.0f} s"
    if job.diagnosing and desk.baseline_took_s:
        low, high = 2 * desk.baseline_took_s, 15 * desk.baseline_took_s
        words += f" (usually {low:.0f} to {high:.0f} s)"
    return words


def _figures(desk: Desk) -> str:
    """The error, the floor, and the effects in the model, always in sight."""
    if not desk.rungs:
        return "<p class='soft'>The baseline has not been fitted yet.</p>"
    first, last = desk.rungs[0], desk.rungs[-1]
    fall = percent(last.error)
    if len(desk.rungs) > 1:
        fall = f"{percent(first.error)} → {fall}"
    model = " + ".join(("baseline", *last.added))
    runs = "held out" if desk.campaign.validate_runs else "fitted"
    pairs = (
        (f"error E, runs {runs}", "e", fall),
        ("noise floor", "floor", percent(last.floor)),
        ("error / floor", "floor", significant(last.over_floor)),
        ("model", "baseline", model),
    )
    items = "".join(
        f"<div><dt>{term(words, entry)}</dt><dd>{escape(value)}</dd></div>"
        for words, entry, value in pairs
    )
    return f'<dl class="key">{items}</dl>'
