"""Time integration against closed forms: one mass on a spring, with and without force laws."""

import gc
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from math import pi
from pkgutil import iter_modules
from time import sleep

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from wheelhop import effects
from wheelhop.campaign import Averaging
from wheelhop.effects.dry_friction import elastic_slip
from wheelhop.effects.progressive_spring import cubic
from wheelhop.simulate.integrator import Task, integrate
from wheelhop.simulate.laws import remembers
from wheelhop.vehicle import Assembly, between, ground

MASS, OMEGA, ZETA = 20.0, 2 * pi * 3.0, 0.15


def one_mass(zeta=ZETA, law=None, parameters=()):
    """A mass on a spring and a damper above the ground; free coordinate 3 of 4."""
    parts = Assembly(prescribed=("ground 1",))
    mass = parts.add_coordinate("mass")
    parts.add_mass(((1.0, mass),), MASS)
    row = between(mass, ground(0))
    parts.add_spring(row, MASS * OMEGA**2, 2 * zeta * MASS * OMEGA)
    if law is not None:
        parts.add_law(row, law, parameters)
    parts.add_force(((1.0, mass),))
    parts.add_output(((1.0, mass),))
    return parts.system((1.0, 1.0, 1.0))


def run(system, step_s, duration_s, *, ground_m=None, force=None, at=(0.0, 0.0), window_s=0.0):
    """Acceleration (n,) at every step from the window's half width on, and those times."""
    steps = round(duration_s / step_s)
    time = step_s * np.arange(steps + 1)
    half = step_s / 2 * np.arange(2 * steps + 1)
    zero = np.zeros((steps + 1, 1))
    height, rate = (zero, zero) if ground_m is None else (f(time)[:, None] for f in ground_m)
    margin = int(window_s / 2 / step_s) + 2
    initial = np.zeros(8)
    initial[3], initial[7] = at
    count = steps - 2 * margin
    applied = np.zeros((len(half), 1)) if force is None else force(half)[:, None]
    (found,) = integrate(
        [Task(system, height, rate, applied, initial)],
        step_s=step_s,
        first=margin,
        stride=1,
        averaging=Averaging(window_s),
        n_samples=count,
    )
    return time[margin : margin + count], found[:, 0]


def steady(frequency_hz, amplitude_m=0.01):
    """Ground A sin ωt, and the mass' steady motion as a complex amplitude on exp(iωt)."""
    omega = 2 * pi * frequency_hz
    spring = OMEGA**2 + 2j * ZETA * OMEGA * omega
    amplitude = -1j * amplitude_m * spring / (spring - omega**2)
    at = (amplitude.real, (1j * omega * amplitude).real)
    return (
        (
            lambda t: amplitude_m * np.sin(omega * t),
            lambda t: amplitude_m * omega * np.cos(omega * t),
        ),
        at,
        lambda t: (-(omega**2) * amplitude * np.exp(1j * omega * t)).real,
    )


@given(st.floats(0.0, 0.9), st.floats(-0.05, 0.05), st.floats(-1.0, 1.0))
def test_free_decay(zeta, x0, v0):
    time, found = run(one_mass(zeta), 0.0025, 1.0, at=(x0, v0))
    damped, decay = OMEGA * np.sqrt(1 - zeta**2), zeta * OMEGA
    sine = (v0 + decay * x0) / damped
    # x = e^(-decay t) (x0 cos + sine sin), differentiated twice as a complex exponential
    pole = complex(-decay, damped)
    expected = (pole**2 * (x0 - 1j * sine) * np.exp(pole * time)).real
    size = OMEGA**2 * abs(x0) + OMEGA * abs(v0)
    np.testing.assert_allclose(found, expected, atol=1e-5 * size + 1e-12)


def test_applied_force_deflects_and_rings():
    """A step of force: the mass swings about F/k."""
    time, found = run(one_mass(zeta=0.0), 0.0025, 1.0, force=lambda t: np.full(t.shape, 50.0))
    np.testing.assert_allclose(found, 50.0 / MASS * np.cos(OMEGA * time), atol=1e-4)


def test_linear_error_falls_with_the_fourth_power_of_the_step():
    ground_m, at, expected = steady(4.0)
    errors = []
    for step in (0.01, 0.005, 0.0025):
        time, found = run(one_mass(), step, 2.0, ground_m=ground_m, at=at)
        errors.append(np.abs(found - expected(time)).max())
    assert 13.0 < errors[0] / errors[1] < 20.0
    assert 13.0 < errors[1] / errors[2] < 20.0


def test_error_with_a_cubic_spring_falls_with_the_fourth_power_of_the_step():
    """Against an eighth-order adaptive integrator of another library."""
    k3, (ground_m, at, _) = 5e6, steady(2.5, 0.02)

    def rate(t, y):
        x, v = y[0] - ground_m[0](t), y[1] - ground_m[1](t)
        return [y[1], -(OMEGA**2) * x - 2 * ZETA * OMEGA * v - k3 / MASS * x**3]

    exact = solve_ivp(rate, (0.0, 2.0), at, "DOP853", rtol=1e-12, atol=1e-14, dense_output=True)
    errors = []
    for step in (0.005, 0.0025, 0.00125):
        time, found = run(
            one_mass(law=cubic, parameters=(k3,)), step, 2.0, ground_m=ground_m, at=at
        )
        expected = np.array([rate(t, exact.sol(t))[1] for t in time])
        errors.append(np.abs(found - expected).max())
    assert 12.0 < errors[0] / errors[1] < 21.0
    assert 12.0 < errors[1] / errors[2] < 21.0
    assert errors[1] < 1e-3 * np.abs(expected).max()


@pytest.mark.parametrize("presliding", [30.0, 300.0], ids=["soft joint", "stiff joint"])
def test_coulomb_friction_takes_the_same_from_every_swing(presliding):
    """From turn to turn X − X' = (2 F/k) (1 − 2 F/(k_p (X + X'))): 4 F/k per cycle for k_p → ∞,
    from ½ k (X² − X'²) = F (X + X' − 2 F/k_p), the joint turning over 2 F/k_p without loss."""
    k = MASS * OMEGA**2
    slip, joint = 0.02 * k * 0.1, presliding * k
    step = 1.25e-4
    system = one_mass(zeta=0.0, law=elastic_slip, parameters=(slip, joint))
    _, acceleration = run(system, step, 1.6, at=(0.1, 0.0))
    # Until the mass turns, friction pulls with the spring: there m |a| = k X + F, the most it gets.
    swings = np.split(acceleration, np.flatnonzero(np.diff(np.sign(acceleration))) + 1)
    peaks = np.array([MASS * np.abs(swing).max() - slip for swing in swings[1:9]]) / k
    total = peaks[:-1] + peaks[1:]
    expected = 2 * slip / k * (1 - 2 * slip / (joint * total))
    np.testing.assert_allclose(-np.diff(peaks), expected, rtol=1e-3)


@settings(max_examples=25)
@given(st.floats(0.5, 30.0), st.floats(0.0011, 0.02))
def test_averaging_multiplies_a_harmonic_by_sinc(frequency, window):
    ground_m, at, expected = steady(frequency)
    time, found = run(one_mass(), 0.00125, 0.4, ground_m=ground_m, at=at, window_s=window)
    size = np.abs(expected(time)).max()
    np.testing.assert_allclose(
        found, np.sinc(frequency * window) * expected(time), atol=2e-4 * size + 1e-9
    )


@pytest.mark.parametrize("window", [0.0, 0.0066])
@pytest.mark.parametrize(("count", "step_s"), [(3, 0.0028), (4, 0.0066)])
def test_means_of_means_keep_what_is_left_of_a_harmonic(window, count, step_s):
    """Windows overlap, lie apart, or abut."""
    averaging = Averaging(window, count, step_s)
    ground_m, at, expected = steady(12.0)
    steps, step, first = 320, 0.00125, 20
    time = step * np.arange(steps + 1)
    (found,) = integrate(
        [
            Task(
                one_mass(),
                *(motion(time)[:, None] for motion in ground_m),
                np.zeros((2 * steps + 1, 1)),
                np.array([0.0, 0.0, 0.0, at[0], 0.0, 0.0, 0.0, at[1]]),
            )
        ],
        step_s=step,
        first=first,
        stride=1,
        averaging=averaging,
        n_samples=steps - 2 * first,
    )
    own = expected(time[first : steps - first])
    kept = sum(np.cos(2 * pi * 12.0 * c) for c in averaging.centres_s) / count
    kept *= np.sinc(12.0 * window)
    np.testing.assert_allclose(averaging.kept(np.array([12.0])), [kept], rtol=1e-12)
    np.testing.assert_allclose(found[:, 0], kept * own, atol=2e-4 * np.abs(own).max())


def test_side_by_side_each_does_what_it_does_alone():
    """Ten masses with springs, friction and motions of their own, more than there are lanes."""
    rng, tasks = np.random.default_rng(5), []
    zero, half = np.zeros((401, 1)), np.zeros((801, 1))
    for i in range(10):
        slip, joint = rng.uniform(10.0, 60.0), rng.uniform(1e5, 1e6)
        system = one_mass(0.02 * i, law=elastic_slip, parameters=(slip, joint))
        height = zero if i % 2 else 0.01 * np.cumsum(rng.normal(size=zero.shape), axis=0)
        initial = rng.normal(size=8) * np.repeat([1e-3, 0.1], 4)
        tasks.append(Task(system, height, np.gradient(height, 0.001, axis=0), half, initial))
    sampling = {
        "step_s": 0.001,
        "first": 10,
        "stride": 2,
        "averaging": Averaging(0.0066),
        "n_samples": 190,
    }
    for task, found in zip(tasks, integrate(tasks, **sampling), strict=True):
        np.testing.assert_allclose(found, integrate([task], **sampling)[0], rtol=1e-9, atol=1e-9)


def laws_of_the_library():
    rooms = [f"wheelhop.effects.{room.name}" for room in iter_modules(effects.__path__)]
    for name in (*rooms, "wheelhop.law.terms"):
        for law in vars(import_module(name)).values():
            code = getattr(getattr(law, "py_func", None), "__code__", None)
            if code is not None and code.co_varnames[:6] == ("x", "v", "dx", "dt", "z", "p"):
                yield law


LAWS = {law.py_func.__name__: law for law in laws_of_the_library()}


def test_the_library_has_laws_of_both_kinds():
    assert {remembers(law) for law in LAWS.values()} == {True, False}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_what_has_no_memory_leaves_it_alone(law):
    """At the end of a step only laws with a memory are asked what they keep."""
    rng = np.random.default_rng(1)
    changed = False
    for _ in range(50):
        x, v, dx, z = rng.normal(0.0, [0.02, 0.5, 0.001, 0.3])
        numbers = rng.uniform(0.5, 2.0, 64)
        changed |= law(x, v, dx, 0.001, z, numbers)[1] != z
    assert remembers(law) == changed


def test_threads_may_ask_for_memories_at_once():
    """They take turns whenever Python collects garbage, in the middle of a law's tree, too."""

    def turn(*_):
        sleep(0.0)

    usual = gc.get_threshold()
    gc.callbacks.append(turn)
    gc.set_threshold(20)
    try:
        with ThreadPoolExecutor(4) as pool:
            asked = [*LAWS.values()] * 100
            assert [*pool.map(remembers.__wrapped__, asked)] == [*map(remembers, asked)]
    finally:
        gc.set_threshold(*usual)
        gc.callbacks.remove(turn)


def test_a_law_whose_text_is_lost_may_have_a_memory():
    made = {}
    exec("def slip(x, v, dx, dt, z, p):\n    return 0.0, z\n", made)

    class Lost:
        py_func = staticmethod(made["slip"])

    assert remembers(Lost)


def test_samples_must_lie_inside_the_span():
    zero = np.zeros((11, 1))
    with pytest.raises(ValueError, match="inside the integrated span"):
        integrate(
            [Task(one_mass(), zero, zero, np.zeros((21, 1)), np.zeros(8))],
            step_s=0.001,
            first=0,
            stride=1,
            averaging=Averaging(0.0066),
            n_samples=5,
        )
