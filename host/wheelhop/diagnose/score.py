"""Judgement: is one model better than another on runs that neither was fitted to?

Where few runs are held out, chance decides: then fitted runs judge, too, each left out in turn.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import erfc, inf, isfinite, sqrt

import numpy as np
from numpy.typing import NDArray

from wheelhop.diagnose.left_out import left_out
from wheelhop.fit import Fit, RunFit
from wheelhop.simulate import Model


class Exact:
    """Finds that no simulation is wrong."""

    def __call__(self) -> float:
        """Power, in units of the noise's: none."""
        return 0.0


EXACTLY = Exact()


@dataclass(frozen=True, eq=False)
class Rung:
    """A model fitted to the "fit" runs, and what it does on the "validate" runs: when only what
    those leave free is fitted there (``validation``), and, where that leaves more than a model
    which explains the fitted runs should, when the numbers that runs share may move as far as they
    are uncertain (``update``). ``simulated_wrong`` finds what is ``inexact``; ``by_laws`` is how
    much less `power` it leaves than without that law of the struts which explains most."""

    fit: Fit
    validation: Fit | None
    update: Fit | None = None
    simulated_wrong: Callable[[], float] = EXACTLY
    by_laws: float = 0.0

    @cached_property
    def inexact(self) -> float:
        """Power, in units of the noise's, by which the simulation of the model's effects may itself
        be wrong on the runs that judge. Few rungs are asked for it: it takes simulations."""
        return self.simulated_wrong()

    @property
    def judging(self) -> Fit:
        """The fit whose runs judge the model: those held out, or the fitted ones if there are no
        others."""
        return self.update or self.validation or self.fit

    @property
    def model(self) -> Model:
        """The model, what every run leaves free included."""
        fitted = self.fit.model
        if self.validation is None:
            return fitted
        other = self.validation.model
        runs, heights = {**fitted.runs, **other.runs}, {**fitted.heights, **other.heights}
        return Model(fitted.values, fitted.effects, runs, heights)

    @property
    def error_fit(self) -> float:
        """E over the runs fitted."""
        return self.fit.error

    @property
    def error_validate(self) -> float:
        """E over the other runs as foreseen, charged for the degrees of freedom each was given."""
        return float("nan") if self.validation is None else _error(self.validation)

    @property
    def error(self) -> float:
        """E over the other runs as foreseen, or over the fitted ones if there are no others."""
        return self.error_fit if self.validation is None else self.error_validate

    @property
    def error_judging(self) -> float:
        """`error` once shared numbers may move as far as they are uncertain."""
        return self.error_fit if self.validation is None else _error(self.judging)

    @property
    def evidence(self) -> float:
        """Logarithm of the model's evidence by Laplace's method, up to a constant of the data: that
        of the runs fitted, and of the others given what was fitted."""
        held_out = 0.0 if self.validation is None else self.judging.evidence
        return self.fit.evidence + held_out


def _error(held_out: Fit) -> float:
    left = sum(run.left / run.spare for run in held_out.runs)
    return float(np.sqrt(left / sum(run.bench.energy for run in held_out.runs)))


Array = NDArray[np.float64]

FEW_BLOCKS = 25
"""An effect that shows in half of n blocks, and there alike, reaches Λ = n/4. One of thirty tried
needs ln(30/0.05) = 6.4: so many blocks. With fewer held out, chance would decide."""

MATERIAL = 0.02
"""What takes less than this share of the noise's power out of the held-out residual is immaterial,
however simple the model: a rounding of the simulation could be mistaken for physics."""

EXACT = 0.003
"""Models of machines are exact to about this share of the signal: what is left beyond the noise is
held against a model, and taken for one more effect, only if it is more."""

LAW = 0.1
"""A law of the right name leaves about this share, in amplitude, of what its machine does: machines
part from textbooks. Laws of wrong names leave a third and more (theory, section 10)."""

FEW_LAWS = 2.0
"""Few laws of the right name leave more than so many times `LAW`."""

SIGNIFICANT = 0.05
"""An effect is accepted below this chance of being mistaken, all effects tried counted."""

WHITE = 1.1
"""A residual whose mean square is within this factor of the noise's is taken for noise."""

NEARLY_ALL = 0.9
"""What explains this share of the power above the noise leaves little for anything else."""

AGREED = 0.01
"""No evidence makes up for leaving this share more of the runs than another model does."""

HOPELESS = 2.0
"""What leaves this many times the error of another won't catch up: in a full fit after a quick one,
in any fit after both were screened."""


def log_odds(base: Rung, rival: Rung, noise: float = 0.0) -> float:
    """Logarithm of the likelihood ratio of `rival` over `base` on the runs that judge.

    While something unexplained is left in the rival's residual, Λ = Σ g, g = ½ ln(S_base / S_rival)
    over blocks of half a second: Gaussian residuals of unknown size with one degree of freedom a
    block; S is the block's sum of squares, charged for the numbers free in its run. Each block
    counts by how many times smaller its residual became, so that loud and quiet runs are heard
    alike. Two models that are both wrong may differ by large factors, now up, now down: Λ is no
    more than the toss of a coin in every block allows, Λ² / 2 Σ g² (W. Hoeffding, Probability
    inequalities for sums of bounded random variables, J. Am. Stat. Assoc. 58 (1963) 13, eq. 2.6,
    for signs ±g). Once the rival is down at the sensors' white noise, of which `noise` is the
    standard deviation of one in-band coefficient (0: not known), every coefficient counts:
    Λ = Σ (S_base − S_rival) / 2 noise², unknown heights integrated out with the density that the
    fitted runs gave them. Negative if the rival is worse, −∞ if its simulation runs away.

    The runs with role "validate" judge. Where they are few, or there are none, and something is
    left, every fitted run judges, too, as a fit to the others foresees it.
    """
    if runs_away(rival) or runs_away(base):
        return -inf if runs_away(rival) else inf
    if at_noise(rival, noise):
        return 0.5 * (_cost(base, noise) - _cost(rival, noise))
    pairs = zip(_foreseen(base), _foreseen(rival), strict=True)
    gains = np.concatenate([_gains(before, after) for before, after in pairs])
    total, squares = float(gains.sum()), float(gains @ gains)
    by_chance = total * abs(total) / (2.0 * squares) if squares > 0.0 else 0.0
    return min(total, by_chance, key=abs)


def runs_away(rung: Rung) -> bool:
    """Whether a model's simulation runs away, of the runs fitted or of those that judge."""
    return not isfinite(rung.fit.rss + rung.judging.rss)


def p_value(odds: float, tried: int) -> float:
    """Chance that one of `tried` worthless effects reaches these log-odds.

    A likelihood ratio on data that the models were not fitted to exceeds 1/p with a probability
    of at most p if the simpler model is true (L. Wasserman, A. Ramdas, S. Balakrishnan, Universal
    inference, PNAS 117 (2020) 16880, theorem 1); Bonferroni's correction for the effects tried.
    """
    return min(1.0, tried * float(np.exp(-max(odds, 0.0))))


def holds_against(base: Rung, rival: Rung, odds: float, tried: int, noise: float) -> bool:
    """Whether a rival with these log-odds, one of `tried`, takes something material out of what
    the base leaves, and not by chance. Where both leave something, that is what the typical block
    is left with; where both have effects, too, it has to be more than such models are exact to."""
    least = material(base)
    if noise == 0.0 or at_noise(rival, noise):
        drop = relative_to_noise(base, rival, noise)
    else:
        drop = typical(base, noise) - typical(rival, noise)
        if base.model.effects:
            energy = sum(run.bench.energy for run in rival.judging.runs)
            least += EXACT**2 * energy / (rival.judging.size * noise**2)
    return drop > least and p_value(odds, tried) < SIGNIFICANT


def power(rung: Rung) -> float:
    """Mean square residual per datum of the judging runs, charged for the numbers free there."""
    return rung.judging.charged / rung.judging.size


def of_a_law(dropped: float, by_laws: float) -> bool:
    """Whether a second law of the struts `dropped` no more residual power than the first law, under
    its right name but in another form, may leave of the power that it explains (`by_laws`). That
    residual is a function of the struts' motion, so any second law takes most of it."""
    return dropped < (FEW_LAWS * LAW) ** 2 * by_laws


def material(rung: Rung) -> float:
    """Least drop of residual power that could be physics, in units of the noise's power."""
    return MATERIAL + rung.inexact


def noticeable(rung: Rung, noise: float) -> bool:
    """Whether the residual could hold anything material: more than noise leaves by chance in one
    campaign of fifty."""
    by_chance = 2.0 * float(np.sqrt(2.0 / rung.judging.size))
    return excess(rung, noise) > material(rung) + by_chance


def by_chance(rung: Rung, noise: float, allowed: float = 0.0) -> float:
    """Chance that noise, known as it is stated, leaves at least as much as a rung does, what is
    immaterial allowed for, and `allowed` as a share of the signal's power."""
    if noise == 0.0:
        return 1.0
    judging = rung.judging
    energy = sum(run.bench.energy for run in judging.runs) if allowed else 0.0
    more = excess(rung, noise) - material(rung) - allowed * energy / (judging.size * noise**2)
    return 0.5 * erfc(more / sqrt(2.0 / judging.size) / sqrt(2.0))


def unforeseen(rung: Rung, noise: float) -> bool:
    """Whether a model that explains the runs fitted leaves noticeably more of those held out. What
    it leaves of the fitted runs, too, is expected, and allowed for."""
    if not all_noise(rung.fit, noise):
        return False
    by_chance = 2.0 * float(np.sqrt(2.0 / rung.judging.size + 2.0 / rung.fit.size))
    foreseen = max(above_noise(rung.fit, noise), 0.0)
    return excess(rung, noise) > foreseen + material(rung) + by_chance


def relative_to_noise(base: Rung, rival: Rung, noise: float) -> float:
    """Drop of the held-out sum of squares, charged, in units of what noise alone leaves there.

    `noise` is the standard deviation of one in-band coefficient; infinite if that is 0.
    """
    return excess(base, noise) - excess(rival, noise) if noise > 0 else np.inf


def typical(rung: Rung, noise: float = 1.0) -> float:
    """Geometric mean over half-second blocks of the judging runs' residual power, charged for the
    numbers free in each run, in units of the noise's power. Loud and quiet runs count alike."""
    if runs_away(rung):
        return np.inf
    each = [
        np.log(_block_squares(run, run.blocks) * run.blocks / (run.spare * run.bench.size))
        for run in _foreseen(rung)
    ]
    return float(np.exp(np.concatenate(each).mean())) / noise**2


def excess(rung: Rung, noise: float) -> float:
    """Residual power of the judging runs above the noise, in units of the noise's power."""
    return above_noise(rung.judging, noise)


def above_noise(fit: Fit, noise: float) -> float:
    """Residual power of a fit's runs above the noise, in units of the noise's power."""
    return fit.charged / (fit.size * noise**2) - 1.0 if noise > 0 else np.inf


def fall(base: Rung, rung: Rung) -> float:
    """How far the error E of the runs that judge falls, as a logarithm: from 8 to 4 % as far as
    from 2 to 1 %."""
    with np.errstate(divide="ignore"):  # of a model that leaves nothing, or runs away
        return float(np.log(base.error_judging) - np.log(rung.error_judging))


def nearly_all(base: Rung, rung: Rung, noise: float) -> bool:
    """Whether a rung explains at least nine tenths of the base's power above the noise. False where
    the noise is not known."""
    return noise > 0.0 and excess(rung, noise) <= (1.0 - NEARLY_ALL) * excess(base, noise)


def worth_seeking(fit: Fit) -> float:
    """Least drop in cost that justifies a search: 10 % of the cost above the noise."""
    return (1.0 - NEARLY_ALL) * (fit.cost - fit.size)


def lead(rung: Rung, rival: Rung) -> float:
    """Squared residual of the rival minus that of `rung`, over all runs fitted and held out, per
    coefficient and per mean square residual of `rung` on the fitted runs.

    Evidence grows with the number of data even where two models differ by less than either is
    exact; this does not.
    """
    size = rung.fit.size + rung.judging.size
    level = max(rung.fit.sigma**2, rung.fit.rss / rung.fit.size)
    return (_left(rival) - _left(rung)) / (size * level)


def _left(rung: Rung) -> float:
    """Sum of squared residuals of the runs fitted and held out."""
    return sum(left(run) for run in (*rung.fit.runs, *rung.judging.runs))


def left(run: RunFit) -> float:
    """Sum of squares a model leaves of a run, as if nothing in it followed the noise.

    Heights that nobody knows do so twice, in what they take and in what they spoil (generalised
    cross-validation: T. Hastie, R. Tibshirani, J. Friedman, The Elements of Statistical Learning,
    2009, eq. 7.52).
    """
    spent = 0.0 if run.heights is None else run.heights.freedom / run.bench.size
    return run.charged / (1.0 - spent)


def at_noise(rung: Rung, noise: float) -> bool:
    """Whether the residual of the runs that judge is no larger than noise, `noise` being the
    standard deviation of one in-band coefficient."""
    return all_noise(rung.judging, noise)


def all_noise(fit: Fit, noise: float) -> bool:
    """Whether the residual of a fit's runs is no larger than noise; see `at_noise`."""
    by_chance = 3.0 * float(np.sqrt(2.0 / fit.size))  # few data: their mean square is uncertain
    return fit.charged < (WHITE + by_chance) * noise**2 * fit.size


def best_first(rungs: Sequence[Rung], noise: float) -> list[Rung]:
    """Where one of them reaches the noise the evidence orders them, as far as what they leave
    agrees: unknown heights can follow whatever resembles them, and the likelihood of that depends
    on how their density is assumed to look. While all leave something unexplained, the likelihood
    of the fitted runs is not to be trusted at all, and the runs held out decide, by what the
    typical block is left with: of the loudest runs each of several effects may explain nothing
    alone."""
    if not any(at_noise(rung, noise) for rung in rungs):
        return sorted(rungs, key=typical)
    least = min(rungs, key=_left)
    return sorted(rungs, key=lambda r: (lead(least, r) > AGREED, -r.evidence))


def _cost(rung: Rung, noise: float) -> float:
    """−2 × the logarithm of the likelihood of the runs that judge, up to a constant; numbers that
    were free to move among them are integrated out, as the heights are."""
    total = 0.0
    for run in rung.judging.runs:
        size = run.bench.size
        total += run.rss / noise**2 * size / max(size - len(run.own), 1)
        if run.heights is not None:
            total += run.heights.penalty - run.heights.log_volume
    if rung.update is not None:
        total += rung.fit.posterior.distance(rung.update.model.values)
        total += rung.update.posterior.log_precision - rung.fit.posterior.log_precision
    return total


def _foreseen(rung: Rung) -> tuple[RunFit, ...]:
    """The runs that judge, none of them fitted to itself."""
    held_out = () if rung.judging is rung.fit else rung.judging.runs
    return held_out if enough_held_out(rung) else (*held_out, *left_out(rung.fit))


def enough_held_out(rung: Rung) -> bool:
    """Whether the runs held out judge by themselves: no derivatives are asked for then."""
    held_out = () if rung.judging is rung.fit else rung.judging.runs
    return sum(run.blocks for run in held_out) >= FEW_BLOCKS


def _gains(base: RunFit, rival: RunFit) -> Array:
    count = base.blocks
    ratio = _block_squares(base, count) / _block_squares(rival, count)
    return np.asarray(0.5 * np.log(ratio * rival.spare / base.spare))


def _block_squares(run: RunFit, count: int) -> Array:
    signal = run.in_time(run.residual)
    return np.array([np.sum(part**2) for part in np.array_split(signal, count)])
