"""The tables: heat map, ranking, parameters, runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from wheelhop.campaign import Campaign, ComponentCampaign, RigRun, Run
from wheelhop.compare import Comparison
from wheelhop.diagnose import Limit, Ranked, Step
from wheelhop.effects import Effect
from wheelhop.files.words import (
    chance,
    interval,
    label_of,
    listed,
    percent,
    signed,
    significant,
    unit_of,
)
from wheelhop.fit import Free
from wheelhop.report.heat import heat_class, heat_words
from wheelhop.report.page import table
from wheelhop.report.words import limit_words, track_words


def heat_map(steps: Sequence[Step]) -> str:
    """Residual over noise floor, runs × channels, for the first model and the last beside it;
    runs held out are marked, channels no model predicts are left out."""
    models = [steps[0]] if len(steps) == 1 else [steps[0], steps[-1]]
    breakdowns = [step.comparison.breakdown for step in models]
    grid = breakdowns[0].runs_channels
    shown = np.asarray(np.isfinite(grid.ratio).any(axis=0))
    names = [name for name, is_shown in zip(grid.columns, shown, strict=True) if is_shown]
    head, heads = "", "".join(f'<th class="r">{escape(name)}</th>' for name in (*names, "all"))
    for step in models:
        title = escape(f"with {listed(step.added)}" if step.added else "baseline")
        head += f'<th class="gap"></th><th class="group" colspan="{len(names) + 1}">{title}</th>'
    rows = []
    for i, run in enumerate(grid.rows):
        mark = "" if models[0].comparison.roles[run] == "fit" else " *"
        blocks = [[*w.runs_channels.ratio[i][shown], w.run[i].ratio] for w in breakdowns]
        rows.append(_heat_row(run + mark, blocks))
    columns = [[part.ratio for part in w.channel if part.noise > 0] for w in breakdowns]
    totals = [[*c, w.total.ratio] for c, w in zip(columns, breakdowns, strict=True)]
    rows.append(_heat_row("all", totals))
    second = f'<th class="gap"></th>{heads}' * len(models)
    return (
        f'<table class="heat"><thead><tr><th></th>{head}</tr><tr><th></th>{second}</tr></thead>'
        f"<tbody>{chr(10).join(rows)}</tbody></table>"
    )


def motion_map(steps: Sequence[Step]) -> str:
    """Residual over noise floor, third-octave bands × motions, for the first model and the last
    beside it; "" where the channels determine no motion."""
    models = [steps[0]] if len(steps) == 1 else [steps[0], steps[-1]]
    grids = [step.comparison.breakdown.bands_motions for step in models]
    names = grids[0].columns
    if not names:
        return ""
    heads = "".join(f'<th class="r">{escape(name)}</th>' for name in names)
    groups = "".join(
        f'<th class="gap"></th><th class="group" colspan="{len(names)}">'
        f"{escape(f'with {listed(step.added)}' if step.added else 'baseline')}</th>"
        for step in models
    )
    rows = [
        _heat_row(f"{band} Hz", [grid.ratio[i].tolist() for grid in grids])
        for i, band in enumerate(grids[0].rows)
    ]
    second = f'<th class="gap"></th>{heads}' * len(models)
    return (
        f'<table class="heat"><thead><tr><th></th>{groups}</tr><tr><th></th>{second}</tr></thead>'
        f"<tbody>{chr(10).join(rows)}</tbody></table>"
    )


def size_table(steps: Sequence[Step]) -> str:
    """Error and floor in quarters of all samples by how large the motion is, first and last
    model."""
    models = [steps[0]] if len(steps) == 1 else [steps[0], steps[-1]]
    cuts = [step.comparison.breakdown.amplitude for step in models]
    rows = [
        [
            escape(cuts[0][i].name),
            *(percent(cut[i].error) for cut in cuts),
            percent(cuts[0][i].floor),
        ]
        for i in range(len(cuts[0]))
    ]
    names = [listed(step.added) or "baseline" for step in models]
    heads = ["motion", *(f"E, {escape(name)}" for name in names), "floor"]
    return table(heads, rows, "l" + "r" * (len(heads) - 1))


def _heat_row(name: str, blocks: Sequence[Sequence[float]]) -> str:
    cells = "".join('<td class="gap"></td>' + "".join(map(_heat_cell, b)) for b in blocks)
    return f'<tr><td class="name">{escape(name)}</td>{cells}</tr>'


def _heat_cell(ratio: float) -> str:
    colour = heat_class(ratio)
    coloured = f' class="{colour}"' if colour else ""
    return f"<td{coloured}>{heat_words(ratio)}</td>"


def ranking_table(ranking: Sequence[Ranked], effects: Mapping[str, Effect]) -> str:
    """The effects of the library that were simulated in full on the first rung, best first; those
    that were screened only, and those that do not apply, folded into a line each."""
    idle = [item for item in ranking if item.reason.startswith("does not apply")]
    shown = [item for item in ranking if item not in idle]
    rows = [_ranking_row(i, item, effects) for i, item in enumerate(shown, start=1)]
    pairs = list(zip(shown, rows, strict=True))
    tried = [row for item, row in pairs if item.confirmed_error is not None]
    rest = [[*row[:3], row[-1]] for item, row in pairs if item.confirmed_error is None]
    headings = ["", "effect", "screened E", "confirmed E", "held-out E", "log evidence", "p"]
    found = table([*headings, "why, or why not"], tried, "rlrrrrrl") if tried else ""
    if rest:
        screened = table([*headings[:3], "why not"], rest, "rlrl")
        count = "1 effect was" if len(rest) == 1 else f"{len(rest)} effects were"
        found += f"<details><summary>{count} screened only</summary>{screened}</details>"
    return found + _folded(idle)


def _folded(idle: Sequence[Ranked]) -> str:
    """The effects that do not apply, by their reason; closed until somebody asks."""
    if not idle:
        return ""
    reasons: dict[str, list[str]] = {}
    for item in idle:
        reasons.setdefault(item.reason.removeprefix("does not apply: "), []).append(item.effect)
    lines = "".join(
        f"<p>{escape(reason[0].upper() + reason[1:])}: {escape(', '.join(names))}.</p>"
        for reason, names in reasons.items()
    )
    count = f"{len(idle)} effects do" if len(idle) > 1 else "1 effect does"
    return f"<details><summary>{count} not apply</summary>{lines}</details>"


def _ranking_row(number: int, item: Ranked, effects: Mapping[str, Effect]) -> list[str]:
    title = f"{effects[item.effect].title} " if item.effect in effects else ""
    name = escape(item.effect)
    if item.reason.startswith("accepted"):
        name = f"<strong>{name}</strong>"
    near = listed([f"{name} ({angle:.0f}°)" for name, angle in item.ambiguous_with])
    doubt = f"<small>hard to tell from {escape(near)}</small>" if near else ""
    return [
        str(number),
        f"{name}<small>{escape(f'{title}({item.place})')}</small>",
        "–" if item.screened_error is None else percent(item.screened_error),
        "–" if item.confirmed_error is None else percent(item.confirmed_error),
        "–" if item.validated_error is None else percent(item.validated_error),
        "–" if item.evidence is None else signed(item.evidence),
        "–" if item.p_value is None else chance(item.p_value),
        escape(item.reason.replace("e-", "e\u2011")) + doubt,
    ]


def limits_table(limits: Sequence[Limit]) -> str:
    """Effects, the form they were screened in, and from where on they would have been found."""
    rows = [[escape(part) for part in (x.effect, x.form, limit_words(x))] for x in limits]
    return table(["effect", "form", "from"], rows, "lll")


def effect_parameters_table(effect: Effect, step: Step, campaign: Campaign) -> str:
    """An accepted effect's numbers with their intervals and meanings."""
    meanings = {
        p.name: (p.unit, p.meaning)
        for p in effect.parameters_for(step.rung.model.values, campaign.channels)
    }
    rows = []
    prefix = f"{effect.id}."
    for full, (value, deviation) in step.parameters.items():
        if full.startswith(prefix):
            name = full.removeprefix(prefix)
            unit, meaning = meanings.get(name, (unit_of(name), "over the fitted runs"))
            shown = "" if unit == "1" else unit
            cells = [name, meaning, interval(value, deviation), shown]
            rows.append([f"<code>{escape(cells[0])}</code>", *map(escape, cells[1:])])
    return table(["parameter", "meaning", "value ± 2 sd", "unit"], rows, "llrl")


def vehicle_table(step: Step) -> str:
    """The vehicle's numbers, and what was measured of several of them: nominal, fitted, and how far
    the fit moved them."""
    rows, fitted = [], step.rung.fit
    effects = tuple(f"{effect.id}." for effect in step.rung.model.effects)
    for free in (*fitted.shared, *map(Free.of, fitted.measured)):
        if free.name.startswith(effects):
            continue
        value, deviation = step.parameters[free.name]
        moved = round(free.away(value), 1) + 0.0
        rows.append(
            [
                escape(label_of(free.name)),
                escape(interval(free.mean, free.sigma)),
                f"<strong>{escape(interval(value, deviation))}</strong>",
                escape(unit_of(free.name)),
                f"{moved:+.1f}".replace("-", "−") if moved else "0.0",
                _moved(free, value, deviation),
            ]
        )
    headings = ["", "nominal ± 2 sd", "fitted ± 2 sd", "unit", "moved, sd", "−3 … +3 sd"]
    return table(headings, rows, "lrrlrl")


def _moved(free: Free, value: float, deviation: float) -> str:
    """The fitted interval on a scale of ±3 nominal standard deviations, as a small drawing."""

    def x(away: float) -> float:
        return 60 + 20 * min(max(away, -3.0), 3.0)

    away, known = free.away(value), 2 * deviation / free.sigma_at(value)
    low, high = x(away - known), x(away + known)
    return (
        '<svg class="moved" viewBox="0 0 120 14" aria-hidden="true">'
        '<rect x="20" y="4" width="80" height="6" style="fill:var(--rule)"/>'
        '<path d="M60 2V12" style="stroke:var(--soft);stroke-width:1"/>'
        f'<path d="M{low:.1f} 7H{high:.1f}" style="stroke:var(--after);stroke-width:2"/>'
        f'<circle cx="{x(away):.1f}" cy="7" r="2.8" style="fill:var(--after)"/></svg>'
    )


def runs_table(campaign: Campaign, step: Step) -> str:
    """Every run: role, what it drove over or what the rig imposed, error."""
    where = {part.name: part for part in step.comparison.breakdown.run}
    rows = []
    for run in campaign.runs:
        part = where[run.id]
        rows.append(
            [
                escape(run.id),
                "fitted" if run.role == "fit" else "held out",
                *(_motion(run) if isinstance(run, RigRun) else _drive(run, step)),
                f"{len(run.time_s) / campaign.sample_rate_hz:.1f}",
                percent(part.error),
                percent(part.floor),
            ]
        )
    about = ["track", "nominal km/h", "fitted km/h"]
    if isinstance(campaign, ComponentCampaign):
        about = [f"{campaign.drive} imposed", "largest m", "largest N"]
    return table(["run", "role", *about, "s", "error E", "floor"], rows, "lllrrrrr")


def _drive(run: Run, step: Step) -> list[str]:
    """Track, nominal and fitted speed."""
    model = step.rung.model
    fitted = "speed_m_s" in model.runs.get(run.id, {})
    return [
        escape(track_words(run.track)),
        f"{run.speed_m_s * 3.6:.3g}",
        f"{model.speed_m_s(run.id, run.speed_m_s) * 3.6:.2f}" if fitted else "–",
    ]


def _motion(run: RigRun) -> list[str]:
    """What the rig did, and the largest displacement and force."""
    kind = "" if run.force.any() else "none: free decay"
    return [kind, *(significant(float(np.abs(y).max())) for y in (run.displacement, run.force))]


def level_table(levels: Sequence[tuple[str, float, float]]) -> str:
    """Runs held out, from the least motion to the most, and what a linear model leaves of each."""
    rows = [
        [escape(run), significant(level), percent(error)]
        for run, level, error in sorted(levels, key=lambda row: row[1])
    ]
    return table(["run", "body, rms m/s²", "left by the best linear model"], rows, "lrr")


def quantity_table(comparison: Comparison) -> str:
    """What each quantity leaves by itself, in units of its own; nothing where there is but one."""
    rows = [
        [
            escape(each.quantity),
            f"{significant(each.noise_rms)} {escape(each.unit)}",
            percent(each.error_fit),
            percent(each.floor_fit),
            percent(each.error_validate),
            percent(each.floor_validate),
        ]
        for each in comparison.by_quantity
    ]
    headings = ["quantity", "noise in band", "E, runs fitted", "its floor", "E, runs held out"]
    return table([*headings, "its floor"], rows, "lrrrrr") if rows else ""


def ladder_table(steps: Sequence[Step]) -> str:
    """The rungs as numbers."""
    floor = steps[-1].comparison.floor
    rows = []
    for step in steps:
        rows.append(
            [
                escape(" + ".join(["baseline", *step.added])),
                percent(step.rung.error_fit),
                percent(step.rung.error_validate),
                significant(step.comparison.breakdown.total.error / step.comparison.floor.error),
            ]
        )
    rows.append(["noise floor", percent(floor.error_fit), percent(floor.error_validate), "1"])
    if floor.beside_noise:
        least = percent(floor.expected_fit), percent(floor.expected_validate)
        times = significant(floor.expected / floor.error)
        rows.append([f"a right model may leave, with {floor.beside_noise}", *least, times])
    headings = ["model", "E, runs fitted", "E, runs held out", "residual / floor, all runs"]
    return table(headings, rows, "lrrr")
