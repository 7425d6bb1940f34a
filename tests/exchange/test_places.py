"""Where a channel sits, as far as its name says."""

import pytest

from wheelhop.exchange.places import likely_point


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
