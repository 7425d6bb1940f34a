"""Where a judgement turns: chances, units, and numbers that nobody stated."""

from dataclasses import replace
from math import inf, log
from types import SimpleNamespace

import numpy as np
import pytest

from tests.diagnose.test_score import BLOCKS, RUNS, BesideEffects, fit_of, leaving, noise, rung
from wheelhop.diagnose.diagnosis import Step
from wheelhop.diagnose.score import (
    MATERIAL,
    Rung,
    by_chance,
    holds_against,
    lead,
    log_odds,
    material,
    nearly_all,
    p_value,
    relative_to_noise,
)

SIGNALS = noise(np.random.default_rng(21))


def times(factor, own=2):
    return rung([factor * signal for signal in SIGNALS], own)


@pytest.mark.parametrize(("chance", "held"), [(0.0501, False), (0.0499, True)])
def test_one_of_twenty_is_chance(chance, held):
    """All effects tried counted, of which there are 27."""
    base, rival = leaving(2.0), leaving(1.0)
    assert holds_against(base, rival, log(27.0 / chance), 27, 1.0) is held
    assert p_value(log(27.0 / chance), 27) == pytest.approx(chance)


@pytest.mark.parametrize(("drop", "held"), [(0.0199, False), (0.0201, True)])
def test_two_percent_of_the_noise_are_immaterial(drop, held):
    assert holds_against(leaving(1.0 + drop), leaving(1.0), 100.0, 27, 1.0) is held


def test_a_drop_of_exactly_what_is_immaterial_is_immaterial():
    base, rival = leaving(2.0), leaving(1.0)
    drop = relative_to_noise(base, rival, 1.0)
    wrong = replace(base, simulated_wrong=lambda: drop - MATERIAL)
    assert material(wrong) == drop
    assert not holds_against(wrong, rival, 100.0, 1, 1.0)


def test_a_small_gain_everywhere_counts_as_often_as_it_is_found():
    """A thousandth less in every half-second: as many thousandths, though none is much."""
    odds = log_odds(times(1.0), times(0.999))
    assert odds == pytest.approx(-BLOCKS * log(0.999), rel=1e-6)


def test_odds_have_no_unit_where_the_noise_is_not_stated():
    plain, small = (log_odds(times(size), times(0.5 * size)) for size in (1.0, 1e-3))
    assert plain == pytest.approx(small) == pytest.approx(0.5 * BLOCKS)


def test_where_the_noise_is_not_known_every_drop_is_material():
    base, rival = times(1.0), times(0.5)
    assert relative_to_noise(base, rival, 0.0) == inf
    beside = BesideEffects(base.fit, base.validation)
    assert holds_against(beside, rival, 100.0, 27, 0.0)
    assert not holds_against(beside, rival, 0.0, 27, 0.0)


def test_nearly_all_is_nearly_all_in_any_unit():
    for unit in (1.0, 0.05):
        base, good, poor = (leaving(power, unit) for power in (11.0, 1.5, 3.0))
        assert nearly_all(base, good, unit)
        assert not nearly_all(base, poor, unit)


def test_models_judged_on_other_runs_cannot_be_compared():
    fewer = rung(SIGNALS[: RUNS - 1])
    with pytest.raises(ValueError):
        log_odds(times(1.0), fewer)


def test_numbers_of_a_run_are_charged_for_in_its_error():
    """Half as many of them as data: what is left counts twice."""
    size = rung(SIGNALS).validation.runs[0].bench.size
    free, charged = times(1.0, 0), times(1.0, size // 2)
    for one in (free, charged):
        for run in one.validation.runs:
            run.bench.energy = 100.0
    assert charged.error / free.error == pytest.approx(np.sqrt(2.0))


def test_a_run_with_as_many_numbers_as_data_explains_nothing():
    """Its one datum left over is charged for all; nothing is divided by zero."""
    size = rung(SIGNALS).validation.runs[0].bench.size
    exhausted = times(1e-3, size)
    assert -inf < log_odds(times(0.9), exhausted, 1.0) < inf
    assert log_odds(times(1e-3), exhausted, 1.0) < 0.0


def test_a_lead_is_told_in_units_of_the_sensors_noise():
    """If that is more than what is left of the runs fitted."""
    one, other = (Rung(leaving(1.0).judging, leaving(power).judging) for power in (1.0, 1.5))
    for sigma, level in ((0.5, 1.0), (2.0, 4.0)):
        quiet = replace(one, fit=replace(one.fit, sigma=sigma))
        assert lead(quiet, other) == pytest.approx(0.25 / level)


def test_nothing_is_allowed_for_where_nothing_is_said():
    """A run's energy counts only as far as a share of it is allowed."""
    loud, quiet = leaving(1.05), leaving(1.05)
    for run in loud.judging.runs:
        run.bench.energy *= 1e6
    assert by_chance(loud, 1.0) == by_chance(quiet, 1.0) < 0.5
    assert by_chance(loud, 1.0, 1e-3) > 0.99


@pytest.mark.parametrize("lacked", [1.0, 0.3])
@pytest.mark.parametrize(("amplitude", "above"), [(0.09, False), (0.11, True), (0.33, True)])
def test_a_law_of_the_right_name_leaves_a_tenth_of_its_machine(amplitude, above, lacked):
    """Of the amplitude that the model lacked before; one of a wrong name leaves a third."""
    left = SimpleNamespace(unexplained=amplitude**2 * lacked, lacked=lacked)
    assert Step.above_floor.fget(left) is above


def test_a_model_without_runs_held_out_is_judged_on_those_fitted():
    fitted = leaving(1.0).judging
    assert Rung(fitted, None).judging is fitted
    assert Rung(fitted, None, None).evidence == fitted.evidence
    assert Rung(fit_of(()), fitted).judging is fitted
