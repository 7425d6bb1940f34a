"""An accelerometer on the driver, the engine: on its mount, on an effect's, or on the body."""

import numpy as np
import pytest

from tests.campaign.build import ROWS, csv_text, edit, write_campaign
from tests.simulate.setup import ATV, model_of
from tests.simulate.test_against_mujoco import RUNS
from wheelhop.campaign import CampaignError, Channel, read_campaign
from wheelhop.simulate import frequency_response
from wheelhop.vehicle import read_nominal

FREQUENCY = np.linspace(0.5, 30.0, 80)
AHEAD, LEFT, MASS, SEAT_HZ, ZETA = -0.2, 0.1, 60.0, 3.0, 0.3
DRIVEN = {**ATV, "driver.mass_kg": MASS, "driver.x_m": AHEAD, "driver.y_m": LEFT}
TABLE = """
[channels]
B1 = "B1"
block = { quantity = "acceleration", on = "engine" }
"""
CHANNELS = (Channel("seat", "driver"), Channel("below", "body-xy", AHEAD, LEFT))


def shown(model, drive="road"):
    """What the driver's sensor shows per what the body does below (f, w)."""
    found = frequency_response(model.system(CHANNELS, drive), FREQUENCY)
    return found[:, 0] / found[:, 1]


def carried():
    """The gain of a mass on a spring and a damper (f, 1), driven at its foot."""
    ratio = FREQUENCY[:, None] / SEAT_HZ
    return (1 + 2j * ZETA * ratio) / (1 - ratio**2 + 2j * ZETA * ratio)


def test_without_a_mount_it_moves_as_the_body_does_there():
    np.testing.assert_allclose(shown(model_of(DRIVEN, RUNS)), 1.0, rtol=1e-9)


@pytest.mark.parametrize("drive", ["road", "axles", "travel"])
def test_on_a_mount_of_the_vehicle_it_moves_with_what_the_mount_carries(drive):
    omega = 2 * np.pi * SEAT_HZ
    mount = {
        "driver.stiffness_N_m": MASS * omega**2,
        "driver.damping_N_s_m": 2 * ZETA * MASS * omega,
    }
    found = shown(model_of({**DRIVEN, **mount}, RUNS), drive)
    np.testing.assert_allclose(found, np.broadcast_to(carried(), found.shape), rtol=1e-9)


def test_an_effect_that_puts_the_driver_on_a_seat_takes_the_sensor_along():
    theta = {"mass_kg": MASS, "freq_hz": SEAT_HZ, "zeta": ZETA, "x_m": AHEAD}
    found = shown(model_of(DRIVEN, RUNS, "driver-seat", theta))
    np.testing.assert_allclose(found, np.broadcast_to(carried(), found.shape), rtol=1e-9)


def test_what_vehicle_toml_does_not_have_carries_no_sensor(tmp_path):
    write_campaign(tmp_path)
    edit(tmp_path / "campaign.toml", "\n[[run]]", f"{TABLE}\n[[run]]")
    for seed, run in enumerate(("slow", "fast")):
        values = np.random.default_rng(seed).normal(0.0, 0.5, (ROWS, 2))
        (tmp_path / f"runs/{run}.csv").write_text(csv_text(values, ("B1", "block")))
    with pytest.raises(CampaignError, match="block sits on the engine, and vehicle"):
        read_nominal(read_campaign(tmp_path))
