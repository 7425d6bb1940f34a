"""The blind benchmark: honest strengths, honest scores, and the whole way on two campaigns."""

import json
from csv import DictReader
from dataclasses import replace
from math import inf, sqrt
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from benchmarks.blind import compare, without
from benchmarks.blind.__main__ import main
from benchmarks.blind.answers import read_answers, write_answers
from benchmarks.blind.intervals import held
from benchmarks.blind.outside import OUTSIDE
from benchmarks.blind.plan import EFFECTS, FIRST_SEED, ROUND, plan
from benchmarks.blind.recipes import RECIPES
from benchmarks.blind.score import MASS, Outcome, outcome
from benchmarks.blind.statistics import rates, reliability, wilson
from benchmarks.blind.strength import Unreachable, Wanted, seek
from benchmarks.blind.vehicles import Car
from tests.truth import PRESETS
from wheelhop.api import verbs


def answer(kind, hidden, verdict, confidence=0.9, ranking=(), error=1.0):
    return Outcome("x", kind, hidden, "atv", verdict, confidence, ranking, 3.0, error, 10.0)


@pytest.mark.parametrize(
    ("kind", "hidden", "verdict", "confidence", "passed"),
    [
        ("clear", ("backlash",), ("backlash",), 0.9, True),
        ("clear", ("backlash",), ("backlash", "unknown"), 0.9, True),
        ("clear", ("backlash",), ("dry-friction",), 0.9, False),
        ("weak", ("backlash",), ("none",), 0.9, False),
        ("weak", ("backlash",), (), 1.0, False),  # the program gave no answer
        ("faint", ("backlash",), ("backlash",), 0.6, True),
        ("faint", ("backlash",), ("none",), 0.5, False),
        ("none", (), ("none",), 0.9, True),
        ("none", (), ("backlash",), 0.1, False),
        ("none", (), ("unknown",), 0.9, False),
        ("outside", ("damper-fade",), ("unknown",), 0.9, True),
        ("outside", ("damper-fade",), ("dry-friction", "unknown"), 0.4, True),
        ("outside", ("damper-fade",), ("dry-friction", "unknown"), 0.6, False),
        ("without", ("backlash",), ("dry-friction",), 0.9, False),
        ("two", ("backlash", "bump-stop"), ("bump-stop", "backlash"), 0.9, True),
        ("two", ("backlash", "bump-stop"), ("bump-stop",), 0.9, False),
        ("two", ("backlash", "bump-stop"), ("bump-stop", "backlash", "sensor-gain"), 0.9, False),
        ("four", EFFECTS[:4], (*EFFECTS[:3], "unknown"), 0.9, True),
        ("four", EFFECTS[:4], EFFECTS[:2], 0.9, False),
        ("four", EFFECTS[:4], (*EFFECTS[:3], "sensor-gain"), 0.9, False),
    ],
)
def test_an_answer_is_counted_as_it_should_be(kind, hidden, verdict, confidence, passed):
    assert answer(kind, hidden, verdict, confidence).passed is passed


@pytest.mark.parametrize(
    ("kind", "verdict", "mass", "off"),
    [
        ("clear", ("backlash",), 206.0, 3.0),
        ("clear", ("backlash",), None, None),  # its table says no mass
        ("clear", ("backlash", "sensor-gain"), 206.0, None),
        ("mass-believed", ("backlash",), 206.0, None),  # what was believed of it is wrong
    ],
)
def test_a_mass_counts_where_all_is_named(kind, verdict, mass, off):
    """By how many of the deviations stated for it it is not the true one, 200 kg."""
    case = next(c for c in plan(FIRST_SEED["dev"], 1, EFFECTS) if c.kind == "clear")
    case = replace(case, kind=kind, hidden=("backlash",))
    told = {} if mass is None else {MASS: mass}
    last = {"error_validate": 0.01, "parameters": told, "uncertainties": dict.fromkeys(told, 2.0)}
    ended = {"status": 0, "seconds": 1.0, "complaint": ""}
    made = {"baseline_over_floor": 3.0, "oracle_rel_validate": 0.01}
    said = {"verdict": verdict, "confidence": 0.9, "ladder": [last]}
    found = outcome(case, made, ended, said, {"vehicle_true": {"body": {"mass_kg": 200.0}}})
    assert (found.mass_off if found.tells_mass else None) == off


def test_intervals_are_held_against_the_truth():
    """Of forces and stiffnesses of the vehicle and of effects that are there, at two deviations."""
    truth = {
        "vehicle_true": {
            "suspension": {"front": {"stiffness_N_m": 1000.0, "damping_N_s_m": 10.0}},
            "body": {"mass_kg": 200.0},
        },
        "effect": {
            "dry-friction": {"coulomb_front_N": 70.0, "presliding_N_m": 5e5},
            "bump-stop": {"stiffness_N_m": 2e4},
        },
    }
    said = {
        "suspension.front.stiffness_N_m": (1019.0, 10.0, True),
        "dry-friction.front_N": (59.0, 5.0, False),
        "bump-stop.stiffness_N_m": (2.1e4, 600.0, True),
        # These are no forces or stiffnesses, are not there, or are one form's own.
        "suspension.front.damping_N_s_m": (90.0, 1.0, None),
        "dry-friction.presliding_N_m": (1e3, 1.0, None),
        "backlash.stiffness_N_m": (1e3, 1.0, None),
        "body.mass_kg": (100.0, 1.0, None),
    }
    step = {
        "parameters": {name: value for name, (value, *_) in said.items()},
        "uncertainties": {name: sd for name, (_, sd, _) in said.items()},
    }
    for name, (_, _, inside) in said.items():
        alone = {key: {name: part[name]} for key, part in step.items()}
        assert held(alone, truth) == ((0, 0) if inside is None else (int(inside), 1)), name
    assert held(step, truth) == (2, 3)
    assert held({}, truth) == (0, 0)


def test_rates_and_their_intervals():
    assert wilson(5, 10) == pytest.approx((0.2366, 0.7634), abs=1e-4)
    assert wilson(0, 20) == pytest.approx((0.0, 0.1611), abs=1e-4)
    hidden, wrong = ("backlash",), ("dry-friction", "bump-stop", "sensor-gain", "backlash")
    outcomes = [answer("clear", hidden, hidden, ranking=hidden)] * 97
    outcomes += [answer("clear", hidden, ("dry-friction",), ranking=wrong)] * 3
    top_1, top_3, *_ = rates(outcomes)
    assert (top_1.rate, top_1.met, top_3.rate, top_3.met) == (0.97, True, 0.97, False)


def test_boasting_is_found_out():
    """99 % claimed and half of it right; 50 % claimed and half of it right."""
    hidden = ("backlash",)
    half = [hidden, ("dry-friction",)] * 20
    boasting = [answer("clear", hidden, verdict, 0.99) for verdict in half]
    modest = [answer("clear", hidden, verdict, 0.5) for verdict in half]
    low, high, middle = reliability([*boasting, *modest])
    assert low.met and low.within and (middle.of, middle.claimed) == (low.of, low.claimed)
    assert not high.met and not high.within


@given(
    power=st.floats(0.6, 3.0),
    visible=st.floats(0.05, 50.0),
    aim=st.floats(1.25, 10.0),
)
def test_the_amount_is_found_that_shows_as_much_as_wanted(power, visible, aim):
    """Where an effect's part of the residual grows with any power of its amount."""

    def measure(amount):
        return sqrt(1.0 + (visible * amount**power) ** 2)

    wanted, most = Wanted(aim, aim / 1.03, aim * 1.03), 1e3
    assume(measure(most) > aim)
    amount, ratio = seek(measure, wanted, 1.0, (1e-4, most))
    assert wanted.low <= ratio == measure(amount) <= wanted.high
    with pytest.raises(Unreachable):
        seek(lambda amount: 1.0 + 0.1 * amount / (1.0 + amount), Wanted(3.0, 2.0, 4.0), 1.0, (1, 9))


def test_no_tracks_are_made_that_no_wheel_follows():
    """However clear is wanted: on steeper ones the campaign is refused, or the simulation ends."""
    wanted = Wanted(4.0, 2.0, inf)
    amount, ratio = seek(lambda a: 1.0 + a if a < 1.7 else inf, wanted, 3.0, (0.1, 9.0))
    assert ratio == 1.0 + amount and amount < 1.7


def test_every_effect_of_the_library_is_asked_for():
    """On vehicles: rigs have `benchmarks/rigs.py`."""
    of_vehicles = {name for name, effect in verbs.load_effects().items() if effect.on_vehicle}
    assert set(RECIPES) == set(EFFECTS) == of_vehicles


def test_development_never_looks_at_published_seeds():
    every = [case for name in FIRST_SEED for case in plan(FIRST_SEED[name], 2, EFFECTS)]
    assert len({case.name for case in every}) == len(every)
    dev = {case.seed for case in plan(FIRST_SEED["dev"], 5, EFFECTS)}
    published = {case.seed for case in plan(FIRST_SEED["published"], 5, EFFECTS)}
    assert max(dev) < 2000 and min(published) >= 5000


@pytest.mark.parametrize("name", [*RECIPES, *OUTSIDE])
def test_every_recipe_makes_its_effect_at_any_amount(name):
    """From hardly any to the most; the shape depends on nothing but the random numbers."""
    vehicle = dict(PRESETS["passenger-car"].vehicle)
    corner = np.array([1.0, 1.0, 0.8, 0.8])
    car = Car(vehicle, 2000.0 * corner, 0.03 * corner, corner, 0.01, np.full(8, 20.0))
    for seed in range(20):
        hidden, again = (
            (RECIPES | OUTSIDE)[name](np.random.default_rng(seed), car) for _ in range(2)
        )
        for amount in (1e-3, 1.0, hidden.most):
            effect = hidden.at(amount)
            assert effect.id == name
            assert effect == again.at(amount)
        assert hidden.by_severity or hidden.at(1e-3) != hidden.at(hidden.most)


def test_an_effect_is_taken_out_of_the_library(monkeypatch):
    monkeypatch.setattr(without, "main", lambda argv: sorted(verbs.load_effects()))
    whole = set(verbs.load_effects())
    assert whole - set(without.ask_without("dry-friction", [])) == {"dry-friction"}


@pytest.mark.slow
def test_the_whole_way(tmp_path, capsys):
    """One campaign, rightly diagnosed; then a wrong answer is put in its place."""

    def blind(command):
        chosen = ["--short", "--work", str(tmp_path), "--effects", "sensor-gain"]
        assert main([command, *chosen, "--kinds", "clear"]) == 0
        return capsys.readouterr().out

    blind("generate")
    (campaign,) = (tmp_path / "short" / "campaigns").iterdir()
    assert not list(campaign.rglob("truth*"))
    (made,) = (tmp_path / "short" / "truth").glob("*.json")
    assert json.loads(made.read_text())["baseline_over_floor"] >= 2.0

    assert "[1/1]" in blind("run")
    assert blind("run") == ""  # nothing is done twice
    assert "said" not in blind("table").split("failures")[1]
    results = tmp_path / "short" / "results" / "latest"
    table = json.loads((results / "table.json").read_text())
    assert (table["rates"][0]["right"], table["rates"][0]["met"]) == (1, True)
    assert (results / "confusion.png").stat().st_size > 5000

    said = next(f for f in results.glob("*-clear-*.json") if not f.name.endswith("run.json"))
    said.write_text(json.dumps(json.loads(said.read_text()) | {"verdict": ["backlash"]}))
    assert "said backlash" in blind("table").split("failures")[1]
    table = json.loads((results / "table.json").read_text())
    assert (table["rates"][0]["right"], table["rates"][0]["met"]) == (0, False)


def test_answers_are_stored_and_counted_again(tmp_path):
    """An answer, a crash, and a campaign that could not be made."""
    told, crashed, unmade = cases = list(plan(FIRST_SEED["dev"], 1, EFFECTS))[:3]
    outcomes = [
        answer(told.kind, told.hidden, (*told.hidden, "unknown"), ranking=EFFECTS[:3]),
        replace(answer(crashed.kind, crashed.hidden, (), 1.0, error=inf), complaint="a, b\nc"),
    ]
    outcomes = [
        replace(o, name=case.name, preset=case.preset)
        for o, case in zip(outcomes, cases, strict=False)
    ]
    file = tmp_path / "answers.csv"
    write_answers(file, outcomes, [unmade.name])
    assert read_answers(file, cases) == ({o.name: o for o in outcomes}, {unmade.name})
    assert read_answers(file, [crashed]) == ({crashed.name: outcomes[1]}, set())


PUBLISHED = Path(__file__).parents[1] / "benchmarks" / "blind" / "published"


@pytest.mark.parametrize("table", [file.stem for file in sorted(PUBLISHED.glob("*.txt"))])
def test_the_published_answers_give_the_published_table(table, tmp_path, capsys):
    """Every table can be counted again from its answers."""
    text, answers = (PUBLISHED / f"{table}.txt").read_text(), PUBLISHED / f"{table}.csv"
    names = [row["name"] for row in DictReader(answers.read_text().splitlines())]
    seeds = [int(name.split("-")[0]) - FIRST_SEED["published"] for name in names]
    first, last = min(seeds) // ROUND, max(seeds) // ROUND
    asked = ["--seeds", "published", "--first-round", str(first), "--rounds", str(last - first + 1)]
    asked += ["--short"] if " 8 runs" in text.partition("\n")[0] else []
    assert main(["table", *asked, "--answers", str(answers), "--work", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith(text)


def test_two_versions_are_compared_verdict_by_verdict():
    hidden = ("backlash",)
    before = [answer("clear", hidden, hidden), answer("clear", hidden, hidden, error=2.0)]
    after = [answer("clear", hidden, hidden), answer("clear", hidden, ("unknown",), 0.4)]
    pairs = list(zip(before, after, strict=True))
    told = compare.text(pairs)
    assert compare.differing(pairs) == pairs[1:] and compare.differing(pairs[:1]) == []
    assert "x: backlash (0.90) -> unknown (0.40)  WORSE" in told
    assert "2 campaigns asked of both: 1 verdicts the same" in told
    assert "right: 2 before, 1 after" in told
    assert f"error / floor, geometric mean, after / before: {sqrt(0.5):.3f}" in told


def test_campaigns_of_everything_have_seeds_of_their_own():
    cases = [c for c in plan(FIRST_SEED["dev"], 6, EFFECTS) if c.kind == "everything"]
    others = [c for c in plan(FIRST_SEED["dev"], 6, EFFECTS) if c.kind != "everything"]
    assert len(cases) == 60 and not {c.seed for c in cases} & {c.seed for c in others}
    assert 5 <= sum(not c.hidden for c in cases) <= 20
    assert {c.preset for c in cases} == set(PRESETS)
