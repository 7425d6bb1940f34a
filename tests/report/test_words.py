"""Numbers as people read them."""

from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.diagnose.next_run import NextRun
from wheelhop.effects import form_of, load_effects
from wheelhop.files.words import chance, interval, label_of, percent, signed, significant, unit_of
from wheelhop.report.words import in_numbers, next_run_words


def number(text: str) -> float:
    return float(text.replace("\u202f", "").replace("−", "-"))


@pytest.mark.parametrize(
    ("value", "deviation", "text"),
    [
        (73.073, 0.07, "73.07 ± 0.14"),
        (10480.0, 160.0, "10\u202f480 ± 320"),
        (8425.0, 6299.0, "8\u202f000 ± 13\u202f000"),
        (-0.0001, 0.05, "0.00 ± 0.10"),
        (1.419994, 1.15e-5, "1.419994 ± 0.000023"),
        (0.0417, float("nan"), "0.0417"),
    ],
)
def test_an_interval_shows_two_digits_of_its_width(value, deviation, text):
    assert interval(value, deviation) == text


@given(st.floats(1e-4, 1e8), st.integers(2, 6))
def test_significant_digits_hold_the_number(value, digits):
    assert number(significant(value, digits)) == pytest.approx(value, rel=0.51 * 10 ** (1 - digits))


@given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e5))
def test_an_interval_is_never_off_by_more_than_a_fraction_of_its_width(value, deviation):
    centre, half = map(number, interval(value, deviation).split(" ± "))
    assert abs(centre - value) <= 0.1 * 2 * deviation + 1e-9
    assert half == pytest.approx(2 * deviation, rel=0.06)


def test_what_is_not_known_is_a_dash():
    assert percent(float("nan")) == significant(float("inf")) == "–"
    assert percent(0.00551) == "0.551 %"
    assert signed(132447.2) == "+132\u202f447" and signed(-2.4) == "−2"
    assert chance(1e-11) == "< 10⁻⁶" and chance(0.0312) == "0.03"


@pytest.mark.parametrize(
    ("name", "label", "unit"),
    [
        ("suspension.front.stiffness_N_m", "front suspension stiffness", "N/m"),
        ("wheel.rear.tyre_damping_N_s_m", "rear tyre damping", "N s/m"),
        ("wheel.rear.radius_m", "rear wheel radius", "m"),
        ("body.pitch_inertia_kg_m2", "body pitch inertia", "kg m²"),
        ("geometry.cg_to_front_axle_m", "cg to front axle", "m"),
        ("channel.imu.x_m", "channel imu x", "m"),
    ],
)
def test_names_of_the_vehicle_become_words_and_units(name, label, unit):
    assert (label_of(name), unit_of(name)) == (label, unit)


def test_the_form_of_an_effect_is_told(friction):
    channels, library = friction.campaign.channels, load_effects()
    for effect in library.values():
        for choice in effect.choices(channels):
            chosen = effect.with_choice(choice) if choice else effect
            assert form_of(chosen, channels) == choice


@pytest.mark.parametrize(("log_odds", "words"), [(3.0, "of 20."), (65741.0, "of more than 10⁶.")])
def test_odds_are_told_as_far_as_they_mean_anything(log_odds, words):
    run = NextRun("slow", "washboard", 7.5, ("dry-friction", "digressive-damper"), 71, 17, log_odds)
    assert next_run_words(run).endswith(f"expected to change the odds by a factor {words}")


def test_a_verdict_states_the_numbers_of_its_effects_in_their_first_unit():
    numbers = {"front_N": (72.9, 2.0), "rear_N": (53.5, 1.5), "presliding_N_m": (2e5, 4e3)}
    parameters = {f"dry-friction.{name}": number for name, number in numbers.items()}
    parameters["body.mass_kg"] = (209.0, 6.0)
    steps = [
        SimpleNamespace(added=(), rung=SimpleNamespace(error=0.0913), parameters={}),
        SimpleNamespace(
            added=("dry-friction",), rung=SimpleNamespace(error=0.00551), parameters=parameters
        ),
    ]
    found = "dry-friction: front 72.9 ± 4.0 N, rear 53.5 ± 3.0 N. Error 9.13 % → 0.551 %."
    assert in_numbers(steps) == found
    assert in_numbers(steps[:1]) == ""
