"""What to record next: the run on which two explanations predict the most different records."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Run
from wheelhop.diagnose.score import Rung
from wheelhop.fit import Bench, Free, Workshop
from wheelhop.simulate import Model

Array = NDArray[np.float64]

SPEEDS = 7
"""So many speeds are tried on every track, from the slowest run of the campaign to the fastest."""

FEW = 4
"""For so many of the runs that promise most, a new fit of the vehicle is allowed for, too."""


LEAST_LOG_ODDS = 1.0
"""A run expected to say less is not worth driving: of what differs from run to run by its nature (a
driver's speed, heights nobody knows) nothing can be said beforehand."""


@dataclass(frozen=True)
class NextRun:
    """A run that would settle a doubt.

    ``like`` is the recorded run on the same track whose speed is nearest. ``expected_log_odds`` is
    what the run is expected to add to the logarithm of the odds between the two effects it
    separates, whichever of them is right; ``angle_deg`` lies between what the two would
    contribute to it, against ``present_angle_deg`` on the runs at hand.
    """

    like: str
    track: str
    speed_kmph: float
    separates: tuple[str, str]
    angle_deg: float
    present_angle_deg: float
    expected_log_odds: float


@dataclass(frozen=True, eq=False)
class _Trial:
    """A run that could be driven, and what the two models could not both explain of it. A bench
    remembers whatever was simulated on it: one for every such run would fill the memory."""

    planned: Run
    like: Run
    gain: float


def propose(
    workshop: Workshop, first: tuple[str, Rung], second: tuple[str, Rung], present_deg: float
) -> NextRun | None:
    """The run, of all the campaign's tracks and the speeds it was driven at, that separates two
    fitted explanations best; None if no run drives over a known track, or none separates them.

    Both are simulated on each such run. Of the difference d of their records, in units of the noise
    σ, a new fit would absorb what speed, start and the vehicle's numbers can; the rest is evidence:
    Λ = ½ dᵀ (σ² + J C Jᵀ)⁻¹ d, with J the derivatives and C what is believed of those numbers now.
    """

    def gain(planned: Run, refitted: bool) -> float:
        bench = workshop.bench(planned)
        return _gain(workshop, bench, first[1], second[1], refitted=refitted)

    trials = workshop.each(lambda pair: _Trial(*pair, gain(pair[0], False)), _reachable(workshop))
    trials = [trial for trial in trials if np.isfinite(trial.gain)]
    if not trials:
        return None
    few = sorted(trials, key=lambda trial: -trial.gain)[:FEW]
    gains = workshop.each(lambda trial: gain(trial.planned, True), few)
    if max(gains) < LEAST_LOG_ODDS:
        return None
    best = few[int(np.argmax(gains))]
    bench = workshop.bench(best.planned)
    one, other = (_contribution(workshop, bench, rung, id_) for id_, rung in (first, second))
    return NextRun(
        like=best.like.id,
        track=best.like.track.kind,
        speed_kmph=best.planned.speed_m_s * 3.6,
        separates=(first[0], second[0]),
        angle_deg=angle_deg(one, other),
        present_angle_deg=present_deg,
        expected_log_odds=float(max(gains)),
    )


def angle_deg(a: Array, b: Array) -> float:
    """Angle between two signals, whatever their sign, 0 to 90 degrees; 90 if one vanishes."""
    norm = float(np.linalg.norm(a) * np.linalg.norm(b))
    if norm == 0.0:
        return 90.0
    return float(np.degrees(np.arccos(min(1.0, abs(float(a @ b)) / norm))))


def _reachable(workshop: Workshop) -> Iterator[tuple[Run, Run]]:
    """Every known track at every speed within the campaign's, and the recorded run most like it."""
    driven = [bench.run for bench in workshop.benches.values() if bench.drive == "road"]
    driven = [run for run in driven if run.speed_m_s > 0]
    tracks = {repr(run.track): run.track for run in driven}
    if not driven:
        return
    slowest, fastest = min(r.speed_m_s for r in driven), max(r.speed_m_s for r in driven)
    for track in tracks.values():
        for speed in np.geomspace(slowest, fastest, SPEEDS if fastest > slowest else 1):
            same = [run for run in driven if run.track == track]
            like = min(same, key=lambda run: abs(run.speed_m_s - speed))
            yield replace(like, id="next", role="fit", speed_m_s=float(speed)), like


def _gain(workshop: Workshop, bench: Bench, first: Rung, second: Rung, *, refitted: bool) -> float:
    shared = second.fit.shared if refitted else ()
    own = (
        Free("speed_m_s", bench.run.speed_m_s, np.inf, 1e-3 * bench.run.speed_m_s),
        Free("start_m", 0.0, np.inf, 1e-2),
    )
    model = _driven(second.model, bench)
    moved = [
        *(model.with_values({f.name: model.values[f.name] + f.step * f.scale}) for f in shared),
        *(_nudged(model, bench, f) for f in own),
    ]
    steps = [f.step for f in (*shared, *own)]
    models = [model, _driven(first.model, bench), *moved]
    start, other, *answers = _answers(workshop, bench, models)
    difference = other - start
    columns = np.stack([(a - start) / d for a, d in zip(answers, steps, strict=True)], axis=1)
    sigma = max(second.fit.sigma, first.fit.sigma)
    precision = np.zeros((len(steps), len(steps)))
    if refitted:
        precision[: len(shared), : len(shared)] = second.fit.precision
    inner = columns.T @ columns / sigma**2 + precision
    slope = columns.T @ difference / sigma**2
    absorbed = slope @ np.linalg.lstsq(inner, slope, rcond=None)[0]
    return 0.5 * float(difference @ difference / sigma**2 - absorbed)


def _contribution(workshop: Workshop, bench: Bench, rung: Rung, effect_id: str) -> Array:
    """What an effect contributes to a run, the rest of its model being as fitted."""
    model = _driven(rung.model, bench)
    full, without = _answers(workshop, bench, [model, model.without_effect(effect_id)])
    return full - without


def _driven(model: Model, bench: Bench) -> Model:
    """The model on a run nobody has driven yet: at its speed, nothing else particular to it."""
    return model.with_run(bench.run.id, {"speed_m_s": bench.run.speed_m_s, "start_m": 30.0})


def _nudged(model: Model, bench: Bench, free: Free) -> Model:
    value = model.runs[bench.run.id][free.name]
    return model.with_run(bench.run.id, {free.name: value + free.step * free.scale})


def _answers(workshop: Workshop, bench: Bench, models: Sequence[Model]) -> list[Array]:
    trials = [(model, workshop.systems(model)) for model in models]
    return [bench.coefficients(record) for record in bench.records(trials)]
