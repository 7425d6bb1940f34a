"""Wheels that average: means of paths, exact over kinks, ends and periods."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.work import array_bytes
from wheelhop.campaign import TrackSpec
from wheelhop.track import Wheel, make_track, wheel_envelope
from wheelhop.track.wheel import PathTables

LEFT, RADIUS = 0.59, 0.28
WASHBOARD = TrackSpec("washboard", {"amplitude_m": 0.015, "pitch_m": 0.4})  # has kinks
BUMP = TrackSpec("half-sine-bump", {"amplitude_m": 0.05, "length_m": 1.0, "side": "both"})
STEP = TrackSpec("step-bump", {"height_m": 0.05, "width_m": 0.3, "side": "both"})
ROAD = TrackSpec("iso8608", {"unevenness_m3": 1e-5, "waviness": 2.0, "seed": 3.0})
TRACKS = pytest.mark.parametrize("spec", [WASHBOARD, BUMP, STEP, ROAD], ids=lambda s: s.kind)
PLACES = np.linspace(-1.5, 3.5, 97)


def wheel(spec, radius=RADIUS):
    return Wheel(make_track(spec), LEFT, radius, -2.0, 4.0)


def mean(heights, x, length, points=4000):
    """By brute force: many places under the contact."""
    inside = length * ((np.arange(points) + 0.5) / points - 0.5)
    return np.array([heights(at + inside).mean() for at in x])


@TRACKS
@pytest.mark.parametrize("length", [0.003, 0.11, 0.4])
def test_the_average_is_the_mean_of_the_path(spec, length):
    rigid = Wheel(make_track(spec), LEFT, RADIUS, -3.0, 5.0).rigid()
    height, _ = wheel(spec).averaged(length).height_and_slope(PLACES)
    np.testing.assert_allclose(height, mean(rigid.height, PLACES, length), atol=2e-7)


@TRACKS
def test_a_footprint_averages_the_ground_itself(spec):
    track = make_track(spec)
    height, _ = wheel(spec).on_footprint(0.12).height_and_slope(PLACES)
    expected = mean(lambda x: track.elevation(x, LEFT), PLACES, 0.12)
    # A step's edge falls between two places of the brute force and two of the table.
    tolerance = 0.05 * 1e-3 / 0.12 if spec is STEP else 2e-6
    np.testing.assert_allclose(height, expected, atol=tolerance)


@pytest.mark.parametrize("spec", [WASHBOARD, BUMP], ids=lambda s: s.kind)
def test_a_wheel_over_averaged_ground_touches_it_but_never_enters(spec):
    length = 0.1
    track = make_track(spec)
    s = np.linspace(-0.999 * RADIUS, 0.999 * RADIUS, 1401)
    height, _ = wheel(spec).over_averaged_ground(length).height_and_slope(PLACES)
    for x, h in zip(PLACES[::8], height[::8], strict=True):
        under = mean(lambda at: track.elevation(at, LEFT), x + s, length, 200)
        clearance = h + RADIUS - np.sqrt(RADIUS**2 - s**2) - under
        assert -2e-6 < clearance.min() < 2e-5


@TRACKS
@pytest.mark.parametrize("kind", ["averaged", "on_footprint", "over_averaged_ground"])
def test_slope_is_the_derivative_of_the_height(spec, kind):
    path = getattr(wheel(spec), kind)(0.15)
    step = 1e-6
    ahead, _ = path.height_and_slope(PLACES + step)
    behind, _ = path.height_and_slope(PLACES - step)
    _, slope = path.height_and_slope(PLACES)
    np.testing.assert_allclose((ahead - behind) / (2 * step), slope, atol=2e-4)


@given(st.floats(0.01, 0.35), st.floats(0.0, 2.0))
def test_a_sine_on_a_footprint_shrinks_by_the_sinc_of_its_length(length, x):
    spec = TrackSpec("washboard", {"amplitude_m": 0.01, "pitch_m": 0.5})
    height, _ = wheel(spec).on_footprint(length).height_and_slope(x)
    expected = 0.01 * np.sinc(length / 0.5) * np.sin(2 * np.pi * x / 0.5)
    assert float(height) == pytest.approx(expected, abs=1e-8)


def test_far_from_the_origin_of_a_periodic_track_the_average_is_the_same():
    path = wheel(WASHBOARD).averaged(0.13)
    here, _ = path.height_and_slope(PLACES)
    there, _ = path.height_and_slope(PLACES + 0.4 * 5000)
    np.testing.assert_allclose(there, here, atol=1e-10)


def test_paths_kept_take_no_more_memory_than_they_may_and_the_last_asked_for_stay():
    one = make_track(ROAD)
    room = 3 * wheel_envelope(one, LEFT, RADIUS, 0.0, 2.0).nbytes
    tables = PathTables(room)
    paths = [tables(one, LEFT, RADIUS, 0.0, 2.0 + 0.01 * i) for i in range(10)]
    assert sum(path.nbytes for path in tables.kept()) <= room
    assert tables(one, LEFT, RADIUS, 0.0, 2.09) is paths[-1]
    assert tables(one, LEFT, RADIUS, 0.0, 2.0) is not paths[0]


def test_a_path_says_what_memory_its_table_takes():
    for spec in (ROAD, STEP):
        path = wheel_envelope(make_track(spec), LEFT, RADIUS, 0.0, 50.0)
        path.height_and_area(0.0)
        assert path.nbytes == array_bytes(path) > 10_000
