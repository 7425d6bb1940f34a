"""Linear laws of the suspension, bushings, bars and unlike corners, against their closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.simulate.setup import ATV, CHANNELS, EFFECTS
from wheelhop.effects.mount_bushing import in_series, relaxing
from wheelhop.material import Elements
from wheelhop.material.series import in_series as on_elements
from wheelhop.vehicle import baseline
from wheelhop.vehicle.layout import body_inertia

K, C = 10_000.0, 600.0


def system_of(effect, theta, vehicle=ATV):
    parts = baseline(vehicle, CHANNELS, "road")
    effect.modify(theta, vehicle, parts)
    return parts.system(body_inertia(vehicle))


PLAIN = baseline(ATV, CHANNELS, "road").system(body_inertia(ATV))


def mounted(compliance, tau, frequency, step, cycles=12):
    """Dynamic stiffness of strut and mount in series at a frequency, from the last two cycles of
    a harmonic motion."""
    omega = 2 * np.pi * frequency
    time = np.arange(0.0, cycles / frequency, step)
    path, rate = np.cos(omega * time), -omega * np.sin(omega * time)
    force, memory = np.zeros(len(time)), 0.0
    parameters = np.array([compliance, tau, K, C, 0.0, 0.0])
    for i in range(1, len(time)):
        added, memory = in_series(path[i], rate[i], path[i] - path[i - 1], step, memory, parameters)
        force[i] = K * path[i] + C * rate[i] + added
    last = time > (cycles - 2) / frequency
    basis = np.column_stack([np.cos(omega * time), -np.sin(omega * time)])[last]
    real, imaginary = np.linalg.lstsq(basis, force[last], rcond=None)[0]
    return complex(real, imaginary)


@pytest.mark.parametrize("frequency", [1.0, 6.0, 25.0])
@pytest.mark.parametrize("tau", [1e-4, 0.005, 0.05])
@pytest.mark.parametrize("compliance", [1e-7, 2e-5, 1e-3])
def test_a_mount_in_series_adds_its_compliance_to_the_struts(frequency, tau, compliance):
    """1/Z = 1/(k + iωc) + s/(1 + iωτ), at the integrator's step."""
    omega = 2j * np.pi * frequency
    expected = 1.0 / (1.0 / (K + omega * C) + compliance / (1.0 + omega * tau))
    found = mounted(compliance, tau, frequency, 0.00125)
    assert abs(found - expected) < 2e-3 * abs(expected)


@given(st.floats(-0.1, 0.1), st.floats(-2.0, 2.0), st.floats(1e-4, 0.2))
def test_a_rigid_mount_is_no_effect(x, v, tau):
    force, memory = in_series(x, v, 0.01, 0.002, 0.0, np.array([0.0, tau, K, C, 0.0, 0.0]))
    assert force == 0.0 and memory == 0.0


@given(st.floats(1e-9, 1.0), st.floats(1e-4, 0.2), st.floats(1e-5, 1.0))
def test_a_mount_is_stable_for_any_stiffness_and_step(compliance, tau, step):
    """Held at an extension, spring and mount share it in the end: f = −k x · s k / (1 + s k)."""
    parameters = np.array([compliance, tau, K, C, 0.0, 0.0])
    x, memory, forces = 0.01, 0.0, []
    for _ in range(4000):
        force, memory = in_series(x, 0.0, 0.0, step, memory, parameters)
        forces.append(force)
    assert np.abs(forces).max() < 1e3 * K * x
    settled = 4000 * step > 20 * (tau + compliance * C) / (1 + compliance * K)
    share = compliance * K / (1 + compliance * K)
    if settled:
        assert forces[-1] == pytest.approx(-K * x * share, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("end", ["front", "rear"])
def test_an_anti_roll_bar_is_a_roll_stiffness_without_heave_or_pitch(end):
    """Body rolled by φ about its x axis, wheels on the ground: the travels differ by t φ, the bar
    takes ½ k (t φ)²."""
    theta = {"front_N_m": 0.0, "rear_N_m": 0.0, f"{end}_N_m": 800.0}
    added = system_of(EFFECTS["anti-roll-bar"], theta).stiffness - PLAIN.stiffness
    body = added[:3, :3]
    expected = np.zeros((3, 3))
    expected[2, 2] = 800.0 * ATV["geometry.track_width_m"] ** 2
    np.testing.assert_allclose(body, expected, atol=1e-6)
    assert np.linalg.matrix_rank(added, tol=1e-6) == 1  # one spring
    wheels = slice(3, 5) if end == "front" else slice(5, 7)
    np.testing.assert_allclose(added[wheels, wheels], [[800.0, -800.0], [-800.0, 800.0]])


@given(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6))
def test_one_corner_changed_is_a_left_right_difference_about_another_mean(spring, damper):
    """k and c of the rear left strut times (1 + δ): the means grow by δ/2, and the excess of the
    left one over them is δ / (2 + δ)."""
    means = dict(ATV)
    means["suspension.rear.stiffness_N_m"] *= 1 + spring / 2
    means["suspension.rear.damping_N_s_m"] *= 1 + damper / 2
    theta = {
        "spring_excess": spring / (2 + spring),
        "damper_excess": damper / (2 + damper),
    }
    found = system_of(EFFECTS["corner-asymmetry"].with_choice("rear"), theta, means)
    strut = PLAIN.output[2] - PLAIN.output[6]
    k, c = ATV["suspension.rear.stiffness_N_m"], ATV["suspension.rear.damping_N_s_m"]
    one = np.outer(strut, strut)
    np.testing.assert_allclose(found.stiffness, PLAIN.stiffness + spring * k * one, atol=1e-6)
    np.testing.assert_allclose(found.damping, PLAIN.damping + damper * c * one, atol=1e-6)


@pytest.mark.parametrize("axle", ["front", "rear"])
def test_a_left_right_difference_couples_heave_to_roll(axle):
    """What no symmetric vehicle does; the other axle is left alone."""
    effect = EFFECTS["corner-asymmetry"].with_choice(axle)
    added = system_of(effect, {"spring_excess": 0.1, "damper_excess": 0.0}).stiffness
    added = added - PLAIN.stiffness
    k = ATV[f"suspension.{axle}.stiffness_N_m"]
    assert added[0, 0] == pytest.approx(0.0, abs=1e-9)
    assert added[0, 2] == pytest.approx(0.1 * k * ATV["geometry.track_width_m"])
    other = slice(5, 7) if axle == "front" else slice(3, 5)
    assert not added[other].any()


SPECIMEN = Elements(4e4, 30.0, np.array([1e4, 2e4, 1e4]), np.array([0.3, 0.02, 0.002]))


@pytest.mark.parametrize("share", [0.0, 1e-6, 0.01, 1.0, 30.0])
def test_a_strut_on_elements_is_the_series_of_both(share):
    """D = S M/(M + share S) at every frequency, from the modes; all of them decay."""
    omega = 2 * np.pi * np.geomspace(0.05, 200.0, 50)
    modes = on_elements(K, C, SPECIMEN, share)
    lag = modes.gains_N_m / (1 + 1j * omega[:, None] / modes.rates_1_s)
    found = modes.stiffness_N_m + 1j * omega * modes.damping_N_s_m + lag.sum(axis=1)
    strut, mount = K + 1j * omega * C, SPECIMEN.modulus(omega)
    assert np.allclose(found, strut * mount / (mount + share * strut), rtol=1e-9)
    assert (modes.rates_1_s > 0).all()


@pytest.mark.parametrize("frequency", [1.0, 6.0, 25.0])
@pytest.mark.parametrize("rate", [0.5, 30.0, 5e3])
def test_a_relaxing_force_is_exact_along_a_parabola_and_right_at_every_frequency(frequency, rate):
    omega, step = 2 * np.pi * frequency, 0.00125
    time = np.arange(0.0, 8 / frequency + 10 / rate, step)
    path, speed = np.cos(omega * time), -omega * np.sin(omega * time)
    p = np.array([300.0, rate, 20.0, 3.0, 0.0, 0.0])
    force, memory = np.zeros(len(time)), 0.0
    for i in range(1, len(time)):
        force[i], memory = relaxing(path[i], speed[i], path[i] - path[i - 1], step, memory, p)
    last = time > time[-1] - 2 / frequency
    basis = np.column_stack([np.cos(omega * time), -np.sin(omega * time)])[last]
    real, imaginary = np.linalg.lstsq(basis, force[last], rcond=None)[0]
    expected = 300.0 / (1 + 1j * omega / rate) + 20.0 + 3j * omega
    assert abs(complex(real, imaginary) - expected) < 2e-3 * abs(expected)
    # Along x = t² from rest the memory is what the equation says.
    t = 0.3
    _, memory = relaxing(t**2, 2 * t, t**2, t, 0.0, p)
    lag = 2 / rate * (t - (1 - np.exp(-rate * t)) / rate)
    assert memory == pytest.approx(t**2 - lag, rel=1e-9)
