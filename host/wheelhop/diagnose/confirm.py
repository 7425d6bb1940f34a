"""Confirmation: an effect simulated in full and fitted together with the vehicle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from wheelhop.diagnose.probe import FitProbe
from wheelhop.diagnose.screen import Screened, Variant, with_variant
from wheelhop.fit import Fit, Workshop, effect_parameters, fit
from wheelhop.simulate import Model


@dataclass(frozen=True, eq=False)
class Rung:
    """A model fitted to the "fit" runs, and what it does on the "validate" runs when only what
    those leave free is fitted there."""

    fit: Fit
    validation: Fit | None

    @property
    def model(self) -> Model:
        """The model, what every run leaves free included."""
        runs = self.validation.model.runs if self.validation is not None else {}
        return Model(self.fit.model.values, self.fit.model.effects, {**self.fit.model.runs, **runs})

    @property
    def error_fit(self) -> float:
        """E over the runs fitted."""
        return self.fit.error

    @property
    def error_validate(self) -> float:
        """E over the other runs, charged for the degrees of freedom each of them was given."""
        if self.validation is None:
            return float("nan")
        runs = self.validation.runs
        rss = sum(r.rss * r.bench.size / max(r.bench.size - len(r.own), 1) for r in runs)
        return float(np.sqrt(rss / sum(r.bench.energy for r in runs)))

    @property
    def evidence(self) -> float:
        """Logarithm of the model's evidence by Laplace's method, up to a constant of the data."""
        return self.fit.evidence


def validate(workshop: Workshop, fitted: Fit) -> Rung:
    """Fit what the "validate" runs leave free, everything else kept."""
    benches = workshop.of_role("validate")
    if not benches:
        return Rung(fitted, None)
    return Rung(fitted, fit(workshop, fitted.model, (), benches))


def confirm(workshop: Workshop, base: Rung, screened: Screened) -> Rung:
    """Fit the model of `base` with the screened effect added.

    Derivatives with respect to the base's parameters are taken from the base: a quick fit that
    ends a little above the minimum; `refit` goes all the way.
    """
    variant, amplitudes = _start(workshop, base, screened)
    model = with_variant(base.model, variant, amplitudes)
    shared = [*base.fit.shared, *effect_parameters(workshop.campaign, model, variant.effect)]
    benches = workshop.of_role("fit")
    return validate(workshop, fit(workshop, model, shared, benches, base.fit))


def refit(workshop: Workshop, rung: Rung) -> Rung:
    """Fit all parameters of a rung again, with all derivatives following the model."""
    return validate(workshop, fit(workshop, rung.model, rung.fit.shared, workshop.of_role("fit")))


def without(workshop: Workshop, rung: Rung, effect_id: str) -> Rung:
    """The rung's model with one effect taken out, fitted again."""
    shared = [f for f in rung.fit.shared if not f.name.startswith(f"{effect_id}.")]
    model = rung.model.without_effect(effect_id)
    return validate(workshop, fit(workshop, model, shared, workshop.of_role("fit")))


SMALLEST_START = 0.1
"""A fit begins with at least this fraction of an amplitude's scale: at zero some laws are flat."""


def _start(
    workshop: Workshop, base: Rung, screened: Screened
) -> tuple[Variant, Mapping[str, float]]:
    """Where the fit of an effect begins: at what screening found, or where the effect suggests."""
    variant = screened.variant
    amplitudes = {}
    for p in variant.amplitudes:
        value = min(max(screened.amplitudes[p.name], -3 * p.scale), 3 * p.scale)
        small = abs(value - p.absent) < SMALLEST_START * p.scale
        amplitudes[p.name] = p.absent + SMALLEST_START * p.scale if small else value
    benches = list(workshop.benches.values())
    probe = FitProbe(workshop, base.model, benches)
    starts = workshop.each(lambda b: variant.effect.run_start(probe, b.simulator.setting), benches)
    runs = {bench.run.id: start for bench, start in zip(benches, starts, strict=True)}
    return replace(variant, runs=runs), amplitudes
