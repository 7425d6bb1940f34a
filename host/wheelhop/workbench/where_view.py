"""Where it fails: the report's breakdown of the residual, of the baseline and the last model, and
the chain from the track to the sensor, with what each link could explain."""

from __future__ import annotations

from html import escape

from wheelhop.files.words import percent
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.glossary import term
from wheelhop.workbench.shown import Ranking, Row, Rung
from wheelhop.workbench.view import Looking, acting, drawn, html

WAITING = "<p class='soft'>The model is being fitted; where it fails is known after that.</p>"
CHAIN = {
    "track": ("track", "speed"),
    "tyre": ("wheel", "tyre"),
    "axle": ("axle",),
    "strut": ("suspension",),
    "body": ("body",),
    "sensor": ("sensor",),
}
"""The links, and the places of the effects that belong to each."""


class WhereView:
    """The chain, and below it the sentences beside their pictures."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk, self._looking = desk, looking
        self._seen: object = None
        self._chain = acting(html(), self._act)
        self._body = drawn(WAITING)

    def show(self) -> None:
        """Bring it up to date."""
        desk = self._desk
        rung = desk.rungs[-1] if desk.rungs else None
        ranking = desk.ranking
        if (rung, ranking) != self._seen:
            self._seen = (rung, ranking)
            self._chain.set_content(chain(desk.rungs[0], ranking) if desk.rungs else "")
            self._body.set_content(rung.html["where"] if rung else WAITING)

    def _act(self, data: dict[str, str]) -> None:
        self._looking.effect = data.get("effect", "")
        self._looking.go("missing")


def chain(baseline: Rung, ranking: Ranking | None) -> str:
    """Every link with the effect there that would take most of the baseline's residual."""
    rows = ranking.rows if ranking else ()
    boxes = "<li aria-hidden='true'>→</li>".join(
        _link(name, [row for row in rows if row.place in places], baseline, ranking is not None)
        for name, places in CHAIN.items()
    )
    hint = (
        f"Of the squared {term('residual')}, what the best effect of each link would take, alone"
        " and to first order or, where it was simulated, in full. Links share what they explain:"
        " the sum says nothing."
        if ranking
        else "What each link could explain is known once "
        '<button data-act="missing">what is missing</button> was looked for.'
    )
    return (
        f"<h2>From the track to the sensor</h2><ol class='chain'>{boxes}</ol>"
        f"<p class='soft'>{hint}</p>"
    )


def _link(name: str, rows: list[Row], baseline: Rung, known: bool) -> str:
    errors = {row.effect: error for row in rows if (error := _error(row)) is not None}
    if not errors:
        words = "nothing of it shows here" if known else ""
        return f"<li class='link'><strong>{name}</strong><small>{words}</small></li>"
    best = min(errors, key=lambda effect: errors[effect])
    taken = max(0.0, 1.0 - (errors[best] / baseline.error_fit) ** 2)
    width = f"{100 * taken:.0f}"
    return (
        f"<li class='link'><strong>{name}</strong>"
        f"<span class='share' style='width:{width}%'></span><span>{width} %</span>"
        f"<button data-act='card' data-effect='{escape(best)}'>{escape(best)}</button>"
        f"<small>E {percent(baseline.error_fit)} → {percent(errors[best])}</small></li>"
    )


def _error(row: Row) -> float | None:
    return row.screened if row.confirmed is None else row.confirmed
