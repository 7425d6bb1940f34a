"""Every fitted run as the others foresee it.

Where few runs are held out, chance decides. A run that was fitted tells as much, once the fit is
taken back to what it would be without that run. Derivatives are at hand, so no run is simulated:
with the precision A of the shared parameters, of which the run gave M, and the pull g the run has
on them, they would move by −(A − M)⁻¹ g (W. Belsley, E. Kuh, R. Welsch, Regression Diagnostics,
1980, section 2.1, for a block of data). What is free in the run follows.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wheelhop.fit import Fit, RunFit


def left_out(fit: Fit) -> tuple[RunFit, ...]:
    """The runs of a fit, each with the residual that a fit to the other runs would leave of it, to
    first order."""
    return tuple(_left_out(fit, run) for run in fit.runs)


def _left_out(fit: Fit, run: RunFit) -> RunFit:
    g = len(fit.shared)
    if g == 0:
        return run
    columns = run.freed(run.weighed)
    square = columns.T @ run.weighed / fit.sigma**2
    # The run's own numbers are at their best: only the shared ones are still pulled.
    pull = columns.T[:g] @ run.surprise / fit.sigma**2
    prior = np.array([(f.scale / f.sigma) ** 2 for f in run.own]) + 1e-6
    own = square[g:, g:] + np.diag(prior)
    follow = np.linalg.solve(own, square[g:, :g])
    given = square[:g, :g] - square[:g, g:] @ follow
    rest = fit.precision - given
    unit = np.sqrt(np.maximum(np.diag(fit.precision), 1e-300))
    # What no other run nor belief says anything of stays where it is.
    share = rest / np.outer(unit, unit)
    if not np.isfinite(share).all():  # too large for a number: nothing can be taken back
        return run
    value, vector = np.linalg.eigh(share)
    known = value > 1e-9
    along = vector[:, known].T @ (pull / unit)
    moved = -(vector[:, known] @ (along / value[known])) / unit
    step = np.concatenate([moved, -follow @ moved])
    return replace(run, residual=run.residual - run.freed(run.derivatives.matrix) @ step)
