"""Tuning: against rides of its own settings, closed forms, and cars without room for gain."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from tests.tune.cars import ROAD, SHORT_S, VEHICLE, car, tuned
from wheelhop.campaign import CampaignError
from wheelhop.effects import load_effects
from wheelhop.predict import Case, read_effects
from wheelhop.predict.ride import Rider, ride
from wheelhop.report.tune_words import sentences, to_json
from wheelhop.tune.damper_curve import read_clicks
from wheelhop.tune.search import Tried, compromise, spread_out
from wheelhop.tune.variables import read_freedom

FRONT, REAR = (f"suspension.{end}.damping_N_s_m" for end in ("front", "rear"))


RUN_UP = 6e-3
"""What is left of the start, where runs run up for different times: 1.5 s or more."""


def single(changes, effects=(), drives=ROAD):
    """A ride by itself."""
    chosen = read_effects(effects, load_effects())
    return ride(Case(VEHICLE.with_values(changes), chosen, drives, SHORT_S), 0)


@pytest.mark.parametrize("effects", [(), ("dry-friction", "tyre-lift-off")], ids=str)
def test_rides_side_by_side_are_those_one_after_the_other(effects):
    settings = [{FRONT: c, "body.mass_kg": 200.0 + c / 100} for c in (300.0, 600.0, 900.0)]
    case = Case(VEHICLE, read_effects(effects, load_effects()), ROAD, SHORT_S)
    # The scale of an effect that is not stated follows the vehicle: it is kept.
    kept = [
        f"{e.effect.id}:"
        + ":".join(f"{k}={float(v)!r}" for k, v in case.nominal.theta(e.effect).items())
        for e in case.effects
    ]
    for setting, found in zip(settings, Rider(case, 0).rides(settings), strict=True):
        alone = single(setting, kept)
        assert vars(found) == pytest.approx(vars(alone), rel=RUN_UP)


def test_a_vehicle_that_does_not_stand_is_ridden_by_nobody():
    case = Case(VEHICLE, (), ROAD, SHORT_S)
    fine, falls = Rider(case, 0).rides([{}, {"suspension.front.stiffness_N_m": -1e6}])
    assert fine is not None and falls is None


def test_roll_of_the_body_is_that_of_its_rolling_ground():
    """On a ground that only twists slowly the body follows the mean slope of front and rear."""
    assert single({}).roll_rms_rad > 0.0
    case = Case(VEHICLE, (), ROAD, SHORT_S)
    motion = case.motion(0)
    roll = motion.displacement[motion.recorded, case.system.coordinates.index("roll")]
    assert single({}).roll_rms_rad == pytest.approx(float(np.sqrt(np.mean(roll**2))), rel=RUN_UP)


def test_the_best_damping_is_the_best_on_a_fine_grid():
    found = tuned(car(), ["front.damping=-80%:+300%", "rear.damping=-80%:+300%"], settings=320)
    grid = np.geomspace(0.2, 4.0, 8)
    rides = Rider(Case(VEHICLE, (), ROAD, SHORT_S), 0, 6.0).rides(
        [{FRONT: a * VEHICLE[FRONT], REAR: b * VEHICLE[REAR]} for a in grid for b in grid]
    )
    least = min(one.comfort_wk_rms_m_s2 for one in rides)
    (score,) = found.front[0].scores
    assert found.proposed and score <= 1.005 * least
    told = found.proposed.values
    again = single({FRONT: told["front.damping"], REAR: told["rear.damping"]})
    assert score == pytest.approx(again.comfort_wk_rms_m_s2, rel=RUN_UP)


def test_of_the_best_car_it_says_that_there_is_no_room():
    best = tuned(car(), ["front.damping=-90%:+300%"], settings=80).front[0].values["front.damping"]
    known = car(relative=0.05)
    known = replace(known, vehicle=VEHICLE.with_values({FRONT: best}))
    found = tuned(known, ["front.damping=±30%"])
    assert found.proposed is None
    assert sentences(found)[0].startswith("There is no room for gain")
    assert to_json(found)["room_for_gain"] is False


def test_what_friction_costs_is_what_the_car_without_it_gains():
    words = ["dry-friction:front_N=80:rear_N=60"]
    found = tuned(car(words), ["front.damping=±20%"])
    (cost,) = found.costs
    now = single({}, words).comfort_wk_rms_m_s2
    without = single({}, ["dry-friction:front_N=0:rear_N=0"]).comfort_wk_rms_m_s2
    half = single({}, ["dry-friction:front_N=40:rear_N=30"]).comfort_wk_rms_m_s2
    assert cost.whole[0] == pytest.approx(now - without, abs=RUN_UP * now)
    assert cost.half[0] == pytest.approx(now - half, abs=RUN_UP * now)
    (line,) = [s for s in sentences(found) if "dry-friction" in s]
    more = cost.half[0] > found.dampers[0]
    assert ("more than any setting" in line) == more


@pytest.mark.parametrize("relative", [0.0, 0.1])
def test_intervals_are_what_is_not_known_of_the_car(relative):
    """Nothing unknown, no interval; else it holds the gains of most cars drawn anew."""
    known = car(relative=relative)
    found = tuned(known, ["front.damping=±50%"])
    setting, (gain,) = found.front[0].values, found.front[0].gains
    if relative == 0.0:
        assert gain.half == pytest.approx(0.0, abs=1e-12)
        return
    rider = Rider(Case(VEHICLE, (), ROAD, SHORT_S), 0)
    more, held = setting["front.damping"] - VEHICLE[FRONT], 0
    cars = known.draws(60, np.random.default_rng(99))
    before = rider.rides(cars)
    after = rider.rides([known.bounded({**c, FRONT: c[FRONT] + more}) for c in cars])
    gains = [
        b.comfort_wk_rms_m_s2 - a.comfort_wk_rms_m_s2 for b, a in zip(before, after, strict=True)
    ]
    held = np.mean(np.abs(np.array(gains) - gain.value) <= gain.half)
    assert held >= 0.88
    assert gain.half < 4 * np.std(gains), "no wider than it has to be"


def test_a_model_that_is_wrong_makes_intervals_wider():
    right, wrong = (tuned(car(misfit=e), ["front.damping=±50%"]) for e in (0.0, 0.02))
    half = wrong.front[0].gains[0].half
    wide = stats.t.ppf(0.975, 24 - 1)
    assert right.front[0].gains[0].half == pytest.approx(0.0, abs=1e-12)
    assert half == pytest.approx(wide * 0.02 * wrong.now.scores[0])


SCORES = st.lists(st.tuples(*3 * [st.integers(0, 6)]), min_size=1, max_size=30)


@given(SCORES)
def test_the_front_is_what_nothing_dominates(rows):
    scores = np.array(rows, float)
    front = Tried(np.zeros((len(rows), 1)), scores).front
    for i in range(len(scores)):
        better = [(s <= scores[i]).all() and (s < scores[i]).any() for s in scores]
        if i in front:
            assert not any(better)
        else:
            assert any((scores[j] <= scores[i]).all() for j in front)
    assert len({tuple(scores[i]) for i in front}) == len(front)


@given(SCORES, st.integers(1, 12))
def test_settings_spread_out_hold_the_best_of_each_objective(rows, count):
    scores = np.array(rows, float)
    first = compromise(scores, np.ones(3))
    taken = spread_out(scores, [first], count)
    assert taken[0] == first and len(set(taken)) == len(taken)
    assert set(np.argmin(scores, axis=0)) <= set(taken)
    assert len(taken) <= max(count, 4)


CLICKS = "click,velocity_m_s,force_N\n" + "".join(
    f"{click},{v},{100 * click * v}\n" for click in (1, 2, 4) for v in (-1.0, -0.2, 0.0, 0.3, 1.0)
)


def test_a_click_is_the_damping_of_its_curve(tmp_path):
    """Straight curves: two more clicks are 200 N s/m more, seen through the linkage squared."""
    file = tmp_path / "valves.csv"
    file.write_text(CLICKS)
    known = car()
    found = tuned(known, [f"front.damper={file}:now=2:ratio=0.7"])
    assert set(one.values["front.damper"] for one in found.front) <= {1.0, 2.0, 4.0}
    chosen = found.front[0]
    more = 100.0 * (chosen.values["front.damper"] - 2.0) * 0.7**2
    linear = single({FRONT: VEHICLE[FRONT] + more})
    assert chosen.scores[0] == pytest.approx(linear.comfort_wk_rms_m_s2, rel=RUN_UP)
    assert found.now.scores[0] == pytest.approx(single({}).comfort_wk_rms_m_s2, rel=RUN_UP)


def test_springs_are_chosen_from_the_list(tmp_path):
    file = tmp_path / "springs.csv"
    file.write_text("stiffness_N_mm\n10\n20\n40\n")
    found = tuned(car(), [f"rear.springs={file}:ratio=0.5"])
    assert found.variables[0].choices == (2500.0, 5000.0, 10000.0)
    assert {one.values["rear.springs"] for one in found.front} <= {2500.0, 5000.0, 10000.0}


def test_a_car_outside_of_the_bounds_is_compared_as_it_is(tmp_path):
    """Present springs that nobody sells: each variable alone leaves them where they are."""
    file = tmp_path / "springs.csv"
    file.write_text("stiffness_N_mm\n20\n40\n")
    found = tuned(car(), [f"front.springs={file}", "rear.damping=±50%"])
    assert found.now.scores[0] == pytest.approx(single({}).comfort_wk_rms_m_s2, rel=RUN_UP)
    places = np.linspace(0.5, 1.5, 7) * VEHICLE[REAR]
    best = min(single({REAR: place}).comfort_wk_rms_m_s2 for place in places)
    gain = found.now.scores[0] - best
    assert found.alone[1, 0] == pytest.approx(gain, abs=RUN_UP * found.now.scores[0])
    assert all(one.values["front.springs"] in (2e4, 4e4) for one in found.front)


WRONG = {
    "front.dampng=±50%": "did you mean",
    "front.damping": "write NAME",
    "front.damping=50": "write NAME",
    "front.damping=±0%": "write NAME",
    "front.damping=-200%:+50%": "damping_N_s_m",
    "front.damping=a:b": "write NAME",
    "front.damper=no.csv": "now=8",
    "front.damper=no.csv:now=1": "no.csv",
    "front.damper=no.csv:now=1:rato=2": "rato",
    "front.springs=no.csv:ratio=5": "ratio",
    "dry-friction.front_N=10:20": "has no dry-friction",
}


@pytest.mark.parametrize("word", WRONG)
def test_what_cannot_be_varied_is_one_line(word, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(CampaignError, match=WRONG[word]) as told:
        read_freedom([word], car())
    assert "\n" not in str(told.value)


def test_nothing_is_varied_twice_and_nothing_beyond_its_bounds():
    with pytest.raises(CampaignError, match="twice"):
        read_freedom(["front.damping=±5%", f"{FRONT}=±9%"], car())
    with pytest.raises(CampaignError, match="outside"):
        read_freedom(["front.friction=-5:10"], car(["dry-friction:front_N=5"]))


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        ("click,velocity_m_s,force_N\n1,0,0\n1,1,5\n2,0,0\n2,0,9\n", "click 2"),
        ("click,velocity_m_s,force_N\n1,0,0\n1,1,5\n2,0,0\n2,1,9\n", "none of 1, 2"),
        ("click,velocity,force_N\n1,0,0\n1,1,5\n2,0,0\n2,1,9\n", "velocity"),
    ],
)
def test_a_table_of_clicks_that_is_wrong_is_one_line(rows, says, tmp_path):
    file = tmp_path / "valves.csv"
    file.write_text(rows)
    with pytest.raises(CampaignError, match=says):
        read_clicks(file, 7.0, 1.0)
