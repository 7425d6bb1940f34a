"""What is missing: the ranking as it fills in, a card for every effect, and the button that adds
it."""

from __future__ import annotations

from html import escape

from nicegui import ui

from wheelhop.campaign import ComponentCampaign
from wheelhop.files.words import listed
from wheelhop.report.page import QUESTIONS, bullets, facts
from wheelhop.workbench.charts import AFTER, BEFORE, MEASURED, WHOLE, Line, Panel, chart
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.gallery import picture_of
from wheelhop.workbench.own_effects import OwnEffects
from wheelhop.workbench.ranking_view import RankingView
from wheelhop.workbench.shown import CanShow, Card, Case, Law, Ranking, Row, Trace, Verdict
from wheelhop.workbench.view import Looking, acting, drawn, fix_buttons, html, verbatim

SHOWN_S = 2.5
"""So much of a run is drawn on a card, around the largest signature."""

FIRST = "Every effect below is tried. Any of them can be added by hand: open its card."
WORKING = (
    "Every effect of the library is tried; the ranking fills in below. You may look elsewhere"
    " meanwhile, or press Stop above."
)
STOPPED = "Stopped before the end: this is what was found until then."
NONE = (
    "<h3>none</h3><p>No effect of the library shows in what the model leaves, beyond the noise.</p>"
    "<p>That is no proof that nothing is there: below the strengths in this list these runs would"
    " not have shown it.</p>"
)
UNKNOWN = (
    "<h3>unknown</h3><p>Something is at work, and no effect of the library is confirmed as its"
    " cause.</p>"
    "<p>Look where it fails: the band and the motion say where to search. Or let the force that is"
    " missing be found in free form, as a curve and as a formula: that takes a minute or more.</p>"
    '<p><button class="primary" data-act="law">Find the missing force</button></p>'
)
FORCE = (
    '<p class="soft"><button data-act="law">Find the force that is missing</button> in free form,'
    " as a curve and as a formula: that takes a minute or more.</p>"
)
NOT_DRAWN = "Its signature is drawn when you find out again."
NOT_IN_RESIDUAL = "What is left of these runs holds nothing of its signature."


class MissingView:
    """The diagnosis while it runs and after."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk, self._looking = desk, looking
        self._seen: object = None
        self._drawn: object = None
        self._on_rig = isinstance(desk.campaign, ComponentCampaign)
        with ui.row().classes("bench-controls"):
            self._start = ui.button("Find out what is missing", on_click=desk.diagnose)
            self._start.props("no-caps unelevated")
            ask = "What can these channels show?"
            self._foresee = ui.button(ask, on_click=lambda: desk.find("foresee"))
            self._foresee.props("no-caps outline")
            self._hint = ui.label().classes("soft")
        with ui.element("div").classes("bench-verdict"):
            self._verdict = acting(html(), self._act)
            self._case = ui.echart({}).classes("bench-trace")
        self._law = drawn()
        with ui.element("div").classes("bench-split wide"):
            with ui.element("div"):
                self._table = RankingView(self._choose)
                OwnEffects(desk)
            self._aside = ui.element("aside").classes("card")
            with self._aside:
                self._card = acting(drawn(), self._act)
                self._chart = ui.echart({}).classes("bench-trace")

    def show(self) -> None:
        """Bring it up to date."""
        desk = self._desk
        ranking, diagnosis = desk.ranking, desk.diagnosis
        diagnosing = self._diagnosing
        self._start.set_enabled(not diagnosing)
        can_show = desk.beside(CanShow)
        self._foresee.set_visibility(ranking is None and not self._on_rig)
        self._foresee.set_enabled(desk.job is None)
        seen = (ranking, diagnosis, desk.choice, diagnosing, tuple(desk.cards), can_show)
        if seen != self._seen:
            self._seen = seen
            self._verdict.set_content("" if diagnosing else self._verdict_html())
            case = None if diagnosing or diagnosis is None else diagnosis.case
            self._case.set_visibility(case is not None)
            if case is not None:
                self._case.options.update(_case_chart(case))
                self._case.update()
            if ranking is None:
                self._table.show_library(desk.cards, can_show)
            else:
                verdict = self._verdict_now
                accepted = verdict.effects if verdict else ()
                self._table.show_ranking(ranking, accepted, settled=self._settled)
            found = "" if diagnosis else STOPPED if ranking else FIRST
            self._hint.set_text(WORKING if diagnosing else found)
        law = desk.beside(Law)
        self._law.set_content(_law_html(law) if law is not None else "")
        self._show_card(ranking)

    @property
    def _verdict_now(self) -> Verdict | None:
        return self._desk.diagnosis.verdict if self._desk.diagnosis else None

    def _verdict_html(self) -> str:
        verdict = self._verdict_now
        if verdict is None:
            return ""
        missing = [e for e in verdict.effects if e not in ("none", "unknown")]
        left = [e for e in missing if e not in self._desk.choice.added]
        known = missing and not left
        head = f"In the model now: {listed(missing)}" if known else verdict.headline
        label = f"Add {escape(' and '.join(left))} to the model"
        add = f'<p><button class="primary" data-act="add all">{label}</button></p>' if left else ""
        add += f"<p>{fix_buttons(verdict.fixes)}</p>" if verdict.fixes else ""
        look = '<p><button class="primary" data-act="look">Look at it in Compare</button></p>'
        told = verdict.answers or not verdict.next_run
        following = "" if told else f"<p>To record next: {escape(verdict.next_run)}</p>"
        extra = {"none": NONE, "unknown": UNKNOWN}.get(verdict.effects[-1], FORCE)
        numbers = f'<p class="numbers">{escape(verdict.numbers)}</p>' if verdict.numbers else ""
        return (
            f'<section class="verdict"><h2>{escape(head)}</h2>{numbers}'
            f"{add}{look if known else ''}{_answers(verdict)}{following}{extra}"
            f"<details><summary>Why</summary>{bullets(verdict.explanation)}</details>"
            f"{_limits(verdict)}</section>"
        )

    @property
    def _settled(self) -> bool:
        """Whether every effect worth it was simulated in full."""
        return self._desk.diagnosis is not None and not self._diagnosing

    @property
    def _diagnosing(self) -> bool:
        return self._desk.job is not None and self._desk.job.diagnosing

    def _show_card(self, ranking: Ranking | None) -> None:
        rows = {row.effect: row for row in ranking.rows} if ranking else {}
        verdict = self._verdict_now
        nothing = verdict is not None and verdict.effects == ("none",)
        first = next(iter(rows or self._desk.cards), "")
        chosen = self._looking.effect or ("" if nothing else first)
        row, card = rows.get(chosen), self._desk.cards.get(chosen)
        trace = ranking.traces.get(chosen) if ranking else None
        absent = NOT_IN_RESIDUAL if ranking and ranking.traces else NOT_DRAWN
        drawn = (row, card, trace, absent, self._desk.choice.added)
        if drawn == self._drawn:
            return
        self._drawn = drawn
        self._aside.set_visibility(row is not None or card is not None)
        self._card.set_content(self._card_html(card, row, trace, absent) if row or card else "")
        self._chart.set_visibility(trace is not None)
        if trace is not None:
            self._chart.options.update(_trace_chart(trace))
            self._chart.update()

    def _card_html(
        self, card: Card | None, row: Row | None, trace: Trace | None, absent: str
    ) -> str:
        name = card.effect if card else row.effect if row else ""
        parts = [f"<h3>{escape(name)}</h3>"]
        if name in self._desk.choice.added:
            parts.append('<p class="soft">It is part of the model.</p>')
        elif card and (row is None or row.screened is not None):
            label = f"Add {escape(name)} to the model"
            parts.append(
                f'<p><button class="primary" data-act="add" data-effect="{escape(name)}">{label}'
                "</button></p>"
            )
        if card:
            title = f"{card.title[:1].upper()}{card.title[1:]}"
            parts.append(f"<p>{escape(title)} ({escape(card.place)}).</p>")
            parts.append(f'<p class="equation">{card.equation}</p>')
        if row:
            parts.append(f"<p>{escape(row.reason[:1].upper() + row.reason[1:])}.</p>")
            if row.near:
                parts.append(f"<p>Hard to tell from {escape(', '.join(row.near))}.</p>")
        if card:
            parts.append(f'<p class="soft">Source: {escape(card.source)}.</p>')
            parts.append(_gallery(name))
        if trace:
            parts.append(
                f"<p class='soft'>What it would make of the residual, to first order, where that"
                f" shows best: {escape(trace.channel)} in {escape(trace.run)}.</p>"
            )
        elif row and row.screened is not None:
            parts.append(f"<p class='soft'>{absent}</p>")
        return "".join(parts)

    def _choose(self, effect: str) -> None:
        self._looking.effect = effect
        self.show()

    async def _act(self, data: dict[str, str]) -> None:
        desk = self._desk
        match data["act"]:
            case "fix" if self._verdict_now is not None:
                await self._looking.propose(self._verdict_now.fixes[int(data["fix"])])
            case "add":
                desk.add(data["effect"])
            case "look":
                self._looking.go("compare")
            case "law":
                desk.find("law")
            case "add all" if self._verdict_now is not None:
                for effect in self._verdict_now.effects:
                    if effect not in ("none", "unknown"):
                        desk.add(effect)


def _law_html(law: Law) -> str:
    words = verbatim("\n".join(law.lines))
    figure = f"<figure>{law.figure}</figure>" if law.figure else ""
    return f"<section><h2>The force that is missing</h2>{words}{figure}</section>"


def _answers(verdict: Verdict) -> str:
    """What the report's summary answers, but for what the heading says already."""
    if len(verdict.answers) != len(QUESTIONS):  # of a session before they were kept
        return f"<p>Confidence {100 * verdict.confidence:.0f} %.</p>"
    pairs = zip(QUESTIONS[1:], verdict.answers[1:], strict=True)
    return facts(pairs, "answers")


def _limits(verdict: Verdict) -> str:
    """From which strength on an effect would have shown."""
    if not verdict.limits:
        return ""
    items = "".join(f"<li>{escape(line)}</li>" for line in verdict.limits)
    return (
        "<details><summary>What these runs would have shown, from so much on (to first order)"
        f"</summary><ul>{items}</ul></details>"
    )


def _gallery(effect: str) -> str:
    source = picture_of(effect)
    alt = f"how {effect} shows in records"
    picture = f'<img src="{source}" alt="{escape(alt)}">'
    return f'<a href="{source}" target="_blank" title="enlarge">{picture}</a>' if source else ""


def _case_chart(case: Case) -> dict[str, object]:
    """Before and after, over what was measured."""
    lines = [
        Line("measured", case.time_s, case.measured, MEASURED, 4.0),
        Line("baseline", case.time_s, case.before, BEFORE, 1.4),
    ]
    if case.after is not None:
        lines.append(Line("with what is missing", case.time_s, case.after, AFTER, 1.4))
    y_name = f"{case.channel}, {case.unit}"
    panel = Panel(f"time, s, in {case.run}", y_name, lines, units=("s", case.unit))
    return chart([panel], (100,), (0,), WHOLE, gap=14.0)


def _trace_chart(trace: Trace) -> dict[str, object]:
    """Residual and signature around the largest signature."""
    at = int(abs(trace.signature).argmax())
    step = float(trace.time_s[1] - trace.time_s[0])
    half = int(SHOWN_S / 2 / step)
    part = slice(max(0, at - half), at + half)
    time = trace.time_s[part]
    lines = [
        Line("residual", time, trace.residual[part], MEASURED, 2.0),
        Line("its signature", time, trace.signature[part], AFTER),
    ]
    return chart(
        [Panel("time, s", trace.unit, lines, units=("s", trace.unit))], (100,), (0,), WHOLE
    )
