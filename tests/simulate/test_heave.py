"""Heave of the body over heave of the ground, against what must be so for any vehicle."""

from pathlib import Path

import numpy as np
import pytest

from wheelhop.simulate.heave import heave_transmissibility
from wheelhop.vehicle import read_vehicle

CLEAN = Path(__file__).parents[2] / "examples/clean"


@pytest.fixture(scope="module")
def values():
    return dict(read_vehicle(CLEAN / "vehicle.toml").values)


def test_on_slow_ground_the_body_follows(values):
    assert heave_transmissibility(values, [1e-3]) == pytest.approx(1.0, abs=1e-4)
    assert heave_transmissibility(values, [1e-3], 3.0) == pytest.approx(1.0, abs=1e-3)


def test_alike_front_and_rear_it_is_the_quarter_car(values):
    """Nothing pitches then: two masses on two springs, solved by hand."""
    values |= {"geometry.cg_to_front_axle_m": values["geometry.wheelbase_m"] / 2}
    for key in [key for key in values if ".rear." in key]:
        values[key] = values[key.replace(".rear.", ".front.")]
    frequency = np.geomspace(0.5, 20, 30)
    s = 2j * np.pi * frequency
    body = (values["body.mass_kg"]) / 4
    wheel = values["wheel.front.unsprung_mass_kg"]
    strut = values["suspension.front.stiffness_N_m"] + s * values["suspension.front.damping_N_s_m"]
    tyre = values["wheel.front.tyre_stiffness_N_m"] + s * values["wheel.front.tyre_damping_N_s_m"]
    denominator = (body * s**2 + strut) * (wheel * s**2 + strut + tyre) - strut**2
    np.testing.assert_allclose(
        heave_transmissibility(values, frequency), np.abs(strut * tyre / denominator), rtol=1e-9
    )


def test_waves_of_one_wheelbase_lift_the_body_and_of_two_only_pitch_it(values):
    """At a wavelength of one wheelbase the rear wheels do as the front ones; at two wheelbases the
    opposite, and a vehicle that is alike front and rear only pitches."""
    values |= {"geometry.cg_to_front_axle_m": values["geometry.wheelbase_m"] / 2}
    for key in [key for key in values if ".rear." in key]:
        values[key] = values[key.replace(".rear.", ".front.")]
    speed, wheelbase = 4.0, values["geometry.wheelbase_m"]
    alike, opposite = speed / wheelbase, speed / (2 * wheelbase)
    whole = heave_transmissibility(values, [alike])
    np.testing.assert_allclose(heave_transmissibility(values, [alike], speed), whole, rtol=1e-9)
    assert heave_transmissibility(values, [opposite], speed) == pytest.approx(0.0, abs=1e-9)
