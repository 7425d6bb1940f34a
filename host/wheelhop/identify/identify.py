"""A transfer matrix from axle to body motion, fitted to all runs at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from wheelhop.campaign import CampaignError
from wheelhop.identify.folded import apart, beyond_chance
from wheelhop.identify.gram import Stack, condensed, projected, transient_basis, unabsorbed
from wheelhop.identify.matrix import TransferMatrix
from wheelhop.identify.problem import Point, Problem, descend
from wheelhop.identify.sections import Sections
from wheelhop.identify.spectra import Spectra, through
from wheelhop.identify.start import WELL_DAMPED, relocated, starts
from wheelhop.identify.structure import Structure, Suspensions

Array = NDArray[np.float64]

CORNERS = (0, 1, 2, 3)
FINE = 0.1
"""Standard errors."""
ROUGH = 1e-3
"""Share of the cost that a step must promise while the weights are not known."""
ROUGH_PRICE = 0.05
"""Share of a section's price to which the cost without it is found."""
CHANCE = 5.0
"""Standard deviations beyond what chance takes off the cost."""
NARROW = 10.0
"""A mode that decays by fewer e-folds in a run is a few lines wide: its initial states can pass a
driven line off as its decay."""
WASTED = 2.0
"""A damping ratio above this is two real poles far apart: a section that found no mode."""


def identify(
    runs: Sequence[Spectra],
    structure: Structure | None = None,
    *,
    order: int = 8,
    inputs: tuple[int, ...] = CORNERS,
    outputs: tuple[int, ...] = CORNERS,
    suspensions: Suspensions | None = None,
    noise_rms: float | None = None,
    start: Sections | None = None,
) -> TransferMatrix:
    """Fit H to all runs by the output error, each run's initial state projected out.

    Noise of the inputs counts as well as that of the outputs: at each line the weight is one over
    σ² (1 + Σ|H|²), H from the fit before (errors in both, with the weights held: R. Pintelon and
    J. Schoukens, System Identification, 2nd ed., chapter 9). Of stated level, it is also taken out
    of the inputs' power, unless it leaves too little of it. Lines of a run that leave more than
    noise may are weighed by what they leave (`folded`).

    Sections that the runs do not need are left out again: those without which the sum of squares
    grows by less than information criteria ask for their numerators and initial states.

    Parameters
    ----------
    order : number of poles, at most; with a `start`, just as many.
    inputs, outputs : corners 0..3 of the spectra's columns.
    suspensions : belief about the suspensions, needed by the structure "reciprocal".
    noise_rms : of one channel in band, m/s²; None: told from the residual.
    start : sections to begin at; None: relocated from the middle of the band.

    Raises
    ------
    CampaignError : more unknowns than the runs have lines, or an unstable or ill-sized start.
    """
    structure = structure or Structure()
    if structure.symmetry == "reciprocal" and suspensions is None:
        raise CampaignError(
            'structure "reciprocal" needs the suspensions: give them, or take "free"'
        )
    if start is not None:
        _check_start(start, order, structure)
    fitter = _Fitter(runs, structure, order, inputs, outputs, suspensions, noise_rms)
    point = fitter.first(start)
    fitter.reweigh(point)
    point = fitter.doubted(fitter.refined(point.numbers))
    return fitter.result(point if start is not None else fitter.pruned(point))


def _check_start(start: Sections, order: int, structure: Structure) -> None:
    if start.order != order:
        raise CampaignError(f"the start has {start.order} poles, the model {order}")
    if structure.stable and (start.zeta <= 0).any():
        worst = int(np.argmin(start.zeta))
        raise CampaignError(
            f"the start is unstable: {start.frequency_hz[worst]:.3g} Hz has damping ratio"
            f" {start.zeta[worst]:.3g}; give one above 0"
        )


class _Fitter:
    """The runs, and the weights that change between fits."""

    def __init__(
        self,
        runs: Sequence[Spectra],
        structure: Structure,
        order: int,
        inputs: tuple[int, ...],
        outputs: tuple[int, ...],
        suspensions: Suspensions | None,
        noise_rms: float | None,
    ) -> None:
        self.runs, self.structure, self.order = list(runs), structure, order
        self.excess = [np.ones(len(p.omega)) for p in runs]
        self.inputs, self.outputs = inputs, outputs
        self.suspensions, self.noise_rms = suspensions, noise_rms
        rows = sum(2 * len(p.omega) * len(p.runs) for p in runs)
        power = sum(np.sum(np.abs(p.outputs) ** 2, axis=(0, 1)) for p in runs)
        self._use([np.ones(len(p.omega)) for p in runs], rows / np.maximum(power, 1e-300))
        spent = self.problem.unknowns + len(outputs) * self.problem.stack.transients
        if rows * len(outputs) <= spent:
            raise CampaignError(
                f"{len(self.problem.elements.ravel())} elements of order {order} and the runs'"
                f" initial states are {spent} unknowns, and the runs have {rows * len(outputs)}"
                " lines in band: take a lower order or longer runs"
            )

    def _use(
        self,
        weights: Sequence[Array],
        output_weight: Array,
        noise: Sequence[Array] | None = None,
    ) -> None:
        self.weights, self.noise = weights, noise
        self.problem = self._of(Stack(self.runs, weights, self.order, noise=noise), output_weight)

    def _of(self, stack: Stack, output_weight: Array) -> Problem:
        return Problem(
            stack,
            self.structure,
            self.inputs,
            self.outputs,
            self.suspensions,
            output_weight,
            stack.order,
        )

    def first(self, start: Sections | None) -> Point:
        """Relocated poles, or the given ones, followed a few steps; no initial states yet, for
        without them the runs condense to few. If some ended where they explain nothing, all begin
        once more close about the others: modes may lie closer than relocation tells."""
        few = condensed(self.runs)
        stack = Stack(few, [np.ones(len(p.omega)) for p in few], self.order, at_rest=True)
        problem = self._of(stack, self.problem.output_weight)
        if start is not None:
            return descend(problem, problem.start(start), tolerance=ROUGH)
        band = self._band
        point = relocated(problem, starts(self.order, band))
        point = _followed(problem, point.numbers, band, ROUGH)
        found, wasted = point.sections, _wasted(point.sections, band)
        if not wasted.any() or wasted.all():
            return point
        near = found.omega[~wasted]
        crowd = np.geomspace(near.min() / 2, 2 * near.max(), len(wasted))
        again = problem.start(Sections(crowd, np.full(len(wasted), WELL_DAMPED), found.rate))
        return min(point, descend(problem, again, tolerance=ROUGH), key=lambda p: p.cost)

    @property
    def _longest_s(self) -> float:
        return max(2 * np.pi / float(p.omega[1] - p.omega[0]) for p in self.runs)

    @property
    def _band(self) -> tuple[float, float]:
        lowest = min(float(p.omega[0]) for p in self.runs)
        return lowest, max(float(p.omega[-1]) for p in self.runs)

    def refined(self, start: Array) -> Point:
        """Followed until a step moves nothing by more than `FINE` standard errors: it then promises
        less than FINE² of the cost a degree of freedom."""
        tolerance = FINE**2 / self._freedom()
        return _followed(self.problem, start, self._band, tolerance)

    def pruned(self, point: Point) -> Point:
        """Without the sections that the runs do not need."""
        order = self.order
        fewer: Point | None = point
        while fewer is not None:
            point, fewer = fewer, None
            for section, price in self._weak(point) if self.order > 3 else []:
                fewer = self._without(section, point, price)
                if fewer is not None:
                    break
        return point if self.order == order else self.refined(point.numbers)

    def _weak(self, point: Point) -> list[tuple[int, float]]:
        """Sections that may be superfluous, and what each has to take off the cost to stay.

        Their numerators take off less (to first order: Wald's statistic) than the Bayesian
        information criterion asks for. To stay, a section with its initial states has to take off
        more than chance gives as many numbers; one that rings on, so that its initial states can
        pass driven lines off as its decay, as much as the Bayesian criterion asks for them all.
        """
        m, outputs, problem = len(point.sections.omega), len(self.outputs), self.problem
        scale = max(1.0, (point.cost + problem.heard(point)) / self._freedom())
        numbers = 2 * (problem.unknowns // self.order + 1)
        states = 2 * outputs * sum(len(p.runs) for p in self.runs)
        least = numbers * np.log(problem.stack.rows * outputs)
        chance = numbers + states + CHANCE * np.sqrt(2 * (numbers + states))
        lasting = least + states * np.log(2 * max(len(p.omega) for p in self.runs))
        efolds = point.sections.zeta * point.sections.omega * self._longest_s
        covariance = self._covariance(point, 1.0)
        found = []
        for k in range(m):
            own = np.arange(0, problem.unknowns, self.order)[:, None] + np.array([k, m + k])
            own = own.ravel()
            gain = point.free[own] @ linalg.pinvh(covariance[np.ix_(own, own)]) @ point.free[own]
            if gain < scale * least:
                price = lasting if efolds[k] < NARROW else chance
                found.append((-price, float(gain), k))
        return [(k, float(-scale * price)) for price, _, k in sorted(found)]

    def _without(self, section: int, point: Point, price: float) -> Point | None:
        """The fit without a section if that costs less than its price."""
        problem, m = self.problem, len(point.sections.omega)
        self.order -= 2
        self._use(self.weights, problem.output_weight, self.noise)
        start = np.delete(point.numbers, [section, m + section])
        fewer = _followed(self.problem, start, self._band, ROUGH_PRICE * price / point.cost)
        if fewer.cost - point.cost < price:
            return fewer
        self.problem, self.order = problem, self.order + 2
        return None

    def doubted(self, point: Point) -> Point:
        """With lines that leave more than noise may weighed by what they leave."""
        h = self.result(point, covariance=False)
        excess = beyond_chance(h, self.runs, self.weights, self.problem.output_weight)
        if all((power == 1.0).all() for power in excess):
            return point
        self.runs, self.excess = apart(self.runs, excess)
        self.reweigh(point)
        return self.refined(point.numbers)

    def reweigh(self, point: Point) -> None:
        """Weights from the noise and what the last fit says of its way to the outputs."""
        h = self.result(point, covariance=False)
        growth = [
            np.sqrt(1.0 + np.mean(np.sum(np.abs(h(1j * p.omega)) ** 2, axis=2), axis=1))
            for p in self.runs
        ]
        weights = [1.0 / (g * np.sqrt(e)) for g, e in zip(growth, self.excess, strict=True)]
        if self.noise_rms is not None:
            lines = sum(len(p.runs) * len(p.omega) for p in self.runs)
            energy = sum(len(p.runs) * p.samples for p in self.runs) * self.noise_rms**2
            variance = np.full(len(self.outputs), energy / (2 * lines))
            self._use(weights, 1.0 / variance, self._heard(h, weights, 2 * float(variance[0])))
            if np.isfinite(self.problem.at(point.numbers).cost):
                return
        else:
            variance = self._told(h, weights)
        self._use(weights, 1.0 / variance)

    def _heard(self, h: TransferMatrix, weights: Sequence[Array], square: float) -> list[Array]:
        """The inputs' noise of this mean square a line, as `Stack` takes it."""
        return [
            square * weight**2 * unabsorbed(part.omega, h.sections, weight)
            for part, weight in zip(self.runs, weights, strict=True)
        ]

    def _told(self, h: TransferMatrix, weights: Sequence[Array]) -> Array:
        """Variance (n,) of a real coordinate of each output's weighted residual."""
        total, count = np.zeros(len(self.outputs)), 0
        for part, weight in zip(self.runs, weights, strict=True):
            basis = transient_basis(part.omega, h.sections, weight)
            model = through(h(1j * part.omega), part.inputs)
            rest = projected((part.outputs - model) * weight[:, None], basis)
            total += np.sum(rest**2, axis=0)
            count += len(rest) - len(part.runs) * basis.shape[1]
        count -= self.problem.unknowns // len(self.outputs)
        signal = sum(np.sum(np.abs(p.outputs) ** 2, axis=(0, 1)) for p in self.runs) / count
        return np.asarray(np.maximum(total / max(count, 1), 1e-24 * np.maximum(signal, 1e-300)))

    def result(self, point: Point, *, covariance: bool = True) -> TransferMatrix:
        """What was fitted, from the least squares at its minimum."""
        problem = self.problem
        count = problem.unknowns + self.order + 3
        cov = np.zeros((count, count))
        freedom, cost = self._freedom(), point.cost + problem.heard(point)
        if covariance:
            cov = self._covariance(point, max(1.0, cost / freedom))
        used = problem.uses_suspensions and self.suspensions is not None
        belief = (
            replace(self.suspensions, value=point.suspension)
            if used and self.suspensions is not None
            else None
        )
        lines = sum(2 * len(p.runs) * len(p.omega) for p in self.runs)
        samples = sum(len(p.runs) * p.samples for p in self.runs)
        return TransferMatrix(
            sections=point.sections,
            theta=point.theta,
            structure=self.structure,
            inputs=self.inputs,
            outputs=self.outputs,
            suspensions=belief,
            noise_rms=np.sqrt(lines / samples / problem.output_weight),
            index=problem.index,
            covariance=cov,
            unknowns=problem.unknowns - problem.fixed + self.order,
            cost=cost,
            freedom=float(freedom),
        )

    def _freedom(self) -> int:
        stack, count = self.problem.stack, len(self.outputs)
        known = self.problem.unknowns - self.problem.fixed + self.order
        return (stack.rows - stack.transients) * count - known

    def _covariance(self, point: Point, scale: float) -> Array:
        """Of (free numbers, ln ω, ζ, ln r, three suspension numbers)."""
        problem = self.problem
        step = problem.linearised(point)
        d = 1.0 / np.sqrt(np.maximum(np.diag(step.normal), 1e-200))
        scaled = step.normal * d[:, None] * d
        values, vectors = linalg.eigh(scaled)
        inverse = (vectors / np.maximum(values, 1e-12)) @ vectors.T * d[:, None] * d
        inner = step.basis @ inverse @ step.basis.T * scale
        m = self.order // 2
        to = np.zeros((problem.unknowns + self.order + 3, len(inner)))
        known = problem.unknowns + self.order
        to[:known, :known] = np.eye(known)
        if self.structure.stable:
            zeta = problem.unknowns + m + np.arange(m)
            to[zeta, zeta] = point.sections.zeta
        for column, number in enumerate(problem.moving):
            to[known + number, known + column] = 1.0
        return np.asarray(to @ inner @ to.T)


def _followed(problem: Problem, start: Array, band: tuple[float, float], tolerance: float) -> Point:
    """The end of a descent. Sections that went where they explain nothing begin once more at the
    band's upper end."""
    point = descend(problem, start, tolerance=tolerance)
    found, wasted = point.sections, _wasted(point.sections, band)
    if not wasted.any():
        return point
    omega, zeta = found.omega.copy(), np.maximum(found.zeta, 1e-3)
    omega[wasted] = band[1] * np.geomspace(0.9, 0.5, int(wasted.sum()))
    zeta[wasted] = 0.7
    again = problem.start(Sections(omega, zeta, found.rate))
    return min(point, descend(problem, again, tolerance=tolerance), key=lambda p: p.cost)


def _wasted(found: Sections, band: tuple[float, float]) -> NDArray[np.bool_]:
    """Which sections stand where they explain nothing in band."""
    out: NDArray[np.bool_] = (
        (found.zeta > WASTED) | (found.omega > 2 * band[1]) | (found.omega < band[0] / 2)
    )
    return out
