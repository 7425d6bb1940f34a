"""The sections that the reports share, each from what it shows to HTML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from importlib.metadata import version
from math import isfinite

from wheelhop.campaign import Campaign, ComponentCampaign, RigRun
from wheelhop.compare import describe
from wheelhop.diagnose import Diagnosis, Step, caveats
from wheelhop.effects import Effect, form_of
from wheelhop.files.words import listed, percent, significant
from wheelhop.gate import Finding
from wheelhop.report import figures, strut_figures, tables
from wheelhop.report.cases import Case, cases
from wheelhop.report.heat import heat_legend
from wheelhop.report.loops import loops_figure
from wheelhop.report.page import bullets, facts, figure, paragraph, section
from wheelhop.report.strut_motion import LOW_SPEED_M_S, strut_histories
from wheelhop.report.svg import equation, inline
from wheelhop.report.words import chain_words, next_run_words, track_words

WHEN = {"before": "Of the campaign, before anything was fitted:", "after": "Of the fit:"}


def findings(found: Sequence[Finding]) -> str:
    """What to know before the verdict is believed, if anything."""
    if not found:
        return ""
    said = {when: [f"{f.text} {f.remedy}" for f in found if f.when == when] for when in WHEN}
    return section(
        "Before you believe it",
        *(
            part
            for when, heading in WHEN.items()
            if said[when]
            for part in (paragraph(heading, "soft"), bullets(said[when]))
        ),
    )


def ladder(steps: Sequence[Step]) -> str:
    """The error falling to the floor."""
    own = "how each one began is" if _on_rig(steps) else "each one’s own speed and start are"
    drawing = inline(figures.ladder_figure(steps), "ladder", "error of every model")
    return section(
        "The error, from the baseline to the floor",
        figure(
            drawing,
            "E = √(Σ|measured − modelled|² / Σ|measured|²) over runs and channels in band, on a"
            f" logarithmic scale. Runs held out take no part in any fit, except that {own} found,"
            " and charged for.",
        ),
        tables.ladder_table(steps),
        tables.quantity_table(steps[-1].comparison),
        *(paragraph(text) for text in caveats(steps[-1])),
    )


def _on_rig(steps: Sequence[Step]) -> bool:
    return steps[0].comparison.breakdown.on_rig


def loops(campaign: Campaign, steps: Sequence[Step]) -> str:
    """Of a component: force over displacement and velocity, measured and modelled."""
    if not isinstance(campaign, ComponentCampaign):
        return ""
    less = " The force is that imposed less mass times acceleration, in band."
    less = less if campaign.drive == "force" else ""
    drawing = inline(loops_figure(campaign, steps), "loops", "loops, measured and modelled")
    return section(
        "The loops",
        figure(
            drawing,
            "Some waves of the runs with the largest travel, the highest speed and the smallest"
            f" travel.{less}",
        ),
    )


def struts(campaign: Campaign, steps: Sequence[Step]) -> str:
    """Of a vehicle: histograms and loops of its struts, measured and modelled."""
    histories = strut_histories(campaign, steps)
    if not histories:
        return ""
    measured = strut_figures.any_measured(histories)
    noise = (
        " Differentiating travel enlarges the sensor’s noise: the table says how much of the"
        " measured velocity is noise."
    )
    histograms = inline(
        strut_figures.histograms_figure(histories),
        "histograms",
        "velocity and travel of the struts",
    )
    loops_drawn = inline(
        strut_figures.strut_loops_figure(histories, steps[-1].rung.model),
        "strut-loops",
        "force of the struts over travel and velocity",
    )
    return section(
        "What the struts did",
        figure(
            histograms,
            "All runs, in band, at the wheel: a damper’s own are these times its motion ratio."
            f" Grey behind the velocities: low speed, below {1e3 * LOW_SPEED_M_S:g} mm/s."
            f"{noise if measured else ''}",
        ),
        strut_figures.shares_table(histories),
        figure(
            loops_drawn,
            "Of each strut the run with the largest travel, some waves about the farthest point."
            " Left: force of spring, damper and all laws along the strut, in band. Right: the same"
            " without the last model’s spring.",
        ),
    )


def traces(campaign: Campaign, steps: Sequence[Step]) -> str:
    """Measured against modelled, in time and frequency."""
    parts = []
    for i, case in enumerate(cases(campaign.channels, steps)):
        drawing = inline(
            figures.case_figure(case, listed(steps[-1].added)),
            f"case{i}",
            f"channel {case.channel} of run {case.run_id}, measured and modelled",
        )
        parts += [
            f"<h3>{case.title}: {escape(case.channel)} in {escape(case.run_id)}</h3>",
            figure(drawing, _case_caption(case, campaign)),
        ]
    return section("Measured and modelled", *parts)


def _case_caption(case: Case, campaign: Campaign) -> str:
    run = next(run for run in campaign.runs if run.id == case.run_id)
    role = "fitted" if run.role == "fit" else "held out"
    seconds = (case.shown.stop - case.shown.start) / case.rate_hz
    drive = f"{track_words(run.track)}, {run.speed_m_s * 3.6:.3g} km/h"
    about = run.id if isinstance(run, RigRun) else f"{run.id} ({drive})"
    return (
        f"In band. Left: the {seconds:.2g} s with the largest baseline residual; grey is"
        f" ±2 standard deviations of the noise. Right: power density of the whole run, dashed the"
        f" noise floor. Run {about}, {role}."
    )


def where(steps: Sequence[Step]) -> str:
    """The residual cut along every axis, for the first and the last model."""
    first, last = steps[0].comparison, steps[-1].comparison
    compared = len(steps) > 1
    maps = figure(
        tables.heat_map(steps) + heat_legend(),
        "Residual / noise floor, runs × channels, in band. * held out.",
    )
    drawing = figures.where_figure(first.breakdown, last.breakdown if compared else None)
    words = "Orange: baseline. Blue: last model. Dashed: noise floor. " if compared else ""
    road = "is coherent with the drive" if _on_rig(steps) else "repeats with the road"
    return section(
        "Where it fails",
        bullets(describe(first.breakdown)),
        maps,
        figure(
            inline(drawing, "where", "residual by band, by motion, and what it is locked to"),
            f"{words}Right: the residual’s sum of squares shared out between what {road}, lines at"
            " a fixed frequency, neither, and the noise expected.",
        ),
        paragraph("What the last model leaves:", "soft") if compared else "",
        bullets(describe(last.breakdown)) if compared else "",
    )


def where_else(steps: Sequence[Step]) -> str:
    """The residual by band and motion at once, and whether it grows with the motion."""
    found = tables.motion_map(steps)
    maps = figure(found, "Residual / noise floor, third-octave bands × motions.") if found else ""
    growth = steps[0].comparison.breakdown.growth
    words = (
        f"The baseline’s excess residual grows with the motion to the power {growth:.1f}: 1 is what"
        " a wrong number of a linear model leaves, less is what friction leaves, more what stops"
        " and progressive springs leave."
        if isfinite(growth)
        else ""
    )
    return section(
        "By band and motion, and by how large the motion is",
        maps,
        tables.size_table(steps),
        paragraph(words) if words else "",
    )


def axle_driven(road: Step, axles: Step) -> str:
    """The second comparison: measured axle motion against the body."""
    return section(
        "With the measured axle motion driving the body",
        paragraph(chain_words(road, axles)),
        figure(
            tables.heat_map([axles]) + heat_legend(),
            "Residual / noise floor, runs × channels of the body, in band; the axles’ own noise is"
            " part of the floor, what is folded into their records is not. * held out.",
        ),
        bullets(describe(axles.comparison.breakdown)),
    )


def ranking(diagnosis: Diagnosis, effects: Mapping[str, Effect]) -> str:
    """Every effect of the library on the first rung."""
    return section(
        "Which effect",
        paragraph(
            "Every effect of the library against the baseline’s residual. Screened: the error first"
            " order expects; confirmed: the error reached when the effect is simulated in full and"
            " fitted with the vehicle; held out: the same model on runs no fit has seen. Log"
            " evidence is relative to the baseline’s, p the chance that any of the effects tried"
            " does as well without being there. What screening foresees little of is not simulated."
        ),
        tables.ranking_table(diagnosis.ranking, effects),
    )


def model(campaign: Campaign, steps: Sequence[Step]) -> str:
    """The effects in the last model, and its numbers."""
    step = steps[-1]
    parts = []
    for effect in step.rung.model.effects:
        form = form_of(effect, campaign.channels)
        parts += [
            f"<h3>{escape(effect.id)}{f' ({escape(form)})' if form else ''}</h3>",
            paragraph(f"{effect.title[0].upper()}{effect.title[1:]}."),
            f'<p class="equation">{equation(effect.equation)}</p>',
            paragraph(f"Source: {effect.source}.", "soft"),
            tables.effect_parameters_table(effect, step, campaign),
        ]
    parts += [
        f"<h3>The {'component' if isinstance(campaign, ComponentCampaign) else 'vehicle'}</h3>",
        paragraph(
            "Intervals are two standard deviations and hold as far as the model is right. The"
            " drawing shows the fitted interval; the shaded bar is the nominal one."
        ),
        tables.vehicle_table(step),
    ]
    return section("The model", *parts)


def next_run(diagnosis: Diagnosis) -> str:
    """What to record next, if anything."""
    if diagnosis.next_run is None:
        return ""
    return section("What to record next", paragraph(next_run_words(diagnosis.next_run)))


def limits(diagnosis: Diagnosis) -> str:
    """What else these runs would have shown, and from where on."""
    if not diagnosis.limits:
        return ""
    return section(
        "What these runs would have shown",
        paragraph(
            "The smallest amplitudes of every effect not in the model with which it would have been"
            " found, to first order; all amplitudes of an effect together."
        ),
        tables.limits_table(diagnosis.limits),
    )


def method(campaign: Campaign, steps: Sequence[Step]) -> str:
    """What was computed from what."""
    low, high = campaign.band_hz
    comparison = steps[-1].comparison
    floor = comparison.floor
    noise = [f"{significant(q.noise_rms)} {q.unit}" for q in comparison.by_quantity]
    said = ", ".join(noise) or f"{floor.pooled_rms:.3g} {floor.unit}"
    pairs = [
        ("Campaign", campaign.title),
        ("Runs", f"{len(campaign.fit_runs)} fitted, {len(campaign.validate_runs)} held out"),
        ("Channels", ", ".join(channel.name for channel in campaign.channels)),
        ("Samples", campaign.sampling),
        ("Band", f"{low:g} to {high:g} Hz"),
        ("Noise floor", f"{said} rms per channel in band, {floor.origin}"),
        ("Floor as E", f"{percent(floor.error)} over all runs"),
        ("Computed by", f"wheelhop {version('wheelhop')}"),
    ]
    return section("How it was computed", facts(pairs), tables.runs_table(campaign, steps[-1]))
