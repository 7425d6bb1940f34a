"""A fitted model, run by run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from wheelhop.fit.belief import Belief
from wheelhop.fit.bench import Bench
from wheelhop.fit.density import Spectrum
from wheelhop.fit.heights import Heights
from wheelhop.fit.parameters import Free, of_forces, scale_is_given
from wheelhop.simulate import Model
from wheelhop.vehicle import Measured

Array = NDArray[np.float64]

BLOCK_S = 0.5
"""Residuals are not white: what half a second of a run says of a model is counted as one degree of
freedom, however many samples it holds (a second: one oscillation with amplitude and phase)."""


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Of one run's model with respect to the shared parameters, the first `shared` columns, and
    its own, per `Free.scale`.

    They are differences, good to five digits, and stay in memory with every model that was tried:
    seven digits are kept, and a model holds the columns it borrows in common with their owner.
    """

    columns: Sequence[NDArray[np.floating]]  #: g + r of them, each (size,)
    shared: int


def kept(columns: Array) -> NDArray[np.floating]:
    """Columns of derivatives (k, size) as they are kept, side by side; nothing moves where a way
    leads to no stable model."""
    with np.errstate(over="ignore"):  # what no float holds is not finite either
        short = columns.astype(np.float32)
    short[~np.isfinite(short).all(axis=1)] = 0.0
    return short


@dataclass(frozen=True, eq=False)
class RunFit:
    """One run at the solution: its own parameters, residual (size,) and derivatives; the `spread`
    (size,) of the residual per the sensors' noise; the unknown heights of its ground, if an effect
    adds any; and how much `missed` the steps made with these derivatives what they foresaw, as the
    length of a residual per spread."""

    bench: Bench
    own: tuple[Free, ...]
    residual: Array
    derivatives: Derivatives
    spread: Array
    heights: Heights | None = None
    missed: float = 0.0

    @property
    def jacobian(self) -> Array:
        """Derivatives (size, g + r), the shared parameters first, per `Free.scale`."""
        columns = self.derivatives.columns
        return np.array(columns, np.float64).reshape(len(columns), len(self.residual)).T

    @property
    def weighed(self) -> Array:
        """The Jacobian per spread of each datum."""
        return np.asarray(self.jacobian / self.spread[:, None])

    @property
    def surprise(self) -> Array:
        """Residual (size,) per spread."""
        return np.asarray(self.residual / self.spread)

    @property
    def rss(self) -> float:
        """Σ residual²."""
        with np.errstate(over="ignore"):  # a model that runs away leaves infinitely much
            return float(self.residual @ self.residual)

    @property
    def left(self) -> float:
        """Σ residual² as recorded, however uncertain what drives the run is."""
        with np.errstate(over="ignore"):
            return float((self.bench.undoubted(self.residual) ** 2).sum())

    @property
    def freedom(self) -> float:
        """Degrees of freedom this run was given for itself."""
        return len(self.own) + (0.0 if self.heights is None else self.heights.freedom)

    @property
    def spare(self) -> float:
        """Share of the run's data left over by the numbers that are free in it."""
        return max(self.bench.size - self.freedom, 1) / self.bench.size

    @property
    def charged(self) -> float:
        """Σ residual², as it would be had nothing in the run followed the noise."""
        return self.rss / self.spare

    @property
    def data(self) -> Array:
        """The residual (size,) with what heights contribute put back, to first order."""
        if self.heights is None:
            return self.residual
        return self.residual + self.heights.contribution()

    def spectrum(self) -> Spectrum:
        """What the density of its heights is told from."""
        assert self.heights is not None
        return Spectrum.of(self.heights.ground, self.data, self.residual)

    def uncertainties(self, sigma: float) -> dict[str, float]:
        """Standard deviation of each of the run's own numbers, what runs share held fixed, where
        `sigma` is that of one in-band coefficient."""
        columns = self.weighed[:, self.derivatives.shared :]
        prior = [max((f.scale * sigma / f.sigma) ** 2, 1e-12) for f in self.own]
        inverse = np.linalg.inv(columns.T @ self.freed(columns) + np.diag(prior))
        spread = sigma * np.sqrt(np.diag(inverse))
        return {f.name: f.scale * float(s) for f, s in zip(self.own, spread, strict=True)}

    @property
    def blocks(self) -> int:
        """How many times `BLOCK_S` the run lasts."""
        time = self.bench.run.time_s
        return max(1, round(float(time[-1] - time[0]) / BLOCK_S))

    def in_time(self, column: Array) -> Array:
        """A column (size,) of in-band coefficients as a signal (n, channels)."""
        band = self.bench.band
        return band.from_coefficients(column.reshape(band.count, -1))

    def followed(self) -> Array:
        """Derivatives (size, g) with respect to the shared parameters, per spread and `Free.scale`,
        where the run's own numbers and heights follow."""
        columns, shared = self.freed(self.weighed), self.derivatives.shared
        own = columns[:, shared:]
        return columns[:, :shared] - own @ np.linalg.lstsq(own, columns[:, :shared], rcond=None)[0]

    def by_block(self, columns: Array) -> Array:
        """What the surprise of every half-second pulls at columns (size, m): (blocks, m)."""
        surprise = self.in_time(self.surprise)
        ends = np.array_split(np.arange(len(surprise)), self.blocks)
        pulls = [(self.in_time(column) * surprise).sum(axis=1) for column in columns.T]
        return np.array([[pull[block].sum() for pull in pulls] for block in ends])

    def freed(self, columns: Array) -> Array:
        """What heights would leave of columns (size, m)."""
        return columns if self.heights is None else self.heights.freed(columns)

    def settled(self) -> RunFit:
        """The run, its heights without what led to them."""
        return replace(self, heights=self.heights and self.heights.settled())


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted model.

    ``precision`` (g, g) is that of the shared parameters, in the order of ``shared``, per
    `Free.scale`.
    ``sigma`` is the standard deviation of the sensors' noise of one in-band coefficient, ``cost``
    −2 × the logarithm of likelihood and prior, and ``log_volume`` half the logarithm of prior over
    posterior precision of all parameters. ``measured`` is what was known of several of them.
    """

    model: Model
    shared: tuple[Free, ...]
    runs: tuple[RunFit, ...]
    precision: Array
    sigma: float
    cost: float
    log_volume: float
    measured: tuple[Measured, ...] = ()

    @property
    def derivatives(self) -> dict[str, dict[str, NDArray[np.floating]]]:
        """Columns of derivatives by run and by the name of the number."""
        return {
            run.bench.run.id: {
                f.name: column
                for f, column in zip((*self.shared, *run.own), run.derivatives.columns, strict=True)
            }
            for run in self.runs
        }

    @property
    def evidence(self) -> float:
        """Logarithm of the evidence by Laplace's method, up to a constant of the data.

        Likelihood at the best fit times the share of the prior volume the data leave (D. MacKay,
        Information Theory, Inference, and Learning Algorithms, eq. 28.7).
        """
        return -0.5 * self.misfit + self.log_volume

    @property
    def misfit(self) -> float:
        """−2 ln p of the data and the numbers found, up to a constant of the data: the cost, which
        is in units of the noise found, and what that noise makes of it."""
        return self.cost + 2.0 * self.size * float(np.log(self.sigma))

    @property
    def rss(self) -> float:
        """Σ residual² over the runs fitted."""
        return sum(run.rss for run in self.runs)

    @property
    def charged(self) -> float:
        """Σ residual² over the runs fitted, each run's charged for the numbers free in it."""
        return sum(run.charged for run in self.runs)

    @property
    def error(self) -> float:
        """E over the runs fitted: √(Σ residual² / Σ measured²)."""
        energy = sum(run.bench.energy for run in self.runs)
        return float(np.sqrt(sum(run.left for run in self.runs) / energy))

    @property
    def size(self) -> int:
        """Number of in-band data."""
        return sum(run.bench.size for run in self.runs)

    @property
    def of_heights(self) -> bool:
        """Whether some run's ground has unknown heights: what is left counts by squares."""
        return any(run.heights is not None for run in self.runs)

    @property
    def measures_force(self) -> bool:
        """Whether the records show the common scale of masses and forces."""
        return any(run.bench.measures_force for run in self.runs)

    @property
    def has_derivatives(self) -> bool:
        """Whether it has not been taken `without_derivatives`."""
        return any(run.derivatives.columns for run in self.runs)

    @property
    def without_derivatives(self) -> Fit:
        """Copy without Jacobian columns, which dominate memory."""
        runs = [replace(r, derivatives=Derivatives((), r.derivatives.shared)) for r in self.runs]
        return replace(self, runs=tuple(runs))

    @property
    def believed(self) -> Array:
        """Precision (g, g) with which the shared parameters are believed, per scale, where they
        lie."""
        return self.belief.precision_at(self.model.values)

    @cached_property
    def belief(self) -> Belief:
        """What was believed of the shared parameters before anything was fitted."""
        return Belief.of(self.shared, self.measured)

    @property
    def posterior(self) -> Belief:
        """What is known of the shared parameters after the fit."""
        return Belief.after(self.shared, self.model.values, self.precision)

    @cached_property
    def covariance(self) -> Array:
        """Of the shared parameters (g, g), in their units."""
        # Forces scale with masses, a direction only the prior holds: unit diagonals keep it apart.
        unit = np.sqrt(np.diag(self.precision))
        scale = np.array([free.scale for free in self.shared]) / unit
        inverse = np.linalg.inv(self.precision / np.outer(unit, unit))
        return np.asarray(inverse * np.outer(scale, scale))

    @cached_property
    def ahead(self) -> dict[str, float]:
        """How much further each shared number would go if nothing bounded it, in its unit: one
        undamped step, to first order."""
        pull = self.belief.pull(self.model.values)
        with np.errstate(invalid="ignore", over="ignore"):  # of a model that runs away
            for run in self.runs:
                pull += run.followed().T @ run.surprise / self.sigma**2
            step = self.covariance @ (pull / [free.scale for free in self.shared])
        return {f.name: float(s) for f, s in zip(self.shared, step, strict=True)}

    @cached_property
    def deviations(self) -> dict[str, float]:
        """Standard deviation of each shared parameter, in its unit; NaN where nothing tells it.

        What a model leaves is neither as small nor as white as noise, and the numbers scatter as
        the pulls of its half-seconds do (J. MacKinnon, M. Nielsen, M. Webb, Cluster-robust
        inference, J. Econometrics 232 (2023) 272, eq. 7). They are never known better than noise
        alone would have them, nor masses and forces better than what is believed of their common
        scale, whatever derivatives with an error seem to tell of it; and none worse than it was
        believed: however little the runs tell, they take nothing away from that.
        """
        scale = np.array([free.scale for free in self.shared])
        spread = (scale * self._spread(np.eye(len(scale)))).tolist()
        believed = self.believed_deviations
        pairs = zip(self.shared, spread, strict=True)
        return {f.name: min(believed[f.name], s) if s == s else s for f, s in pairs}

    @cached_property
    def believed_deviations(self) -> dict[str, float]:
        """Standard deviation of each shared parameter in its unit, were it believed beforehand to
        lie where it was fitted; infinite where nothing was believed."""
        spread = self.belief.deviations_at(self.model.values).tolist()
        return {f.name: f.scale * s for f, s in zip(self.shared, spread, strict=True)}

    @cached_property
    def relations(self) -> dict[str, tuple[float, float]]:
        """What was `measured` of the vehicle, by its name, as fitted: value and standard
        deviation."""
        values = self.model.values
        spread = self._spread(self.belief.slopes_of_measured(values))
        return {
            m.name: (value := m.of(values), value * min(float(s), m.relative))
            for m, s in zip(self.belief.measured, spread, strict=True)
        }

    @cached_property
    def scatter(self) -> Array:
        """How much more the shared numbers scatter (g, g) than noise alone would have them, per
        scale."""
        scale = np.array([free.scale for free in self.shared])
        more = np.zeros((len(scale), len(scale)))
        for run in self.runs:
            columns = run.followed()
            pulls = run.by_block(columns) / self.sigma**2
            more += pulls.T @ pulls - columns.T @ columns / self.sigma**2
        half = self.covariance / scale  # per what the pulls are per
        return np.asarray(half @ more @ half.T)

    def _spread(self, along: Array) -> Array:
        """Standard deviation (k,) of k sums of shared numbers (k, g), per scale."""
        scale = np.array([free.scale for free in self.shared])
        covariance = self.covariance / np.outer(scale, scale)
        with np.errstate(invalid="ignore", over="ignore"):  # of a model that runs away
            white, more = (
                np.einsum("ki,ij,kj->k", along, matrix, along)
                for matrix in (covariance, self.scatter / np.outer(scale, scale))
            )
            spread = np.sqrt(white + np.maximum(more, 0.0))
        return np.asarray(np.maximum(spread, abs(along @ self.of_scale)))

    @property
    def of_scale(self) -> Array:
        """How much every shared number moves (g,), per scale, with one standard deviation of the
        common scale of masses and forces, which records do not show; 0 of others, and where one of
        these numbers is given or a force is measured."""
        values = {f.name: self.model.values[f.name] * of_forces(f.name) for f in self.shared}
        along = np.array([*values.values()]) / [f.scale for f in self.shared]
        told = float(along @ self.believed @ along)
        given = scale_is_given(self.shared, self.model.values)
        if not told > 0.0 or given or self.measures_force:
            return np.zeros(len(along))
        return np.asarray(along / np.sqrt(told))

    def uncertainty(self, name: str) -> float:
        """Standard deviation of a shared parameter, in its unit; see `deviations`."""
        return self.deviations[name]
