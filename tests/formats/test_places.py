"""Where a channel sits, as far as its name says."""

from pathlib import Path

import numpy as np
import pytest

from wheelhop.formats.places import likely_on_body, likely_point, likely_points
from wheelhop.formats.table import Table, to_recording
from wheelhop.logger.recording import Channel


@pytest.mark.parametrize(
    ("name", "point"),
    [
        ("A1", "A1"),
        ("b 3", "B3"),
        ("Acc axle FL", "A1"),
        ("wheel_RR_z", "A4"),
        ("AccBodyFR", "B2"),
        ("chassis rear left", "B3"),
        ("Unsprung-Front-Right", "A2"),
        ("strut tower LF", "B1"),
        ("Aufbau hinten rechts", "B4"),
    ],
)
def test_names_people_use(name, point):
    assert likely_point(name) == point


@pytest.mark.parametrize(
    "name",
    ["", "time", "FL", "axle", "acc 1", "axle body FL", "front left or rear left axle", "A5"],
)
def test_what_does_not_say_is_not_guessed(name):
    assert likely_point(name) == ""


@pytest.mark.parametrize(
    ("names", "points"),
    [
        ("FL FR RL RR", "B1 B2 B3 B4"),
        ("FL FR RL RR axle_FL axle_FR axle_RL axle_RR", "B1 B2 B3 B4 A1 A2 A3 A4"),
        ("RR body_FL body_FR body_RL body_RR FL FR RL", "A4 B1 B2 B3 B4 A1 A2 A3"),
        ("hub_FL_x hub_FL_z gyro FR", "- A1 - B2"),
        ("FL_gyro_axle_body A1 B1", "- A1 B1"),
    ],
)
def test_corners_alone_are_what_the_others_are_not(names, points):
    assert [point or "-" for point in likely_points(names.split())] == points.split()


def test_import_takes_places_from_names_of_accelerometers_and_says_so():
    units = {"FL": "g", "FR": "g", "speed FL wheel": "km/h", "hub FL": "m/s^2", "B4": "g"}
    channels = tuple(Channel(name, unit) for name, unit in units.items())
    table = Table(Path("drive.mf4"), "ASAM MDF", channels, np.zeros((3, 5)), rate_hz=100.0)
    recording = to_recording(table, None)
    assert [c.point for c in recording.channels] == ["B1", "B2", "", "A1", "B4"]
    assert "FR: taken for B2, by its name" in recording.history
    assert not any("speed" in step and "taken" in step for step in recording.history)


@pytest.mark.parametrize("name", ["Hub FL x", "acc_hub_FL_Y", "Body FR lateral", "hub RL -Z"])
def test_what_is_not_measured_upwards_is_at_no_place(name):
    assert likely_points([name, "hub RR z"]) == ["", "A4"]


def test_of_three_directions_the_upward_one_sits_there():
    assert likely_points(["hub FL x", "hub FL y", "hub FL z"]) == ["", "", "A1"]
    assert likely_points(["FL_X", "FL_Y", "FL_Z"]) == ["", "", "B1"]


@pytest.mark.parametrize(
    ("names", "places"),
    [
        ("Acc_Z", "body"),
        ("ax ay az", "along:x along:y body"),
        ("imu_z dash_z", "- -"),
        ("acc_x long_acc acc_lat", "- - along:y"),
        ("hub_z FL_z engine_z acc_-Z", "- - - -"),
    ],
)
def test_of_accelerometers_on_the_body_a_lone_one_is_told(names, places):
    """Two that seem to mean the same get no place, as nobody knows which is which."""
    names = [name.replace("_", " ") for name in names.split()]
    assert [place or "-" for place in likely_on_body(names)] == places.split()
