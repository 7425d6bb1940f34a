"""From the recording of a car with potentiometers, a gyro, a gauge and GPS to a campaign."""

import numpy as np
import pytest

from tests.workbench.test_draft import KNOWN
from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.formats.places import likely_quantity
from wheelhop.workbench.draft import Column, Draft
from wheelhop.workbench.kept import keep, resume

COLUMNS = {  # heading: amplitude in its unit, what is guessed
    "Damper FL [mm]": (10.0, "travel:1"),
    "Damper RR [mm]": (8.0, "travel:4"),
    "Gyro pitch [deg/s]": (12.0, "rate:pitch"),
    "Pushrod FR [kN]": (0.4, "force:2"),
    "GPS speed [km/h]": (1.0, "speed"),
    "Engine [rpm]": (100.0, "speed:engine"),
    "Acc body FL [g]": (0.2, "B1"),
    "Brake [bar]": (3.0, "not used"),
    "Acc Z [g]": (0.2, "body"),
    "Acc X [g]": (0.1, "along:x"),
    "Wheel speed RL [rad/s]": (1.0, "speed:wheel:3"),
}


@pytest.fixture
def draft(tmp_path):
    time_s = np.arange(2000) / 100.0
    driven = (time_s > 4.0) & (time_s < 16.0)
    rng = np.random.default_rng(5)
    values = [
        size * (driven * np.sin(2 * np.pi * (2 + i) * time_s) + rng.normal(0, 0.003, len(time_s)))
        for i, (size, _) in enumerate(COLUMNS.values())
    ]
    head = ";".join(("Time [s]", *COLUMNS))
    file = tmp_path / "drive.csv"
    np.savetxt(file, np.column_stack([time_s, *values]), "%.6f", ";", header=head, comments="")
    draft = Draft(tmp_path / "draft")
    draft.add(file)
    draft.answers |= KNOWN
    return draft


def test_they_are_guessed_from_name_and_unit(draft):
    assert [column.place for column in draft.columns] == [place for _, place in COLUMNS.values()]
    assert "deg/s" in draft.units(draft.columns[2]) and "g" not in draft.units(draft.columns[2])


@pytest.mark.parametrize(
    "name, unit, word",
    [("laser", "m", ""), ("gyro z", "rad/s", ""), ("pitch roll", "rad/s", ""), ("FL", "m/s²", "")],
)
def test_what_does_not_say_is_asked(name, unit, word):
    assert likely_quantity(name, unit) == word


def test_the_campaign_holds_them_in_si(draft, tmp_path):
    draft.columns[0].per_wheel = 0.65
    draft.columns[1].per_wheel = -0.8
    draft.read()
    (piece,) = draft.pieces
    assert 10.0 < piece.to_s - piece.from_s < 14.0
    piece.speed_kmph = 12.0
    draft.make(tmp_path / "made", "pots")
    campaign = read_campaign(tmp_path / "made")
    by_point = {(c.quantity, c.point): c for c in campaign.channels}
    assert by_point["travel", "S1"].per_wheel == 0.65
    assert by_point["travel", "S4"].per_wheel == -0.8
    assert set(by_point) == {
        *(("travel", "S1"), ("travel", "S4"), ("rate", "pitch"), ("force", "S2")),
        ("acceleration", "B1"),
        ("acceleration", "body"),
    }
    assert {(c.name, c.unit) for c in campaign.known} == {
        ("GPS speed", "m/s"),
        ("Engine", "rad/s"),
        ("Wheel speed RL", "rad/s"),
        ("Acc X", "m/s²"),
    }
    pot = campaign.channels.index(by_point["travel", "S1"])
    assert campaign.runs[0].record[:, pot].std() == pytest.approx(0.01 / np.sqrt(2), rel=0.1)


def test_a_unit_of_something_else_is_one_line(draft):
    draft.columns[6].place = "rate:roll"
    with pytest.raises(CampaignError, match="Acc body FL is in g, no unit of rate"):
        draft.read()


def test_the_ratio_is_kept(draft, tmp_path):
    draft.columns[0].per_wheel = 0.65
    keep(draft)
    assert resume(tmp_path / "draft", None).columns[0].per_wheel == 0.65


def test_a_draft_of_before_is_resumed():
    assert Column(**{"key": 1, "name": "a", "unit": "g", "place": "B1"}).per_wheel == 1.0
