"""A dynamometer's cards, on a damper whose force is known in closed form."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.report.test_loops import fitted  # noqa: F401
from wheelhop.report.dynamometer import Card, cards_of, dynamometer
from wheelhop.report.loops import speed_of

RATE_HZ = 1000.0
TIME = np.arange(8000) / RATE_HZ


def card(frequency_hz=1.0, amplitude_m=0.02, lag_s=0.0, friction_N=0.0, gas_N=0.0, c=1000.0):
    """A sine through a damper of 1 and 2 times `c` that follows the speed late."""
    turn = 2 * np.pi * frequency_hz
    x = amplitude_m * np.sin(turn * TIME)
    v = amplitude_m * turn * np.cos(turn * TIME)
    late = amplitude_m * turn * np.cos(turn * (TIME - lag_s))
    force = c * late * np.where(late > 0.0, 2.0, 1.0) + friction_N * np.sign(v) + gas_N
    return Card("sine", x, speed_of(x, RATE_HZ), force)


@given(st.floats(0.25, 4.0), st.floats(0.005, 0.05))
def test_speed_of_a_sine(frequency_hz, amplitude_m):
    """A twentieth of a wave takes 0.4 % off, sin(π/20) over π/20."""
    found = card(frequency_hz, amplitude_m)
    exact = 2 * np.pi * frequency_hz * amplitude_m
    assert found.fastest_m_s == pytest.approx(exact * 0.9959, rel=2e-3)


@given(st.floats(-200.0, 200.0), st.floats(0.0, 80.0))
def test_peaks_gas_force_and_friction(gas_N, friction_N):
    """Peaks are the two slopes times the speed, friction and gas force beside them; at creep only
    these two are left."""
    fast = card(2.0, 0.02, friction_N=friction_N, gas_N=gas_N)
    speed = 2 * np.pi * 2.0 * 0.02
    # Within 18° of its peak a cosine is 0.984 of it on average.
    assert fast.peak_N(1) == pytest.approx(2000 * speed * 0.984 + friction_N + gas_N, rel=0.01)
    assert fast.peak_N(-1) == pytest.approx(-1000 * speed * 0.984 - friction_N + gas_N, rel=0.01)
    creep = card(0.25, 0.02, friction_N=friction_N, gas_N=gas_N, c=1.0)
    assert creep.gas_N == pytest.approx(gas_N, abs=0.05)
    assert creep.friction_N == pytest.approx(friction_N, abs=0.1)


def test_a_force_that_lags_has_hysteresis():
    """None without a lag; with one as far apart as the slope times the change of speed in twice
    the lag, 2 τ a."""
    assert card(1.0).hysteresis_N < 3.0
    lag, turn = 0.01, 2 * np.pi
    apart = 1.5 * 1000.0 * 2 * lag * 0.02 * turn**2 * 0.64  # mean of |sin| over equal speeds is π/4
    assert card(1.0, lag_s=lag).hysteresis_N == pytest.approx(apart, rel=0.3)


def test_the_section_is_of_imposed_displacement_alone(fitted):  # noqa: F811
    campaign, step = fitted
    page = dynamometer(campaign, [step])
    assert ("On the dynamometer" in page) == (campaign.drive == "displacement")
    if page:
        measured, modelled = cards_of(campaign, None, step), cards_of(campaign, step, step)
        assert [c.run_id for c in measured] == [c.run_id for c in modelled]
        for one, other in zip(measured, modelled, strict=True):
            assert one.peak_N(1) == pytest.approx(other.peak_N(1), rel=0.05, abs=10.0)
        assert page.count("<tr>") == 1 + len(measured)
