"""Least squares over a campaign, with what each run leaves free eliminated run by run.

The cost is Σ (measured − model)² / σ² over in-band coefficients + Σ ((p − mean)/sigma)² over the
parameters with a prior, as long as the model leaves no more than the sensors' noise σ; what it
leaves more counts by its logarithm, channel by channel of every run (`spread.py`): a model that is
wrong somewhere must not outvote the rest, nor what is believed of the vehicle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.fit.belief import Belief
from wheelhop.fit.bench import RUNS_AWAY, Bench, Workshop
from wheelhop.fit.density import Noise, find_density
from wheelhop.fit.derivatives import moves
from wheelhop.fit.height_response import Ground
from wheelhop.fit.heights import Heights
from wheelhop.fit.parameters import Free, after, between, run_parameters, stepped
from wheelhop.fit.result import Derivatives, Fit, RunFit, kept
from wheelhop.fit.step import Linear, Normal, Prior, damped, least
from wheelhop.simulate import Model

Array = NDArray[np.float64]

ITERATIONS = 60

FIRST_DAMPING = 1e-3
"""Until a step has done better, what the linearised model foresees of a channel is not trusted."""

LEAST_DAMPING = 1e-8
"""Along what little but the priors holds a larger damping would make a hundredth of the way."""

MOST_DAMPING = 10.0
"""Where even a tenth of a step does not help, none does."""

CONVERGED = 1e-4
"""The fit ends when a step lowers the cost by less than this fraction of it, or of the number of
data: what noise costs, as −2 ln p has no zero."""

CONVERGED_QUICK = 3e-3
"""`CONVERGED` of a fit with borrowed derivatives, which cannot reach the minimum anyhow."""

SOLVED = 0.1
"""A step is solved for to this share of that, which is small beside what a fit neglects."""

NEAR_NOISE = 1.1
"""A fit that costs no more than so many times what noise does leaves hardly anything else."""

WORTHWHILE = 0.3
"""As long as steps lower the cost by more than this fraction, derivatives are not renewed."""

AHEAD = 10.0
"""A fit has no hope where ten more steps as good as the last would not lead, once they shrink."""


def fit(
    workshop: Workshop,
    model: Model,
    shared: Sequence[Free],
    benches: Sequence[Bench],
    known: Fit | None = None,
    bar: float = -np.inf,
) -> Fit:
    """Fit the shared parameters and what each of the runs leaves free (Levenberg–Marquardt).

    Start values are those of `model`; with no `shared` parameters only the runs' own are fitted.
    Derivatives that a fit of a similar model, `known`, holds already are taken from there: much
    faster, and a fit that ends a little above the minimum. A fit that has no hope to come below the
    misfit `bar` ends early.
    """
    belief = Belief.of(shared, workshop.measured)
    if shared or len(benches) < 2 or model.random_heights is not None:
        problem = _Problem(workshop, belief, tuple(benches), known, density_free=bool(shared))
        return _solved(problem, model, bar)
    # Runs that share nothing are fitted each by itself: one that is lost keeps no other waiting.
    return _together(workshop.each(lambda bench: fit(workshop, model, (), [bench], known), benches))


def _together(parts: Sequence[Fit]) -> Fit:
    """One fit of what fits to single runs have found."""
    first, *others = parts
    model = first.model
    for part in others:
        run_id = part.runs[0].bench.run.id
        model = model.with_run(run_id, part.model.runs[run_id])
    size = sum(part.size for part in parts)
    return replace(
        first,
        model=model,
        runs=tuple(run for part in parts for run in part.runs),
        sigma=float(np.sqrt(sum(part.sigma**2 * part.size for part in parts) / size)),
        cost=sum(part.cost for part in parts),
        log_volume=sum(part.log_volume for part in parts),
    )


def update(
    workshop: Workshop,
    fitted: Fit,
    model: Model,
    benches: Sequence[Bench],
    known: Fit | None = None,
) -> Fit:
    """Fit runs that `fitted` was not fitted to, for which its shared parameters are as uncertain
    as it left them: its posterior is their prior. Start values are those of `model`; a density of
    unknown heights stays. Derivatives are borrowed from `known` as in `fit`."""
    problem = _Problem(workshop, fitted.posterior, tuple(benches), known, density_free=False)
    return _solved(problem, model)


def follow(workshop: Workshop, before: Model, fitted: Fit, benches: Sequence[Bench]) -> Model:
    """`fitted.model` with what these runs, none of which it was fitted to, leave free moved along
    with the shared numbers from where it was best in `before`, to first order. An engine's speed in
    a run is told against the mean speed: a fit to one run would else begin turns away from it."""
    problem = _Problem(workshop, fitted.posterior, tuple(benches), None, density_free=False)
    state = problem.linearise(problem.completed(before))
    model = fitted.model
    step = [(model.values[f.name] - before.values[f.name]) / f.scale for f in fitted.shared]
    for run in state.runs if np.isfinite(state.cost) else ():
        normal, own = problem.normal(run, state), state.model.runs[run.bench.run.id]
        along = np.linalg.solve(damped(normal.own, 0.0), normal.mixed.T @ step)
        model = model.with_run(run.bench.run.id, after(run.own, own, -np.asarray(along)))
    return model


def foreseen(
    workshop: Workshop, model: Model, shared: Sequence[Free], benches: Sequence[Bench]
) -> Fit:
    """The fit that runs nobody has driven yet would end in were `model` true: it leaves the stated
    noise and nothing else, whatever stands in their records."""
    belief = Belief.of(shared, workshop.measured)
    problem = _Problem(workshop, belief, tuple(benches), None, density_free=False)
    state = problem.linearise(problem.completed(model))
    runs = tuple(
        replace(run, residual=np.zeros(run.bench.size), spread=np.ones(run.bench.size))
        for run in state.runs
    )
    return problem.concluded(replace(state, runs=runs))


def linearised(
    workshop: Workshop, model: Model, shared: Sequence[Free], benches: Sequence[Bench]
) -> Fit:
    """Where a fit begins, with the derivatives there."""
    belief = Belief.of(shared, workshop.measured)
    problem = _Problem(workshop, belief, tuple(benches), None, density_free=False)
    return problem.linearise(problem.completed(model))


@RUNS_AWAY
def _solved(problem: _Problem, model: Model, bar: float = -np.inf) -> Fit:
    state, damping, before = problem.linearise(problem.completed(model)), FIRST_DAMPING, 0.0
    if not np.isfinite(state.cost):
        return state
    for iteration in range(ITERATIONS):
        if problem.shared:
            problem.workshop.watch(iteration + 1, state.error)
        trial, promised, room = problem.stepped(state, damping)
        drop = state.cost - trial.cost + room if np.isfinite(trial.cost) else -np.inf
        gain = drop / max(state.cost, state.size)
        if gain > 0:
            state, damping = problem.weighted(trial), max(damping / 10.0, LEAST_DAMPING)
        if 0 <= gain < problem.converged:
            if damping <= LEAST_DAMPING or problem.known or not problem.promises(state):
                break
            damping = LEAST_DAMPING
            continue
        if 0 < drop <= before and state.misfit - AHEAD * drop > bar > -np.inf:
            break
        before = drop
        if gain > WORTHWHILE and not state.of_heights:
            continue  # old derivatives still serve; but those of no heights do not where some are
        misled = problem.misled(state)
        if misled:
            state = problem.linearise(state.model, [r for r in state.runs if r not in misled])
        elif gain <= 0:
            damping *= 8.0
            if damping > MOST_DAMPING or promised < problem.converged * max(state.cost, state.size):
                break
    return problem.concluded(state)


class _Problem:
    def __init__(
        self,
        workshop: Workshop,
        belief: Belief,
        benches: tuple[Bench, ...],
        known: Fit | None,
        *,
        density_free: bool,
    ) -> None:
        self.workshop, self.belief, self.benches = workshop, belief, benches
        self.shared, self.density_free = belief.free, density_free
        self.known = {} if known is None else known.derivatives
        self.converged = CONVERGED_QUICK if self.known else CONVERGED
        self.borrowed = set[str]() if known is None else {f.name for f in known.shared}
        self.heights = {} if known is None else {r.bench.run.id: r.heights for r in known.runs}

    def own(self, bench: Bench, model: Model) -> tuple[Free, ...]:
        return tuple(run_parameters(bench.run, bench.simulator.setting, model))

    def completed(self, model: Model) -> Model:
        """The model with everything the runs leave free stated: at its prior mean if it is not."""
        for bench in self.benches:
            means = {free.name: free.mean for free in self.own(bench, model)}
            model = model.with_run(bench.run.id, {**means, **model.runs.get(bench.run.id, {})})
            series = bench.simulator.series
            if model.random_heights is not None and series is not None:
                level = np.zeros((2, series.count), dtype=np.complex128)
                model = model.with_heights({bench.run.id: level, **model.heights})
        return model

    def misled(self, state: Fit) -> list[RunFit]:
        """The runs that need new derivatives. Near the noise a run that is still out of place does
        at every step, and the others are done: a step goes wrong there by less than `SOLVED` of the
        one that the fit neglects. Where more is left, what derivatives miss leads astray."""
        near = 0.0 < state.cost < NEAR_NOISE * state.size and self.workshop.noise > 0.0
        neglected = self.converged * max(state.cost, state.size) / len(state.runs)
        least = SOLVED**2 * neglected if near else 0.0
        return [run for run in state.runs if not run.missed**2 <= least]

    def linearise(self, model: Model, known: Sequence[RunFit] = ()) -> Fit:
        """Residuals, derivatives, noise and cost at a model; infinite if it is not stable. Some of
        the runs are `known` there."""
        systems, found = self.workshop.systems(model), {run.bench.run.id: run for run in known}
        benches = [bench for bench in self.benches if bench.run.id not in found]
        self.workshop.ahead(model, systems, benches)
        moved = {}
        for free in self.shared:
            if free.name not in self.borrowed:
                other = model.with_values(stepped(free, model.values))
                moved[free.name] = (other, self.workshop.systems(other))

        @RUNS_AWAY
        def linearise_run(bench: Bench) -> RunFit:
            # Before the derivatives: the record is there already.
            residual = bench.residual(model, systems)
            own = self.own(bench, model)
            columns = dict(self.known.get(bench.run.id, {}))
            others = [f for f in self.shared if f.name not in columns]
            new = [f for f in own if f.name not in columns]
            together = moves(bench, model, new, lambda f: f.step * f.scale)
            trials = [moved[f.name] for f in others] + [(m.model, systems) for m in together]
            changes = bench.changes((model, systems), trials)
            made = {
                f.name: bench.coefficients(change) / f.step
                for f, change in zip(others, changes, strict=False)
            }
            for move, change in zip(together, changes[len(others) :], strict=True):
                for k, part in move.parts(bench, change):
                    made[new[k].name] = part / new[k].step
            if made:
                columns |= zip(made, kept(np.array([*made.values()])), strict=True)
            free = (*self.shared, *own)
            derivatives = Derivatives([columns[f.name] for f in free], len(self.shared))
            heights = None
            if model.random_heights is not None and bench.simulator.series is not None:
                ground = Ground(bench, model, systems[bench.drive])
                level, known = model.heights[bench.run.id].ravel(), self.heights.get(bench.run.id)
                slopes = {**known.slopes} if known else {}
                # Derivatives made without heights do not know what a sharper resonance gains.
                for f in others if known or not self.known else ():
                    other, beside = moved[f.name]
                    slopes[f.name] = ground.slope(other, beside[bench.drive], f.step)
                heights = Heights(ground, level, np.zeros(len(level)), 1.0, slopes)
            return RunFit(bench, own, residual, derivatives, np.ones(bench.size), heights)

        found |= {run.bench.run.id: run for run in self.workshop.each(linearise_run, benches)}
        runs = tuple(found[bench.run.id] for bench in self.benches)
        precision, measured = self.belief.precision_at(model.values), self.workshop.measured
        state = Fit(model, self.shared, runs, precision, 1.0, np.inf, 0.0, measured)
        return self.weighted(state) if np.isfinite(state.rss) else state

    def weighted(self, state: Fit) -> Fit:
        """The state with the noise, density of unknown heights and cost that follow from its
        residuals. Heights take up what a model is wrong by, and are told from white noise."""
        given = sum(len(run.own) for run in state.runs) + len(self.shared)
        noise = Noise(state.rss, state.size - given, self.workshop.noise)
        effect = state.model.random_heights
        if effect is None or not state.of_heights:
            sigma = self.workshop.noise or noise.sigma
            runs = tuple(
                replace(run, spread=run.bench.spread(run.residual, sigma)) for run in state.runs
            )
            return self._costed(replace(state, runs=runs, sigma=sigma))
        parameters = self.workshop.parameters_of(effect) if self.density_free else ()
        rough = [run for run in state.runs if run.heights is not None]
        spectra = self.workshop.each(RunFit.spectrum, rough)
        theta, noise = find_density(effect, parameters, state.model.theta(effect), spectra, noise)
        model = state.model.with_values({f"{effect.id}.{k}": v for k, v in theta.items()})
        runs = tuple(
            replace(run, heights=run.heights and run.heights.believed(effect, theta, noise.sigma))
            for run in state.runs
        )
        return self._costed(replace(state, model=model, runs=runs, sigma=noise.sigma))

    def _costed(self, state: Fit) -> Fit:
        if state.of_heights:
            likelihood = state.rss / state.sigma**2
        else:
            likelihood = sum(r.bench.cost(r.residual, state.sigma) for r in state.runs)
        return replace(state, cost=likelihood + self._prior(state.model, state.runs))

    def stepped(self, state: Fit, damping: float) -> tuple[Fit, float, float]:
        """The state after a damped Gauss–Newton step, the drop of the cost that it promised, and
        how much more room unknown heights have there, which is part of that: residuals and cost
        (at the same noise) are new, derivatives old."""
        model, promised, room = self._moved(state, damping)
        systems = self.workshop.systems(model)
        self.workshop.ahead(model, systems, self.benches)
        step = between(self.shared, state.model.values, model.values)

        @RUNS_AWAY
        def moved(run: RunFit) -> RunFit:
            residual, run_id = run.bench.residual(model, systems), run.bench.run.id
            own = between(run.own, state.model.runs[run_id], model.runs[run_id])
            foreseen = run.residual - run.jacobian @ np.concatenate([step, own])
            missed = float(np.linalg.norm((residual - foreseen) / run.spread)) / state.sigma
            heights = run.heights and run.heights.at(model.heights[run_id])
            return replace(run, residual=residual, heights=heights, missed=run.missed + missed)

        runs = tuple(self.workshop.each(moved, state.runs))
        return self._costed(replace(state, model=model, runs=runs)), promised, room

    def promises(self, state: Fit) -> bool:
        """Whether an undamped step would gain: one damped hardly moves what priors alone hold."""
        return self._moved(state, LEAST_DAMPING)[1] >= self.converged * max(state.cost, state.size)

    def concluded(self, state: Fit) -> Fit:
        """The state with precision and prior volume, its common scale the likeliest if untold."""
        moved = {} if state.measures_force else self.belief.on_scale(state.model.values)
        state = self._costed(replace(state, model=state.model.with_values(moved)))
        precision, log_volume = self._posterior(state)
        runs = self.workshop.each(RunFit.settled, state.runs)
        return replace(state, runs=tuple(runs), precision=precision, log_volume=log_volume)

    def _moved(self, state: Fit, damping: float) -> tuple[Model, float, float]:
        values, pull = state.model.values, self._pull_of_heights(state)
        prior, along = Prior.of(self.belief, values, pull), self.belief.coordinates(values)
        runs = self.workshop.each(lambda run: self.linear(run, state).along(along), state.runs)
        enough = SOLVED * self.converged * max(state.cost, state.size)
        enough = enough if damping < FIRST_DAMPING else np.inf
        step, own_steps, promised = least(prior, runs, damping, enough)
        model = state.model.with_values(self.belief.moved(values, step))
        for run, linear, own_step in zip(state.runs, runs, own_steps, strict=True):
            run_id = run.bench.run.id
            model = model.with_run(run_id, after(run.own, model.runs.get(run_id, {}), own_step))
            if run.heights is not None and linear.heights is not None:
                ahead, less = linear.heights
                moved = run.heights.coefficients + ahead - less @ np.concatenate([step, own_step])
                model = model.with_heights({run_id: moved.reshape(2, -1)})
        return model, promised, 2.0 * float(pull @ along @ step)

    def _pull_of_heights(self, state: Fit) -> Array:
        """Half of how the logarithm of the volume that unknown heights may fill grows (g,) along
        the shared numbers. Without it resonances come out too sharp: the sharper, the less height
        explains a record."""
        heights = [run.heights for run in state.runs if run.heights is not None]
        rough = [h for h in heights if h.coefficients.any()]
        names = [f.name for f in self.shared]
        grown = self.workshop.each(lambda heights: heights.growths(names), rough)
        return np.asarray(0.5 * np.sum(grown, axis=0) if grown else np.zeros(len(names)))

    def _prior(self, model: Model, runs: Sequence[RunFit]) -> float:
        total = self.belief.distance(model.values)
        for bench in self.benches:
            own = Belief.of(self.own(bench, model))
            total += own.distance(model.runs.get(bench.run.id, {}))
        return total + sum(run.heights.penalty for run in runs if run.heights is not None)

    def linear(self, run: RunFit, state: Fit) -> Linear:
        """A run of a state, linearised."""
        own, even = state.model.runs[run.bench.run.id], state.of_heights
        return Linear.of(run, own, state.sigma, even=even)

    def normal(self, run: RunFit, state: Fit) -> Normal:
        """Its normal equations, weighed by what it leaves."""
        linear = self.linear(run, state)
        return linear.normal(linear.weights)

    def _posterior(self, state: Fit) -> tuple[Array, float]:
        """Precision of the shared parameters, and the share of prior volume left."""
        values = state.model.values
        matrix = self.belief.precision_at(values)
        log_volume = self.belief.log_precision_at(values)
        normals = self.workshop.each(lambda run: self.normal(run, state), state.runs)
        for run, normal in zip(state.runs, normals, strict=True):
            own = damped(normal.own, 0.0)
            matrix += normal.shared - normal.mixed @ np.linalg.solve(own, normal.mixed.T)
            log_volume += Belief.of(run.own).log_precision - np.linalg.slogdet(own)[1]
            log_volume += 0.0 if run.heights is None else run.heights.log_volume
        matrix = damped(matrix, 0.0)
        log_volume -= np.linalg.slogdet(matrix)[1]
        return matrix, 0.5 * float(log_volume)
