"""Driver, engine, battery and payload on mounts: closed forms, limits, what the fit finds."""

from pathlib import Path

import numpy as np
import pytest

from tests.truth import PRESETS
from wheelhop.campaign import CampaignError, Channel
from wheelhop.effects import load_effects
from wheelhop.fit import Workshop, fit, vehicle_parameters
from wheelhop.predict import Case, read_drives, read_effects
from wheelhop.predict.ride import ride
from wheelhop.simulate import Model, frequency_response
from wheelhop.vehicle import Vehicle, read_vehicle

ATV = dict(PRESETS["atv"].vehicle)
TEXT = (Path(__file__).parents[2] / "examples/clean/vehicle.toml").read_text(encoding="utf-8")
CHANNELS = [Channel(name, name) for name in ("B1", "B2", "B3", "B4", "A1", "A4")]
FREQUENCY_HZ = np.geomspace(0.3, 40.0, 40)
BATTERY = {
    "battery.mass_kg": 25.0,
    "battery.x_m": 0.3,
    "battery.y_m": -0.2,
    "battery.stiffness_N_m": 60e3,
    "battery.damping_N_s_m": 150.0,
}
SEAT = {"driver.stiffness_N_m": 40e3, "driver.damping_N_s_m": 900.0}


def response(values):
    return frequency_response(Model(values).system(CHANNELS, "road"), FREQUENCY_HZ)


def test_a_mount_is_a_mass_that_depends_on_frequency():
    """Seen from the body a mass m on a mount Z weighs m Z / (Z − m ω²): the body's equations with
    that in place of m, solved by themselves."""
    omega = 2 * np.pi * FREQUENCY_HZ
    rigid = Model(ATV).system(CHANNELS, "road")
    mount = BATTERY["battery.stiffness_N_m"] + 1j * omega * BATTERY["battery.damping_N_s_m"]
    mass = BATTERY["battery.mass_kg"]
    place = np.zeros(len(rigid.mass))
    place[:3] = 1.0, -BATTERY["battery.x_m"], BATTERY["battery.y_m"]
    expected = []
    for w, z in zip(omega, mount, strict=True):
        more = mass * z / (z - mass * w**2) - mass
        moving = rigid.mass + more * np.outer(place, place)
        dynamic = rigid.stiffness + 1j * w * rigid.damping - w**2 * moving
        driven = rigid.input_stiffness + 1j * w * rigid.input_damping
        expected.append(-(w**2) * rigid.output @ np.linalg.solve(dynamic, driven))
    np.testing.assert_allclose(response(ATV | BATTERY), expected, rtol=1e-9, atol=1e-9)
    assert np.abs(response(ATV | BATTERY) - response(ATV)).max() > 1.0


def test_a_hard_mount_is_none():
    hard = ATV | BATTERY | {"battery.stiffness_N_m": 1e11, "battery.damping_N_s_m": 0.0}
    np.testing.assert_allclose(response(hard), response(ATV), rtol=1e-4, atol=1e-6)


def test_the_driver_s_seat_is_the_effect_of_that_name():
    effect = load_effects()["driver-seat"]
    mass, place = ATV["driver.mass_kg"], {"driver-seat.x_m": ATV["driver.x_m"]}
    omega = np.sqrt(SEAT["driver.stiffness_N_m"] / mass)
    theta = {
        "driver-seat.mass_kg": mass,
        "driver-seat.freq_hz": omega / (2 * np.pi),
        "driver-seat.zeta": SEAT["driver.damping_N_s_m"] / (2 * mass * omega),
    }
    with_effect = Model(ATV | theta | place, (effect,)).system(CHANNELS, "road")
    found = frequency_response(with_effect, FREQUENCY_HZ)
    np.testing.assert_allclose(response(ATV | SEAT), found, rtol=1e-9, atol=1e-9)
    assert effect.applies_to(ATV) and not effect.applies_to(ATV | SEAT)


def test_an_engine_s_force_comes_through_its_mount():
    """Of what shakes an engine the body gets Z / (Z − m ω²), as far as it hardly moves itself."""
    heavy = ATV | {"body.mass_kg": 1e6, "body.pitch_inertia_kg_m2": 1e6}
    heavy |= {"body.roll_inertia_kg_m2": 1e6}
    k, c, m = 50e3, 200.0, ATV["engine.mass_kg"]
    mounted = heavy | {"engine.stiffness_N_m": k, "engine.damping_N_s_m": c}
    moved = []
    for values in (heavy, mounted):
        effect = load_effects()["engine-vibration"]
        system = Model(values, (effect,)).system(CHANNELS, "road")
        w = 2 * np.pi * 20.0
        dynamic = system.stiffness + 1j * w * system.damping - w**2 * system.mass
        moved.append((system.output @ np.linalg.solve(dynamic, system.force))[0, 0])
    z = k + 1j * w * c
    assert moved[1] / moved[0] == pytest.approx(z / (z - m * w**2), rel=1e-3)


def test_the_driver_on_his_seat_is_whose_comfort_is_told():
    vehicle = Vehicle("atv", ATV, dict.fromkeys(ATV, 0.0))
    soft = {"driver.stiffness_N_m": 5e3, "driver.damping_N_s_m": 200.0}
    seated = Vehicle("atv", ATV | soft, dict.fromkeys(ATV | soft, 0.0))
    drives = read_drives(["washboard/low"], [9.5])
    bolted, sprung = (
        ride(Case(v, (), drives, seconds=4.0), 0).comfort_wk_rms_m_s2 for v in (vehicle, seated)
    )
    assert sprung < 0.6 * bolted


def test_the_fit_finds_mounts_as_any_other_number():
    """Three runs without noise, everything believed 5 % off: the mounts' numbers come back."""
    true = ATV | BATTERY | SEAT
    spread = {k: 0.1 * abs(v) + 1e-3 for k, v in true.items()}
    vehicle = Vehicle("atv", true, spread)
    tracks = ["washboard:amplitude_mm=10:pitch_mm=500", "herringbone:amplitude_mm=10:pitch_mm=700"]
    case = Case(vehicle, (), read_drives(tracks, [9.0, 16.0]), seconds=5.0)
    campaign, model = case.campaign(0.05)
    numbers = [free.name for free in vehicle_parameters(campaign, vehicle)]
    assert {"battery.x_m", "battery.stiffness_N_m", "driver.damping_N_s_m"} <= set(numbers)
    assert not any(name.startswith("engine.") for name in numbers)
    wrong = {k: v * (1.05 if i % 2 else 0.95) for i, (k, v) in enumerate(true.items())}
    wrong = {k: v for k, v in wrong.items() if not k.startswith(("geometry.", "engine."))}
    start = model.with_values(wrong)
    workshop = Workshop(campaign, start, jobs=1)
    believed = Vehicle("atv", true | wrong, spread)
    shared = vehicle_parameters(campaign, believed)
    found = fit(workshop, start, shared, workshop.of_role("fit")).model.values
    # No run on a road tells the scale that all masses and forces share.
    scale = found["body.mass_kg"] / true["body.mass_kg"]
    for key in ("battery.stiffness_N_m", "driver.stiffness_N_m", "driver.damping_N_s_m"):
        assert found[key] / scale == pytest.approx(true[key], rel=0.02)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("[battery]\nmass_kg = 20\nx_m = 0\ny_m = 0\n", "stiffness_N_m and damping_N_s_m of its"),
        ("[payload]\nmass_kg = 20\nx_m = 0\ny_m = 0\nstiffness_N_m = 1e4\n", "needs damping_N_s_m"),
        (
            "[battery]\nmass_kg = 20\nx_m = 3\ny_m = 0\nstiffness_N_m = 1e4\ndamping_N_s_m = 1\n",
            "inertia includes battery",
        ),
        (
            "[battery]\nmass_kg = -2\nx_m = 3\ny_m = 0\nstiffness_N_m = 1e4\ndamping_N_s_m = 1\n",
            "mass_kg = -2 must be greater than 0",
        ),
    ],
)
def test_what_is_aboard_wrongly_is_a_line(more, said, tmp_path):
    file = tmp_path / "vehicle.toml"
    file.write_text(TEXT + more, encoding="utf-8")
    with pytest.raises(CampaignError, match=said) as error:
        read_vehicle(file)
    assert "\n" not in str(error.value)


def test_what_is_aboard_is_read_with_its_uncertainty(tmp_path):
    file = tmp_path / "vehicle.toml"
    mount = "stiffness_N_m = 3e4\ndamping_N_s_m = 800\ndamping_N_s_m_uncertainty = 300\n"
    file.write_text(TEXT.replace("[driver]\n", f"[driver]\n{mount}"), encoding="utf-8")
    vehicle = read_vehicle(file)
    assert vehicle["driver.stiffness_N_m"] == 3e4
    assert vehicle.uncertainty["driver.damping_N_s_m"] == 300.0
    with pytest.raises(CampaignError, match="does not apply"):
        Case(vehicle, read_effects(["driver-seat"], load_effects()), read_drives(["flat"], [5.0]))
