"""Laws of the suspension and the tyre, each against its closed form."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.simulate.setup import ATV, CHANNELS, EFFECTS
from wheelhop.effects.asymmetric_damper import one_sided_difference
from wheelhop.effects.digressive_damper import blow_off
from wheelhop.effects.dry_friction import creeping_slip, elastic_slip
from wheelhop.effects.progressive_spring import POLYTROPIC_EXPONENT, cubic, gas
from wheelhop.effects.tyre_lift_off import no_pull
from wheelhop.vehicle import baseline, static_load, static_tyre_load
from wheelhop.vehicle.layout import body_inertia


def force(law, x, v, *parameters):
    """Force of a law without memory."""
    value, memory = law(float(x), float(v), 0.0, 0.0, 7.0, np.array([*parameters, 0.0, 0.0]))
    assert memory == 7.0
    return value


def along(path, slip, joint):
    """Forces of the friction element along a path of extensions, starting at rest."""
    forces, memory = [], 0.0
    for before, now in pairwise(path):
        value, memory = elastic_slip(now, 0.0, now - before, 0.0, memory, np.array([slip, joint]))
        forces.append(value)
    return np.array(forces)


@given(st.floats(1.0, 200.0), st.floats(1e4, 1e7), st.floats(0.1, 50.0))
def test_dry_friction_loses_4_f_times_the_slipped_way_per_cycle(slip, joint, ratio):
    """Loop area of a Jenkins element at amplitude X: 4 F (X − F/k_p), nothing below F/k_p."""
    reach = slip / joint
    amplitude = ratio * reach
    angle = np.linspace(0.0, 4 * np.pi, 8001)
    path = amplitude * np.sin(angle)
    forces = along(path, slip, joint)
    second = slice(4000, None)
    # While it sticks the force is linear between the ends of a step, so the mean is exact.
    mean = 0.5 * (forces + np.concatenate([[0.0], forces[:-1]]))
    loss = float(np.sum(mean[second] * np.diff(path)[second]))
    expected = 4 * slip * max(amplitude - reach, 0.0)
    assert loss == pytest.approx(expected, abs=2e-3 * slip * amplitude)


@given(st.lists(st.floats(-0.05, 0.05), min_size=2, max_size=60), st.floats(0.0, 100.0))
def test_dry_friction_never_exceeds_its_slip_force(path, slip):
    assert np.abs(along(np.array([0.0, *path]), slip, 1e6)).max() <= slip


@given(st.floats(-0.01, 0.01), st.floats(-0.01, 0.01), st.integers(2, 40))
def test_dry_friction_does_not_depend_on_how_finely_a_way_is_cut(first, second, pieces):
    path = np.array([0.0, first, second])
    fine = np.concatenate(
        [np.linspace(0.0, first, pieces + 1), np.linspace(first, second, pieces + 1)[1:]]
    )
    one, other = along(path, 50.0, 2e4)[-1], along(fine, 50.0, 2e4)[-1]
    assert other == pytest.approx(one, abs=1e-8)


@given(st.floats(1e5, 1e7), st.floats(-0.1, 0.1))
def test_progressive_spring_cubic(rate, x):
    assert force(cubic, x, 0.3, rate) == pytest.approx(rate * x**3)
    assert force(cubic, -x, 0.3, rate) == -force(cubic, x, 0.3, rate)


@given(st.floats(200.0, 3000.0), st.floats(0.05, 0.6), st.floats(-0.6, 0.6))
def test_progressive_spring_air_is_a_polytropic_column_about_its_static_load(load, height, share):
    """Column length h + x at extension x: pressure force F₀ (1 + x/h)^−n; with the tangent n F₀/h
    that vehicle.toml's rate holds already, what carries the body is F₀ − n F₀ x/h − f."""
    n, x = POLYTROPIC_EXPONENT, share * height
    carried = load - n * load / height * x - force(gas, x, 0.0, load, 1 / height, n)
    assert carried * (height + x) ** n == pytest.approx(load * height**n)


@given(st.floats(200.0, 3000.0), st.floats(0.05, 0.6))
def test_progressive_spring_air_has_an_even_part_that_a_cubic_lacks(load, height):
    """To second order f = −F₀ n (n + 1)/2 (x/h)²: softer in rebound, stiffer in compression."""
    n, x = POLYTROPIC_EXPONENT, 1e-3 * height
    parameters = (load, 1 / height, n)
    even = 0.5 * (force(gas, x, 0.0, *parameters) + force(gas, -x, 0.0, *parameters))
    assert even == pytest.approx(-load * n * (n + 1) / 2 * 1e-6, rel=1e-4)
    slope = (force(gas, x, 0.0, *parameters) - force(gas, -x, 0.0, *parameters)) / (2 * x)
    assert abs(slope) < 1e-5 * n * load / height
    assert np.isfinite(force(gas, -3 * height, 0.0, *parameters))


def test_progressive_spring_whole_air_is_its_scale():
    """At the parameter's scale the strut is carried by gas alone: n F₀/h is the wheel rate."""
    front, rear = EFFECTS["progressive-spring"].with_choice("air").parameters_for(ATV, CHANNELS)
    for parameter, corner, end in ((front, 0, "front"), (rear, 2, "rear")):
        rate = POLYTROPIC_EXPONENT * static_load(ATV, corner) * parameter.scale
        assert rate == pytest.approx(ATV[f"suspension.{end}.stiffness_N_m"])


@given(st.floats(0.0, 1000.0), st.floats(-2.0, 2.0), st.floats(100.0, 3000.0))
def test_asymmetric_damper_adds_in_rebound_what_it_takes_in_compression(half, v, c):
    total = c * v + force(one_sided_difference, 0.01, v, half)
    assert total == pytest.approx((c + half) * v if v > 0 else (c - half) * v)


@given(st.floats(0.0, 1.0), st.floats(0.01, 0.6), st.floats(-2.0, 2.0))
def test_digressive_damper_knee(loss, knee, v):
    """Slope c up to the knee, c (1 − loss) beyond, continuous and odd."""
    c = 800.0
    total = c * v + force(blow_off, 0.0, v, loss * c, knee)
    beyond = max(abs(v) - knee, 0.0)
    expected = np.sign(v) * (c * (abs(v) - beyond) + c * (1 - loss) * beyond)
    assert total == pytest.approx(expected, abs=1e-9)
    assert force(blow_off, 0.0, -v, loss * c, knee) == -force(blow_off, 0.0, v, loss * c, knee)


@given(st.floats(-0.1, 0.1), st.floats(-3.0, 3.0), st.floats(100.0, 5000.0))
def test_tyre_lift_off_never_pulls(x, v, load):
    """The tyre's pull, static load included, is W at most; where it pushes nothing changes."""
    k, c = 4e4, 200.0
    linear = k * x + c * v
    total = linear + force(no_pull, x, v, k, c, load, 1.0)
    assert total <= load * (1 + 1e-12)
    assert total == pytest.approx(min(linear, load))


@given(st.floats(0.2, 1.3), st.floats(50.0, 2000.0))
def test_static_loads_carry_the_vehicle(ahead, mass):
    """Forces and moments about the centre of mass balance; the wheels' own weight is added."""
    values = ATV | {"geometry.cg_to_front_axle_m": ahead, "body.mass_kg": mass}
    assume(ahead < values["geometry.wheelbase_m"])
    struts = [static_load(values, i) for i in range(4)]
    behind = values["geometry.wheelbase_m"] - ahead
    assert sum(struts) == pytest.approx(mass * 9.80665)
    assert (struts[0] + struts[1]) * ahead == pytest.approx((struts[2] + struts[3]) * behind)
    assert struts[0] == struts[1] and struts[2] == struts[3]
    wheel = values["wheel.front.unsprung_mass_kg"] * 9.80665
    assert static_tyre_load(values, 0) == pytest.approx(struts[0] + wheel)


WHERE = {
    "dry-friction": ("", {"front_N": 11.0, "rear_N": 22.0, "presliding_N_m": 1e6}, (11.0, 22.0)),
    "progressive-spring": ("cubic", {"front_N_m3": 11.0, "rear_N_m3": 22.0}, (11.0, 22.0)),
    "asymmetric-damper": ("", {"front_N_s_m": 11.0, "rear_N_s_m": 22.0}, (11.0, 22.0)),
    "digressive-damper": (
        "",
        {"front_loss": 0.1, "rear_loss": 0.2, "knee_m_s": 0.3},
        (
            0.1 * ATV["suspension.front.damping_N_s_m"],
            0.2 * ATV["suspension.rear.damping_N_s_m"],
        ),
    ),
}


@pytest.mark.parametrize("name", WHERE)
def test_suspension_effects_sit_beside_each_strut(name):
    """Their port is body minus axle of every corner: rebound is positive."""
    choice, theta, (front, rear) = WHERE[name]
    effect = EFFECTS[name].with_choice(choice) if choice else EFFECTS[name]
    parts = baseline(ATV, CHANNELS, "road")
    effect.modify(theta, ATV, parts)
    system = parts.system(body_inertia(ATV))
    np.testing.assert_allclose(system.port, system.output[:4] - system.output[4:])
    assert not system.port_input.any()
    np.testing.assert_allclose(system.law_parameters[:, 0], [front, front, rear, rear])


def test_tyre_lift_off_sits_between_axle_and_ground():
    parts = baseline(ATV, CHANNELS, "road")
    EFFECTS["tyre-lift-off"].modify({"lifts": 1.0}, ATV, parts)
    system = parts.system(body_inertia(ATV))
    np.testing.assert_allclose(system.port, system.output[4:])
    np.testing.assert_allclose(system.port_input, -np.eye(4))


@given(st.floats(-0.5, 0.5), st.floats(5.0, 200.0), st.floats(0.002, 0.04))
def test_creeping_friction_is_a_damper_at_first_and_never_exceeds_its_force(v, slip, creep):
    """Odd, dissipative, of slope F/w at rest, and Coulomb's beyond a few w."""
    force, memory = creeping_slip(0.0, v, 0.0, 0.0, 0.3, np.array([slip, creep]))
    opposite = creeping_slip(0.0, -v, 0.0, 0.0, 0.3, np.array([slip, creep]))[0]
    assert memory == 0.3 and opposite == -force and force * v >= 0.0 and abs(force) <= slip
    slow = creeping_slip(0.0, 1e-3 * creep, 0.0, 0.0, 0.0, np.array([slip, creep]))[0]
    assert slow == pytest.approx(1e-3 * slip, rel=1e-5)
    if abs(v) > 4 * creep:
        assert abs(force) > 0.999 * slip
