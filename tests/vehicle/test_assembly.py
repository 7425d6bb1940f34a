"""The equations of motion: energies, reciprocity, rigid-body limits and frequencies by hand."""

from itertools import product
from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.truth import PRESETS
from tests.truth.closed_form import matrices
from wheelhop.campaign import Channel
from wheelhop.simulate import frequency_response
from wheelhop.vehicle import CORNERS, Assembly, Body, Coordinate, axle, baseline, between, ground
from wheelhop.vehicle.layout import body_inertia

POINTS = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")
CHANNELS = [Channel(name, name) for name in POINTS]
ATV = dict(PRESETS["atv"].vehicle)


@st.composite
def vehicles(draw):
    """Any plausible vehicle: each number of a preset times something between 1/2 and 2."""
    values = dict(PRESETS[draw(st.sampled_from(sorted(PRESETS)))].vehicle)
    for key, value in values.items():
        if key != "geometry.cg_to_front_axle_m":
            values[key] = value * draw(st.floats(0.5, 2.0))
    share = draw(st.floats(0.3, 0.7))
    values["geometry.cg_to_front_axle_m"] = share * values["geometry.wheelbase_m"]
    return values


def car(values, drive="road"):
    return baseline(values, CHANNELS, drive).system(body_inertia(values))


def displacement(system, frequency_hz):
    """Displacement of the outputs per prescribed motion, (c, m)."""
    omega = 2 * pi * frequency_hz
    return frequency_response(system, frequency_hz)[0] / -(omega**2)


@given(vehicles())
def test_the_matrices_are_those_written_by_hand(values):
    system = car(values)
    mass, damping, stiffness = matrices(values)
    np.testing.assert_allclose(system.mass, mass, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(system.damping, damping, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(system.stiffness, stiffness, rtol=1e-12, atol=1e-6)
    assert np.linalg.eigvalsh(system.mass).min() > 0
    assert np.linalg.eigvalsh(system.stiffness).min() > 0
    assert np.linalg.eigvalsh(system.damping).min() >= -1e-9 * np.abs(system.damping).max()


@given(vehicles(), st.lists(st.floats(-1.0, 1.0), min_size=7, max_size=7))
def test_energies_are_those_of_the_parts(values, motion):
    """Kinetic energy of a rigid body and four masses; springs by the stretch seen at their ends."""
    system, q = car(values), np.array(motion)
    z, theta, phi, wheels = q[0], q[1], q[2], q[3:]
    mass, pitch, roll = body_inertia(values)
    ahead = values["geometry.cg_to_front_axle_m"]
    behind, half = values["geometry.wheelbase_m"] - ahead, values["geometry.track_width_m"] / 2
    kinetic = 0.5 * (mass * z**2 + pitch * theta**2 + roll * phi**2)
    potential = 0.0
    for i, (x, y) in enumerate(product((ahead, -behind), (half, -half))):
        end = "front" if i < 2 else "rear"
        kinetic += 0.5 * values[f"wheel.{end}.unsprung_mass_kg"] * wheels[i] ** 2
        potential += 0.5 * values[f"wheel.{end}.tyre_stiffness_N_m"] * wheels[i] ** 2
        # Nose down (theta > 0) lowers what is ahead; left side up (phi > 0) raises the left.
        stretch = z - x * theta + y * phi - wheels[i]
        potential += 0.5 * values[f"suspension.{end}.stiffness_N_m"] * stretch**2
    assert 0.5 * q @ system.mass @ q == pytest.approx(kinetic)
    assert 0.5 * q @ system.stiffness @ q == pytest.approx(potential)


@given(vehicles(), st.floats(0.1, 50.0))
def test_force_here_moves_there_as_force_there_moves_here(values, frequency):
    """Reciprocity between body points and axles: outputs of displacement, applied forces."""
    parts = baseline(values, CHANNELS, "road")
    for channel in CHANNELS:
        node = axle(channel.corner) if channel.is_axle else _point(values, channel.corner)
        parts.add_force(((1.0, node),))
    system, omega = parts.system(body_inertia(values)), 2 * pi * frequency
    dynamic = system.stiffness - omega**2 * system.mass + 1j * omega * system.damping
    compliance = system.output @ np.linalg.solve(dynamic, system.force)
    np.testing.assert_allclose(compliance, compliance.T, rtol=1e-8)
    assert np.abs(compliance).min() > 0


def _point(values, corner):
    x = values["geometry.cg_to_front_axle_m"]
    half = values["geometry.track_width_m"] / 2
    return Body(
        x if corner < 2 else x - values["geometry.wheelbase_m"], half if corner % 2 == 0 else -half
    )


@given(vehicles(), st.sampled_from(["road", "axles"]))
def test_slow_motion_of_the_ground_carries_the_vehicle_along(values, drive):
    """At 0 Hz any plane displacement of the ground is followed; rows sum to 1 (errata 4)."""
    still = displacement(car(values, drive), 1e-4)
    seen = ~np.isnan(still).any(axis=1)
    assert seen.sum() == (8 if drive == "road" else 4)
    heave, pitch, roll = 0.013, 0.021, -0.034
    corners = [_point(values, i) for i in CORNERS]
    plane = np.array([heave - p.x_m * pitch + p.y_m * roll for p in corners])
    expected = np.concatenate([plane, plane])[seen]
    np.testing.assert_allclose(still[seen] @ plane, expected, rtol=1e-3, atol=1e-6)
    np.testing.assert_allclose(still[seen].sum(axis=1), 1.0, atol=1e-4)


def test_a_symmetric_vehicle_is_four_quarter_cars():
    """Heave, pitch, roll and warp decouple: each is a quarter car with its own sprung mass."""
    values = dict(ATV)
    values["geometry.cg_to_front_axle_m"] = values["geometry.wheelbase_m"] / 2
    for key in list(values):
        if ".rear." in key:
            values[key] = values[key.replace(".rear.", ".front.")]
        if "damping" in key:
            values[key] = 0.0
    half_base, half_track = values["geometry.wheelbase_m"] / 2, values["geometry.track_width_m"] / 2
    k = values["suspension.front.stiffness_N_m"]
    kt, mu = values["wheel.front.tyre_stiffness_N_m"], values["wheel.front.unsprung_mass_kg"]
    expected = [np.sqrt((k + kt) / mu)]  # warp: the body stays still
    mass, pitch, roll = body_inertia(values)
    for ms in (mass / 4, pitch / (4 * half_base**2), roll / (4 * half_track**2)):
        # ms mu w^4 - (ms (k + kt) + mu k) w^2 + k kt = 0
        total = ms * (k + kt) + mu * k
        root = np.sqrt(total**2 - 4 * ms * mu * k * kt)
        expected += [np.sqrt((total + sign * root) / (2 * ms * mu)) for sign in (1, -1)]
    poles = car(values).poles()
    found = np.sort(poles.imag[poles.imag > 0])
    np.testing.assert_allclose(found, np.sort(expected), rtol=1e-7)
    np.testing.assert_allclose(poles.real, 0.0, atol=1e-6)


def test_poles_of_one_damped_mass():
    m, f, zeta = 30.0, 3.0, 0.2
    parts = Assembly(prescribed=("ground 1",))
    mass = parts.add_coordinate("mass")
    omega = 2 * pi * f
    parts.add_mass(((1.0, mass),), m)
    parts.add_spring(between(mass, ground(0)), m * omega**2, 2 * zeta * m * omega)
    poles = parts.system((1.0, 1.0, 1.0)).poles()
    expected = omega * complex(-zeta, np.sqrt(1 - zeta**2))
    assert min(abs(poles - expected)) < 1e-6 * omega


@given(vehicles(), st.permutations(range(11)), st.floats(0.5, 30.0))
def test_parts_may_be_added_in_any_order(values, order, frequency):
    """A mode added last moves the points attached before it; coordinates may change places."""

    def build(sequence):
        parts = Assembly(prescribed=tuple(ground(i).name for i in CORNERS))

        def corner(i):
            parts.add_coordinate(axle(i).name)
            parts.add_mass(((1.0, axle(i)),), 14.0 + i)
            parts.add_spring(between(axle(i), ground(i)), 4e4, 200.0)

        def strut(i):
            parts.add_spring(between(_point(values, i), axle(i)), 9e3 + 100 * i, 600.0)

        def twist():
            parts.add_body_mode("twist", lambda x, y: x * y)
            parts.add_mass(((1.0, Coordinate("twist")),), 40.0)
            parts.add_spring(((1.0, Coordinate("twist")),), 3e5, 100.0)

        def seat():
            parts.add_coordinate("driver")
            parts.add_mass(((1.0, Coordinate("driver")),), 70.0)
            parts.add_spring(between(Coordinate("driver"), Body(-0.1, 0.2)), 2e4, 500.0)

        def bar():
            left, right = between(_point(values, 0), axle(0)), between(_point(values, 1), axle(1))
            parts.add_spring((*left, *((-c, node) for c, node in right)), 5e3)

        steps = [lambda i=i: corner(i) for i in CORNERS] + [lambda i=i: strut(i) for i in CORNERS]
        steps += [twist, seat, bar]
        for i in sequence:
            steps[i]()
        for i in CORNERS:
            parts.add_output(((1.0, _point(values, i)),))
        return parts.system(body_inertia(values))

    straight, shuffled = (build(s) for s in (range(11), order))
    one, other = (displacement(s, frequency) for s in (straight, shuffled))
    np.testing.assert_allclose(other, one, rtol=1e-7, atol=1e-12)
    np.testing.assert_allclose(
        np.sort(abs(shuffled.poles())), np.sort(abs(straight.poles())), rtol=1e-6
    )


def test_a_body_mode_moves_the_points_attached_to_the_body():
    """A stiff mode leaves the rigid car; a soft light one lets the corners move against it."""
    frequency = 6.0

    def with_mode(stiffness):
        parts = baseline(ATV, CHANNELS, "road")
        twist = parts.add_body_mode("twist", lambda x, y: np.sign(x * y))
        parts.add_mass(((1.0, twist),), 1.0)
        parts.add_spring(((1.0, twist),), stiffness)
        return displacement(parts.system(body_inertia(ATV)), frequency)

    rigid = displacement(car(ATV), frequency)
    np.testing.assert_allclose(with_mode(1e12), rigid, atol=1e-6)
    warp = np.array([1.0, -1.0, -1.0, 1.0])
    loose = with_mode(1e-3)
    # With nothing to hold it the mode follows the warp of the axles, nearly all of it.
    assert abs(warp @ loose[:4] @ warp) > 10 * abs(warp @ rigid[:4] @ warp)


def test_what_is_not_predicted_is_nan():
    system = car(ATV, "axles")
    assert np.isnan(system.output).all(axis=1).tolist() == [False] * 4 + [True] * 4
