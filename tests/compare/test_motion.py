"""Motions of the vehicle from the points that were measured."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.campaign import Channel
from wheelhop.compare.motion import MOTIONS, motion_matrix

ALL = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")


def matrix_of(points):
    channels = [Channel(p, p) for p in points]
    return motion_matrix(channels, np.ones(len(points), dtype=bool))


def determined(points):
    return {m for m, row in zip(MOTIONS, matrix_of(points), strict=True) if np.isfinite(row).all()}


@given(st.permutations(ALL))
def test_eight_points_in_any_order_turn_into_eight_orthonormal_motions(points):
    matrix = matrix_of(points)
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(8), atol=1e-12)


@pytest.mark.parametrize(
    ("motion", "at_points"),
    [
        ("heave", [1, 1, 1, 1, 0, 0, 0, 0]),
        ("pitch", [-1, -1, 1, 1, 0, 0, 0, 0]),  # nose down: the rear goes up
        ("roll", [1, -1, 1, -1, 0, 0, 0, 0]),  # right side down: the left goes up
        ("warp", [1, -1, -1, 1, 0, 0, 0, 0]),
        ("front hop", [0, 0, 0, 0, 1, 1, 0, 0]),
        ("front tramp", [0, 0, 0, 0, 1, -1, 0, 0]),
        ("rear hop", [0, 0, 0, 0, 0, 0, 1, 1]),
        ("rear tramp", [0, 0, 0, 0, 0, 0, 1, -1]),
    ],
)
def test_each_motion_is_found_and_no_other(motion, at_points):
    found = matrix_of(ALL) @ np.array(at_points, dtype=float)
    assert [m for m, value in zip(MOTIONS, found, strict=True) if abs(value) > 1e-12] == [motion]
    assert found[MOTIONS.index(motion)] > 0.0


def test_a_missing_body_point_leaves_heave_pitch_and_roll_of_a_rigid_body():
    assert determined(("B1", "B2", "B4")) == {"heave", "pitch", "roll"}
    # The body heaves by 3 and rolls by 2: the point that is missing changes nothing.
    body = {"B1": 5.0, "B2": 1.0, "B3": 5.0, "B4": 1.0}
    for points in (("B1", "B2", "B3", "B4"), ("B1", "B2", "B4"), ("B4", "B3", "B1")):
        found = matrix_of(points) @ np.array([body[p] for p in points])
        assert found[:3] == pytest.approx([6.0, 0.0, 4.0])


def test_two_points_determine_what_they_can():
    assert determined(("B1", "B2")) == {"roll"}
    assert determined(("B1", "B3")) == {"pitch"}
    assert determined(("B1",)) == set()
    assert determined(("A1", "A2", "A3")) == {"front hop", "front tramp"}


def test_other_places_take_no_part():
    channels = [Channel("dash", "body-xy", 0.3, 0.0), Channel("imu", "body"), Channel("A1", "A1")]
    assert np.isnan(motion_matrix(channels, np.ones(3, dtype=bool))).all()
