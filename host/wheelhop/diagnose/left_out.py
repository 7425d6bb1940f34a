"""What a fit would leave of some of its data had it not been fitted to them, to first order.

A run that was fitted tells as much of a model as one held out, once the fit is taken back to what
it would be without that run. Derivatives are at hand, so nothing is simulated: with the precision A
of the shared parameters, of which the run gave M, and the pull g the run has on them, they would
move by −(A − M)⁻¹ g (W. Belsley, E. Kuh, R. Welsch, Regression Diagnostics, 1980, section 2.1, for
a block of data). What is free in the run follows. A single run has no others: there a quarter of it
is left out, and the run's own numbers are as uncertain as the shared ones.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.fit import Fit, RunFit

Array = NDArray[np.float64]

PARTS = 4
"""Of a single run."""


def left_out(fit: Fit) -> tuple[RunFit, ...]:
    """The runs of a fit, each with the residual that a fit to the other runs would leave of it, to
    first order; of a single run, each part as a fit to the other parts would."""
    if len(fit.runs) == 1:
        return (_parts_left_out(fit, fit.runs[0]),)
    return tuple(_left_out(fit, run) for run in fit.runs)


def _left_out(fit: Fit, run: RunFit) -> RunFit:
    g = len(fit.shared)
    if g == 0:
        return run
    weighed = run.weighed
    columns = run.freed(weighed)
    square = columns.T @ weighed / fit.sigma**2
    # The run's own numbers are at their best: only the shared ones are still pulled.
    pull = columns.T[:g] @ run.surprise / fit.sigma**2
    own = square[g:, g:] + _prior_of_own(run)
    follow = np.linalg.solve(own, square[g:, :g])
    given = square[:g, :g] - square[:g, g:] @ follow
    moved = _without(fit.precision, given, pull)
    step = np.concatenate([moved, -follow @ moved])
    return replace(run, residual=run.residual - run.freed(run.jacobian) @ step)


def _parts_left_out(fit: Fit, run: RunFit) -> RunFit:
    """Only the other parts say anything of the run's own numbers, too: all are treated alike."""
    g, jacobian = len(fit.shared), run.jacobian
    weighed, free = run.weighed, run.freed(jacobian)
    precision = run.freed(weighed).T @ weighed / fit.sigma**2
    precision[g:, g:] += _prior_of_own(run)
    mixed = precision[:g, g:]
    precision[:g, :g] = fit.precision + mixed @ np.linalg.solve(precision[g:, g:], mixed.T)

    def in_time(columns: Array) -> Array:
        return np.stack([run.in_time(column) for column in columns.T], axis=-1)

    moves, freed, pulled = in_time(free), in_time(run.freed(weighed)), in_time(weighed)
    residual, surprise = run.in_time(run.residual), run.in_time(run.surprise)
    for part in np.array_split(np.arange(len(residual)), PARTS):
        columns = freed[part].reshape(-1, free.shape[1])
        given = columns.T @ pulled[part].reshape(-1, free.shape[1]) / fit.sigma**2
        pull = columns.T @ surprise[part].ravel() / fit.sigma**2
        residual[part] -= moves[part] @ _without(precision, given, pull)
    return replace(run, residual=run.bench.band.coefficients(residual).ravel())


def _prior_of_own(run: RunFit) -> Array:
    return np.diag([(f.scale / f.sigma) ** 2 for f in run.own]) + 1e-6 * np.eye(len(run.own))


def _without(precision: Array, given: Array, pull: Array) -> Array:
    """The step of numbers of this precision once what some data gave of it, and their pull, is
    gone. What nothing else says anything of stays where it is."""
    unit = np.sqrt(np.maximum(np.diag(precision), 1e-300))
    share = (precision - given) / np.outer(unit, unit)
    if not np.isfinite(share).all():  # too large for a number: nothing can be taken back
        return np.zeros(len(pull))
    value, vector = np.linalg.eigh(share)
    known = value > 1e-9
    along = vector[:, known].T @ (pull / unit)
    return np.asarray(-(vector[:, known] @ (along / value[known])) / unit)
