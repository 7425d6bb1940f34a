"""The summary: what is missing, how sure that is, what it changes and what to do next, in plain
words under the numbers; on a page of its own, at the head of the report, and on the page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from wheelhop.campaign import Campaign
from wheelhop.diagnose import Diagnosis
from wheelhop.effects import Misstatement
from wheelhop.files.words import listed, percent, significant
from wheelhop.report import figures
from wheelhop.report.cases import cases
from wheelhop.report.page import QUESTIONS, facts, figure, paragraph, title, write_page
from wheelhop.report.svg import inline
from wheelhop.report.words import headline, in_numbers, next_run_words

SURE = ((0.98, "As good as certain"), (0.9, "Very likely"), (0.7, "Likely"), (0.4, "Open"))
"""Words for a confidence, from so much on."""
GUESS = "A guess"


def answers(diagnosis: Diagnosis, campaign: Campaign) -> tuple[str, str, str, str]:
    """The four answers, to `QUESTIONS`."""
    return (
        headline(diagnosis),
        _sure(diagnosis, campaign),
        _changes(diagnosis, campaign),
        " ".join(_next(diagnosis)),
    )


def summary(diagnosis: Diagnosis, campaign: Campaign) -> list[str]:
    """The numbers on top, the four answers below them, and the worst place before and after."""
    steps = diagnosis.ladder
    worst = cases(campaign.channels, steps)[0]
    drawing = inline(
        figures.case_figure(worst, listed(steps[-1].added)),
        "summary",
        f"channel {worst.channel} of run {worst.run_id}, measured and modelled",
    )
    caption = (
        f"Where the baseline fails worst, {worst.channel} in {worst.run_id}. Grey: measured."
        " Orange: the baseline. Blue: with what was found."
    )
    return [
        *(paragraph(line, "numbers") for line in [in_numbers(steps)] if line),
        facts(list(zip(QUESTIONS, answers(diagnosis, campaign), strict=True)), "answers"),
        figure(drawing, caption),
    ]


def write_summary(path: Path, campaign: Campaign, diagnosis: Diagnosis) -> None:
    """Write the summary as one self-contained page, printed where the name ends in .pdf."""
    body = [
        paragraph(f"wheelhop · {campaign.title}", "kicker"),
        title(" and ".join(diagnosis.verdict)),
        *summary(diagnosis, campaign),
    ]
    write_page(path, f"{campaign.title}: summary", body)


def _sure(diagnosis: Diagnosis, campaign: Campaign) -> str:
    sure = diagnosis.confidence
    words = next((words for least, words in SURE if sure >= least), GUESS)
    held_out = len(campaign.validate_runs)
    judged = f"{held_out} runs that no fit has seen" if held_out else "the runs it was fitted to"
    rivals = [f.about for f in diagnosis.findings if f.kind == "either"]
    also = f" Hard to tell apart: {'; '.join(rivals)}." if rivals else ""
    return f"{words}, {100 * sure:.0f} %. It was judged on {judged}.{also}"


def _changes(diagnosis: Diagnosis, campaign: Campaign) -> str:
    steps = diagnosis.ladder
    first, last = steps[0].rung.error, steps[-1].rung.error
    worst = cases(campaign.channels, steps)[0]
    before, after = (
        float(np.sqrt(np.mean((worst.measured - model) ** 2)))
        for model in (worst.before, worst.after)
    )
    where = f"{worst.channel} in {worst.run_id}"
    if len(steps) == 1:
        return (
            f"Nothing: the model leaves {percent(first)} of the motion, where noise alone would"
            f" leave {percent(steps[-1].floor)}. At the worst place, {where}, it is off by"
            f" {significant(before, 2)} {worst.unit} rms."
        )
    return (
        f"The model leaves {percent(last)} of the motion in place of {percent(first)}; noise alone"
        f" would leave {percent(steps[-1].floor)}. At the worst place, {where}, it was off by"
        f" {significant(before, 2)} {worst.unit} rms and is by {significant(after, 2)}."
    )


def _next(diagnosis: Diagnosis) -> Iterator[str]:
    """What is wrong in the files first, then what is open, then what to drive."""
    effects = diagnosis.ladder[-1].rung.model.effects
    certain = [f for f in diagnosis.findings if f.severity == "certain" and f.fixes]
    if certain:
        yield f"{certain[0].remedy}"
    if wrong := [e.title for e in effects if isinstance(e, Misstatement)]:
        yield f"Correct the campaign: {listed(wrong)}."
    if diagnosis.verdict[-1] == "unknown":
        yield "Have the force that is missing found in free form, as a curve and as a formula."
    if diagnosis.next_run is not None:
        yield next_run_words(diagnosis.next_run)
    elif not certain and not wrong and diagnosis.verdict[-1] != "unknown":
        yield _nothing_more([effect.id for effect in effects])


def _nothing_more(effects: Sequence[str]) -> str:
    if not effects:
        return "Nothing has to be recorded anew: the model can be used as it is."
    return f"Nothing has to be recorded anew: use the model with {listed(effects)} (model.toml)."
