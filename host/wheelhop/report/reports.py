"""The two reports: what a diagnosis found, and how one model compares."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from wheelhop.campaign import Campaign
from wheelhop.diagnose import Diagnosis, Step
from wheelhop.effects import Effect
from wheelhop.files.words import percent, significant
from wheelhop.gate import Finding
from wheelhop.law import LastRungs
from wheelhop.report import sections
from wheelhop.report.axle_to_body import axle_to_body
from wheelhop.report.dynamometer import dynamometer
from wheelhop.report.law_page import law_section
from wheelhop.report.page import facts, paragraph, title, write_page
from wheelhop.report.summary import summary
from wheelhop.report.words import comparison_headline, headline, over_floor


def write_diagnosis_report(
    path: Path,
    campaign: Campaign,
    diagnosis: Diagnosis,
    effects: Mapping[str, Effect],
    law: LastRungs | None = None,
) -> None:
    """Write a diagnosis as one self-contained HTML page.

    ``effects`` is the library that was searched: the page says of each of its effects why it was
    accepted, or why not. ``law`` is what was found beyond their names.
    """
    steps = diagnosis.ladder
    confidence = f"{100 * diagnosis.confidence:.0f} %"
    body = [
        paragraph(f"wheelhop diagnosis · {campaign.title}", "kicker"),
        title(headline(diagnosis)),
        facts([("confidence", confidence), *_key_numbers(campaign, steps)], "key"),
        *summary(diagnosis, campaign),
        sections.findings(diagnosis.findings),
        sections.loops(campaign, steps),
        dynamometer(campaign, steps),
        sections.ladder(steps if law is None else (*steps, *law.shown)),
        "" if law is None else law_section(law),
        sections.traces(campaign, steps),
        sections.where(steps),
        sections.struts(campaign, steps),
        axle_to_body(diagnosis.axle_to_body, campaign, steps),
        sections.ranking(diagnosis, effects),
        sections.model(campaign, steps),
        sections.next_run(diagnosis),
        sections.limits(diagnosis),
        sections.method(campaign, steps),
    ]
    write_page(path, f"{campaign.title}: {', '.join(diagnosis.verdict)}", body)


def write_comparison_report(
    path: Path,
    campaign: Campaign,
    steps: Sequence[Step],
    axles: Step | None = None,
    findings: Sequence[Finding] = (),
) -> None:
    """Write how a model compares with the records, as one self-contained HTML page.

    ``steps`` are the baseline and, if effects were added to it, one step for each of them;
    ``axles`` is the last model driven by the measured axle motion, ``findings`` what the gate said.
    """
    body = [
        paragraph(f"wheelhop comparison · {campaign.title}", "kicker"),
        title(comparison_headline(steps)),
        facts(_key_numbers(campaign, steps), "key"),
        sections.findings(findings),
        sections.loops(campaign, steps),
        dynamometer(campaign, steps),
        sections.ladder(steps),
        sections.traces(campaign, steps),
        sections.where(steps),
        sections.struts(campaign, steps),
        *([sections.axle_driven(steps[-1], axles)] if axles is not None else []),
        sections.model(campaign, steps),
        sections.method(campaign, steps),
    ]
    write_page(path, f"{campaign.title}: comparison", body)


def _key_numbers(campaign: Campaign, steps: Sequence[Step]) -> list[tuple[str, str]]:
    first, last, floor = steps[0].rung.error, steps[-1].rung.error, steps[-1].floor
    runs = "held out" if campaign.validate_runs else "fitted"
    fall = percent(first) if len(steps) == 1 else f"{percent(first)} → {percent(last)}"
    return [
        (f"error E, runs {runs}", fall),
        ("noise floor", percent(floor)),
        ("error / floor", significant(over_floor(steps[-1]))),
        ("runs fitted / held out", f"{len(campaign.fit_runs)} / {len(campaign.validate_runs)}"),
    ]
