"""From weights and a tape to a whole vehicle.toml: the truth lies within what is stated."""

from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import CampaignError
from wheelhop.campaign.sample import marked_numbers
from wheelhop.vehicle import read_vehicle
from wheelhop.vehicle.estimate import ESTIMATED, Axle, Known, estimate, vehicle_toml

ATV = Path(__file__).parents[2] / "examples/clean/vehicle.toml"
# A compact car in round numbers, as textbooks have them.
CAR = {
    "geometry.wheelbase_m": 2.6,
    "geometry.track_width_m": 1.5,
    "geometry.cg_to_front_axle_m": 1.15,
    "geometry.cg_height_m": 0.55,
    "body.mass_kg": 1200.0,
    "body.pitch_inertia_kg_m2": 1850.0,
    "body.roll_inertia_kg_m2": 430.0,
    "suspension.front.stiffness_N_m": 24e3,
    "suspension.front.damping_N_s_m": 1700.0,
    "suspension.rear.stiffness_N_m": 22e3,
    "suspension.rear.damping_N_s_m": 1600.0,
    "wheel.front.unsprung_mass_kg": 42.0,
    "wheel.front.tyre_stiffness_N_m": 200e3,
    "wheel.rear.unsprung_mass_kg": 38.0,
    "wheel.rear.tyre_stiffness_N_m": 200e3,
    "wheel.front.radius_m": 0.31,
}


def weighed(truth, front=None, rear=None):
    """What scales and a tape tell of a vehicle; `front` and `rear` what else is known there."""
    length, ahead = truth["geometry.wheelbase_m"], truth["geometry.cg_to_front_axle_m"]
    share = {"front": 1 - ahead / length, "rear": ahead / length}
    axles = [
        Axle(
            truth["body.mass_kg"] * share[end] + 2 * truth[f"wheel.{end}.unsprung_mass_kg"],
            **(more or {}),
        )
        for end, more in (("front", front), ("rear", rear))
    ]
    return Known("ours", *axles, length, truth["geometry.track_width_m"])


@pytest.mark.parametrize("truth", [read_vehicle(ATV).values, CAR], ids=["ATV", "car"])
def test_what_is_estimated_holds_a_quad_and_a_car(truth):
    numbers = estimate(weighed(truth))
    off = {
        key: (truth[key] - n.value) / n.uncertainty for key, n in numbers.items() if key in truth
    }
    assert max(map(abs, off.values())) < 2.5, off
    assert np.sqrt(np.mean(np.square(list(off.values())))) < 1.2
    assert off["geometry.wheelbase_m"] == 0.0


def test_a_spring_and_the_ride_frequency_it_gives_are_the_same_knowledge():
    """The quarter car by statics: spring and tyre in series carry a quarter of the body."""
    spring, ratio = 30e3, 0.6
    with_spring = estimate(weighed(CAR, {"spring_N_m": spring, "motion_ratio": ratio}))
    at_wheel = with_spring["suspension.front.stiffness_N_m"]
    assert at_wheel.value == pytest.approx(spring * ratio**2)
    tyre = with_spring["wheel.front.tyre_stiffness_N_m"].value
    ahead = with_spring["geometry.cg_to_front_axle_m"].value / CAR["geometry.wheelbase_m"]
    quarter = with_spring["body.mass_kg"].value * (1 - ahead) / 2
    hz = np.sqrt(1 / (1 / at_wheel.value + 1 / tyre) / quarter) / (2 * np.pi)
    counted = estimate(weighed(CAR, {"ride_hz": hz}))["suspension.front.stiffness_N_m"]
    assert counted.value == pytest.approx(at_wheel.value)
    guessed = estimate(weighed(CAR))["suspension.front.stiffness_N_m"]
    relative = [n.uncertainty / n.value for n in (at_wheel, counted, guessed)]
    assert relative == sorted(relative) and "given" in counted.source
    with pytest.raises(CampaignError, match=r"rear axle: 9 Hz takes .* its tyres have"):
        estimate(weighed(CAR, rear={"ride_hz": 9.0}))
    with pytest.raises(CampaignError, match="front axle: a spring rate and a ride frequency"):
        estimate(weighed(CAR, {"ride_hz": 1.5, "spring_N_m": spring}))


def test_the_file_reads_back_and_marks_what_is_a_guess(tmp_path):
    known = weighed(CAR, {"spring_N_m": 25e3}, {"ride_hz": 1.5})
    file = tmp_path / "vehicle.toml"
    file.write_text(vehicle_toml(known))
    vehicle, numbers = read_vehicle(file), estimate(known)
    for key, number in numbers.items():
        assert vehicle[key] == pytest.approx(number.value, rel=1e-3)
        assert vehicle.uncertainty[key] == pytest.approx(number.uncertainty, rel=0.05)
    marked = marked_numbers(file, ESTIMATED)
    assert {"body.pitch_inertia_kg_m2", "wheel.rear.tyre_stiffness_N_m"} < set(marked)
    assert not {"geometry.wheelbase_m", "suspension.front.stiffness_N_m"} & set(marked)
    # What was weighed and counted stands there, too, and all that follows from it agrees.
    measured = {m.key: m for m in vehicle.measured}
    assert measured["front_axle_kg"].value == pytest.approx(known.front.load_kg, rel=1e-3)
    assert measured["front_axle_kg"].relative == pytest.approx(0.02, rel=0.05)
    assert set(measured) == {"front_axle_kg", "rear_axle_kg", "rear_ride_hz"}
    for one in vehicle.measured:
        assert one.of(vehicle.values) == pytest.approx(one.value, rel=1e-3)
