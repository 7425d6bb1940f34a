"""Ground inputs over time, as the thesis draws them (figures 4.14, 4.17 and after)."""

import numpy as np
import pytest

from wheelhop.campaign import CampaignError
from wheelhop.cli.main import main
from wheelhop.predict import read_drives
from wheelhop.report.road import WHEELS, RoadWheels, ground_inputs


def of(track, speed):
    (drive,) = read_drives([track], [speed])
    return ground_inputs(drive, WHEELS)


def test_a_washboard_comes_at_speed_over_pitch_and_to_the_rear_a_wheelbase_later():
    time_s, ground, centres = of("washboard/low", 7.5)
    crests = time_s[1:-1][(np.diff(np.sign(np.diff(ground[:, 0]))) < 0)]
    assert len(crests) == 20  # on 8 m
    assert np.diff(crests) == pytest.approx(0.4 / (7.5 / 3.6), abs=0.005)
    late = round(WHEELS.wheelbase_m / (7.5 / 3.6) * 500)
    assert centres[late:, 2] == pytest.approx(centres[:-late, 0], abs=2e-4)
    # A crest lifts the wheel by all of it; into a trough of 400 mm a 22-inch wheel does not reach.
    assert centres[:, 0].max() == pytest.approx(0.015, abs=1e-4)
    assert -0.015 < centres[:, 0].min() < -0.01


def test_a_herringbone_meets_the_right_wheel_earlier_and_a_one_sided_one_the_left_alone():
    _, ground, _ = of("herringbone/low", 9.0)
    early = round(WHEELS.apart_m * np.tan(np.radians(20.0)) / 2.5 * 500)
    assert ground[:-early, 1] == pytest.approx(ground[early:, 0], abs=2e-4)
    _, _, centres = of("one-sided-washboard/low", 7.0)
    assert np.ptp(centres[:, 0]) > 0.02 and not centres[:, 1].any()


def test_the_command_draws_any_track_and_refuses_what_has_no_speed(tmp_path, capsys):
    file = tmp_path / "ground.png"
    time_s, ground, _ = of("step-bump/thesis", 15.0)
    assert time_s[np.argmax(ground[:, 0] > 0)] == pytest.approx(1.0 / (15.0 / 3.6), abs=0.003)
    assert main(["road", "step-bump/thesis", "--plot", str(file)]) == 0
    assert file.read_bytes().startswith(b"\x89PNG")
    assert main(["road", "washboard/low", "--plot", str(file), "--speed", "0"]) == 2
    assert "must be above 0 km/h" in capsys.readouterr().err
    with pytest.raises(CampaignError, match="full car"):
        RoadWheels.of({"wheel.front.radius_m": 0.3})
