"""The critic: what a fit's own numbers betray, said before the verdict is believed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from math import erfc, isfinite, sqrt

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign.change import Proposal, of_campaign
from wheelhop.campaign.channels import noise_key
from wheelhop.compare import Slice, estimate_noise_between_samples
from wheelhop.diagnose.diagnosis import Belief, Diagnosis, Ranked, Step
from wheelhop.diagnose.score import at_noise, nearly_all
from wheelhop.diagnose.verdict.numbers import Number, measured_of, numbers_of
from wheelhop.effects import Effect, Misstatement
from wheelhop.files.words import listed, percent, significant
from wheelhop.fit import of_forces
from wheelhop.gate import Finding
from wheelhop.gate.fixes import in_vehicle
from wheelhop.gate.numbers import impossible
from wheelhop.vehicle import Vehicle

Array = NDArray[np.float64]

MOVED = 3.0
"""Standard deviations that a number may move, or be held back by a bound, before that is said."""
AT_BOUND = 0.01  # of a number's scale
NEAR = 2.0
"""Standard deviations within which a law is not told from what it becomes at a bound."""
UNTOLD = 0.9
"""Share of the prior's variance from which the data have said next to nothing of a direction."""
FAIR = 0.5
"""A band is fair if the error in it is at most this much of that over all, or beyond it the model
leaves more than there is; and if it holds at least this much of the band, counted in octaves."""
MISFIT = 1.5  # an estimated floor over a second estimate
WHITE = 1.2
"""Two estimates from differences between samples, of fourth and of sixth order, agree this well
where these are noise, and white; a recorder's filter, or motion, makes the latter the smaller."""
ALONG_SCALE = 0.9
NAMED = 3  # numbers, in one sentence
RESTATED = ("geometry", "body", "suspension", "wheel")
"""Tables of vehicle.toml whose numbers may be restated from a fit."""


def upheld(findings: Iterable[Finding], diagnosis: Diagnosis, noise: float) -> list[Finding]:
    """What was said before the fit, less what the verdict refutes. Laws that the nominal vehicle
    lacks shift phases as a wrong clock does. If they explain nearly everything with all clocks as
    they are, no clock was wrong."""
    first, last = diagnosis.ladder[0].rung, diagnosis.ladder[-1].rung
    explained = at_noise(last, noise) or nearly_all(first, last, noise)
    in_step = explained and all(effect.place != "sensor" for effect in last.model.effects)
    return [f for f in findings if not (in_step and f.kind == "out-of-step")]


def criticism(diagnosis: Diagnosis) -> list[Finding]:
    """What is to be said of the last rung of a finished diagnosis."""
    step = diagnosis.ladder[-1]
    numbers, covariance = numbers_of(step)
    effects, floor = step.rung.model.effects, step.comparison.floor
    surely = 1.0 if floor.is_stated else 1.0 - 2.0 * floor.uncertainty
    least = surely * floor.expected_fit, surely * floor.expected_validate
    return [
        *_rivals(diagnosis.ranking, [e.id for e in effects], *least),
        *_laws(numbers, effects),
        *_bounds(numbers, effects),
        *_moved([*numbers, *measured_of(step)], effects),
        *_no_vehicle(step, numbers),
        *_untold(numbers, covariance, step.comparison.units),
        *_fair_band(diagnosis.ladder),
        *_floor(step),
    ]


def refuted(diagnosis: Diagnosis) -> list[Belief]:
    """What was stated and is held to be wrong: the beliefs in the model, and the vehicle's numbers
    that moved too far, or what was measured of several of them."""
    step = diagnosis.ladder[-1]
    effects, found = step.rung.model.effects, []
    for effect in effects:
        stated_of = effect.stated() if isinstance(effect, Misstatement) else {}
        for name, (what, stated) in stated_of.items():
            error, sd = step.parameters[f"{effect.id}.{name}"]
            sure = diagnosis.confidence if effect.id == diagnosis.verdict[0] else None
            found.append(Belief(what, stated, stated + error, sd, sure))
    vehicle = _of_vehicle([*numbers_of(step)[0], *measured_of(step)], effects)
    for n in vehicle:
        if (away := _moved_by(n)) > MOVED:
            by_chance = len(vehicle) * erfc(away / sqrt(2.0))
            found.append(Belief(n.name, n.free.mean, n.value, n.sd, max(1.0 - by_chance, 0.0)))
    return found


def _rivals(
    ranking: Sequence[Ranked], accepted: Sequence[str], least_fit: float, least_held_out: float
) -> Iterator[Finding]:
    """Effects that come as far as the one accepted: on fitted and on held-out runs there is less
    power between the two than between the better of them and the least that a right model is
    expected to leave. A law that leaves more than noise cannot rule out another by less than
    that."""
    own = next((r for r in ranking if [r.effect] == list(accepted)), None)
    if own is None or own.confirmed_error is None or own.validated_error is None:
        return
    errors = {
        other.effect: other.validated_error
        for other in ranking
        if other is not own
        and other.confirmed_error is not None
        and other.validated_error is not None
        and _as_far(other.confirmed_error, own.confirmed_error, least_fit)
        and _as_far(other.validated_error, own.validated_error, least_held_out)
    }
    if errors:
        names = [own.effect, *errors]
        others = listed([f"{name} ({percent(e)})" for name, e in errors.items()])
        expected = f"the {percent(least_held_out)} that a right model may leave"
        above = own.validated_error > least_held_out
        beyond = f"the difference is less than what is left beyond {expected}"
        told = beyond if above else f"that is within {expected}"
        yield Finding(
            "after",
            "either",
            " and ".join(names),
            f"Held out, {own.effect} leaves {percent(own.validated_error)}, about the same as"
            f" {others}: {told}.",
            f"Read the verdict as {' or '.join(names)}, and record slower and faster runs.",
        )


def _as_far(other: float, own: float, least: float) -> bool:
    return other**2 - own**2 <= max(own**2 - least**2, 0.0)


def _laws(numbers: Sequence[Number], effects: Sequence[Effect]) -> Iterator[Finding]:
    """Laws that have become another: at a bound their effect declares for it, or at no strength."""
    for effect in effects:
        own = {n.name.removeprefix(f"{effect.id}."): n for n in numbers if _of(n, effect)}
        for limit in effect.becomes:
            number = own.get(limit.parameter)
            if number is None:
                continue
            bound = number.free.lower if limit.at == "lower" else number.free.upper
            if abs(number.value - bound) <= max(
                AT_BOUND * number.free.scale, NEAR * _finite(number.sd)
            ):
                yield Finding(
                    "after",
                    "degenerate",
                    number.name,
                    f"{effect.id} with {limit.parameter} = {number.value:.3g} (its bound is"
                    f" {bound:.3g}) is no longer told from {limit.into}: {limit.why}.",
                    f"Read the verdict as {effect.id} or {limit.into}"
                    " (wheelhop compare --add tries one), and record slower and faster runs.",
                )
        strengths = [n for n in own.values() if not n.free.is_shape]
        if strengths and all(abs(n.value - n.free.mean) < NEAR * n.sd for n in strengths):
            yield Finding(
                "after",
                "degenerate",
                effect.id,
                f"{effect.id} is there at no strength that is told from none"
                f" ({_listed(strengths)}).",
                "Leave it out, or record runs that excite it more.",
            )


def cramped(step: Step) -> list[str]:
    """Numbers of a model's effects that sit on their bounds: what the runs show is more than such
    an effect can be, and a law that the library lacks may be what they show."""
    effects = step.rung.model.effects
    at_bound = _at_bound(numbers_of(step)[0], effects)
    return [n.name for n in at_bound if any(_of(n, e) for e in effects)]


def _bounds(numbers: Sequence[Number], effects: Sequence[Effect]) -> Iterator[Finding]:
    for n in _at_bound(numbers, effects):
        yield Finding(
            "after",
            "at-bound",
            n.name,
            f"{n.name} = {n.value:.4g} sits on its bound: the fit wanted to go further.",
            "Do not use this number, nor its interval; something else is missing, or these runs"
            " cannot show it.",
        )


def _at_bound(numbers: Sequence[Number], effects: Sequence[Effect]) -> Iterator[Number]:
    """Numbers on a bound that would go beyond it by more than the data leave them uncertain: Rao's
    score test. Not strengths of nothing, nor laws that become another there."""
    said = {f"{e.id}.{limit.parameter}" for e in effects for limit in e.becomes}
    for n in numbers:
        if abs(n.ahead) <= MOVED * n.sd:
            continue
        bounds = [
            bound for bound in (n.free.lower if n.ahead < 0.0 else n.free.upper,) if isfinite(bound)
        ]
        if not n.free.is_shape and any(_of(n, e) for e in effects):
            bounds = [bound for bound in bounds if bound != n.free.mean]
        if n.name not in said and any(abs(n.value - b) <= AT_BOUND * n.free.scale for b in bounds):
            yield n


def _moved(numbers: Sequence[Number], effects: Sequence[Effect]) -> Iterator[Finding]:
    vehicle = _of_vehicle(numbers, effects)
    away = {n.name: _moved_by(n) for n in vehicle}
    far = sorted((n for n in vehicle if away[n.name] > MOVED), key=lambda n: -away[n.name])
    if far:
        most = ", ".join(
            f"{n.name} from {n.free.mean:.4g} to {n.value:.4g} ({away[n.name]:.1f} sd)"
            for n in far[:NAMED]
        )
        yield Finding(
            "after",
            "moved",
            ", ".join(n.name for n in far),
            f"The fit moved {most} away from what was stated"
            + (f", and {len(far) - NAMED} more." if len(far) > NAMED else "."),
            "Measure it again, or state it with more doubt; if it is right, the model makes it up"
            " for something that is missing.",
            fixes=tuple(_restated(far)),
        )


def _restated(far: Sequence[Number]) -> Iterator[Proposal]:
    """Numbers as fitted; or as stated, with standard deviations as large as they moved."""
    named = [n for n in far if n.name.split(".")[0] in (*RESTATED, "component")]
    if named:
        names = listed([n.name for n in named])
        taken = {n.name: float(n.value) for n in named}
        doubt = {f"{n.name}_uncertainty": float(abs(n.value - n.free.mean)) for n in named}
        yield in_vehicle(f"Take the fitted {names}", taken)
        yield in_vehicle(f"State a larger uncertainty of {names}", doubt)


def _of_vehicle(numbers: Sequence[Number], effects: Sequence[Effect]) -> list[Number]:
    return [n for n in numbers if not any(_of(n, e) for e in effects) and isfinite(n.sigma)]


def _moved_by(number: Number) -> float:
    """How far a fit has moved a number, in deviations with which it moves it if what was believed
    is right: of the prior's variance, what is left afterwards is what the data did not tell."""
    told = 1.0 - (_finite(number.sd) / number.sigma) ** 2
    return abs(number.free.away(number.value)) / sqrt(max(told, 1e-4))


def _no_vehicle(step: Step, numbers: Sequence[Number]) -> Iterator[Finding]:
    values = step.rung.fit.model.values
    if "body.mass_kg" not in values:
        return
    free = {n.name for n in numbers}
    for finding in impossible(Vehicle("", values, dict.fromkeys(values, 0.0))):
        if finding.about in free:
            remedy = "Do not use the fitted numbers: they make up for something that is missing."
            yield replace(finding, when="after", remedy=remedy, severity="likely", fixes=())


def _untold(
    numbers: Sequence[Number], covariance: Array, units: Sequence[str] = ("m/s²",)
) -> Iterator[Finding]:
    """Directions of which the data say nothing: eigenvectors of the covariance in units of the
    prior, their eigenvalue, at most 1, being what is left of the prior's variance."""
    believed = [i for i, n in enumerate(numbers) if isfinite(n.sigma)]
    if not believed:
        return
    motions = "Accelerations" if set(units) == {"m/s²"} else "Motions"
    sigma = np.array([numbers[i].sigma for i in believed])
    left, directions = np.linalg.eigh(
        covariance[np.ix_(believed, believed)] / np.outer(sigma, sigma)
    )
    names = [numbers[i].name for i in believed]
    scale = np.array(
        [
            numbers[i].value / numbers[i].sigma if of_forces(name) else 0.0
            for i, name in zip(believed, names, strict=True)
        ]
    )
    if scale.any():
        scale /= np.linalg.norm(scale)
    alone = []
    for share, direction in zip(left[::-1], directions.T[::-1], strict=True):
        if share < UNTOLD:
            break
        if abs(direction @ scale) > ALONG_SCALE:
            yield Finding(
                "after",
                "unobservable",
                "common scale of masses, stiffnesses, dampings and forces",
                f"{motions} fix ratios: the common scale of all masses, stiffnesses, dampings and"
                " forces is what vehicle.toml says.",
                "Weigh the vehicle; every fitted force is as good as that number.",
                "certain",
            )
            continue
        order = np.argsort(-np.abs(direction))
        weights = np.cumsum(direction[order] ** 2)
        alone.append(
            " with ".join(names[k] for k in order[: int(np.sum(weights < 0.8)) + 1][:NAMED])
        )
    if alone:
        yield Finding(
            "after",
            "unobservable",
            ", ".join(alone),
            f"These runs say next to nothing of {'; of '.join(alone)}: the values are what was"
            " believed beforehand.",
            "Do not read them as found.",
            "possible",
        )


def _fair_band(ladder: Sequence[Step]) -> Iterator[Finding]:
    """Where the last model is fair; or else the baseline, for an effect found may stand for what
    the baseline gets wrong."""
    for step, who in ((ladder[-1], "the same model"), (ladder[0], "the baseline")):
        bands, total = step.comparison.breakdown.band, step.comparison.breakdown.total
        if not ladder[-1].above_floor or len(bands) < 4 or not total.measured > 0.0:
            return
        found = _fairest(bands, (FAIR * total.error) ** 2), _explained(bands)
        best = next((b for b in found if FAIR * len(bands) <= len(b) < len(bands)), None)
        if best is None:
            continue
        residual, measured = sum(b.residual for b in best), sum(b.measured for b in best)
        low, high = best[0].name, best[-1].name
        ends = [float(low), float(high)]
        yield Finding(
            "after",
            "fair-band",
            "band_hz",
            f"From {low} to {high} Hz {who} leaves {100 * np.sqrt(residual / measured):.0f} %, over"
            f" the whole band {100 * total.error:.0f} %: it is fairest there.",
            f"Set band_hz = [{low}, {high}] in campaign.toml to look only there.",
            "possible",
            (of_campaign(f"Look only from {low} to {high} Hz", (("band_hz",), ends)),),
        )
        return


def _stretches(bands: Sequence[Slice]) -> Iterator[Sequence[Slice]]:
    for first in range(len(bands)):
        for last in range(first + 1, len(bands) + 1):
            yield bands[first:last]


def _fairest(bands: Sequence[Slice], allowed: float) -> Sequence[Slice]:
    """The widest stretch in which so much of the power is left, no more; empty if none is."""
    fair = (
        part
        for part in _stretches(bands)
        if sum(b.residual for b in part) <= allowed * sum(b.measured for b in part)
    )
    return max(fair, key=len, default=())


def _explained(bands: Sequence[Slice]) -> Sequence[Slice]:
    """The stretch in which the model explains most: beyond it, it leaves more than no model."""
    return max(_stretches(bands), key=lambda part: sum(b.measured - b.residual for b in part))


def _floor(step: Step) -> Iterator[Finding]:
    floor = step.comparison.floor
    if not floor.is_guess:
        return
    rung = step.rung
    runs = rung.fit.runs + (() if rung.validation is None else rung.validation.runs)
    records = [
        (run.bench.run.record / run.bench.noise_scale)[:, run.bench.predicted] for run in runs
    ]
    share = runs[0].bench.band.count / runs[0].bench.band.n
    second, third = (estimate_noise_between_samples(records, share, order) for order in (4, 6))
    if second > WHITE * third:
        return
    if floor.pooled_rms > MISFIT * second:
        unstated = runs[0].bench.simulator.campaign.unstated
        keys = ", ".join(dict.fromkeys(noise_key(channel.unit) for channel in unstated))
        yield Finding(
            "after",
            "floor",
            keys,
            f"The estimated floor, {significant(floor.pooled_rms, 2)} {floor.unit}, is misfit"
            " rather than noise: from one sample to the next, where it is quietest, there is"
            f" {significant(second, 2)}.",
            f"Record a run at rest and state {keys}; the error over the floor is larger"
            " than it looks.",
        )


def _of(number: Number, effect: Effect) -> bool:
    return number.name.startswith(f"{effect.id}.")


def _finite(value: float) -> float:
    return value if isfinite(value) else 0.0


def _listed(numbers: Sequence[Number]) -> str:
    return ", ".join(f"{n.name} = {n.value:.3g} ± {2 * n.sd:.2g}" for n in numbers)
