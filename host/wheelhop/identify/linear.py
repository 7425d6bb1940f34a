"""Is what is missing between axle and body linear?

The best linear model from axles to body is all that a linear mechanism can be, whatever it holds: a
seat, a mount, a bending frame. Where it leaves no more than noise, what the physical model lacks
there is linear. Where it leaves more, that alone says little (an engine that shakes the body is no
function of the axles' motion at all): "not linear" is said only if a nonlinear law of the struts'
motion explains what no linear model does, on runs no fit has seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, CampaignError
from wheelhop.identify.gram import projected, transient_basis
from wheelhop.identify.identify import identify
from wheelhop.identify.judge import Judged
from wheelhop.identify.laws import explained, strut_motion
from wheelhop.identify.matrix import TransferMatrix
from wheelhop.identify.select import Candidate, best, candidate, of_orders
from wheelhop.identify.spectra import Measured, Spectra, measure, through
from wheelhop.identify.structure import Structure, Suspensions, suspensions
from wheelhop.vehicle import Vehicle

Array = NDArray[np.float64]

Answer = Literal["linear", "not linear", "cannot tell"]

ORDERS = (6, 8, 10)
QUIET_ORDERS = (6, 8)
AT_FLOOR = 1.5
"""Error over that of stated noise up to which noise may be all: channels differ by that much."""
FLAT_REST = 1.3
"""Mean over median power up to which a residual may be noise."""
LASTING = 5.0
"""A mode that decays by fewer e-folds in a run can pass a line off as an initial state: a matrix
that has none must be at the floor, too."""
EXPLAINED = 0.2
"""Share of the squared residual on held-out runs that a law must explain to be believed."""


@dataclass(frozen=True, eq=False)
class Linearity:
    """The answer and what it stands on.

    `over_floor` is the error of the best linear model on held-out runs over that of the noise (NaN
    without stated noise), `peakedness` its residual's mean over median power, `law` the kind of
    nonlinear law that explains most and `share` how much of the squared residual. `coherence` (n,)
    is the share of each output's power on held-out runs that the linear model explains. `levels`
    are the held-out runs' rms motion of the body, m/s², and residual over measured: a linear
    mechanism errs alike at every level, noise apart. `model` is the best linear model itself.
    """

    answer: Answer
    sentence: str
    order: int
    error: float
    over_floor: float
    peakedness: float
    law: str | None
    share: float
    coherence: Array
    levels: tuple[tuple[str, float, float], ...]
    model: TransferMatrix | None = None

    def to_json(self) -> dict[str, Any]:
        """Plain numbers; what is undetermined is None."""
        return {
            "answer": self.answer,
            "sentence": self.sentence,
            "order": self.order,
            "error_validate": _number(self.error),
            "over_floor": _number(self.over_floor),
            "peakedness": _number(self.peakedness),
            "law": self.law,
            "share_explained_by_law": _number(self.share),
            "coherence": [_number(c) for c in self.coherence.tolist()],
            "levels": [
                {"run": run, "rms_m_s2": level, "error": error} for run, level, error in self.levels
            ],
        }


def linearity(campaign: Campaign, vehicle: Vehicle) -> Linearity:
    """Whether a linear mechanism can explain the body's motion from the axles'.

    "cannot tell" with a reason, too, where points or held-out runs are lacking.
    """
    try:
        measured = measure(campaign)
    except CampaignError as error:
        return _cannot(f"what the axles do to the body cannot be identified: {error}")
    if measured.inputs != (0, 1, 2, 3) or measured.outputs != (0, 1, 2, 3):
        return _cannot("four axle and four body points are needed to tell linear from not linear")
    if len(measured.fit_ids) < 2 or not measured.validate:
        return _cannot("two runs to fit and one held out are needed to tell linear from not linear")
    belief = suspensions(vehicle.values, vehicle.uncertainty)
    try:
        tried = _tried(measured, belief)
    except CampaignError as error:
        return _cannot(f"the runs are too short for a transfer matrix: {error}")
    chosen = min(best(tried[:-1]), tried[-1], key=lambda c: c.judging.error)
    return _answer(chosen, tried, measured, belief, campaign.sample_rate_hz)


def _tried(measured: Measured, belief: Suspensions) -> list[Candidate]:
    """Each order, and the best of them once more without left-right symmetry."""
    mirrored = of_orders(measured, Structure(), belief, ORDERS)
    return [
        *mirrored,
        candidate(measured, Structure(left_right=False), best(mirrored).order, belief),
    ]


def _answer(
    chosen: Candidate,
    tried: Sequence[Candidate],
    measured: Measured,
    belief: Suspensions,
    rate_hz: float,
) -> Linearity:
    held = chosen.judging
    over = held.error / held.floor
    peak = peakedness(chosen.model, measured.validate)
    law, share = None, 0.0
    at_floor = _at_floor(held, peak)
    rings = at_floor and not any(
        _at_floor(c.judging, peakedness(c.model, measured.validate))
        and not _rings_on(c.model, measured, rate_hz)
        for c in tried
    )
    if not at_floor:
        law, share = _law(chosen.model, measured, belief, rate_hz)
    power = np.sqrt(held.measured.sum(axis=1) / (4 * measured.validate[0].samples))
    each = np.sqrt(held.residual.sum(axis=1) / held.measured.sum(axis=1))
    found = Linearity(
        answer="cannot tell",
        sentence="",
        order=chosen.order,
        error=held.error,
        over_floor=over,
        peakedness=peak,
        law=law,
        share=share,
        coherence=1.0 - held.residual.sum(axis=0) / held.measured.sum(axis=0),
        levels=tuple(zip(held.runs, power.tolist(), each.tolist(), strict=True)),
        model=chosen.model,
    )
    times = (
        f"{over:.1f} times the noise" if np.isfinite(over) else f"{held.error:.1%} of the motion"
    )
    leaves = f"the best linear model from axles to body (order {chosen.order}) leaves {times}"
    if rings:
        return replace(
            found,
            sentence="Whether what is missing between axle and body is linear cannot be told: a"
            " line that never decays shakes the body, and the axles may have no part in it.",
        )
    if at_floor:
        return replace(
            found,
            answer="linear",
            sentence=f"Between axle and body a linear mechanism explains all: {leaves}.",
        )
    if law is not None and share >= EXPLAINED:
        return replace(
            found,
            answer="not linear",
            sentence=f"Between axle and body something is not linear: {leaves}, and a law of the"
            f' kind "{law}" explains {share:.0%} of that on runs held out.',
        )
    return replace(
        found,
        sentence="Whether what is missing between axle and body is linear cannot be told:"
        f" {leaves}, of which laws of the struts explain {max(share, 0.0):.0%}: too little.",
    )


def _at_floor(held: Judged, peak: float) -> bool:
    return peak <= FLAT_REST and not held.error / held.floor > AT_FLOOR


def _rings_on(model: TransferMatrix, measured: Measured, rate_hz: float) -> bool:
    """Whether a mode in band outlasts the longest run."""
    longest = max(part.samples for part in measured.fit) / rate_hz
    high = max(float(part.omega[-1]) for part in measured.fit)
    omega, zeta = model.sections.omega, model.sections.zeta
    return bool(((omega < high) & (zeta * omega * longest < LASTING)).any())


def _law(
    model: TransferMatrix, measured: Measured, belief: Suspensions, rate_hz: float
) -> tuple[str | None, float]:
    """Kind of law and share explained: on the best linear matrix, and on those of the half of the
    runs with least travel, where a stop is not reached and the linear body shows."""
    quiet = _quiet_half(measured.fit, rate_hz)
    tried = [model] if model.structure.symmetry == "reciprocal" else []
    for order in QUIET_ORDERS:
        try:
            tried.append(
                identify(quiet, order=order, suspensions=belief, noise_rms=measured.noise_rms)
            )
        except CampaignError:
            break
    found: tuple[str | None, float] = (None, 0.0)
    power = np.concatenate([p.sum(axis=(1, 2)) for p in _residual_power(model, measured.validate)])
    for body in tried:
        law, left = explained(body, model, measured, rate_hz)
        share = 1.0 - float(left @ power / power.sum())
        if share > found[1]:
            found = (law, share)
    return found


def _residual_power(model: TransferMatrix, runs: Sequence[Spectra]) -> list[Array]:
    """Power (r, k, n) of what the model leaves of each run, initial states projected out."""
    out = []
    for part in runs:
        basis = transient_basis(part.omega, model.sections, np.ones(len(part.omega)))
        rest = part.outputs - through(model(1j * part.omega), part.inputs)
        rows = projected(rest, basis).reshape(len(part.runs), 2, len(part.omega), -1)
        out.append(np.asarray(np.sum(rows**2, axis=1)))
    return out


def peakedness(model: TransferMatrix, runs: Sequence[Spectra]) -> float:
    """Mean over median of the residual's power, scaled to 1 for noise of any level and colour of
    the inputs' share; more where the residual gathers in lines or in some runs."""
    total = expected = 0.0
    for part, power in zip(runs, _residual_power(model, runs), strict=True):
        white = power / (1.0 + np.sum(np.abs(model(1j * part.omega)) ** 2, axis=2))
        level = np.median(white, axis=(0, 1)) / np.log(2.0)
        total += float(white.mean(axis=(0, 1)).sum()) * len(part.runs)
        expected += float(level.sum()) * len(part.runs)
    return total / expected


def _quiet_half(runs: Sequence[Spectra], rate_hz: float) -> list[Spectra]:
    travel = [np.abs(strut_motion(part, rate_hz)[0]).max(axis=(1, 2)) for part in runs]
    limit = float(np.median(np.concatenate(travel)))
    out = []
    for part, peak in zip(runs, travel, strict=True):
        keep = np.flatnonzero(peak <= limit)
        if len(keep):
            out.append(part.only(keep))
    return out


def _cannot(why: str) -> Linearity:
    nan = float("nan")
    return Linearity(
        "cannot tell", f"{why[0].upper()}{why[1:]}.", 0, nan, nan, nan, None, 0.0, np.zeros(0), ()
    )


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
