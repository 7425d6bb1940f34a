"""Results on the terminal: the ladder as bars, the ranking, the parameters."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, log

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from wheelhop.diagnose import Diagnosis, Limit, Ranked, Step
from wheelhop.files.words import chance, interval, percent, signed, significant, unit_of
from wheelhop.gate import Finding
from wheelhop.report.words import headline, limit_words, over_floor

BAR = 40  # characters, for the largest error
LEAST_SPAN = log(3.0)  # of a bar of that length: noise alone must not look like a fall


def print_ladder(steps: Sequence[Step], console: Console) -> None:
    """The error of every rung as a bar that begins at the noise floor."""
    ratios = [over_floor(step) for step in steps]
    span = max([LEAST_SPAN, *(log(ratio) for ratio in ratios if ratio > 0)])
    table = Table(box=None, pad_edge=False, show_header=False)
    for justify in ("left", "left", "right", "right"):
        table.add_column(justify=justify)
    before: tuple[str, ...] | None = None
    for step, ratio in zip(steps, ratios, strict=True):
        length = round(BAR * max(log(ratio), 0.0) / span) if ratio > 0 else 0
        error = percent(step.rung.error)
        times = f"{significant(ratio)} × floor"
        table.add_row(Text(_rung(before, step)), "│" + "█" * length, error, times)
        before = step.added
    last = steps[-1]
    table.add_row("noise floor", "│", percent(last.floor))
    if last.comparison.floor.beside_noise:
        times = f"{significant(last.expected / last.floor)} × floor"
        table.add_row("a right model may leave", "│", percent(last.expected), times)
    console.print(table)
    if not last.comparison.floor.is_stated:
        console.print(f"The noise floor is {last.comparison.floor.origin}.", highlight=False)


def _rung(before: tuple[str, ...] | None, step: Step) -> str:
    if before is None:
        return "baseline"
    added = [f"+ {name}" for name in step.added if name not in before]
    dropped = [f"- {name}" for name in before if name not in step.added]
    return " ".join(added + dropped)


def print_ranking(ranking: Sequence[Ranked], console: Console, *, rows: int = 6) -> None:
    """The first few effects and the errors they reach."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("effect", "screened", "confirmed", "held out", "log evidence", "p"):
        table.add_column(heading, justify="left" if heading == "effect" else "right")
    table.add_column("hard to tell from")
    for item in ranking[:rows]:
        near = ", ".join(f"{name} ({angle:.0f}°)" for name, angle in item.ambiguous_with)
        table.add_row(
            Text(item.effect),
            "–" if item.screened_error is None else percent(item.screened_error),
            "" if item.confirmed_error is None else percent(item.confirmed_error),
            "" if item.validated_error is None else percent(item.validated_error),
            "" if item.evidence is None else signed(item.evidence),
            "" if item.p_value is None else chance(item.p_value),
            Text(near),
        )
    console.print(table)


def print_parameters(step: Step, console: Console) -> None:
    """The numbers of the effects in a model, with their intervals."""
    prefixes = tuple(f"{effect.id}." for effect in step.rung.model.effects)
    for name, (value, deviation) in step.parameters.items():
        if name.startswith(prefixes):
            spread = " (2 sd)" if isfinite(deviation) else ""
            words = f"{interval(value, deviation)} {unit_of(name)}".rstrip()
            console.print(Text(f"  {name} = {words}{spread}"))


def print_limits(limits: Sequence[Limit], console: Console) -> None:
    """From where on these runs would have shown what is not in the model."""
    console.print("These runs would have shown, from so much on (to first order):")
    table = Table(box=None, pad_edge=False, show_header=False)
    for limit in limits:
        form = f" ({limit.form})" if limit.form else ""
        table.add_row(Text(f"  {limit.effect}{form}"), Text(limit_words(limit)))
    console.print(table)


def print_findings(findings: Sequence[Finding], console: Console) -> None:
    """One finding a paragraph: how sure it is, what it is, what to do."""
    for finding in findings:
        console.print(Text(f"{finding.severity:9s} {finding.text} {finding.remedy}"))


def print_verdict(diagnosis: Diagnosis, console: Console, *, explain: bool = True) -> None:
    """The verdict in a sentence, how sure it is, and why."""
    console.print(Text(headline(diagnosis), style="bold"))
    console.print(Text(f"Confidence {100 * diagnosis.confidence:.0f} %."))
    for line in diagnosis.explanation if explain else ():
        console.print(Text(line))
    if explain and diagnosis.axle_to_body is not None:
        console.print(Text(diagnosis.axle_to_body.sentence))
