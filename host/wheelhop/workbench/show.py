"""From fits to what the page shows: the last place where a model is a model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from html import escape

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, ComponentCampaign, RigRun
from wheelhop.compare import Record, describe
from wheelhop.compare.settings import SettingsComparison
from wheelhop.diagnose import Diagnosis, Limit, Ranked, Step
from wheelhop.diagnose.screen.first_order import Screened
from wheelhop.diagnose.search.scored import Scored
from wheelhop.diagnose.verdict.ranking import Angles, ranked_so_far
from wheelhop.effects import Effect
from wheelhop.fit import Fit, RunFit, Workshop
from wheelhop.gate import Finding
from wheelhop.identify import Linearity, TransferMatrix, measure, predict
from wheelhop.law import Found
from wheelhop.predict.detectable import Detectable
from wheelhop.report import sections
from wheelhop.report.axle_to_body import axle_to_body
from wheelhop.report.can_show import best_words, seen_from
from wheelhop.report.cases import cases, records_of
from wheelhop.report.identified import predictions
from wheelhop.report.law import law_figure, law_lines
from wheelhop.report.loops import FINER, loop_of
from wheelhop.report.settings import settings_headline, settings_sections
from wheelhop.report.summary import answers
from wheelhop.report.svg import equation, inline
from wheelhop.report.words import headline, in_numbers, limit_words, next_run_words
from wheelhop.workbench import shown
from wheelhop.workbench.proposed import of_effects

Array = NDArray[np.float64]

OPEN = "screened; it may still be simulated in full"
COMMAND = "wheelhop law"
"""A line of the verdict that names this is for the command line: the page has a button for it."""

Traced = set[tuple[tuple[str, ...], str]]
"""Which effects, beside which others, have been shown laid over the residual."""


def findings(found: Iterable[Finding]) -> tuple[shown.Found, ...]:
    """How sure, the sentence with what to do, and what does it."""
    return tuple(shown.Found(f.severity, f"{f.text} {f.remedy}", f.fixes) for f in found)


def library(effects: Mapping[str, Effect]) -> shown.Library:
    """A card for every effect."""
    return shown.Library(
        tuple(
            shown.Card(e.id, e.place, e.title, equation(e.equation), e.source)
            for e in effects.values()
        )
    )


def rungs(campaign: Campaign, steps: Sequence[Step]) -> tuple[shown.Rung, ...]:
    """Every model of a ladder; finished sections for the last one alone."""
    last = len(steps) - 1
    return tuple(_rung(campaign, steps[: i + 1], drawn=i == last) for i in range(len(steps)))


def _rung(campaign: Campaign, steps: Sequence[Step], *, drawn: bool) -> shown.Rung:
    step = steps[-1]
    comparison = step.comparison
    grid = comparison.breakdown.runs_channels
    html = {}
    if drawn:
        html = {
            "ladder": sections.ladder(steps),
            "where": sections.where(steps) + sections.where_else(steps),
            "struts": sections.struts(campaign, steps) or sections.loops(campaign, steps),
            "model": sections.model(campaign, steps),
        }
    return shown.Rung(
        added=step.added,
        error=step.rung.error,
        error_fit=step.rung.error_fit,
        floor=step.floor,
        floor_fit=comparison.floor.error_fit,
        at_floor=not step.above_floor,
        runs=grid.rows,
        channels=grid.columns,
        points=_points(campaign, grid.columns),
        shape=_shape(step),
        numbers={
            free.name: shown.Number(free.mean, free.sigma, *step.parameters[free.name])
            for free in step.rung.fit.shared
        },
        ratio=grid.ratio,
        noise_rms=comparison.floor.of_channels,
        signals=_all_signals(campaign, step),
        sentences=tuple(describe(comparison.breakdown)),
        html=html,
    )


def _points(campaign: Campaign, channels: Sequence[str]) -> tuple[str, ...]:
    point = {channel.name: channel.point for channel in campaign.channels}
    return tuple(point[name] for name in channels)


def _shape(step: Step) -> shown.Shape | None:
    values = step.rung.model.values
    if "geometry.wheelbase_m" not in values:
        return None
    names = ("geometry.wheelbase_m", "geometry.track_width_m", "wheel.front.radius_m")
    return shown.Shape(*(float(values[name]) for name in names))


def _all_signals(campaign: Campaign, step: Step) -> dict[str, shown.Signals]:
    positions = {record.run.id: record.position_m for record in step.comparison.records}
    mass_kg = float(step.rung.model.values.get("component.mass_kg", 0.0))
    return {
        run: _signals(record, positions.get(run), _loop(campaign, record, mass_kg))
        for run, record in records_of(step.rung).items()
    }


def _loop(campaign: Campaign, record: Record, mass_kg: float) -> dict[str, shown.Pair]:
    """What a component did, as the report's loops show it."""
    run = record.run
    if not isinstance(campaign, ComponentCampaign) or not isinstance(run, RigRun):
        return {}
    finer = FINER if campaign.drive == "force" else 1
    measured, modelled = (
        [part[::finer].astype(np.float32) for part in loop_of(campaign, run, record, one, mass_kg)]
        for one in (record.measured, record.model)
    )
    names = ("displacement", "velocity", "force")
    return {name: shown.Pair(*of) for name, *of in zip(names, measured, modelled, strict=True)}


def _signals(
    record: Record, position_m: Array | None, loop: Mapping[str, shown.Pair]
) -> shown.Signals:
    band = record.band

    def samples(coefficients: Array) -> shown.Samples:
        return record.signal(coefficients).astype(np.float32)

    return shown.Signals(
        band.rate_hz,
        samples(record.measured),
        samples(record.model),
        samples(band.integrated_twice(record.measured)),
        samples(band.integrated_twice(record.model)),
        None if position_m is None else position_m.astype(np.float32),
        loop,
    )


def ranking(workshop: Workshop, scored: Scored, traced: Traced) -> shown.Ranking:
    """What is known beside a set by now; signatures come once, `traced` keeps which did."""
    ranked = ranked_so_far(scored, Angles(scored.rung.fit, scored.screened, scored.candidates))
    beside = tuple(effect.id for effect in scored.rung.model.effects)
    fit = scored.rung.fit
    traces = {}
    for screened in scored.screened:
        name = screened.id
        if (beside, name) not in traced and _shows(screened):
            traces[name] = _trace(workshop, fit, screened)
            traced.add((beside, name))
    rows = tuple(_row(item) for item in ranked)
    if scored.chosen is None:  # nothing is settled yet
        rows = tuple(replace(row, reason=OPEN) if row.confirmed is None else row for row in rows)
    return shown.Ranking(beside, rows, traces)


def final_ranking(workshop: Workshop, diagnosis: Diagnosis) -> shown.Ranking:
    """The ranking as the diagnosis states it, the effects that do not apply at its end."""
    return shown.Ranking((), tuple(map(_row, diagnosis.ranking)), {})


def _row(item: Ranked) -> shown.Row:
    return shown.Row(
        item.effect,
        item.place,
        item.screened_error,
        item.confirmed_error,
        item.validated_error,
        item.evidence,
        item.p_value,
        tuple(f"{name} ({angle:.0f}°)" for name, angle in item.ambiguous_with),
        item.reason,
    )


def _shows(screened: Screened) -> bool:
    return any(part.any() for part in screened.contribution.values())


def _trace(workshop: Workshop, fit: Fit, screened: Screened) -> shown.Trace:
    """Where an effect would take most out of the residual."""
    places = []
    for run in fit.runs:
        residual, signature = _columns(run, fit, screened)
        gain = (2 * residual * signature - signature**2).sum(axis=0)
        column = int(np.argmax(gain))
        places.append((float(gain[column]), run, residual[:, column], signature[:, column], column))
    _, run, residual, signature, column = max(places, key=lambda place: place[0])
    band, bench = run.bench.band, run.bench
    column = int(np.flatnonzero(bench.predicted)[column])
    channel, scale = workshop.campaign.channels[column], bench.noise_scale[column]
    return shown.Trace(
        bench.run.id,
        channel.name,
        channel.unit,
        np.asarray(bench.run.time_s),
        band.from_coefficients(residual) * scale,
        band.from_coefficients(signature) * scale,
    )


def _columns(run: RunFit, fit: Fit, screened: Screened) -> tuple[Array, Array]:
    """Residual and signature (coefficients, channels predicted); with the effect the vehicle's own
    numbers move, and what the run leaves free takes its share."""
    shared = run.derivatives.shared
    moved = np.array([screened.along.get(f.name, 0.0) / f.scale for f in fit.shared])
    change = screened.contribution[run.bench.run.id] + run.weighed[:, :shared] @ moved
    own = run.weighed[:, shared:]
    change = (change - own @ np.linalg.lstsq(own, change)[0]) * run.spread
    count, bench = run.bench.band.count, run.bench
    residual, signature = bench.undoubted(run.residual), bench.undoubted(change)
    return residual.reshape(count, -1), signature.reshape(count, -1)


def verdict(diagnosis: Diagnosis, campaign: Campaign) -> shown.Verdict:
    """The verdict in words, and what it says is wrong in the campaign's files."""
    following = diagnosis.next_run
    return shown.Verdict(
        diagnosis.verdict,
        diagnosis.confidence,
        headline(diagnosis),
        tuple(line for line in diagnosis.explanation if not line.startswith(COMMAND)),
        "" if following is None else next_run_words(following),
        tuple(_limit(limit) for limit in diagnosis.limits),
        in_numbers(diagnosis.ladder),
        of_effects(diagnosis.ladder[-1], campaign),
        answers(diagnosis, campaign),
    )


def case(campaign: Campaign, steps: Sequence[Step]) -> shown.Case:
    """The worst place, as the report shows it."""
    found = cases(campaign.channels, steps)[0]
    part = found.shown
    return shown.Case(
        *(found.run_id, found.channel, found.unit, found.time_s[part]),
        *(found.measured[part], found.before[part]),
        found.after[part] if len(steps) > 1 else None,
    )


def _limit(limit: Limit) -> str:
    form = f" ({limit.form})" if limit.form else ""
    return f"{limit.effect}{form}: {limit_words(limit)}"


def between(
    found: Linearity, campaign: Campaign, steps: Sequence[Step], foretold: str
) -> shown.AxleToBody:
    """The report's section, beside the models of `steps`, and below it what is `foretold`."""
    return shown.AxleToBody(axle_to_body(found, campaign, steps) + foretold)


def foretold(model: TransferMatrix, campaign: Campaign) -> str:
    """What an identified matrix predicts of the body in every run, beside its record: sections."""
    return "".join(predictions(campaign, predict(model, measure(campaign)), folded=True))


def can_show(found: Detectable) -> shown.CanShow:
    """Of every effect from where on it would be seen, in words."""
    if found.refused:
        return shown.CanShow({}, found.refused)
    limits = zip(found.limits, seen_from(found), strict=True)
    seen = {limit.effect: words for limit, (_, words) in limits}
    return shown.CanShow(seen, best_words(found))


def settings(found: SettingsComparison) -> shown.Settings:
    """The report's page of it, as sections."""
    head = f"<h2>{escape(settings_headline(found))}</h2>"
    return shown.Settings(head + "".join(settings_sections(found)))


def law(found: Found, words: Sequence[str] | None = None) -> shown.Law:
    """A law in words, its own unless others are given, and as a picture."""
    figure = ""
    if found.free is not None and found.moved is not None:
        figure = inline(law_figure(found), "law", "the force that is missing")
    return shown.Law(tuple(law_lines(found) if words is None else words), figure)
