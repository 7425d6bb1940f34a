"""A damper dynamometer's cards: peak force over velocity, rising and falling speed, force over
displacement by speed, friction and gas force, measured and modelled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, ComponentCampaign, RigRun
from wheelhop.diagnose import Step
from wheelhop.files.words import significant
from wheelhop.report.cases import records_of
from wheelhop.report.figures import AFTER, BEFORE, MEASURED, SOFT, WIDTH
from wheelhop.report.loops import loop_of
from wheelhop.report.page import figure, paragraph, section, table
from wheelhop.report.stretch import seconds_of
from wheelhop.report.svg import STYLE, Drawing, inline, literal

Array = NDArray[np.float64]

FASTEST = 0.95
"""Peak force is the mean where a run is at least this share as fast as it gets: 36° of a sine."""

BINS = 16
"""Speeds, from 0 to the fastest, at which forces of rising and of falling speed are averaged."""

HEADINGS = ("run", "m/s", "rebound, N", "compression, N", "hysteresis, N", "gas force, N")

CARDS, WAVES = 6, 2
"""So many runs are drawn over displacement, from the slowest to the fastest, so many waves each."""


@dataclass(frozen=True)
class Card:
    """What a run shows: displacement, m, speed, m/s, and force, N (n,), measured or modelled."""

    run_id: str
    x: Array
    v: Array
    force: Array

    @property
    def fastest_m_s(self) -> float:
        """The largest speed that the run reaches either way."""
        return min(float(self.v.max()), float(-self.v.min()))

    def peak_N(self, way: int) -> float:
        """Mean force, N, where it is fastest in rebound (`way` 1) or in compression (−1)."""
        along = way * self.v
        return float(self.force[along >= FASTEST * along.max()].mean())

    def amid(self, way: int) -> float:
        """Mean force, N, in the middle third of the stroke on the way out or back."""
        low, high = self.x.min(), self.x.max()
        middle = np.abs(self.x - 0.5 * (low + high)) < (high - low) / 6.0
        return float(self.force[middle & (way * self.v > 0.0)].mean())

    @property
    def friction_N(self) -> float:
        """Half of what the force differs by between both ways, in the middle of the stroke."""
        return 0.5 * (self.amid(1) - self.amid(-1))

    @property
    def gas_N(self) -> float:
        """The force about which both ways lie, in the middle of the stroke."""
        return 0.5 * (self.amid(1) + self.amid(-1))

    def curve(self, way: int, rising: bool) -> tuple[Array, Array]:
        """Speeds (k,) and mean forces (k,) while the speed rises or falls, one way."""
        along = way * self.v
        chosen = (along > 0.0) & ((np.gradient(along) > 0.0) == rising)
        bins = np.minimum(BINS * along[chosen] / along.max(), BINS - 1).astype(int)
        count = np.bincount(bins, minlength=BINS)
        total = np.bincount(bins, self.force[chosen], minlength=BINS)
        some = count > 0
        speeds = way * along.max() * (np.arange(BINS) + 0.5) / BINS
        return speeds[some], total[some] / count[some]

    @property
    def hysteresis_N(self) -> float:
        """Mean, over both ways and all speeds, of how far the forces of rising and of falling
        speed lie apart."""
        apart = []
        for way in (1, -1):
            (a, rises), (b, falls) = (self.curve(way, rising) for rising in (True, False))
            _, i, j = np.intersect1d(a, b, return_indices=True)
            apart += list(np.abs(rises[i] - falls[j]))
        return float(np.mean(apart)) if apart else float("nan")


def cards_of(campaign: ComponentCampaign, step: Step | None, rung: Step) -> list[Card]:
    """A card of every run, the slowest first: of a model, or, without one, as measured. The runs
    are those of `rung`."""
    found = []
    for run in campaign.runs:
        if isinstance(run, RigRun):
            record = records_of((step or rung).rung)[run.id]
            answer = record.measured if step is None else record.model
            found.append(Card(run.id, *loop_of(campaign, run, record, answer, 0.0)))
    return sorted(found, key=lambda card: card.fastest_m_s)


def dynamometer(campaign: Campaign, steps: Sequence[Step]) -> str:
    """The section of the report; "" but for a component whose displacement is imposed."""
    if not isinstance(campaign, ComponentCampaign) or campaign.drive != "displacement":
        return ""
    measured = cards_of(campaign, None, steps[-1])
    modelled = cards_of(campaign, steps[-1], steps[-1])
    by_id = {card.run_id: card for card in modelled}
    pairs = [(card, by_id[card.run_id]) for card in measured]
    drawing = dynamometer_figure(pairs, campaign.sample_rate_hz, with_effects=len(steps) > 1)
    slowest = measured[0]
    return section(
        "On the dynamometer",
        figure(
            inline(drawing, "dynamometer", "dynamometer cards, measured and modelled"),
            "Grey: measured. Colour: last model. Left above: mean force where each run is fastest,"
            " rebound positive. Right above: the fastest run, solid while its speed rises, dashed"
            " while it falls. Below: two waves of runs from the slowest to the fastest.",
        ),
        table(
            [*HEADINGS, *_inputs(campaign)],
            [_row(campaign, *pair) for pair in pairs],
            "l" + "r" * (len(HEADINGS) - 1 + len(_inputs(campaign))),
        ),
        paragraph(
            "Measured / modelled. Gas force is what the forces of both ways lie about in the middle"
            " of the stroke, with whatever the sensor shows at rest. There the forces of the"
            f" slowest run, at {significant(slowest.fastest_m_s)} m/s, lie"
            f" {significant(slowest.friction_N)} N either side of it: friction, with what damping"
            " is left at that speed. Hysteresis is how far the forces of rising and falling speed"
            " lie apart, on average."
        ),
    )


def _inputs(campaign: ComponentCampaign) -> list[str]:
    """The inputs recorded beside force and displacement, a temperature perhaps."""
    run = next(run for run in campaign.runs if isinstance(run, RigRun))
    return [escape(name) for name in run.inputs]


def _row(campaign: ComponentCampaign, measured: Card, modelled: Card) -> list[str]:
    def both(a: float, b: float) -> str:
        return f"{significant(a)} / {significant(b)}"

    run = next(r for r in campaign.runs if r.id == measured.run_id)
    inputs = run.inputs.values() if isinstance(run, RigRun) else ()
    return [
        escape(measured.run_id),
        significant(measured.fastest_m_s),
        *(both(measured.peak_N(way), modelled.peak_N(way)) for way in (1, -1)),
        both(measured.hysteresis_N, modelled.hysteresis_N),
        significant(measured.gas_N),
        *(f"{significant(float(v.min()))} to {significant(float(v.max()))}" for v in inputs),
    ]


def dynamometer_figure(
    pairs: Sequence[tuple[Card, Card]], rate_hz: float, *, with_effects: bool
) -> Drawing:
    """Three panels of measured cards and modelled ones."""
    colour = AFTER if with_effects else BEFORE
    with mpl.rc_context(STYLE):
        drawing = Drawing(figsize=(WIDTH, 5.6), layout="constrained")
        grid = drawing.add_gridspec(2, 2)
        peaks, curves = (drawing.add_subplot(grid[0, i]) for i in (0, 1))
        over = drawing.add_subplot(grid[1, :])
        _draw_peaks(peaks, pairs, colour)
        for card, (line, width) in zip(pairs[-1], ((MEASURED, 2.4), (colour, 1.1)), strict=True):
            for way in (1, -1):
                curves.plot(*card.curve(way, True), color=line, linewidth=width)
                curves.plot(*card.curve(way, False), color=line, linewidth=width, linestyle="--")
        curves.set_title(literal(f"speed rising and falling, {pairs[-1][0].run_id}"))
        for i in np.unique(np.linspace(0, len(pairs) - 1, CARDS).round().astype(int)):
            measured, modelled = pairs[i]
            length = round(seconds_of(measured.x, rate_hz, WAVES) * rate_hz)
            middle = int(np.argmax(np.abs(measured.v)))
            begin = min(max(middle - length // 2, 0), max(len(measured.x) - length, 0))
            part = slice(begin, begin + length)
            over.plot(1e3 * measured.x[part], measured.force[part], color=MEASURED, linewidth=2.4)
            over.plot(1e3 * modelled.x[part], modelled.force[part], color=colour, linewidth=1.1)
            top = begin + int(np.argmax(measured.force[part]))
            at = 1e3 * measured.x[top], measured.force[top]
            over.annotate(f"{significant(measured.fastest_m_s)} m/s", at, va="bottom", size="small")
        over.set_title("force over displacement, by speed")
        over.set_xlabel("displacement, mm")
        over.set_ylabel("force, N")
        for panel in (peaks, curves):
            panel.set_xlabel("velocity, m/s")
            panel.axhline(0.0, color=SOFT, linewidth=0.6)
        peaks.set_ylabel("force, N")
    return drawing


def _draw_peaks(axes: Axes, pairs: Sequence[tuple[Card, Card]], colour: str) -> None:
    for way in (1, -1):
        speeds = [way * measured.fastest_m_s for measured, _ in pairs]
        measured, modelled = (
            [pair[i].peak_N(way) - pair[0].gas_N for pair in pairs] for i in (0, 1)
        )
        axes.plot(speeds, measured, "o", color=MEASURED, ms=7)
        axes.plot(speeds, modelled, ".-", color=colour)
    axes.set_title("peak force over velocity, less gas force")
