"""Pavements of stones, and wheels that are as wide as they are."""

import numpy as np
import pytest

from wheelhop.campaign import CampaignError, TrackSpec
from wheelhop.campaign.tracks import read_track
from wheelhop.files import Table
from wheelhop.track import Wheel, make_track

STONES = {
    "height_m": 0.01,
    "seed": 3.0,
    "stone_length_m": 0.15,
    "stone_width_m": 0.12,
    "joint_m": 0.01,
    "joint_depth_m": 0.015,
}
ANGLE = np.radians(35.0)
OBLIQUE = TrackSpec("herringbone", {"amplitude_m": 0.01, "pitch_m": 0.3, "angle_rad": ANGLE})
PLACES = np.linspace(-0.4, 0.4, 33)


def pavement(**changes):
    return make_track(TrackSpec("cobblestone", STONES | changes))


def test_stones_have_the_height_asked_for_and_joints_between_them():
    ground = pavement()
    x = (np.arange(128) + 0.5) * 0.15
    middles = np.stack(
        [
            ground.elevation(x, (column + 0.5 + 0.5 * (np.arange(128) % 2)) * 0.12)
            for column in range(64)
        ]
    )
    assert np.sqrt(np.mean(middles**2)) == pytest.approx(0.01, rel=1e-9)
    assert abs(middles.mean()) < 1e-9
    joints = ground.elevation(np.arange(20) * 0.15, 0.06)
    np.testing.assert_allclose(joints, -0.015, atol=1e-12)


def test_a_pavement_repeats_and_is_that_of_its_seed():
    ground = pavement()
    x = np.linspace(0.0, 3.0, 500)
    np.testing.assert_allclose(
        ground.elevation(x + ground.period_m, 0.31), ground.elevation(x, 0.31), atol=1e-9
    )
    assert np.array_equal(ground.elevation(x, 0.31), pavement().elevation(x, 0.31))
    assert np.abs(ground.elevation(x, 0.31) - pavement(seed=4.0).elevation(x, 0.31)).max() > 0.005


def test_no_cliffs():
    """Nowhere, along or across, does the height jump."""
    ground = pavement()
    fine = np.linspace(-0.5, 0.5, 200001)
    for z in (ground.elevation(fine, 0.17), ground.elevation(0.04, fine)):
        assert np.abs(np.diff(z)).max() < 3e-5


@pytest.mark.parametrize("width", [0.05, 0.18, 0.4])
def test_a_wide_wheel_weakens_an_oblique_wave_by_the_sinc_of_its_width(width):
    """∫ sin(k(x − y tan α)) dy/w over a width w is the wave times sin(u)/u, u = k w tan α / 2."""
    wheel = Wheel(make_track(OBLIQUE), 0.0, 0.0, -1.0, 1.0, width)
    half = np.pi * width * np.tan(ANGLE) / 0.3
    expected = 0.01 * np.sin(2 * np.pi * PLACES / 0.3) * np.sin(half) / half
    np.testing.assert_allclose(wheel.rigid().height(PLACES), expected, atol=2e-6)


def test_a_footprint_has_two_dimensions():
    """Averaged along ℓ and across w, the same wave is weakened by both sincs."""
    length, width = 0.1, 0.15
    wheel = Wheel(make_track(OBLIQUE), 0.0, 0.3, -1.0, 1.0, width)
    along, across = np.pi * length / 0.3, np.pi * width * np.tan(ANGLE) / 0.3
    weaker = np.sin(along) / along * np.sin(across) / across
    found, _ = wheel.on_footprint(length).height_and_slope(PLACES)
    expected = 0.01 * np.sin(2 * np.pi * PLACES / 0.3) * weaker
    np.testing.assert_allclose(found, expected, atol=3e-6)


def test_across_a_washboard_a_wide_wheel_is_a_narrow_one():
    spec = TrackSpec("washboard", {"amplitude_m": 0.015, "pitch_m": 0.4})
    disc, wide = (Wheel(make_track(spec), 0.5, 0.3, -1, 1, width).rigid() for width in (0.0, 0.2))
    np.testing.assert_allclose(wide.height(PLACES), disc.height(PLACES), atol=1e-12)


def test_a_wide_wheel_over_stones_is_the_mean_across():
    ground = pavement()
    across = 0.59 + 0.2 * ((np.arange(4000) + 0.5) / 4000 - 0.5)
    expected = [ground.elevation(x, across).mean() for x in PLACES]
    found = Wheel(ground, 0.59, 0.0, -1.0, 1.0, 0.2).rigid().height(PLACES)
    np.testing.assert_allclose(found, expected, atol=3e-4)


@pytest.mark.parametrize(
    ("keys", "said"),
    [({"height_mm": 5.0}, "seed"), ({"height_mm": 0.0, "seed": 1}, "must be greater than 0")],
)
def test_what_is_no_pavement_is_a_line(keys, said, tmp_path):
    table = Table({"track": {"kind": "cobblestone", **keys}}, tmp_path / "c", kind=CampaignError)
    with pytest.raises(CampaignError, match=said):
        read_track(table, tmp_path)
