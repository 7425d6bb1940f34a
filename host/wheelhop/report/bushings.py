"""The report on bushings: moduli, loops, models and what they are worth, one section a specimen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from wheelhop.files.words import significant
from wheelhop.material import Candidate, Consistency, ModulusFit, RigData
from wheelhop.report import bushing_figures as figures
from wheelhop.report.page import figure, paragraph, section, table, title, write_page
from wheelhop.report.svg import equation, inline


@dataclass(frozen=True, eq=False)
class BushingResult:
    """What was found about one specimen: the models, best first, and whether its data are causal.

    ``elements`` is the number of Maxwell elements the best model takes in the time domain, or the
    reason why none follow it.
    """

    name: str
    data: RigData
    candidates: Sequence[Candidate]
    consistency: Consistency
    passive_hz: tuple[float, float] | None
    violation: float
    elements: str

    @property
    def best(self) -> ModulusFit:
        """The fit of least AICc."""
        return self.candidates[0].fit


def write_bushing_report(path: Path, results: Sequence[BushingResult]) -> None:
    """Write what was found about bushings as one self-contained HTML page."""
    names = ", ".join(result.name for result in results)
    body = [
        paragraph("wheelhop bushing", "kicker"),
        title(_headline(results)),
    ]
    if len(results) > 1:
        body.append(
            section(
                "Loss angle of all specimens",
                figure(
                    inline(figures.phase_figure(results), "phase", "loss angle of every specimen"),
                    "Points are measured, lines the model of least AICc. A pure power law has a"
                    " constant angle.",
                ),
            )
        )
    for i, result in enumerate(results):
        body.append(_specimen(result, i))
    body.append(_method(results))
    write_page(path, f"Bushings: {names}", body)


def _headline(results: Sequence[BushingResult]) -> str:
    number = "One specimen" if len(results) == 1 else f"{len(results)} specimens"
    strange = [r.name for r in results if not r.consistency.causal]
    if strange:
        return f"{number}; no causal specimen has the moduli of {', '.join(strange)}."
    worst = max(r.best.rms for r in results)
    return f"{number}, described within {significant(100 * worst, 2)} % rms."


def _specimen(result: BushingResult, number: int) -> str:
    ident = f"s{number}"
    parts = [
        paragraph(_findings(result)),
        figure(
            inline(figures.moduli_figure(result), f"{ident}m", f"moduli of {result.name}"),
            "Dynamic and loss modulus, measured and modelled; below, what each model is off.",
        ),
    ]
    if result.data.points:
        parts.append(
            figure(
                inline(figures.loops_figure(result), f"{ident}l", f"loops of {result.name}"),
                "Force against displacement over one cycle, both about their means; below, the"
                " difference from the best model’s ellipse.",
            )
        )
    parts.append(_models(result))
    parts.append(_parameters(result.best))
    parts += [paragraph(text) for text in _amplitude(result)]
    return section(result.name, *parts)


def _findings(result: BushingResult) -> str:
    found = result.consistency
    causal = (
        "Dynamic and loss modulus belong together (Kramers–Kronig)"
        if found.causal
        else "Dynamic and loss modulus cannot both be right: a causal specimen that has one lacks"
        f" the other by {significant(100 * found.disagreement, 2)} % rms. No model is to be trusted"
    )
    expansion = f"the loss by (3.16) is off by {significant(100 * found.expansion_residual, 2)} %"
    model = result.best.model
    sentences = [f"{causal}; {expansion}.", f"Least AICc: {model.title}."]
    if result.passive_hz is None:
        sentences.append("It gives energy somewhere inside the measured range.")
    else:
        low, high = result.passive_hz
        sentences.append(
            f"It loses energy from {significant(low, 2)} Hz to {significant(high, 2)} Hz at least."
        )
    sentences.append(result.elements)
    return " ".join(sentences)


def _models(result: BushingResult) -> str:
    rows = []
    first = result.candidates[0].aicc
    for candidate in result.candidates:
        fit = candidate.fit
        rows.append(
            (
                escape(fit.model.title),
                str(fit.count),
                f"{fit.error:.3g}",
                f"{100 * fit.rms:.2f}",
                f"{candidate.aicc - first:+.1f}",
                f"{100 * candidate.held_out:.2f}",
            )
        )
    headings = ("model", "free", "J", "rms, %", "AICc", "held out, %")
    return table(headings, rows, "lrrrrr")


def _parameters(fit: ModulusFit) -> str:
    widths = fit.half_widths()
    rows = [
        (escape(c.name), f"{value:.5g}", f"± {width:.2g}" if width else "at its bound", c.unit)
        for c, value, width in zip(fit.model.coefficients, fit.parameters, widths, strict=True)
    ]
    return f'<div class="equation">{equation(fit.model.equation)}</div>' + table(
        ("parameter", "value", "95 %", "unit"), rows, "lrrl"
    )


def _amplitude(result: BushingResult) -> list[str]:
    sentences = []
    for effect in result.data.amplitude_effects:
        change = 100 * effect.per_doubling
        where = "linear theory ends here" if effect.significant else "no more than chance"
        sentences.append(
            f"At {effect.frequency_hz:.3g} Hz the stiffness changes by {change:+.2g} ±"
            f" {100 * effect.uncertainty:.1g} % (standard deviation) when the amplitude doubles:"
            f" {where}."
        )
    return sentences


def _method(results: Sequence[BushingResult]) -> str:
    sources = dict.fromkeys(
        (c.fit.model.title, c.fit.model.source) for r in results for c in r.candidates
    )
    rows = [(escape(name), escape(source)) for name, source in sources]
    return section(
        "How it was done",
        paragraph(
            "J is the sum of squared logarithms of modelled over measured dynamic and loss modulus,"
            " (3.41). Angular frequency is in rad/s wherever a logarithm or a power of it is taken."
            " Intervals are those of a linear model with independent errors. AICc is relative to"
            " the best; held out: rms error at a fifth of the frequencies no fit has seen, in turn."
        ),
        table(("model", "source"), rows, "ll"),
    )
