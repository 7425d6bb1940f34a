"""Confidence: what it may claim, by what the verdict stands on."""

import csv
from dataclasses import replace
from math import inf, log
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.diagnose.test_score import noise, rung
from wheelhop.diagnose import posterior
from wheelhop.diagnose.diagnosis import Grounds, Step
from wheelhop.diagnose.posterior import CEILING, confidence
from wheelhop.diagnose.posterior import grounds as grounds_of
from wheelhop.diagnose.search.scored import Stand
from wheelhop.effects import load_effects

VERDICTS = (
    ("none",),
    ("unknown",),
    ("backlash",),
    ("backlash", "sensor-gain"),
    ("backlash", "unknown"),
    ("backlash", "sensor-gain", "unknown"),
)
over = st.floats(1.0, 50.0)
grounds = st.builds(
    Grounds,
    log_odds=st.floats(-50.0, 1e4),
    lead=st.one_of(st.floats(-1.0, 10.0), st.just(inf)),
    stability=st.floats(-1.0, 1.0),
    p_value=st.floats(0.0, 1.0),
    over_floor=over,
    baseline_over_floor=over,
    by_chance=st.floats(0.0, 1.0),
    unseen=st.floats(0.0, 1.0),
    cramped=st.booleans(),
)
CLEAR = Grounds(
    log_odds=1e4,
    lead=1.0,
    stability=0.9,
    p_value=0.0,
    over_floor=1.0,
    baseline_over_floor=3.0,
    by_chance=1.0,
)


@given(verdict=st.sampled_from(VERDICTS), grounds=grounds)
def test_no_verdict_is_impossible_or_certain(verdict, grounds):
    assert 0.0 <= confidence(verdict, grounds) <= CEILING < 1.0


@given(grounds=grounds)
def test_an_effect_that_would_have_to_be_more_than_it_can_be_is_as_likely_another(grounds):
    free = confidence(("backlash", "unknown"), replace(grounds, cramped=False))
    held = confidence(("backlash", "unknown"), replace(grounds, cramped=True))
    assert held == pytest.approx(0.5 * free)


PUBLISHED = Path(__file__).parents[2] / "benchmarks" / "blind" / "published"


def published():
    """Of every published answer that named an effect and "unknown" beside it: what it stands on,
    and whether the effect was hidden."""
    library = load_effects()
    for file in sorted(PUBLISHED.glob("*.csv")):
        for row in csv.DictReader(file.open(newline="")):
            first, *others = row["verdict"].split("+")
            if row["asked"] == "yes" and "unknown" in others and not first.startswith("belief"):
                before, after = (float(row[f"{b}_over_floor"]) for b in ("baseline", "error"))
                left = {"baseline_over_floor": before, "over_floor": max(after, 1.001)}
                is_law = first in library and library[first].on_rig
                yield replace(CLEAR, **left, is_law=is_law), first in row["name"]


def likelihood(answers):
    """Logarithm of how likely what was right and wrong is by what was said of it."""
    said = [min(max(confidence(("backlash", "unknown"), on), 0.01), 0.99) for on, _ in answers]
    return sum(
        log(sure if right else 1.0 - sure) for sure, (_, right) in zip(said, answers, strict=True)
    )


@pytest.mark.parametrize("odds", [0.5, 2.0])
def test_what_leaves_a_part_is_right_as_often_as_is_said(monkeypatch, odds):
    """The odds beforehand make the published answers likelier than half and twice these do."""
    answers = list(published())
    assert len(answers) > 50
    found = likelihood(answers)
    monkeypatch.setattr(posterior, "ODDS_RIGHT", odds * posterior.ODDS_RIGHT)
    assert found > likelihood(answers)


def test_laws_of_the_struts_leave_more_under_their_right_names():
    """Published answers that named laws are likelier if right ones leave a tenth of the amplitude
    and more than if they leave 0.3 % and more; the others are less likely so."""
    answers = list(published())
    for is_law in (True, False):
        alike = [(on, right) for on, right in answers if on.is_law is is_law]
        other = [(replace(on, is_law=not is_law), right) for on, right in alike]
        assert len(alike) > 25
        assert likelihood(alike) > likelihood(other)


def test_what_explains_nearly_all_is_hardly_a_stand_in():
    """A circuit with a cubic spring leaves 0.2 % of the power beyond the baseline's floor."""
    circuit = replace(CLEAR, over_floor=3.75, baseline_over_floor=83.9)
    assert confidence(("progressive-spring", "unknown"), circuit) > 0.95


@given(grounds=grounds, less=st.floats(0.0, 1.0))
def test_where_something_is_left_one_run_alone_does_not_convince(grounds, less):
    verdict = ("backlash", "unknown")
    shakier = replace(grounds, stability=grounds.stability - less)
    assert confidence(verdict, shakier) <= confidence(verdict, grounds)
    assert confidence(verdict, replace(grounds, stability=0.0)) == 0.0
    # At the floor nothing is left that another run could have meant.
    assert confidence(("backlash",), shakier) == confidence(("backlash",), grounds)


@given(grounds=grounds, more=st.floats(0.0, 10.0))
def test_the_more_is_left_the_less_is_claimed(grounds, more):
    left = replace(grounds, over_floor=grounds.over_floor + more)
    for verdict in VERDICTS[4:]:
        assert confidence(verdict, left) <= confidence(verdict, grounds)
    assert confidence(("unknown",), left) >= confidence(("unknown",), grounds)


@pytest.mark.parametrize("sd", [0.05, 0.15])
def test_an_estimated_noise_is_believed_to_be_log_normal(sd):
    """It is e^sd times as much with a chance of one in six, whatever 10⁶ data leave to chance."""
    judged = SimpleNamespace(error_judging=0.3, judging=SimpleNamespace(size=10**6))
    for times, chance in ((1.0, 0.5), (np.exp(sd), 0.1587), (np.exp(-2.0 * sd), 0.9772)):
        step = SimpleNamespace(
            rung=judged,
            expected=0.3 / times,
            allowed=0.0,
            comparison=SimpleNamespace(floor=SimpleNamespace(uncertainty=sd)),
        )
        assert posterior._by_chance(step) == pytest.approx(chance, abs=1e-3)
    allowed = SimpleNamespace(rung=judged, expected=0.3, allowed=0.1)
    assert posterior._by_chance(allowed) == 1.0


@given(grounds=grounds, missing=st.floats(0.0, 1.0))
def test_where_noise_is_uncertain_both_readings_count_as_likely_as_they_are(grounds, missing):
    alone, beside = (confidence(v, grounds) for v in (("backlash",), ("backlash", "unknown")))
    found = confidence(("backlash",), grounds, missing)
    assert found == pytest.approx((1.0 - missing) * alone + missing * beside)


def test_what_no_law_leaves_less_than_tells_nothing_of_a_name():
    """A name that leaves as little as a free law is as good as one at the floor; one that leaves
    more is no better for it than the power that a law explains says."""
    left = replace(CLEAR, over_floor=10.0, baseline_over_floor=40.0)
    beside = ("backlash", "unknown")
    assert confidence(beside, left, of_laws=10.0) == CEILING
    found = confidence(beside, left, of_laws=8.0)
    plain = replace(CLEAR, over_floor=np.sqrt(1.0 + (100.0 - 64.0) / (1600.0 - 64.0) * 1599.0))
    plain = replace(plain, baseline_over_floor=40.0)
    assert found == pytest.approx(confidence(beside, plain), rel=1e-9)


def test_plain_cases():
    assert confidence(("backlash",), CLEAR) == CEILING
    assert confidence(("backlash",), replace(CLEAR, lead=0.0)) == CEILING / 2.0  # two alike
    assert confidence(("backlash",), replace(CLEAR, lead=-0.02)) < 0.01  # the rival leaves less
    assert confidence(("unknown",), replace(CLEAR, over_floor=3.0)) > 0.98
    assert confidence(("unknown",), replace(CLEAR, over_floor=1.1)) < 0.5
    assert confidence(("none",), replace(CLEAR, p_value=1.0)) == CEILING
    assert confidence(("none",), replace(CLEAR, p_value=0.0)) == CEILING / 2.0
    assert confidence(("none",), replace(CLEAR, p_value=1.0, by_chance=0.0)) == 0.0
    assert confidence(("none",), replace(CLEAR, p_value=1.0, unseen=0.5)) == CEILING / 2.0


def test_a_rival_that_is_worse_than_nothing_is_no_measure():
    """An effect that explains five runs and a rival that spoils one of them by far: what speaks for
    the effect is what it does for all runs, not that the rival fails in one."""
    rng = np.random.default_rng(1)
    final, base = rung(noise(rng)), rung(noise(rng, 4.0))
    spoilt = rung([s * (100.0 if i == 0 else 1.0) for i, s in enumerate(noise(rng, 4.0))])
    final, base, spoilt = (replace(r, fit=r.validation) for r in (final, base, spoilt))
    floor = SimpleNamespace(is_stated=True, tolerance=0.05)
    last = SimpleNamespace(
        rung=final,
        over_floor=1.5,
        floor=0.05,
        expected=0.05,
        allowed=0.0,
        comparison=SimpleNamespace(floor=floor),
    )
    last_look = SimpleNamespace(candidates=())
    steps = [SimpleNamespace(over_floor=4.0), last]
    stand = Stand(final, base, [spoilt], last_look, final)
    found = grounds_of(("a", "unknown"), steps, last_look, stand, 2, 1.0)
    assert found.stability > 0.8


def test_a_law_of_the_right_name_may_leave_what_machines_differ_by():
    """Beside 5 % noise, of 50 % that the baseline lacked: a real circuit's spring left 4.5 % of
    that, a foam stop 10 %, which is the limit; a measured damper 15 %, and no wrong name less than
    31 %. Without noise to speak of models are exact to 0.3 % of the signal."""

    def left(share, lacked=0.25, floor=0.05, noise=0.05):
        comparison = SimpleNamespace(
            floor=SimpleNamespace(expected_fit=noise, tolerance=0.05, scales=0.0)
        )
        error = (floor**2 + share**2 * lacked) ** 0.5
        fitted = SimpleNamespace(validation=None, error_judging=error)
        return Step(("bump-stop",), fitted, {}, comparison, lacked)

    assert [left(share).above_floor for share in (0.0, 0.045, 0.08)] == [False] * 3
    assert [left(share).above_floor for share in (0.15, 0.31, 1.0)] == [True] * 3
    bare = [left(share, 1.0, 0.0, 1e-6) for share in (0.002, 0.005)]
    assert [step.unexplained > 0.0 for step in bare] == [False, True]


@given(grounds=grounds, times=st.floats(1.0, 10.0))
def test_what_a_right_model_may_leave_speaks_against_none(grounds, times):
    """Where measured axles let a right model leave so many times the floor, the same error over
    the floor is worth as much less."""
    more = replace(
        grounds,
        over_floor=times * grounds.over_floor,
        baseline_over_floor=times * grounds.baseline_over_floor,
        expected_over_floor=times,
    )
    for verdict in VERDICTS:
        assert confidence(verdict, more) == pytest.approx(confidence(verdict, grounds), abs=1e-9)
