"""A potentiometer behind a rocker: its curve is undone, and a wrong one is named."""

import numpy as np
import pytest

from tests.campaign.build import ROWS, csv_text, edit, write_campaign
from wheelhop.campaign import CampaignError, read_campaign

WHEEL_M = np.linspace(-0.05, 0.06, 12)
CHANNELS = """
[channels]
B1 = "B1"
pot = { quantity = "travel", corner = 1, per_wheel = "rocker.csv" }
"""


def sensor(wheel_m):
    """What a linkage makes of it: a ratio of 0.6 at ride height that grows in compression."""
    return -0.6 * wheel_m + 3.0 * wheel_m**2


def curve(names="wheel_mm,sensor_mm", wheel_m=WHEEL_M, shown=None):
    shown = sensor(wheel_m) if shown is None else shown
    rows = [
        f"{1e3 * x!r},{1e3 * y!r}" for x, y in zip(wheel_m.tolist(), shown.tolist(), strict=True)
    ]
    return "\n".join([names, *rows]) + "\n"


def campaign(folder, text, reach_m=0.04):
    """Runs whose wheel moves so far either way about ride height; the sensor rests at 31 mm."""
    write_campaign(folder)
    edit(folder / "campaign.toml", "\n[[run]]", f"{CHANNELS}\n[[run]]")
    (folder / "rocker.csv").write_text(text)
    for phase, run in enumerate(("slow", "fast")):
        turns = np.linspace(0.0, 6 * np.pi, ROWS) + phase
        wheel = reach_m * np.sin(turns)
        values = np.stack([np.cos(turns), sensor(wheel) + 0.031], axis=1)
        (folder / f"runs/{run}.csv").write_text(csv_text(values, ("B1", "pot")))
    return read_campaign(folder)


def test_the_record_is_the_wheels_travel_times_the_ratio_at_ride_height(tmp_path):
    found = campaign(tmp_path, curve())
    (pot,) = (c for c in found.channels if c.quantity == "travel")
    assert pot.per_wheel == pytest.approx(-0.6, rel=0.01)
    for phase, run in enumerate(found.runs):
        wheel = 0.04 * np.sin(np.linspace(0.0, 6 * np.pi, ROWS) + phase)
        travel = run.record[:, found.channels.index(pot)] / pot.per_wheel
        np.testing.assert_allclose(travel, wheel, atol=5e-4)
        assert np.abs(sensor(wheel) / -0.6 - wheel).max() > 5e-3


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (curve("wheel,sensor_mm"), 'column "wheel" is not known'),
        (curve(shown=np.abs(WHEEL_M)), "the sensor turns round"),
        (curve(wheel_m=WHEEL_M + 0.1, shown=sensor(WHEEL_M)), "must hold 0, ride height"),
        (curve(wheel_m=WHEEL_M[:2]), "2 points are too few"),
        (curve(wheel_m=WHEEL_M / 3), "mm beyond the curve"),
    ],
)
def test_a_curve_that_is_none_is_named(tmp_path, text, words):
    with pytest.raises(CampaignError, match=words):
        campaign(tmp_path, text)


def test_a_curve_goes_on_straight_for_a_tenth_of_its_length(tmp_path):
    short = WHEEL_M[(WHEEL_M > -0.04) & (WHEEL_M < 0.04)]
    found = campaign(tmp_path, curve(wheel_m=short), reach_m=0.034)
    assert np.abs(found.runs[0].record[:, 1] / found.channels[1].per_wheel).max() > 0.03
