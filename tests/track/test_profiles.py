"""The shapes a campaign can name: equations and sign conventions of the campaign format."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.campaign import TrackSpec
from wheelhop.track import Track, make_track

LEFT, RIGHT = 0.59, -0.59
WAVE = {"amplitude_m": 0.02, "pitch_m": 0.6}


def track(kind: str, **values: float | str) -> Track:
    return make_track(TrackSpec(kind, values))


PERIODIC = {
    "washboard": track("washboard", **WAVE),
    "one-sided-washboard": track("one-sided-washboard", **WAVE),
    "herringbone": track("herringbone", **WAVE, angle_rad=np.radians(20)),
    "chassis-twist": track("chassis-twist", **WAVE, width_m=4.0, lateral_offset_m=0.2),
}
FINITE = {
    "sine-sweep": track(
        "sine-sweep", amplitude_m=0.02, pitch_start_m=1.0, pitch_end_m=0.4, length_m=6.0
    ),
    "half-sine-bump": track("half-sine-bump", amplitude_m=0.05, length_m=0.5, side="both"),
    "step-bump": track("step-bump", height_m=0.04, width_m=0.3, side="both"),
}


def test_a_washboard_is_a_sine_the_same_left_and_right() -> None:
    quarter = [0.0, 0.15, 0.3, 0.45]
    for y in (LEFT, 0.0, RIGHT):
        z = PERIODIC["washboard"].elevation(quarter, y)
        np.testing.assert_allclose(z, [0.0, 0.02, 0.0, -0.02], atol=1e-15)


def test_a_one_sided_washboard_lies_under_the_left_wheels() -> None:
    one_sided = PERIODIC["one-sided-washboard"]
    assert one_sided.elevation(0.15, LEFT) == pytest.approx(0.02)
    assert one_sided.elevation(0.15, RIGHT) == 0.0


def test_on_a_herringbone_the_right_wheel_meets_each_crest_earlier() -> None:
    x = np.linspace(0.0, 0.6, 60001)
    herringbone = PERIODIC["herringbone"]
    left, right = (x[herringbone.elevation(x, y).argmax()] for y in (LEFT, RIGHT))
    lead = (LEFT - RIGHT) * np.tan(np.radians(20))
    assert (left - right) % 0.6 == pytest.approx(lead, abs=2e-5)


def test_a_chassis_twist_is_in_antiphase_at_its_edges_and_level_on_its_axis() -> None:
    twist = PERIODIC["chassis-twist"]
    crest = 0.15
    assert twist.elevation(crest, 2.0 - 0.2) == pytest.approx(0.02)
    assert twist.elevation(crest, -2.0 - 0.2) == pytest.approx(-0.02)
    assert twist.elevation(crest, -0.2) == pytest.approx(0.0)
    half = twist.elevation(crest, 0.5 * (1.8 - 0.2))
    assert half == pytest.approx(0.01)  # straight lines join the edges


@pytest.mark.parametrize("kind", PERIODIC)
@given(x=st.floats(-50.0, 50.0), y=st.floats(-1.0, 1.0), n=st.integers(-40, 40))
def test_periodic_tracks_repeat_both_ways(kind: str, x: float, y: float, n: int) -> None:
    ground = PERIODIC[kind]
    assert ground.period_m == pytest.approx(0.6)
    assert (ground.start_m, ground.end_m) == (-np.inf, np.inf)
    assert ground.elevation(x + 0.6 * n, y) == pytest.approx(ground.elevation(x, y), abs=1e-12)


def test_the_pitch_of_a_sine_sweep_changes_linearly_along_it() -> None:
    # Zero crossings are half a local pitch apart, the pitch taken where the half wave is.
    x = np.linspace(0.0, 6.0, 600_001)[1:-1]
    z = FINITE["sine-sweep"].elevation(x, LEFT)
    crossings = x[:-1][np.diff(np.sign(z)) != 0]
    middle = (crossings[1:] + crossings[:-1]) / 2
    expected = 1.0 + (0.4 - 1.0) * middle / 6.0
    np.testing.assert_allclose(2 * np.diff(crossings), expected, rtol=2e-3)
    assert np.abs(z).max() == pytest.approx(0.02, rel=1e-6)


def test_a_sweep_that_does_not_sweep_is_a_washboard() -> None:
    sweep = track("sine-sweep", amplitude_m=0.02, pitch_start_m=0.6, pitch_end_m=0.6, length_m=6.0)
    x = np.linspace(0.0, 6.0, 500)
    np.testing.assert_allclose(
        sweep.elevation(x, RIGHT), PERIODIC["washboard"].elevation(x, RIGHT), atol=1e-12
    )


def test_bumps_have_their_height_and_length() -> None:
    sine, step = FINITE["half-sine-bump"], FINITE["step-bump"]
    np.testing.assert_allclose(
        sine.elevation([0.0, 0.125, 0.25, 0.5], LEFT), [0, 0.05 * np.sqrt(0.5), 0.05, 0], atol=1e-15
    )
    np.testing.assert_allclose(
        step.elevation([-1e-9, 1e-9, 0.299, 0.301], LEFT), [0, 0.04, 0.04, 0]
    )
    assert step.edges_m == (0.0, 0.3)


@pytest.mark.parametrize("kind", FINITE)
@given(distance=st.floats(1e-6, 1e3), y=st.sampled_from([LEFT, RIGHT]))
def test_finite_tracks_are_flat_outside(kind: str, distance: float, y: float) -> None:
    ground = FINITE[kind]
    assert ground.start_m == 0.0
    assert ground.period_m is None
    outside = ground.elevation([-distance, ground.end_m + distance], y)
    np.testing.assert_allclose(outside, 0.0, atol=1e-15)


@pytest.mark.parametrize("kind", ["half-sine-bump", "step-bump"])
def test_a_bump_may_lie_on_one_side_only(kind: str) -> None:
    size = {"half-sine-bump": ("amplitude_m", "length_m"), "step-bump": ("height_m", "width_m")}
    values = dict(zip(size[kind], (0.05, 0.4), strict=True))
    for side, under, beside in (("left", LEFT, RIGHT), ("right", RIGHT, LEFT)):
        bump = track(kind, **values, side=side)
        assert bump.elevation(0.2, under) == pytest.approx(0.05)
        assert bump.elevation(0.2, beside) == 0.0


@pytest.mark.parametrize("ground", [*PERIODIC.values(), *FINITE.values(), track("flat")])
def test_x_and_y_broadcast(ground: Track) -> None:
    x, y = np.linspace(-1.0, 7.0, 50), np.array([LEFT, RIGHT])
    z = ground.elevation(x[:, None], y)
    assert z.shape == (50, 2)
    np.testing.assert_array_equal(z[:, 1], ground.elevation(x, RIGHT))


def test_an_unknown_track_has_no_shape() -> None:
    with pytest.raises(ValueError, match="no known shape"):
        make_track(TrackSpec("unknown", {}))
