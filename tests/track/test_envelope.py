"""The path of a rigid wheel's centre, against the contact equation, geometry and brute force."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from wheelhop.campaign import TrackSpec
from wheelhop.track import CannotClimb, Track, make_track, wheel_envelope
from wheelhop.track.table import highest
from wheelhop.track.track import Array

RADIUS = 0.279
LEFT = 0.59


def track(kind: str, **values: float | str) -> Track:
    return make_track(TrackSpec(kind, values))


def washboard(amplitude_m: float, pitch_m: float) -> Track:
    return track("washboard", amplitude_m=amplitude_m, pitch_m=pitch_m)


def height_by_brute_force(ground: Track, radius: float, x: Array, y: float = LEFT) -> Array:
    """The largest z + disc among 20001 offsets, then among 2001 about the best; error ~1e-12 m.

    Points either side of the track's edges are among the offsets.
    """
    best = np.empty(len(x))
    for i, centre in enumerate(x):
        edges = [edge + side - centre for edge in ground.edges_m for side in (-1e-9, 0.0, 1e-9)]
        s = np.linspace(-radius, radius, 20001)
        s = np.sort(np.append(s, [e for e in edges if abs(e) < radius]))
        for _ in range(2):
            lift = ground.elevation(centre + s, y) + np.sqrt(np.maximum(radius**2 - s**2, 0))
            top = int(lift.argmax())
            best[i] = lift[top] - radius
            if s[top] in edges:
                break
            s = np.linspace(s[max(top - 1, 0)], s[min(top + 1, len(s) - 1)], 2001)
    return best


@pytest.mark.parametrize(
    ("amplitude", "pitch"), [(0.015, 0.6), (0.025, 0.8), (0.02, 0.5), (0.012, 0.4)]
)
def test_it_follows_the_contact_equation_where_the_wheel_fits(
    amplitude: float, pitch: float
) -> None:
    # Thesis 4.5 and 4.6, corrected: θ̇ = y″ cos²θ ẋ with ẋ the contact point's speed, and the
    # centre is at x - R sin θ, y + R cos θ, so that per metre of the centre's way X
    # dx/dX = 1/(1 - R cos³θ y″) and dθ/dX = y″ cos²θ dx/dX.
    k = 2 * np.pi / pitch
    assert RADIUS * amplitude * k**2 < 1

    def rate(_: float, state: Array) -> list[float]:
        x, theta = state
        bend = -amplitude * k**2 * np.sin(k * x)
        way = 1 / (1 - RADIUS * np.cos(theta) ** 3 * bend)
        return [way, bend * np.cos(theta) ** 2 * way]

    theta = np.arctan(amplitude * k)
    start = -RADIUS * np.sin(theta)
    centre = start + np.linspace(0, 2 * pitch, 997)
    rolled = solve_ivp(
        rate, (start, centre[-1]), [0.0, theta], "DOP853", centre, rtol=1e-11, atol=1e-12
    )
    contact, tilt = rolled.y
    height = amplitude * np.sin(k * contact) + RADIUS * np.cos(tilt) - RADIUS
    envelope = wheel_envelope(washboard(amplitude, pitch), LEFT, RADIUS, -10.0, 10.0)
    assert np.abs(envelope.height(centre) - height).max() < 1e-6
    if RADIUS * amplitude * k**2 < 0.6:
        assert np.abs(envelope.slope(centre) - np.tan(tilt)).max() < 1e-5


@pytest.mark.parametrize(
    ("amplitude", "pitch", "radius"),
    [
        (0.015, 0.4, RADIUS),
        (0.015, 0.4, 0.35),
        (0.03, 0.3, 0.2),
        (0.03, 0.301, 0.2),
        (0.01392036, 0.5, 0.5),
    ],
)
def test_in_a_trough_too_narrow_it_rests_on_two_points(
    amplitude: float, pitch: float, radius: float
) -> None:
    # Over the lowest point, at 3L/4, the two contacts lie symmetrically, at ±s, where the disc is
    # as steep as the profile; a kink of twice that slope lies between them.
    k = 2 * np.pi / pitch
    assert radius * amplitude * k**2 > 1

    def mismatch(s: float) -> float:
        return float(amplitude * k * np.sin(k * s) - s / np.sqrt(radius**2 - s**2))

    s = brentq(mismatch, 1e-3 * pitch, 0.45 * pitch, xtol=1e-14)
    height = -amplitude * np.cos(k * s) + np.sqrt(radius**2 - s**2) - radius
    steep = s / np.sqrt(radius**2 - s**2)
    envelope = wheel_envelope(washboard(amplitude, pitch), LEFT, radius, -10.0, 10.0)
    trough = 0.75 * pitch
    assert abs(envelope.height(trough) - height) < 1e-6
    assert abs(envelope.height(trough) + amplitude) > 1e-5  # it does not reach the bottom
    beside = envelope.slope([trough - 2e-5, trough + 2e-5])
    assert beside == pytest.approx([-steep, steep], abs=4e-3)
    x = trough + np.linspace(-0.002, 0.002, 401)
    climb = np.abs(np.diff(envelope.height(x)))  # no jump, only a bend
    assert climb.max() < 1.1 * np.abs(envelope.slope(x)).max() * 1e-5 + 1e-7
    assert np.abs(
        envelope.height(x) - height_by_brute_force(washboard(amplitude, pitch), radius, x)
    ).max() < 1e-6  # fmt: skip


def test_over_a_step_the_centre_turns_about_the_edges() -> None:
    high, wide = 0.05, 0.333
    step = track("step-bump", height_m=high, width_m=wide, side="both")
    envelope = wheel_envelope(step, LEFT, RADIUS, -2.0, 2.0)
    reach = np.sqrt(RADIUS**2 - (RADIUS - high) ** 2)  # the edge is touched before it is under us
    d = np.linspace(0, reach, 400)
    arc = high + np.sqrt(RADIUS**2 - d**2) - RADIUS
    np.testing.assert_allclose(envelope.height(-d), arc, atol=1e-7)
    np.testing.assert_allclose(envelope.height(wide + d), arc, atol=1e-7)
    np.testing.assert_allclose(envelope.height(np.linspace(0, wide, 50)), high, atol=1e-9)
    np.testing.assert_allclose(envelope.height([-2.0, -reach - 1e-3, wide + reach + 1e-3]), 0)
    before = -0.9 * reach
    expected = -before / np.sqrt(RADIUS**2 - before**2)
    assert envelope.slope(before) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    "ground",
    [
        track("chassis-twist", amplitude_m=0.15, pitch_m=3.0, width_m=4.0, lateral_offset_m=0.1),
        track("herringbone", amplitude_m=0.02, pitch_m=0.5, angle_rad=0.35),
        track("sine-sweep", amplitude_m=0.02, pitch_start_m=0.8, pitch_end_m=0.35, length_m=3.2),
        track("half-sine-bump", amplitude_m=0.06, length_m=0.4, side="both"),
        track("iso8608", unevenness_m3=256e-6, waviness=2.0, seed=7.0),
    ],
    ids=lambda ground: type(ground).__name__,
)
def test_every_shape_agrees_with_brute_force(ground: Track) -> None:
    x = np.linspace(-0.5, 4.0, 331)
    envelope = wheel_envelope(ground, LEFT, RADIUS, -1.0, 5.0)
    assert np.abs(envelope.height(x) - height_by_brute_force(ground, RADIUS, x)).max() < 1e-6


radii = st.floats(0.1, 0.5)
waves = st.tuples(st.floats(0.001, 0.04), st.floats(0.25, 3.0))
places = st.floats(-20.0, 20.0)


@given(waves, radii, places)
@example((0.033203125, 0.6026388655607036), 0.2734375, 0.0)
def test_the_wheel_never_sinks_below_the_profile_and_its_slope_is_its_height_s(
    wave: tuple[float, float], radius: float, x: float
) -> None:
    ground = washboard(*wave)
    envelope = wheel_envelope(ground, LEFT, radius, -20.0, 20.0)
    across = x + np.linspace(0.0, wave[1], 301)
    height = envelope.height(across)
    # A trough just as tight as the wheel is touched at many places at once.
    tight = abs(radius * wave[0] * (2 * np.pi / wave[1]) ** 2 - 1.0) < 0.1
    assert (height >= ground.elevation(across, LEFT) - (1e-5 if tight else 1e-6)).all()
    assert (height <= wave[0] + 1e-9).all()
    fine = x + np.linspace(0.0, wave[1], 4001)
    slope = envelope.slope(fine)
    climbed = np.sum((slope[1:] + slope[:-1]) / 2 * np.diff(fine)[0])
    rise = envelope.height(fine[-1]) - envelope.height(fine[0])
    kinks = np.abs(np.diff(slope)).sum() * np.diff(fine)[0]  # bounds what the sum misses
    assert abs(climbed - rise) < 1e-6 + kinks


@given(waves, radii, st.floats(1.01, 1.5), places)
def test_a_larger_wheel_never_runs_lower(
    wave: tuple[float, float], radius: float, larger: float, x: float
) -> None:
    # √(R² - s²) - R grows with R for every s, and so does the range of s.
    ground, across = washboard(*wave), x + np.linspace(0.0, wave[1], 301)
    small = wheel_envelope(ground, LEFT, radius, -20.0, 20.0).height(across)
    large = wheel_envelope(ground, LEFT, larger * radius, -20.0, 20.0).height(across)
    assert (large >= small - 3e-6).all()


@given(waves, st.floats(1.01, 2.0), radii)
def test_a_higher_bump_is_never_run_over_lower(
    wave: tuple[float, float], factor: float, radius: float
) -> None:
    x = np.linspace(-1.0, 4.0, 501)
    low, high = (
        wheel_envelope(
            track("half-sine-bump", amplitude_m=a, length_m=wave[1], side="both"),
            LEFT,
            radius,
            -1.0,
            4.0,
        ).height(x)
        for a in (wave[0], factor * wave[0])
    )
    assert (high >= low - 3e-6).all()


@given(waves, radii, st.floats(-3.0, 3.0))
def test_a_shifted_track_has_the_shifted_envelope(
    wave: tuple[float, float], radius: float, y: float
) -> None:
    # A herringbone is a washboard shifted by y tan(angle).
    straight = wheel_envelope(washboard(*wave), y, radius, -20.0, 20.0)
    oblique = wheel_envelope(
        track("herringbone", amplitude_m=wave[0], pitch_m=wave[1], angle_rad=0.35),
        y,
        radius,
        -20.0,
        20.0,
    )
    x = np.linspace(-1.0, 1.0, 301)
    # In a trough as tight as the wheel two contacts become one.
    tightness = radius * wave[0] * (2 * np.pi / wave[1]) ** 2
    good_to = 2e-5 if abs(tightness - 1) < 0.05 else 2e-6
    assert np.abs(oblique.height(x) - straight.height(x - y * np.tan(0.35))).max() < good_to


def test_flat_ground_leaves_the_wheel_where_it_is() -> None:
    envelope = wheel_envelope(track("flat"), LEFT, RADIUS, -5.0, 60.0)
    x = np.linspace(-5.0, 60.0, 100)
    assert np.all(envelope.height(x) == 0)
    assert np.all(envelope.slope(x) == 0)


def test_a_periodic_track_is_known_everywhere_and_its_table_is_one_period() -> None:
    envelope = wheel_envelope(washboard(0.015, 0.4), LEFT, RADIUS, 0.0, 100.0)
    x = np.linspace(0.0, 0.4, 1001)
    for periods in (-2500, 1, 2500):
        np.testing.assert_allclose(
            envelope.height(x + 0.4 * periods), envelope.height(x), atol=1e-9
        )


def test_a_range_shorter_than_the_period_gives_the_same_envelope() -> None:
    ground = washboard(0.15, 3.0)
    whole = wheel_envelope(ground, LEFT, RADIUS, 0.0, 50.0)
    part = wheel_envelope(ground, LEFT, RADIUS, 1.0, 2.0)
    x = np.linspace(1.0, 2.0, 500)
    np.testing.assert_allclose(part.height(x), whole.height(x), atol=1e-8)
    with pytest.raises(ValueError, match="leaves the tabulated envelope"):
        part.height([1.5, 2.001])


def test_a_finite_track_is_flat_beyond_its_ends_as_far_as_asked() -> None:
    bump = track("half-sine-bump", amplitude_m=0.05, length_m=0.5, side="both")
    envelope = wheel_envelope(bump, LEFT, RADIUS, -500.0, 500.0)
    np.testing.assert_allclose(envelope.height([-499.0, -0.5, 1.0, 499.0]), 0.0, atol=1e-12)
    away = wheel_envelope(bump, LEFT, RADIUS, 100.0, 200.0)
    np.testing.assert_allclose(away.height([100.0, 200.0]), 0.0, atol=1e-12)


def test_a_rigid_wheel_cannot_climb_a_step_as_high_as_its_radius() -> None:
    wall = track("step-bump", height_m=0.3, width_m=1.0, side="both")
    with pytest.raises(CannotClimb, match="too high for a wheel"):
        wheel_envelope(wall, LEFT, RADIUS, -2.0, 2.0)


def test_any_shape_of_x_is_kept() -> None:
    envelope = wheel_envelope(washboard(0.015, 0.6), LEFT, RADIUS, 0.0, 10.0)
    assert envelope.height(np.zeros((3, 4, 2))).shape == (3, 4, 2)
    assert np.shape(envelope.slope(0.3)) == ()


@given(
    st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=80),
    st.integers(1, 12),
    st.floats(0.1, 10.0),
)
def test_halving_finds_what_a_search_of_every_place_finds(z, reach, bend):
    disc = -bend * (np.arange(-reach, reach + 1) / reach) ** 2
    z = np.array([*z, *np.zeros(2 * reach)])
    count = len(z) - 2 * reach
    sums = np.array([z[i : i + len(disc)] + disc for i in range(count)])
    found = highest(z, disc, count)
    assert sums[np.arange(count), found] == pytest.approx(sums.max(axis=1), abs=1e-12)


def test_a_place_that_is_no_number_has_no_height():
    """A fit that runs away asks for it."""
    envelope = wheel_envelope(washboard(0.015, 0.4), LEFT, RADIUS, 0.0, 50.0)
    height, slope = envelope.height_and_slope([np.nan, 1.0])
    assert np.isnan([height[0], slope[0]]).all() and np.isfinite([height[1], slope[1]]).all()


def test_both_at_once_are_what_each_is_alone():
    """On the washboard with a kink in every trough."""
    track = make_track(TrackSpec("washboard", {"amplitude_m": 0.015, "pitch_m": 0.4}))
    envelope = wheel_envelope(track, 0.0, 0.279, 0.0, 10.0)
    x = np.linspace(-3.0, 3.0, 4001)
    height, slope = envelope.height_and_slope(x)
    np.testing.assert_allclose(height, envelope.height(x), atol=1e-12)
    np.testing.assert_allclose(slope, envelope.slope(x), atol=1e-9)


@pytest.mark.parametrize("pitch", [0.6, 0.6005, 0.4, 0.81])
def test_the_bottom_of_a_trough_too_narrow_for_the_wheel_is_a_kink(pitch: float) -> None:
    """There the contact jumps from one flank to the other, whether or not that is where one of the
    table's cells ends and the next begins: with s the offset of the flank touched, the slope goes
    from -s/sqrt(R² - s²) to s/sqrt(R² - s²)."""
    k = 2 * np.pi / pitch
    amplitude = 2.0 / (RADIUS * k**2)
    flank = brentq(
        lambda s: amplitude * k * np.sin(k * s) - s / np.sqrt(RADIUS**2 - s**2), 1e-3, 0.25
    )
    envelope = wheel_envelope(washboard(amplitude, pitch), LEFT, RADIUS, -10.0, 10.0)
    jump = 2 * flank / np.sqrt(RADIUS**2 - flank**2)
    assert envelope.sharpest_kink == pytest.approx(jump, rel=0.02)


def test_a_trough_that_holds_the_wheel_has_no_kink() -> None:
    amplitude = 0.5 / (RADIUS * (2 * np.pi / 0.6) ** 2)
    envelope = wheel_envelope(washboard(amplitude, 0.6), LEFT, RADIUS, -10.0, 10.0)
    assert envelope.sharpest_kink < 1e-3
