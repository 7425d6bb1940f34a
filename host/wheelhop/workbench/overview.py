"""The overview: the vehicle from above, every run, every channel, and what the gate found."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from math import isfinite
from typing import Any

import numpy as np
from nicegui import ui

from wheelhop.campaign import Campaign, ComponentCampaign, RigRun, Run
from wheelhop.files.words import significant
from wheelhop.report.heat import heat_class, heat_legend, heat_words
from wheelhop.track import make_track
from wheelhop.workbench.compared import opened
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.glossary import term
from wheelhop.workbench.shown import Found, Rung
from wheelhop.workbench.view import Looking, acting, fix_buttons, html

PLACES = {"A1": (52, 66), "A2": (188, 66), "A3": (52, 254), "A4": (188, 254)}
PLACES |= {"B1": (84, 88), "B2": (156, 88), "B3": (84, 232), "B4": (156, 232)}
"""Where the eight points stand in the drawing, forward up."""
WORDS = (
    "<p class='soft'>How many times the sensors' noise the model leaves, in"
    f" {term('band')}: 1 is as good as it gets, the {term('floor')}. Click a number, a run or a"
    " sensor to look at it; a role to fit a run or to hold it out; a channel to leave it out. Grey"
    " numbers need no attention.</p>"
)
RECORDED = (
    "<p class='soft'>What was recorded: rms of every channel without its mean, in the channel’s"
    " unit. Click a number to look at it. How far the model is from it stands here once the"
    " baseline is fitted.</p>"
)
ACTIONS = (
    '<p><button class="primary" data-act="where">Where does it fail?</button>'
    ' <button class="primary" data-act="missing">What is missing?</button></p>'
)
ORDERS = ("as listed", "worst first", "by track", "by speed")
ROWS = 100  # of runs at a time
PROFILE_M = 6.0  # of a track, in its small drawing


class Overview:
    """The first thing to see."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk, self._looking = desk, looking
        self._first = 0  # of the runs on this page of the table
        self._seen: object = None
        self._on_rig = isinstance(desk.campaign, ComponentCampaign)
        self._findings = acting(html(), self._fix)
        self._found: tuple[Found, ...] = ()
        with ui.element("div").classes("" if self._on_rig else "bench-split"):
            self._plan = acting(html(), self._act)
            with ui.element("div"):
                with ui.row().classes("bench-controls"):
                    orders = list(ORDERS if not self._on_rig else ORDERS[:2])
                    self._order: Any = ui.select(orders, label="order", value=ORDERS[0])
                    self._find: Any = ui.input("find runs").props("clearable")
                    for field in (self._order, self._find):
                        field.props("dense options-dense").on_value_change(self._sorted_anew)
                self._runs = acting(html(), self._act)

    def show(self) -> None:
        """Bring it up to date."""
        desk = self._desk
        rung = desk.rungs[-1] if desk.rungs else None
        criticism = desk.diagnosis.findings if desk.diagnosis else ()
        asked = (self._order.value, self._find.value)
        seen = (rung, desk.choice, desk.findings, criticism, self._first, asked)
        if seen == self._seen:
            return
        self._seen = seen
        self._plan.set_content("" if self._on_rig else plan(desk.campaign, rung))
        words = RECORDED if rung is None else heat_legend() + WORDS
        self._runs.set_content(self._table(rung) + words + ACTIONS)
        self._found = found = (*desk.findings, *criticism)
        items = "".join(
            f"<li><strong>{escape(each.severity)}</strong> {escape(each.text)}"
            f" {fix_buttons(each.fixes, finding=i)}</li>"
            for i, each in enumerate(found)
        )
        heading = "<h2>Before you believe it</h2>"
        self._findings.set_content(f"<section>{heading}<ul>{items}</ul></section>" if found else "")

    async def _fix(self, data: dict[str, str]) -> None:
        fixes = self._found[int(data["finding"])].fixes
        await self._looking.propose(fixes[int(data["fix"])])

    def _act(self, data: dict[str, str]) -> None:
        desk, runs = self._desk, self._desk.campaign.runs
        run = runs[int(data["run"])] if "run" in data else None
        match data["act"]:
            case "look":
                self._look_at(data)
            case "leave run" if run is not None:
                desk.toggle_run(run.id)
            case "role" if run is not None:
                now = desk.choice.role_of(run)
                desk.set_role(run.id, "fit" if now == "validate" else "validate")
            case "page":
                self._first = int(data["first"])
                self.show()
            case "where" | "missing" as view:
                self._looking.go(view)
            case "leave channel":
                desk.toggle_channel(desk.campaign.channels[int(data["channel"])].name)

    def _look_at(self, data: dict[str, str]) -> None:
        """Compare a run, a channel or both; of what was not clicked, where that fails worst."""
        campaign = self._desk.campaign
        roles = {run.id: self._desk.choice.role_of(run) for run in campaign.runs}
        state = self._looking.compared or opened(campaign, self._desk.rungs, roles)
        run = campaign.runs[int(data["run"])].id if "run" in data else None
        channel = campaign.channels[int(data["channel"])].name if "channel" in data else None
        self._looking.compared = state.at(run, channel)
        self._looking.go("compare")

    def _table(self, rung: Rung | None) -> str:
        campaign = self._desk.campaign
        left_out = self._desk.choice.without_channels
        heads = "".join(
            f'<th class="r">{_button("leave channel", c.name, c.name in left_out, channel=i)}</th>'
            for i, c in enumerate(campaign.channels)
        )
        every = self._in_order(rung)
        shown = every[self._first : self._first + ROWS]
        rows = [self._row(i, campaign.runs[i], rung) for i in shown]
        drive = "" if self._on_rig else "<th>track</th><th>km/h</th>"
        pages = _pages(self._first, len(shown), len(every))
        return (
            f'<div class="scroll"><table class="heat runs"><thead><tr><th>run</th>{drive}'
            f"<th>role</th>{heads}<th></th></tr></thead>"
            f"<tbody>{''.join(rows)}</tbody></table></div>{pages}"
        )

    def _sorted_anew(self) -> None:
        self._first = 0
        self.show()

    def _in_order(self, rung: Rung | None) -> list[int]:
        """The runs that are asked for, in the order that is."""
        runs, wanted = self._desk.campaign.runs, str(self._find.value or "").lower()
        found = [i for i, run in enumerate(runs) if wanted in run.id.lower()]
        if self._order.value == ORDERS[1]:
            found.sort(key=lambda i: -_worst(rung, runs[i]))
        elif self._order.value == ORDERS[2]:
            found.sort(key=lambda i: (runs[i].track.kind, runs[i].speed_m_s))
        elif self._order.value == ORDERS[3]:
            found.sort(key=lambda i: runs[i].speed_m_s)
        return found

    def _row(self, i: int, run: Run, rung: Rung | None) -> str:
        choice = self._desk.choice
        out = run.id in choice.without_runs
        role = choice.role_of(run)
        cells = "".join(
            _cell(rung, run, channel.name, i, k)
            for k, channel in enumerate(self._desk.campaign.channels)
        )
        speed = f'<td class="r">{run.speed_m_s * 3.6:.3g}</td>'
        drive = "" if self._on_rig else f"<td>{_profile(run)}</td>{speed}"
        words = "fitted" if role == "fit" else "held out"
        leave = _button("leave run", "take in" if out else "leave out", False, run=i)
        return (
            f'<tr{" class=out" if out else ""}><td class="name">'
            f"{_button('look', run.id, out, run=i)}</td>{drive}"
            f"<td>{_button('role', words, False, run=i)}</td>"
            f"{cells}<td>{leave}</td></tr>"
        )


def _pages(first: int, shown: int, count: int) -> str:
    """From one page of a long table to the next."""
    if count <= ROWS:
        return ""
    steps = ((first - ROWS, "earlier runs"), (first + ROWS, "later runs"))
    buttons = " ".join(
        f'<button data-act="page" data-first="{first}">{words}</button>'
        for first, words in steps
        if 0 <= first < count
    )
    return f"<p class='soft'>runs {first + 1} to {first + shown} of {count} {buttons}</p>"


def _button(act: str, text: str, struck: bool, **data: int) -> str:
    """A button that says what it does; struck through for what is left out."""
    values = "".join(f' data-{key}="{value}"' for key, value in data.items())
    tip = {
        "look": "compare measured and modelled",
        "role": "fit this run, or hold it out",
        "leave channel": "leave this channel out, or take it in",
        "leave run": "leave this run out, or take it in",
    }[act]
    kind = ' class="out"' if struck else ""
    return f'<button data-act="{act}"{values}{kind} title="{tip}">{escape(text)}</button>'


def _cell(rung: Rung | None, run: Run, channel: str, i: int, k: int) -> str:
    """Residual over floor; before anything is fitted the rms of what was recorded."""
    ratio = _ratio(rung, run.id, channel)
    words = heat_words(ratio)
    if rung is None and len(run.time_s):
        words = significant(float(run.record[:, k].std()), 2)
    act = f'<button data-act="look" data-run="{i}" data-channel="{k}"'
    label = f'aria-label="{escape(run.id)}, {escape(channel)}"'
    return f'<td class="{heat_class(ratio)}">{act} {label}>{words}</button></td>'


def _ratio(rung: Rung | None, run: str, channel: str) -> float:
    if rung is None or run not in rung.runs or channel not in rung.channels:
        return float("nan")
    return float(rung.ratio[rung.runs.index(run), rung.channels.index(channel)])


def plan(campaign: Campaign, rung: Rung | None) -> str:
    """The vehicle from above, every sensor coloured by residual over floor of all its runs."""
    parts = [
        '<svg class="plan" viewBox="0 0 240 320" role="group" aria-label="vehicle from above">',
        '<path class="shape" d="M92 40 q28 -16 56 0 l14 60 v130 l-12 40 q-30 14 -60 0 l-12 -40'
        ' v-130 z"/>',
        '<text class="soft" x="120" y="16" text-anchor="middle">forward ↑</text>',
    ]
    for x, y in ((30, 46), (192, 46), (30, 234), (192, 234)):
        parts.append(f'<rect class="wheel" x="{x}" y="{y}" width="18" height="40" rx="5"/>')
    for k, channel in enumerate(campaign.channels):
        if channel.point in PLACES:
            parts.append(_point(channel.name, channel.point, k, rung))
    others = [c.name for c in campaign.channels if c.point not in PLACES]
    words = f"also: {', '.join(others)}" if others else ""
    return "".join(parts) + f'</svg><p class="soft">{escape(words)}</p>'


def _point(name: str, point: str, k: int, rung: Rung | None) -> str:
    x, y = PLACES[point]
    ratio = _over_runs(rung, name)
    words = heat_words(ratio)
    return (
        f'<g data-act="look" data-channel="{k}" tabindex="0" role="button"'
        f' aria-label="{escape(name)}: {words} times the floor">'
        f'<circle class="{heat_class(ratio) or "hx"}" cx="{x}" cy="{y}" r="15"/>'
        f'<text class="on {heat_class(ratio) or "hx"}" x="{x}" y="{y + 4}" text-anchor="middle">'
        f"{escape(point)}</text>"
        f'<text class="soft" x="{x}" y="{y + 28}" text-anchor="middle">{words}</text></g>'
    )


def _worst(rung: Rung | None, run: Run) -> float:
    """The largest residual over floor of a run; before anything is fitted the largest motion."""
    if rung is None:
        return float(run.record.std(axis=0).max()) if len(run.time_s) else 0.0
    if run.id not in rung.runs:
        return -1.0
    ratios = rung.ratio[rung.runs.index(run.id)]
    return float(np.nanmax(ratios)) if np.isfinite(ratios).any() else -1.0


def _over_runs(rung: Rung | None, name: str) -> float:
    """Residual over floor of one channel: the rms of its runs."""
    if rung is None or name not in rung.channels:
        return float("nan")
    column = rung.ratio[:, rung.channels.index(name)]
    known = column[np.isfinite(column)]
    return float(np.sqrt((known**2).mean())) if len(known) else float("nan")


def _profile(run: Run) -> str:
    """The first metres of a run's track under the left wheels, as a small drawing."""
    if isinstance(run, RigRun) or run.track.kind == "unknown":
        return ""
    track = make_track(run.track)
    begin = track.start_m if isfinite(track.start_m) else 0.0
    x = np.linspace(begin, begin + PROFILE_M, 240)
    z = track.elevation(x, 0.5)
    return _sparkline(x, z, run.track.kind)


def _sparkline(x: Sequence[float] | np.ndarray, z: np.ndarray, name: str) -> str:
    low, high = float(np.min(z)), float(np.max(z))
    span = max(high - low, 1e-6)
    px = np.linspace(1, 79, len(x))
    py = 16 - 13 * (np.asarray(z) - low) / span
    path = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(px, py, strict=True))
    tip = f"{name}, {span * 1e3:.0f} mm from trough to crest, {PROFILE_M:g} m shown"
    return (
        f'<svg class="spark" viewBox="0 0 80 18" role="img"><title>{escape(tip)}</title>'
        f'<polyline points="{path}"/></svg>'
    )
