"""Laws of contact in the suspension, stops and gaps, against their closed forms."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.simulate.setup import ATV, CHANNELS, EFFECTS
from wheelhop.effects.backlash import RISE_S, free_play
from wheelhop.effects.bump_stop import SHARES, stops
from wheelhop.vehicle import baseline, static_load
from wheelhop.vehicle.layout import body_inertia

K, C, LOAD = 10_000.0, 600.0, 500.0
STRUT = (K, C, LOAD, RISE_S)


def stop_force(x, *parameters):
    value, memory = stops(x, 0.3, 0.0, 0.0, 7.0, np.array(parameters))
    assert memory == 7.0
    return value


@given(st.floats(-0.2, 0.2), st.floats(1e3, 1e6), st.floats(0.0, 0.1), st.floats(0.0, 0.1))
def test_a_stop_pushes_back_by_its_stiffness_times_the_way_beyond(x, k, compression, rebound):
    beyond = x - np.clip(x, -compression, rebound)
    assert stop_force(x, k, compression, rebound) == pytest.approx(k * beyond)


@given(st.floats(-0.2, 0.2))
def test_an_end_without_a_stop_is_never_met(x):
    assert stop_force(x, 1e4, np.inf, 0.02) == pytest.approx(1e4 * max(x - 0.02, 0.0))
    assert stop_force(x, 1e4, 0.02, np.inf) == pytest.approx(1e4 * min(x + 0.02, 0.0))


@pytest.mark.parametrize(
    ("form", "compression", "rebound"),
    [("compression", 0.02, np.inf), ("rebound", np.inf, 0.02), ("both", 0.02, 0.03)],
)
def test_the_form_says_at_which_end_the_stops_are(form, compression, rebound):
    theta = {"stiffness_N_m": 2e4, "stiffness_balance": -0.5}
    theta |= {"clearance_m": 0.02, "clearance_balance": 0.2, "rebound_ratio": 1.5}
    parameters = parts_of(EFFECTS["bump-stop"].with_choice(form), theta).law_parameters
    np.testing.assert_allclose(parameters[:, 0], [1e4, 1e4, 3e4, 3e4])
    both = np.array([compression, rebound])
    np.testing.assert_allclose(parameters[:2, 1:3], [1.2 * both] * 2)
    np.testing.assert_allclose(parameters[2:, 1:3], [0.8 * both] * 2)


class Travels:
    """A probe that knows of two runs how far the struts went."""

    def __init__(self, travels):
        self._travels = travels
        self.settings = [type("Setting", (), {"run_id": name}) for name in travels]

    def travel(self, run_id):
        return self._travels[run_id]


def test_clearances_are_sought_within_the_longest_travel():
    wave = np.sin(np.linspace(0.0, 20.0, 2000))[:, None]
    probe = Travels(
        {
            "quiet": {"front": 0.002 * wave, "rear": 0.050 * wave},
            "loud": {"front": 0.020 * wave * [0.5, -1.0], "rear": 0.010 * wave},
        }
    )
    starts = EFFECTS["bump-stop"].shape_starts(probe)
    assert [start["clearance_m"] for start in starts] == pytest.approx(
        [0.050 * share for share in SHARES], rel=1e-4
    )
    assert EFFECTS["bump-stop"].shape_starts(Travels({"run": {}})) == ()


def along(time, path, gap, strut=STRUT):
    """Total force of a strut with play (without its static load), and its own extension, where
    the joint's ends move along `path` from rest."""
    rate = np.gradient(path, time, edge_order=2)
    force, own, memory = [0.0], [path[0]], path[0]
    for i, (before, now) in enumerate(pairwise(path), start=1):
        step = time[i] - time[i - 1]
        added, memory = free_play(
            now, rate[i], now - before, step, memory, np.array([gap, *strut, 0.0])
        )
        force.append(strut[0] * now + strut[1] * rate[i] + added)
        own.append(min(max(memory, now - gap), now))
    return np.array(force), np.array(own)


def test_a_slow_gap_is_a_dead_zone_where_the_load_is_used_up():
    """Pushed together below F₀, without force over the width of the gap, pulled beyond it."""
    gap, time = 0.004, np.linspace(0.0, 400.0, 40_001)
    path = 0.06 + 0.06 * np.sin(2 * np.pi * (time / 200.0 - 0.25))
    force, _ = along(time, path, gap)
    dead = np.where(path < LOAD / K, K * path, np.maximum(K * (path - gap), LOAD))
    assert np.abs(force - dead).max() < 5e-3 * LOAD


@given(st.floats(0.0, 0.02), st.floats(0.5, 12.0))
def test_a_joint_under_load_has_no_play(gap, frequency):
    """As long as the strut's force does not change sign the gap is not seen."""
    time = np.arange(0.0, 1.0, 5e-4)
    largest = 0.95 * LOAD / np.hypot(K, C * 2 * np.pi * frequency)
    path = largest * (1 - np.cos(2 * np.pi * frequency * time)) / 2
    force, own = along(time, path, gap)
    linear = K * path + C * np.gradient(path, time, edge_order=2)
    np.testing.assert_allclose(force[1:], linear[1:], atol=1e-9 * LOAD)
    np.testing.assert_allclose(own, path, atol=1e-12)


@given(st.floats(0.0, 0.02), st.floats(0.01, 0.1), st.floats(0.5, 12.0))
def test_a_strut_with_play_gives_no_energy(gap, amplitude, frequency):
    """Over a period, once the start is forgotten, the ends of the strut lose work."""
    time = np.linspace(0.0, 3.0 / frequency, 12_001)
    path = amplitude * np.sin(2 * np.pi * frequency * time)
    force, own = along(time, path, gap)
    last = slice(8000, None)
    work = np.trapezoid(force[last], path[last])
    assert work > 0
    assert (own <= path + 1e-12).all() and (own >= path - gap - 1e-12).all()


def test_the_free_strut_relaxes_towards_its_free_length():
    """e = F₀/k − (F₀/k − e₀) exp(−k t / c), for steps of any length."""
    rest, time = LOAD / K, np.array([0.0, 0.003, 0.004, 0.05])
    memory, own = 0.0, []
    for before, now in pairwise(time):
        parameters = np.array([1.0, *STRUT, 0.0])
        force, memory = free_play(0.5, 0.0, 0.0, now - before, memory, parameters)
        assert force == pytest.approx(LOAD - K * 0.5)
        own.append(memory)
    np.testing.assert_allclose(own, rest * (1 - np.exp(-K / C * time[1:])))


@given(st.floats(0.05, 1.0), st.floats(0.01, 0.99))
def test_the_impulse_of_a_closing_does_not_depend_on_the_step_it_falls_into(speed, phase):
    """Two ends that meet at a constant speed: ∫ F dt is that of a force which jumps to k x + c ẋ
    when they touch, whichever instant of a step that is."""
    step, steps = 5e-5, 160
    time = step * np.arange(steps + 1)
    meets = (40 + phase) * step
    path = speed * (meets - time)
    # A strut long relaxed has its free length, without load 0, and stays there.
    parameters, memory, force = np.array([1.0, K, C, 0.0, RISE_S, 0.0]), 0.0, np.zeros(steps + 1)
    for i, (before, now) in enumerate(pairwise(path), start=1):
        added, memory = free_play(now, -speed, now - before, step, memory, parameters)
        force[i] = K * now - C * speed + added
    closed = time[-1] - meets
    jump = -K * speed * closed**2 / 2 - C * speed * closed
    assert np.trapezoid(force, time) == pytest.approx(jump, abs=0.05 * step * C * speed)


@given(st.floats(-2.0, 2.0), st.floats(-0.1, 0.1))
def test_a_joint_passes_push_at_one_end_of_its_gap_and_pull_at_the_other(v, x):
    """Whatever the strut would do there by itself."""
    for end, pushes in ((x, True), (x - 0.01, False)):
        added, _ = free_play(x, v, 0.0, 0.0, end, np.array([0.01, *STRUT, 0.0]))
        linear = K * end + C * v
        expected = min(linear, LOAD) if pushes else max(linear, LOAD)
        assert K * x + C * v + added == pytest.approx(expected)


def test_no_gap_is_no_effect():
    assert free_play(0.3, 5.0, 0.1, 0.001, 0.2, np.array([0.0, *STRUT, 0.0])) == (0.0, 0.3)


def test_gaps_of_front_and_rear():
    """The balance shares the mean gap out; struts carry what statics says."""
    parameters = parts_of(EFFECTS["backlash"], {"gap_m": 0.004, "balance": 0.25}).law_parameters
    np.testing.assert_allclose(parameters[:, 0], [0.005, 0.005, 0.003, 0.003])
    np.testing.assert_allclose(parameters[:, 3], [static_load(ATV, i) for i in range(4)])


def parts_of(effect, theta):
    """The nominal vehicle with an effect, as a system; its laws sit beside the struts."""
    parts = baseline(ATV, CHANNELS, "road")
    effect.modify(theta, ATV, parts)
    system = parts.system(body_inertia(ATV))
    np.testing.assert_allclose(system.port, system.output[:4] - system.output[4:])
    return system
