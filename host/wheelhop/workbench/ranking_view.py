"""The ranking as a table that sorts, with what is folded below it; before that the library."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from html import escape

from wheelhop.files.words import chance, percent, signed
from wheelhop.workbench.glossary import term
from wheelhop.workbench.shown import CanShow, Card, Ranking, Row
from wheelhop.workbench.tables import Column, Sortable
from wheelhop.workbench.view import acting, html

COLUMNS = {
    "screened": "error E expected with the effect, to first order",
    "confirmed": "E reached in full simulation, fitted with the vehicle",
    "held out": "E of that model on runs no fit has seen: it decides",
    "log evidence": "how much more likely the records are with the effect, as a logarithm",
    "p": "chance that any effect does so well without being there",
}
ENTRIES = {"held out": "validate runs", "log evidence": "evidence"}
"""What the glossary calls them."""
WAITING = "<p class='soft'>The effects stand here once the campaign is read.</p>"


class RankingView:
    """Effects by what they explain; a click on one `choose`s it."""

    def __init__(self, choose: Callable[[str], None]) -> None:
        def act(data: dict[str, str]) -> None:
            choose(data["effect"])

        self._sentence = html()
        ranked = (Column("effect", "effect"), *(Column(n, n, True, t) for n, t in COLUMNS.items()))
        listed = (
            *(Column("effect", "effect"), Column("place", "place")),
            Column("seen", "would be seen from, to first order"),
        )
        self._ranked = Sortable(ranked, "effect", "ranking", choose)
        self._listed = Sortable(listed, "effect", "ranking", choose)
        self._below = acting(html(), act)

    def show_ranking(self, ranking: Ranking, accepted: Sequence[str], *, settled: bool) -> None:
        """What is known of every effect; once all is `settled` what explains little is folded."""
        tried = [row for row in ranking.rows if row.screened is not None]
        confirmed = [row for row in tried if row.confirmed is not None] if settled else []
        shown = confirmed or tried
        self._switch(listed=False)
        self._listed.show([])
        self._sentence.set_content("")
        self._ranked.show([_cells(row, row.effect in accepted) for row in shown])
        rest = [row for row in tried if row not in shown]
        others = [row for row in ranking.rows if row.screened is None]
        legend = "; ".join(
            f"<strong>{term(name, ENTRIES.get(name, ''))}</strong>: {words}"
            for name, words in COLUMNS.items()
        )
        self._below.set_content(
            f"<p class='soft'>{legend}.</p>{_explains_nothing(rest)}{_not_applicable(others)}"
        )

    def show_library(self, cards: Mapping[str, Card], found: CanShow | None) -> None:
        """Every effect that will be tried, and from where on it would be seen, if that was
        asked."""
        seen = found.effects if found else {}
        sentence = f"<p>{escape(found.sentence)}</p>" if found and found.sentence else ""
        self._switch(listed=bool(cards))
        self._sentence.set_content(sentence if cards else WAITING)
        self._ranked.show([])
        self._listed.show(
            [
                {"effect": card.effect, "place": card.place, "seen": seen.get(card.effect, "")}
                for card in cards.values()
            ]
        )
        self._below.set_content("")

    def _switch(self, *, listed: bool) -> None:
        self._listed.element.set_visibility(listed)
        self._ranked.element.set_visibility(not listed)


def _cells(row: Row, accepted: bool) -> dict[str, str | bool]:
    numbers = (row.screened, row.confirmed, row.held_out)
    cells = [percent(x) if x is not None else "" for x in numbers]
    cells.append("" if row.evidence is None else signed(row.evidence))
    cells.append("" if row.p is None else chance(row.p))
    return {"effect": row.effect, "accepted": accepted, **dict(zip(COLUMNS, cells, strict=True))}


def _explains_nothing(rows: list[Row]) -> str:
    """Effects that take too little to be simulated in full, folded; each leads to its card."""
    if not rows:
        return ""
    items = "".join(
        f'<li><button data-act="card" data-effect="{escape(row.effect)}">{escape(row.effect)}'
        f"</button> {percent(row.screened or 0.0)}</li>"
        for row in rows
    )
    return (
        f"<details><summary>{len(rows)} more explain too little to be simulated in full (the"
        f" error each would leave, to first order)</summary><ul class='fold'>{items}</ul></details>"
    )


def _not_applicable(rows: list[Row]) -> str:
    """Effects with nothing to act on in these runs, folded."""
    if not rows:
        return ""
    items = "".join(
        f"<li><strong>{escape(row.effect)}</strong> {escape(row.reason)}</li>" for row in rows
    )
    return (
        f"<details><summary>{len(rows)} more do not apply here</summary><ul>{items}</ul></details>"
    )
