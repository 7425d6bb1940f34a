"""Does what a model leaves of the runs held out follow from how well its numbers are known?

A prediction is no better than the numbers it is made with. Where the fitted runs hardly show a
strong effect (no wheel leaves the ground on them), held-out runs that do show it stay above the
floor although no physics is missing, and an effect with many numbers of its own would explain that.
"""

from __future__ import annotations

from wheelhop.diagnose.confirm import Rung
from wheelhop.diagnose.judge import MATERIAL, above_noise, charged, excess
from wheelhop.fit import Workshop, fit

NEARLY_ALL = 0.9
"""So much of what is left of the held-out runs must go."""


def is_settled(workshop: Workshop, rung: Rung) -> bool:
    """Whether the same effects explain all runs at once, fitted and held out, where they explain
    the fitted ones: then only the vehicle's numbers were missing, and nothing is left to explain.

    With Q the charged sum of squares of N data, of which M are held out, what a joint fit adds to
    that of the fitted runs is (Q_joint − Q_fit) / M σ² − 1. Never asked of the baseline, whose
    numbers could make up for a faint effect.
    """
    if rung.validation is None or not rung.model.effects:
        return False
    before = excess(rung, workshop.noise)
    if before <= MATERIAL or above_noise(rung.fit, workshop.noise) > MATERIAL:
        return False
    benches = (*workshop.of_role("fit"), *workshop.of_role("validate"))
    joint = fit(workshop, rung.model, rung.fit.shared, benches)
    added = charged(joint) - charged(rung.fit)
    after = added / (rung.validation.size * workshop.noise**2) - 1.0
    return after <= max(MATERIAL, (1.0 - NEARLY_ALL) * before)
