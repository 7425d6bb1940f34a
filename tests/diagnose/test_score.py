"""The judgement on held-out runs: what chance alone makes of it."""

import warnings
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.compare.band import InBand
from wheelhop.diagnose.score import (
    MATERIAL,
    Rung,
    at_noise,
    best_first,
    by_chance,
    excess,
    holds_against,
    lead,
    left,
    log_odds,
    nearly_all,
    noticeable,
    p_value,
    relative_to_noise,
    unforeseen,
)
from wheelhop.fit import Fit, RunFit

SAMPLES, RUNS = 1024, 6
BAND = InBand(SAMPLES, 100.0, (0.5, 30.0))


def rung(signals, own=2):
    """A validated model whose residuals (n, c) in its runs are these."""
    runs = []
    for i, signal in enumerate(signals):
        residual = BAND.coefficients(signal).ravel()
        run = SimpleNamespace(id=str(i), time_s=np.arange(SAMPLES) / 100.0)
        bench = SimpleNamespace(
            run=run,
            band=BAND,
            size=residual.size,
            undoubted=np.asarray,
            predicted=np.ones(signal.shape[1], dtype=bool),
        )
        runs.append(RunFit(bench, (None,) * own, residual, None, np.ones(len(residual))))
    return Rung(fit_of(()), fit_of(runs))


def fit_of(runs):
    """Runs whose model shares nothing."""
    return Fit(None, (), tuple(runs), np.zeros((0, 0)), 1.0, 0.0, 0.0)


def noise(rng, size=1.0):
    return [size * rng.normal(size=(SAMPLES, 2)) for _ in range(RUNS)]


def blockwise(rng, signals, swing):
    """Each second of the residuals made larger or smaller, by the toss of a coin."""
    seconds = [np.exp(rng.choice([-0.25, 0.25], 10) * swing) for _ in signals]
    grow = [np.repeat(s, -(-SAMPLES // 10))[:SAMPLES, None] for s in seconds]
    return [signal * g for signal, g in zip(signals, grow, strict=True)]


@pytest.mark.parametrize("swing", [0.1, 0.3, 1.0, 3.0])
def test_equally_good_models_are_rarely_told_apart(swing):
    """Residuals differ by a factor in every second, up or down by chance: a p-value of 1 in 20 or
    less turns up in at most one of twenty tries (and a few for the simulation's own chance)."""
    rng, mistaken, tries = np.random.default_rng(8), 0, 300
    for _ in range(tries):
        signals = noise(rng)
        one, other = (rung(blockwise(rng, signals, swing)) for _ in range(2))
        mistaken += p_value(log_odds(one, other), 1) <= 0.05
    assert mistaken <= 0.05 * tries + 3 * np.sqrt(0.05 * tries)


def test_a_model_that_halves_the_residual_everywhere_is_better():
    signals = noise(np.random.default_rng(1))
    better = rung([0.5 * s for s in signals])
    odds = log_odds(rung(signals), better)
    assert odds > 0
    assert p_value(odds, 12) < 1e-6
    assert log_odds(better, rung(signals)) == pytest.approx(-odds)


def test_one_run_is_enough_to_see_that_wheels_leave_the_ground():
    """An effect that acts in a single run, and there takes away nearly all of the residual."""
    rng = np.random.default_rng(2)
    quiet = noise(rng)
    loud = [10.0 * quiet[0], *quiet[1:]]
    assert p_value(log_odds(rung(loud), rung(quiet)), 12) < 0.01


class Baseline(Rung):
    """A rung whose model has no effect."""

    model = SimpleNamespace(effects=())


def test_the_loudest_run_alone_decides_nothing_while_much_is_left():
    """Three effects are missing. One halves what is left of five runs, and of the loudest nothing;
    the other takes a twentieth out of the loudest alone: nearly all of the sum of squares."""
    signals = noise(np.random.default_rng(4), 20.0)
    base = rung([10.0 * signals[0], *signals[1:]])
    widely = rung([10.2 * signals[0], *(0.5 * s for s in signals[1:])])
    loudly = rung([9.5 * signals[0], *signals[1:]])
    base = Baseline(base.fit, base.validation)
    assert relative_to_noise(base, widely, 1.0) < 0.0 < relative_to_noise(base, loudly, 1.0)
    assert holds_against(base, widely, log_odds(base, widely, 1.0), 30, 1.0)
    assert best_first([loudly, base, widely], 1.0) == [widely, loudly, base]


def test_the_same_model_has_no_advantage_and_more_freedom_is_charged():
    signals = noise(np.random.default_rng(3))
    assert log_odds(rung(signals), rung(signals)) == 0.0
    assert log_odds(rung(signals), rung(signals, own=30)) < 0.0
    assert p_value(0.0, 1) == 1.0
    assert relative_to_noise(rung(signals), rung(signals), 1.0) == 0.0


@given(st.floats(-50.0, 200.0), st.integers(1, 40))
def test_p_value_is_a_chance_and_grows_with_the_number_tried(odds, tried):
    assert 0.0 <= p_value(odds, tried) <= p_value(odds, tried + 1) <= 1.0
    assert p_value(odds + 1.0, tried) <= p_value(odds, tried)


@pytest.mark.parametrize("unit", [1.0, 0.2])
def test_down_at_the_noise_every_coefficient_counts(unit):
    """A rival that leaves white noise: Λ = Σ (S_base − S_rival) / 2 noise², small as it may be."""
    rng = np.random.default_rng(6)
    signals = noise(rng, unit)
    faint = [s + 0.1 * unit * rng.normal(size=s.shape) for s in signals]
    base, rival = rung(faint, own=0), rung(signals, own=0)
    drop = sum(run.rss for run in base.validation.runs) - sum(r.rss for r in rival.validation.runs)
    assert log_odds(base, rival, unit) == pytest.approx(drop / (2 * unit**2))
    assert p_value(log_odds(base, rival, unit), 12) < 1e-6
    assert log_odds(base, rival, unit) > 5 * log_odds(base, rival)


def test_noise_alone_seldom_favours_one_of_two_models_at_the_floor():
    """Both leave noise of the size that is known, and differ by 2 % of it."""
    rng, mistaken, tries = np.random.default_rng(9), 0, 200
    for _ in range(tries):
        signals = noise(rng)
        one, other = (
            rung([s + 0.02 * rng.normal(size=s.shape) for s in signals]) for _ in range(2)
        )
        mistaken += p_value(log_odds(one, other, 1.0), 1) <= 0.05
    assert mistaken <= 0.05 * tries + 3 * np.sqrt(0.05 * tries)


def test_drop_in_units_of_the_noise():
    """White noise of standard deviation s has s² per coefficient; twice the residual is 3 more."""
    signals = noise(np.random.default_rng(4), 0.3)
    twice = rung([2.0 * s for s in signals], own=0)
    assert relative_to_noise(twice, rung(signals, own=0), 0.3) == pytest.approx(3.0, rel=0.05)


def test_what_a_simulation_may_be_wrong_by_is_no_physics():
    """A rival that takes a tenth of the noise's power out: enough beside a model that is simulated
    exactly, not beside one with a strong effect that may itself be wrong by more."""
    rng = np.random.default_rng(5)
    signals = noise(rng)
    base = rung([s + np.sqrt(0.1) * rng.normal(size=s.shape) for s in signals])
    rival = rung(signals)
    odds = log_odds(base, rival, 1.0)
    assert holds_against(base, rival, odds, 27, 1.0)
    assert not holds_against(replace(base, simulated_wrong=lambda: 0.15), rival, odds, 27, 1.0)


class BesideEffects(Rung):
    """A rung whose model has effects already."""

    model = SimpleNamespace(effects=("any",))


@pytest.mark.parametrize("unit", [1.0, 0.1])
@pytest.mark.parametrize(("signal", "held"), [(200.0, True), (300.0, False)])
def test_beside_effects_one_more_does_more_than_models_are_exact_to(signal, held, unit):
    """Both leave something; the drop is half the noise's power, 0.35 % of one signal and 0.24 % of
    the other: models are exact to 0.3 %, in any unit."""
    rng = np.random.default_rng(6)
    quiet = noise(rng, np.sqrt(2.0) * unit)
    base, rival = rung([np.sqrt(1.25) * s for s in quiet]), rung(quiet)
    for run in (*base.validation.runs, *rival.validation.runs):
        run.bench.energy = (signal * unit) ** 2 * run.bench.size
    beside = BesideEffects(base.fit, base.validation)
    assert holds_against(beside, rival, 100.0, 27, unit) is held


def test_noise_is_seldom_worth_another_look():
    """What is no more than noise and 2 % is left alone, three times as much is not."""
    rng, tries = np.random.default_rng(10), 300
    size = rung(noise(rng), own=0).judging.size

    def noticed(power):
        signals = noise(rng, np.sqrt(1.0 + power))
        return noticeable(rung(signals, own=0), 1.0)

    assert sum(noticed(0.0) for _ in range(tries)) == 0
    assert sum(noticed(0.02) for _ in range(tries)) < 0.06 * tries
    assert all(noticed(0.06 + 8.0 * np.sqrt(2.0 / size)) for _ in range(tries))


def test_what_is_left_of_all_runs_alike_is_no_surprise():
    """A road's heights are charged by a density that is roughly right: what that leaves of the runs
    fitted, it leaves of the others. Thrice the material more in these is a surprise."""
    rng, tries = np.random.default_rng(12), 100
    size = rung(noise(rng), own=0).judging.size

    def surprising(fitted, held_out):
        before, after = (
            rung(noise(rng, np.sqrt(1.0 + power)), own=0).validation for power in (fitted, held_out)
        )
        return unforeseen(Rung(before, after), 1.0)

    for power in (0.0, 0.02, 0.05):
        assert sum(surprising(power, power) for _ in range(tries)) < 0.03 * tries
        assert sum(surprising(power, 0.0) for _ in range(tries)) == 0
        more = power + 0.06 + 8.0 * np.sqrt(4.0 / size)
        assert all(surprising(power, more) for _ in range(tries))


def test_a_model_that_leaves_much_of_the_runs_fitted_foresees_nothing():
    rng = np.random.default_rng(11)
    fitted = rung(noise(rng, 1.3), own=0).validation
    assert not unforeseen(Rung(fitted, rung(noise(rng, 3.0), own=0).validation), 1.0)


def test_noise_leaves_so_much_as_often_as_is_said():
    """Noise with what is immaterial on top: one residual in ten has a chance of a tenth or less."""
    rng, tries = np.random.default_rng(12), 300
    size = np.sqrt(1.0 + MATERIAL)
    chances = [by_chance(rung(noise(rng, size), own=0), 1.0) for _ in range(tries)]
    rare = sum(chance <= 0.1 for chance in chances)
    assert abs(rare - 0.1 * tries) <= 3 * np.sqrt(0.09 * tries)


def test_noise_hardly_leaves_a_twentieth_more():
    left = rung(noise(np.random.default_rng(13), 1.05), own=0)
    assert by_chance(left, 1.0) < 1e-3
    assert by_chance(left, 0.0) == 1.0  # nothing is known of it


@pytest.mark.parametrize("more", [0.0, 0.005, 0.015, 0.05])
@pytest.mark.parametrize("evidence", [-500.0, -1.0, 1.0, 500.0])
def test_evidence_decides_between_models_that_leave_alike(more, evidence):
    """One leaves `more` of the same residual and has `evidence` for it, which counts as long as
    the two leave alike, to a hundredth, whichever is named first."""
    signals = noise(np.random.default_rng(14))
    fit = rung([np.sqrt(1.0 + more) * s for s in signals], own=0).validation
    one = Rung(rung(signals, own=0).validation, None)
    other = Rung(replace(fit, log_volume=evidence), None)
    expected = [other, one] if evidence > 0.0 and more < 0.01 else [one, other]
    assert best_first([one, other], 1.0) == best_first([other, one], 1.0) == expected


def test_heights_that_follow_the_noise_foresee_none_of_it():
    """A tenth of the directions of noise are taken out of each residual; what is left counts as
    what those heights would leave of another drive: there they do not fit, and spoil as much."""
    rng = np.random.default_rng(15)
    seen, another = (rung(noise(rng), own=0).judging.runs for _ in range(2))
    counted, foreseen = 0.0, 0.0
    for run, other in zip(seen, another, strict=True):
        taken = round(0.1 * run.bench.size)
        learnt = np.where(np.arange(run.bench.size) < taken, run.residual, 0.0)
        heights = SimpleNamespace(freedom=float(taken))
        spare = replace(run, residual=run.residual - learnt, heights=heights)
        counted += left(spare)
        foreseen += float(np.sum((other.residual - learnt) ** 2))
    assert counted == pytest.approx(foreseen, rel=0.05)


def test_heights_that_nobody_would_expect_are_evidence_against_a_model():
    """They cost what the density that they were given says: −2 ln of their probability, the volume
    that noise leaves them allowed for."""
    base = rung(noise(np.random.default_rng(16)), own=0)
    heights = SimpleNamespace(freedom=0.0, penalty=6.0, log_volume=2.0)
    unlikely = [replace(run, heights=heights) for run in base.judging.runs]
    rival = Rung(base.fit, fit_of(unlikely))
    assert log_odds(base, rival, 1.0) == pytest.approx(-0.5 * RUNS * (6.0 - 2.0))


def test_a_rival_that_runs_away_has_no_chance_and_makes_no_noise():
    base, rival = rung(noise(np.random.default_rng(4))), rung(noise(np.random.default_rng(5)))
    lost = [replace(run, residual=np.full_like(run.residual, np.inf)) for run in rival.judging.runs]
    rival = Rung(rival.fit, fit_of(lost))
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        assert log_odds(base, rival) == -np.inf
        assert p_value(log_odds(base, rival), 12) == 1.0


def leaving(power, unit=1.0):
    """A rung that leaves exactly this mean square per coefficient, of a signal of which it is 100;
    the unit of both is `unit` squared."""
    one = rung(noise(np.random.default_rng(17)), own=0)
    scale = unit * np.sqrt(power * one.judging.size / sum(run.rss for run in one.judging.runs))
    scaled = [replace(run, residual=scale * run.residual) for run in one.judging.runs]
    for run in scaled:
        run.bench.energy = 100.0 * unit**2 * run.bench.size
    return Rung(one.fit, fit_of(scaled))


SIZE = rung(noise(np.random.default_rng(17)), own=0).judging.size
CHANCE = float(np.sqrt(2.0 / SIZE))
"""Relative standard deviation of the mean square of so many coefficients of noise."""
BLOCKS = RUNS * 20
"""Of half a second each."""


@pytest.mark.parametrize(
    ("share", "left_of_it", "expected"),
    [(1.0, 0.5, BLOCKS / 2), (0.5, 0.5, BLOCKS / 4), (1.0, 0.9, BLOCKS * np.log(1 / 0.9))],
)
def test_odds_are_half_the_blocks_that_agree_at_most(share, left_of_it, expected):
    """Λ = Σ g, and Λ² / 2 Σ g² of one gain in a share of all blocks is half their number."""
    signals = noise(np.random.default_rng(18))
    factors = [left_of_it if i < share * RUNS else 1.0 for i in range(RUNS)]
    better = [factor * signal for factor, signal in zip(factors, signals, strict=True)]
    assert log_odds(rung(signals), rung(better)) == pytest.approx(expected, rel=1e-9)


def test_one_of_twelve_that_chance_gives_once_in_240_is_one_of_twenty():
    assert p_value(np.log(240.0), 12) == pytest.approx(0.05)
    assert p_value(np.log(12.0), 12) == pytest.approx(1.0)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_where_noise_ends_is_known_to_a_hair(sign):
    """A tenth above the noise and three standard deviations of chance it is noise no more; 2 % and
    two of them are worth another look; a tenth of what was left is nearly all explained."""
    hair = 1e-6 * sign
    assert at_noise(leaving(1.1 + 3.0 * CHANCE + hair), 1.0) is (sign < 0.0)
    assert noticeable(leaving(1.02 + 2.0 * CHANCE + hair), 1.0) is (sign > 0.0)
    assert nearly_all(leaving(11.0), leaving(2.0 + hair), 1.0) is (sign < 0.0)
    assert not nearly_all(leaving(11.0), leaving(1.0), 0.0)  # the noise is not known
    fitted = leaving(1.05).judging
    more = 1.05 + 0.02 + 2.0 * np.sqrt(2.0) * CHANCE
    assert unforeseen(Rung(fitted, leaving(more + hair).judging), 1.0) is (sign > 0.0)


def test_excess_is_in_units_of_the_noise():
    assert excess(leaving(1.3), 1.0) == pytest.approx(0.3)
    assert excess(leaving(1.3, unit=2.0), 2.0) == pytest.approx(0.3)
    assert excess(leaving(1.3), 0.0) == np.inf  # the noise is not known: any residual may be noise


@pytest.mark.parametrize("allowed", [0.0, 1e-3])
def test_one_standard_deviation_of_chance_is_exceeded_once_in_six(allowed):
    """Beyond the immaterial, and beyond a share of the signal, of which the power is 100 times that
    of noise."""
    for unit in (1.0, 3.0):
        left_over = leaving(1.02 + 100.0 * allowed + CHANCE, unit)
        found = by_chance(left_over, unit, allowed)
        assert found == pytest.approx(0.1587, abs=1e-4)


def test_a_lead_is_told_by_the_coefficient():
    """Of the runs fitted and held out together, per what is left of one of those fitted."""
    one, other = (
        Rung(leaving(p).judging, leaving(q).judging) for p, q in ((1.0, 1.0), (1.02, 1.06))
    )
    assert lead(one, other) == pytest.approx(0.04, rel=1e-6)
    assert lead(other, one) == pytest.approx(-0.04 / 1.02, rel=1e-6)


def test_errors_are_of_the_runs_held_out_if_there_are_any():
    """√ of what is left over the signal's power, 100 per coefficient; of fitted runs otherwise."""
    fitted, held_out = leaving(1.0).judging, leaving(4.0).judging
    both, alone = Rung(fitted, held_out), Rung(fitted, None)
    assert both.error == both.error_validate == both.error_judging == pytest.approx(0.2)
    assert both.error_fit == alone.error == alone.error_judging == pytest.approx(0.1)
    assert np.isnan(alone.error_validate)
