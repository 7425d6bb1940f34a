"""Which order, and which physics to impose: judged on runs no fit has seen."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wheelhop.campaign import CampaignError
from wheelhop.identify.folded import narrow
from wheelhop.identify.identify import WASTED, identify
from wheelhop.identify.judge import Judged, judge
from wheelhop.identify.matrix import TransferMatrix
from wheelhop.identify.sections import Sections
from wheelhop.identify.spectra import Measured
from wheelhop.identify.structure import Structure, Suspensions

ORDERS = (4, 6, 8, 10, 12)
NO_WORSE = 1.01
"""A lower order that errs by less than this factor more is preferred."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A matrix of which `asked` poles were asked for, and how it does; `validate` is None where no
    run is held out. `bic` and `aicc` are the Bayesian and Akaike's corrected information criterion
    on the fitted runs: lower is better."""

    model: TransferMatrix
    fit: Judged
    validate: Judged | None
    bic: float
    aicc: float
    asked: int

    @property
    def order(self) -> int:
        """Number of poles that were kept."""
        return self.model.order

    @property
    def judging(self) -> Judged:
        """On the runs held out, or, without any, on those fitted."""
        return self.fit if self.validate is None else self.validate


def candidate(
    measured: Measured,
    structure: Structure,
    order: int,
    suspensions: Suspensions | None,
    start: Sections | None = None,
    below: Candidate | None = None,
) -> Candidate:
    """Fit one structure with at most this many poles and judge it.

    Poles that the runs do not need may end in a worse minimum. Where not all of `order` were kept,
    or one is no mode that the runs resolve, fewer are tried, too (`below`, if they have been), and
    the `best` is kept. With a `start` just its poles are fitted.

    Raises
    ------
    CampaignError
        As `identify` does.
    """
    found = _fitted(measured, structure, order, suspensions, start)
    if start is not None or order < 4 or _sound(found, measured):
        return found
    fewer = below
    if fewer is None:
        fewer = candidate(measured, structure, min(order - 2, found.order), suspensions)
    return replace(best((fewer, found)), asked=order)


def _sound(found: Candidate, measured: Measured) -> bool:
    """Whether all poles asked for were kept, as modes that the runs resolve."""
    longest_s = max(2 * np.pi / float(part.omega[1] - part.omega[0]) for part in measured.fit)
    sections = found.model.sections
    apart = narrow(sections, longest_s) | (sections.zeta > WASTED)
    return found.order == found.asked and not apart.any()


def _fitted(
    measured: Measured,
    structure: Structure,
    order: int,
    suspensions: Suspensions | None,
    start: Sections | None,
) -> Candidate:
    model = identify(
        measured.fit,
        structure,
        order=order,
        inputs=measured.inputs,
        outputs=measured.outputs,
        suspensions=suspensions if structure.symmetry == "reciprocal" else None,
        noise_rms=measured.noise_rms,
        start=start,
    )
    fit = judge(model, measured.fit, measured.noise_rms)
    held_out = judge(model, measured.validate, measured.noise_rms) if measured.validate else None
    rows = sum(2 * len(p.runs) * len(p.omega) for p in measured.fit) * len(measured.outputs)
    count = model.unknowns
    plain = rows * float(np.log(fit.residual.sum()))
    bic = plain + count * float(np.log(rows))
    aicc = plain + 2.0 * count * rows / max(rows - count - 1, 1)
    return Candidate(model, fit, held_out, bic, aicc, order)


def of_orders(
    measured: Measured,
    structure: Structure,
    suspensions: Suspensions | None,
    orders: Sequence[int] = ORDERS,
) -> list[Candidate]:
    """One candidate for each order that the runs are long enough for."""
    found: list[Candidate] = []
    for order in orders:
        below = found[-1] if found and found[-1].asked == order - 2 else None
        try:
            found.append(candidate(measured, structure, order, suspensions, below=below))
        except CampaignError:
            if not found:
                raise
            break
    return found


def best(candidates: Iterable[Candidate]) -> Candidate:
    """The lowest order whose error on held-out runs is hardly more than the least; without runs
    held out, the lowest BIC."""
    several = sorted(candidates, key=lambda c: c.order)
    if several[0].validate is None:
        return min(several, key=lambda c: c.bic)
    least = min(c.judging.error for c in several)
    return next(c for c in several if c.judging.error <= NO_WORSE * least)


def relaxed(structure: Structure) -> dict[str, Structure]:
    """The structure, and it with one piece of physics taken away or replaced at a time."""
    out = {"as chosen": structure}
    if structure.symmetry != "reciprocal":
        out["reciprocal instead"] = replace(structure, symmetry="reciprocal")
    if structure.symmetry != "symmetric":
        out["H itself symmetric (thesis)"] = replace(structure, symmetry="symmetric")
    if structure.symmetry != "free":
        out["without reciprocity"] = replace(structure, symmetry="free")
    if structure.left_right:
        out["without left-right symmetry"] = replace(structure, left_right=False)
    if structure.rigid:
        out["without rigid body at 0 Hz"] = replace(structure, rigid=False)
    if structure.stable:
        out["poles free to be unstable"] = replace(structure, stable=False)
    return out
