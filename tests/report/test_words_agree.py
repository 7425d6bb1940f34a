"""Headline, grounds and JSON of any diagnosis say the same: no sentence against its figures."""

import re
from types import SimpleNamespace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.compare import describe
from wheelhop.compare.breakdown import Breakdown, Grid, slices
from wheelhop.compare.floor import Floor
from wheelhop.compare.locking import Line, Locking
from wheelhop.diagnose.diagnosis import Diagnosis, Grounds, Step
from wheelhop.diagnose.verdict.critic import _rivals
from wheelhop.diagnose.verdict.ranking import explanation
from wheelhop.effects import load_effects
from wheelhop.report.words import chain_words, fails, headline

LIBRARY = load_effects()
IDEA = LIBRARY["speed-fluctuation"]
shares = st.floats(0.0, 1.0)
powers = st.floats(0.01, 100.0)


@st.composite
def floors(draw):
    """Of one role: noise, what is folded into measured axles, uncertain scales."""
    noise, folded, scales = draw(st.floats(1e-3, 0.1)), draw(shares) / 10, draw(shares) / 10
    kind = draw(st.sampled_from(["plain", "folded", "scales"]))
    folded, scales = folded * (kind == "folded"), scales * (kind == "scales")
    expected = float(np.sqrt(noise**2 + folded**2 + scales**2))
    return Floor(
        *[noise] * 3,
        *[expected] * 3,
        source="noise_rms_m_s2",
        noise_rms=np.array([0.1]),
        noise_key="noise_rms_m_s2",
        unit="m/s²",
        scales=scales,
    )


@st.composite
def breakdowns(draw):
    """Two runs, two channels, three bands; any residual, noise and locking."""
    rows, columns = ("4", "5", "6.3"), ("B1", "B2")
    grid = [np.array(draw(st.lists(powers, min_size=6, max_size=6))) for _ in range(3)]
    residual, noise, folded = (a.reshape(3, 2) for a in grid)
    folded = folded * draw(st.booleans())
    sums = residual, 100.0 * residual, noise, folded
    whole = tuple(a.sum(axis=0, keepdims=True) for a in sums)
    runs = Grid(("a", "b"), columns, *(np.vstack([a, a]) / 2.0 for a in whole))
    left = residual.sum()
    road = draw(shares)
    time = (1.0 - road) * draw(shares) * draw(st.booleans())
    lowest = draw(st.floats(2.0, 20.0))
    highest = lowest + draw(st.sampled_from([0.0, 0.7]))
    lines = (Line(lowest, time, ("a", "b"), lowest, highest),) if time > 0.0 else ()
    totals = [np.array([a.sum()]) for a in sums]
    return Breakdown(
        total=slices(("total",), *totals)[0],
        count=6000,
        tolerance=0.05,
        points=columns,
        runs_channels=runs,
        bands_channels=Grid(rows, columns, *sums),
        bands_motions=Grid(rows, (), *(np.zeros((3, 0)) for _ in sums)),
        time=slices(["0-100 %"], *totals),
        amplitude=slices(["all"], *totals),
        growth=float("nan"),
        locking=Locking(road, time, 1.0 - road - time, float(noise.sum() / left), lines),
    )


@st.composite
def steps(draw):
    floor, error = draw(floors()), draw(st.floats(5e-4, 1.0))
    rung = SimpleNamespace(
        validation=None,
        update=None,
        error=error,
        error_fit=error,
        error_judging=error,
        model=SimpleNamespace(effects=()),
        fit=SimpleNamespace(error=error),
    )
    return Step((), rung, {}, SimpleNamespace(floor=floor, breakdown=draw(breakdowns())))


@st.composite
def looks(draw, step):
    """What one effect would take to first order, and what came of it in full, if it was tried."""
    share = draw(shares)
    screened = SimpleNamespace(
        score=1.0,
        error=float(step.rung.error * np.sqrt(1.0 - share)),
        variant=SimpleNamespace(effect=IDEA),
    )
    tried = SimpleNamespace(id=IDEA.id, holds=False, p=draw(shares), effect=IDEA, rung=step.rung)
    candidates = draw(st.sampled_from([(), (tried,)]))
    return SimpleNamespace(rung=step.rung, screened=(screened,), candidates=candidates), share


@given(data=st.data(), step=steps())
def test_the_verdict_says_one_thing(data, step):
    look, share = data.draw(looks(step))
    if any(c.p < 0.05 for c in look.candidates):
        return  # whose numbers are then held against it, run by run
    verdict = ("unknown",) if step.above_floor else ("none",)
    grounds = Grounds(np.inf, np.inf, 1.0, 1.0, step.over_floor, step.over_floor, data.draw(shares))
    lines = explanation(verdict, [step], look, look, grounds, [], [])
    found = Diagnosis(verdict, 0.5, grounds, (), (step,), None, lines)
    said = " ".join([headline(found), *lines])
    assert step.floor <= step.expected
    if verdict == ("unknown",):
        assert "Nothing is missing" not in said and "down to" not in said
        # What may take most of it is named with what came of it, never beside "explains nothing".
        assert not re.search("no effect .* explains", said)
        if share > 0.5:
            assert f"{100 * share:.0f} %, " in said
            came = "in full" if look.candidates else "not simulated in full"
            assert f"{IDEA.title}; {100 * share:.0f} %, {came}" in said
        assert "held-out" not in said  # there are none
    elif "down to the sensors’ noise." in headline(found):
        floor = step.comparison.floor
        assert not floor.beside_noise or step.over_floor <= 1.0 + 2.0 * floor.tolerance
    elif "Nothing is missing" in said:
        # More than noise is left, and both sentences say what else may leave it.
        assert said.count(step.comparison.floor.beside_noise) >= 2


@given(where=breakdowns())
def test_a_breakdown_says_one_thing(where):
    said = " ".join(describe(where))
    excess = where.total.excess / where.total.residual
    locking = where.locking
    if "locked to the road" in said and "partly" not in said:
        assert locking.road >= 0.7 * excess
    if "locked to time" in said:
        assert "neither" not in said and locking.time >= 0.35 * excess
    if "mainly locked neither" in said:
        assert max(locking.road, locking.time) < 0.35 * excess
    for line in locking.lines:
        if "stands out" in said:
            assert f"{line.lowest_hz:.2f}" in said and f"{line.highest_hz:.2f}" in said
            assert ("wanders" in said) == line.wanders
    if "no more than expected" in said:
        assert where.total.residual <= 1.5 * where.total.expected(where.tolerance)
    if "is folded" in said:
        assert where.total.folded > 0.0


@given(road=steps(), axles=steps())
def test_what_two_comparisons_say_is_what_they_show(road, axles):
    said = chain_words(road, axles)
    if "nothing fails" in said:
        assert not fails(road) and not fails(axles)
    if "upstream" in said:
        assert fails(road) and not fails(axles)
    if "something fails above" in said:
        assert fails(road) and fails(axles)


@given(own=st.floats(1e-3, 0.1), other=st.floats(1e-3, 0.1), least=st.floats(1e-3, 0.1))
def test_rivals_are_about_the_same_and_said_to_be_no_more(own, other, least):
    def ranked(name, error):
        return SimpleNamespace(effect=name, confirmed_error=error, validated_error=error)

    found = list(_rivals([ranked("a", own), ranked("b", other)], ["a"], least, least))
    for finding in found:
        if "beyond" in finding.text:
            assert own > least and other**2 - own**2 <= own**2 - least**2
        else:
            assert max(own, other) <= least and "within" in finding.text
