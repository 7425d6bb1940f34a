"""vehicle.toml: what every number means, how well it is known, and what is refused."""

import tempfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.campaign.build import VEHICLE, edit
from wheelhop.campaign import CampaignError
from wheelhop.vehicle import Vehicle, read_vehicle


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "vehicle.toml"
    path.write_text(VEHICLE)
    return path


def complaint(file: Path) -> str:
    with pytest.raises(CampaignError) as caught:
        read_vehicle(file)
    assert str(caught.value).startswith(str(file))
    return str(caught.value)


def test_numbers_stand_under_their_dotted_keys(file):
    vehicle = read_vehicle(file)
    assert vehicle.name == "student-built ATV"
    assert vehicle["geometry.wheelbase_m"] == 1.42
    assert vehicle["suspension.rear.damping_N_s_m"] == 590.0
    assert vehicle["wheel.front.unsprung_mass_kg"] == 15.0
    assert vehicle["driver.x_m"] == -0.10
    assert len(vehicle.values) == 22
    assert vehicle.values.keys() == vehicle.uncertainty.keys()
    assert not any(key.startswith("engine") for key in vehicle.values)


def test_uncertainty_is_relative_unless_it_stands_beside_the_value(file):
    uncertainty = read_vehicle(file).uncertainty
    assert uncertainty["body.mass_kg"] == pytest.approx(22.8)
    assert uncertainty["suspension.front.stiffness_N_m"] == 800.0
    assert uncertainty["driver.mass_kg"] == pytest.approx(7.0)


def test_where_the_driver_sits_is_never_known_better_than_2_cm_unless_stated(file):
    uncertainty = read_vehicle(file).uncertainty
    assert uncertainty["driver.x_m"] == 0.02  # ten per cent of 0.1 m would be 0.01 m
    assert uncertainty["driver.y_m"] == 0.02
    edit(file, "x_m = -0.10", "x_m = -0.50\ny_m_uncertainty = 0.005")
    uncertainty = read_vehicle(file).uncertainty
    assert uncertainty["driver.x_m"] == pytest.approx(0.05)
    assert uncertainty["driver.y_m"] == 0.005


def test_changed_values_make_another_vehicle(file):
    vehicle = read_vehicle(file)
    heavier = vehicle.with_values({"body.mass_kg": 250.0})
    assert heavier["body.mass_kg"] == 250.0
    assert vehicle["body.mass_kg"] == 228.0
    assert heavier.with_values({"body.mass_kg": 228.0}) == vehicle
    with pytest.raises(KeyError, match=r"body\.mass_g"):
        vehicle.with_values({"body.mass_g": 250.0})


MISTAKES = {
    "misspelt key": ("track_width_m", "track_widht_m", ["[geometry]", "'track_width_m'?"]),
    "misspelt table": ("[wheel.rear]", "[wheel.raer]", ["[wheel]", "'rear'?"]),
    "key in the wrong table": ("cg_height_m", "stiffness_N_m", ["[geometry]", "stiffness_N_m"]),
    "newtons per millimetre": (
        "stiffness_N_m = 6500.0",
        "stiffness_N_mm = 6.5",
        ["[suspension.rear]", "newtons per metre", "stiffness_N_m = 6500"],
    ),
    "uncertainty in millimetres": (
        "wheelbase_m = 1.42",
        "wheelbase_m = 1.42\nwheelbase_mm_uncertainty = 5",
        ["wheelbase is given in metres", "wheelbase_m_uncertainty = 0.005"],
    ),
    "missing key": ("cg_height_m = 0.52\n", "", ["[geometry]", "'cg_height_m' is missing"]),
    "missing table": ("[body]", "[bodywork]", ["'bodywork'", "'body'?"]),
    "no mass": ("mass_kg = 228.0", "mass_kg = 0", ["[body]", "mass_kg = 0", "greater than 0"]),
    "negative damping": ("damping_N_s_m = 590.0", "damping_N_s_m = -1", ["[suspension.rear]"]),
    "not finite": ("mass_kg = 228.0", "mass_kg = nan", ["[body]", "mass_kg", "finite"]),
    "centre of mass ahead": ("_axle_m = 0.80", "_axle_m = -0.1", ["[geometry]", "cg_to_front"]),
    "centre of mass behind": (
        "_axle_m = 0.80",
        "_axle_m = 1.5",
        ["[geometry]", "between the axles"],
    ),
    "driver heavier than the body": ("mass_kg = 70.0", "mass_kg = 300.0", ["includes driver"]),
    "per cent": ("= 0.10", "= 10", ["relative_uncertainty = 10", "0.10 for 10 %"]),
    "certainty": ("_uncertainty = 800.0", "_uncertainty = 0", ["greater than 0"]),
    "relative to nothing": (
        "tyre_damping_N_s_m = 200.0",
        "tyre_damping_N_s_m = 0",
        ["[wheel.front]", "give tyre_damping_N_s_m_uncertainty"],
    ),
    "format": ("format = 1", "format = '1'", ["reads format = 1"]),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_get_one_line(file, mistake):
    old, new, words = MISTAKES[mistake]
    edit(file, old, new)
    line = complaint(file)
    assert line.isprintable()
    assert all(word in line for word in words), line


def test_missing_file(tmp_path):
    assert "no such file" in complaint(tmp_path / "vehicle.toml")


@given(st.data())
def test_what_is_written_is_what_is_read(data):
    shape = read_vehicle_text(VEHICLE)
    positive = st.floats(0.01, 1e4)  # of a mass, a length, a stiffness alike
    values = {key: data.draw(positive, key) for key in shape.values}
    values["geometry.wheelbase_m"] = values["geometry.cg_to_front_axle_m"] * 2.0
    values["body.mass_kg"] = values["driver.mass_kg"] * 1.5
    uncertainty = {key: data.draw(positive, f"{key}_uncertainty") for key in values}
    lines = ["format = 1", 'name = "v"', "relative_uncertainty = 0.2"]
    for key, value in values.items():
        lines += [f"{key} = {value!r}", f"{key}_uncertainty = {uncertainty[key]!r}"]
    vehicle = read_vehicle_text("\n".join(lines))
    assert vehicle == Vehicle("v", values, uncertainty)


def read_vehicle_text(text: str) -> Vehicle:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "vehicle.toml"
        file.write_text(text)
        return read_vehicle(file)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("body.mass_kg", 1e12, "too large to be believed: 0.0001 to 1e+06 kilograms"),
        ("suspension.front.stiffness_N_m", 1e-12, "too small to be believed"),
        ("wheel.rear.radius_m", 1e-4, "must not be below 0.005"),
    ],
)
def test_numbers_that_nothing_on_wheels_has_are_refused(file, key, value, words):
    """They once ended as overflow, or as memory for 28 PiB."""
    table, name = key.rsplit(".", 1)
    text = file.read_text()
    at = text.index(f"{name} =", text.index(f"[{table}]"))
    file.write_text(f"{text[:at]}{name} = {value!r}\n#{text[at:]}")
    assert f"{name} = {value:g} " in complaint(file) and words in complaint(file)


def test_what_scales_and_a_stopwatch_tell_of_the_whole_stands_beside_its_numbers(file):
    assert read_vehicle(file).measured == ()
    told = "total_mass_kg = 280.0\nfront_axle_kg = 130.0\nfront_axle_kg_uncertainty = 2.0\n"
    file.write_text(f"{VEHICLE}\n[measured]\n{told}rear_ride_hz = 1.9\n")
    vehicle = read_vehicle(file)
    total, front, ride = vehicle.measured
    assert (front.name, front.value, front.sigma) == ("measured.front_axle_kg", 130.0, 2.0)
    assert (total.sigma, ride.sigma) == pytest.approx((28.0, 0.19))  # relative_uncertainty
    whole = vehicle["body.mass_kg"] + 2 * (15.0 + 12.5)
    behind = vehicle["geometry.cg_to_front_axle_m"] / vehicle["geometry.wheelbase_m"]
    assert total.of(vehicle.values) == pytest.approx(whole)
    assert front.of(vehicle.values) == pytest.approx(
        vehicle["body.mass_kg"] * (1.0 - behind) + 2 * 15.0
    )
    rate = 1.0 / (1.0 / vehicle["suspension.rear.stiffness_N_m"] + 1.0 / 40e3)
    carried = vehicle["body.mass_kg"] * behind / 2
    assert ride.of(vehicle.values) == pytest.approx((rate / carried) ** 0.5 / 6.2832, rel=1e-4)
    assert vehicle.with_values({"body.mass_kg": 250.0}).measured == vehicle.measured


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("front_axel_kg = 130.0", "did you mean 'front_axle_kg'?"),
        ("front_axle_kg = -130.0", "[measured]: front_axle_kg"),
        ("front_axle_lb = 130.0", "is given in"),
        ("rear_ride_hz_uncertainty = 0.1", "'rear_ride_hz' is missing"),
    ],
)
def test_what_was_measured_is_held_to_the_same_rules(file, line, said):
    file.write_text(f"{VEHICLE}\n[measured]\n{line}\n")
    assert said in complaint(file)
