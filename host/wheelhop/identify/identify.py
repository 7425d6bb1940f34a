"""A transfer matrix from axle to body motion, fitted to all runs at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from wheelhop.campaign import CampaignError
from wheelhop.identify.gram import Stack, condensed, projected, transient_basis
from wheelhop.identify.problem import Point, Problem, descend
from wheelhop.identify.sections import Points, Sections
from wheelhop.identify.spectra import Spectra, through
from wheelhop.identify.start import WELL_DAMPED, relocated, starts
from wheelhop.identify.structure import Structure, Suspensions

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

CORNERS = (0, 1, 2, 3)
FINE = 0.1
"""Standard errors."""
ROUGH = 1e-3
"""Share of the cost that a step must promise while the weights are not known."""
WASTED = 2.0
"""A damping ratio above this is two real poles far apart: a section that found no mode."""


@dataclass(frozen=True, eq=False)
class TransferMatrix:
    """H(s) over a common denominator, with its uncertainty.

    H[i, j] = D_j(s) Σ theta[i, j] · fractions(s), with D = 1 unless the structure is "reciprocal";
    then theta are the elements of S times the front stiffness.
    """

    sections: Sections
    theta: Array  #: (n, m, order)
    structure: Structure
    inputs: tuple[int, ...]  #: corners of the columns
    outputs: tuple[int, ...]  #: corners of the rows
    suspensions: Suspensions | None  #: as fitted; None unless "reciprocal"
    noise_rms: Array  #: (n,) assumed of each output, in band, m/s²
    index: NDArray[np.int64]  #: (n, m·order) which free number each theta is
    covariance: Array  #: of the free numbers, then ln ω, ζ, ln r, then the suspensions' three
    unknowns: int  #: numbers fitted
    cost: float  #: weighted sum of squares; about `freedom` where the model is right
    freedom: float  #: rows less everything fitted

    @property
    def order(self) -> int:
        """Number of poles."""
        return self.sections.order

    def __call__(self, s: Points) -> ComplexArray:
        """H(s) (len(s), n, m)."""
        s = np.atleast_1d(np.asarray(s, complex))
        values = np.tensordot(self.sections.basis(s), self.theta, axes=(1, 2))
        out: ComplexArray = values * self._factor(s)[:, None, :]
        return out

    def standard_error(self, s: Points) -> Array:
        """Standard error (len(s), n, m) of |H(s)| as √(variance of real and imaginary part / 2)."""
        s = np.atleast_1d(np.asarray(s, complex))
        basis, factor = self.sections.basis(s), self._factor(s)
        slopes = self.sections.basis_slopes(s)
        count, order = len(self.covariance), self.order
        free = count - order - 3
        out = np.zeros((len(s), len(self.outputs), len(self.inputs)))
        for i in range(len(self.outputs)):
            for j in range(len(self.inputs)):
                by = np.zeros((len(s), count), complex)
                by[:, self.index[i, j * order : (j + 1) * order]] = factor[:, j, None] * basis
                moved = np.einsum("pkl,l->kp", slopes, self.theta[i, j])
                by[:, free : free + order] = factor[:, j, None] * moved
                if self.suspensions is not None:
                    bend = self.suspensions.slopes(self.suspensions.value, s, (self.inputs[j],))
                    by[:, -3:] = (bend[:, :, 0] * (basis @ self.theta[i, j])).T
                variance = np.einsum("kp,pq,kq->k", by, self.covariance, by.conj()).real
                out[:, i, j] = np.sqrt(np.maximum(variance, 0.0) / 2)
        return out

    def poles_table(self) -> list[tuple[float, float, float, float]]:
        """Natural frequency (Hz), its standard error, damping ratio, its standard error; one row a
        section."""
        m, free = len(self.sections.omega), len(self.covariance) - self.order - 3
        sd = np.sqrt(np.maximum(np.diag(self.covariance)[free : free + 2 * m], 0.0))
        frequency = self.sections.frequency_hz
        return [
            (float(frequency[i]), float(frequency[i] * sd[i]), float(z), float(sd[m + i]))
            for i, z in enumerate(self.sections.zeta)
        ]

    def _factor(self, s: Points) -> ComplexArray:
        if self.suspensions is None:
            return np.ones((len(s), len(self.inputs)), complex)
        return self.suspensions.factor(self.suspensions.value, s, self.inputs)


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
    J. Schoukens, System Identification, 2nd ed., chapter 9).

    Parameters
    ----------
    order : number of poles.
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
    return fitter.result(fitter.refined(point))


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
        self.runs, self.structure, self.order = runs, structure, order
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

    def _use(self, weights: Sequence[Array], output_weight: Array) -> None:
        self.problem = self._of(Stack(self.runs, weights, self.order), output_weight)

    def _of(self, stack: Stack, output_weight: Array) -> Problem:
        return Problem(
            stack,
            self.structure,
            self.inputs,
            self.outputs,
            self.suspensions,
            output_weight,
            self.order,
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
    def _band(self) -> tuple[float, float]:
        lowest = min(float(p.omega[0]) for p in self.runs)
        return lowest, max(float(p.omega[-1]) for p in self.runs)

    def refined(self, point: Point) -> Point:
        """Followed until a step moves nothing by more than `FINE` standard errors: it then promises
        less than FINE² of the cost a degree of freedom."""
        tolerance = FINE**2 / self._freedom()
        return _followed(self.problem, point.numbers, self._band, tolerance)

    def reweigh(self, point: Point) -> None:
        """Weights from the noise and what the last fit says of its way to the outputs."""
        h = self.result(point, covariance=False)
        growth = [
            np.sqrt(1.0 + np.mean(np.sum(np.abs(h(1j * p.omega)) ** 2, axis=2), axis=1))
            for p in self.runs
        ]
        weights = [1.0 / g for g in growth]
        if self.noise_rms is not None:
            lines = sum(len(p.runs) * len(p.omega) for p in self.runs)
            energy = sum(len(p.runs) * p.samples for p in self.runs) * self.noise_rms**2
            variance = np.full(len(self.outputs), energy / (2 * lines))
        else:
            variance = self._told(h, weights)
        self._use(weights, 1.0 / variance)

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
        freedom = self._freedom()
        if covariance:
            cov = self._covariance(point, max(1.0, point.cost / freedom))
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
            unknowns=problem.unknowns + self.order,
            cost=point.cost,
            freedom=float(freedom),
        )

    def _freedom(self) -> int:
        stack, count = self.problem.stack, len(self.outputs)
        known = self.problem.unknowns + self.order
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


@dataclass(frozen=True, eq=False)
class Judged:
    """What a transfer matrix leaves of some runs, their initial states projected out.

    Per run and output, as sums of squares in band: `residual`, `measured`, and what the noise
    of inputs and outputs alone is expected to leave, `expected` (r, n). `freedom` is the share of a
    run's coordinates that its initial state leaves.
    """

    runs: tuple[str, ...]
    residual: Array
    measured: Array
    expected: Array

    @property
    def error(self) -> float:
        """√(Σ residual² / Σ measured²)."""
        return float(np.sqrt(self.residual.sum() / self.measured.sum()))

    @property
    def floor(self) -> float:
        """The error that noise alone would leave; NaN where none is stated."""
        return float(np.sqrt(self.expected.sum() / self.measured.sum()))


def judge(h: TransferMatrix, runs: Sequence[Spectra], noise_rms: float | None = None) -> Judged:
    """Error of H on runs, with the degrees of freedom charged that each initial state takes."""
    names: list[str] = []
    parts: list[tuple[Array, Array, Array]] = []
    noise = np.nan if noise_rms is None else noise_rms
    for part in runs:
        k = len(part.omega)
        basis = transient_basis(part.omega, h.sections, np.ones(k))
        response = h(1j * part.omega)
        rest = part.outputs - through(response, part.inputs)
        rows = projected(rest, basis).reshape(len(part.runs), 2 * k, -1)
        charged = 2 * k / (2 * k - basis.shape[1])
        growth = 1.0 + np.mean(np.sum(np.abs(response) ** 2, axis=2), axis=0)
        residual = charged * np.sum(rows**2, axis=1)
        parts.append(
            (
                residual,
                np.sum(np.abs(part.outputs) ** 2, axis=1),
                np.broadcast_to(part.samples * noise**2 * growth, residual.shape),
            )
        )
        names += part.runs
    return Judged(tuple(names), *(np.concatenate(column) for column in zip(*parts, strict=True)))
