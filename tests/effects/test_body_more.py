"""A driver who sways, and a body that pitches and rolls as the vehicle brakes and turns."""

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests import truth
from tests.effects.test_body import by_hand, system_with
from tests.simulate.setup import ATV, TIME, campaign_of, model_of, relative, simulated
from tests.truth.closed_form import matrices
from wheelhop.effects.acceleration_moment import KNOT_S
from wheelhop.effects.history import History
from wheelhop.simulate import RunSimulator, abreast, frequency_response

TWIST = truth.Track("chassis-twist", {"amplitude_mm": 100.0, "pitch_mm": 3000.0})
MASS, HEIGHT = ATV["body.mass_kg"], ATV["geometry.cg_height_m"]
ROLL = np.array([0, 0, 1.0, 0, 0, 0, 0])

rockers = st.fixed_dictionaries(
    {
        "inertia_kg_m2": st.floats(0.5, 15.0),
        "freq_hz": st.floats(0.5, 12.0),
        "zeta": st.floats(0.05, 1.0),
    }
)


@given(rockers, st.floats(0.5, 30.0))
def test_a_rocking_driver_is_an_apparent_roll_inertia(theta, frequency):
    """In place of the inertia I the body feels I (k + iωc)/(k − ω²I + iωc) in roll."""
    inertia, omega, natural = theta["inertia_kg_m2"], 2 * pi * frequency, 2 * pi * theta["freq_hz"]
    spring = inertia * (natural**2 + 2j * theta["zeta"] * natural * omega)
    apparent = inertia * spring / (spring - omega**2 * inertia)
    extra = -(omega**2) * (apparent - inertia) * np.outer(ROLL, ROLL)
    found = frequency_response(system_with("driver-rocking", theta), frequency)[0]
    np.testing.assert_allclose(found, by_hand(ATV, frequency, extra), rtol=1e-6, atol=1e-6)


def test_a_driver_who_cannot_rock_is_part_of_the_vehicle_of_the_file():
    theta = {"inertia_kg_m2": 6.0, "freq_hz": 2000.0, "zeta": 0.3}
    found = frequency_response(system_with("driver-rocking", theta), 8.0)[0]
    np.testing.assert_allclose(found, by_hand(ATV, 8.0, np.zeros((7, 7))), rtol=1e-3, atol=1e-2)


def tyre_forces(effect, acceleration):
    """Static forces (4,), N, the road adds under the wheels while the acceleration lasts."""
    force = system_with(effect, {}).force[:, 0] * acceleration
    _, _, stiffness = matrices(ATV)
    deflection = np.linalg.solve(stiffness, force)[3:]
    rate = [ATV[f"wheel.{end}.tyre_stiffness_N_m"] for end in ("front", "front", "rear", "rear")]
    return -deflection * rate


@given(st.floats(-8.0, 8.0))
def test_braking_moves_load_to_the_front_axle(acceleration):
    """m h a / L (Gillespie, eq. 1-6), whatever springs and tyres are."""
    force, moved = tyre_forces("longitudinal-pitch", acceleration), MASS * HEIGHT * acceleration
    assert force[:2].sum() == pytest.approx(-moved / ATV["geometry.wheelbase_m"], abs=1e-9)
    assert force.sum() == pytest.approx(0.0, abs=1e-6)
    assert force[0] == pytest.approx(force[1], abs=1e-9)


@given(st.floats(-8.0, 8.0))
def test_a_curve_to_the_left_moves_load_to_the_right_wheels(acceleration):
    """m h a / t: front and rear share it as their springs say."""
    force, moved = tyre_forces("cornering-roll", acceleration), MASS * HEIGHT * acceleration
    right = force[1] + force[3]
    assert right == pytest.approx(moved / ATV["geometry.track_width_m"], abs=1e-9)
    assert force.sum() == pytest.approx(0.0, abs=1e-6)


ONE = {"run": truth.Run(TWIST, 4.0, 36.0, TIME, seed=5)}
PERIODS = {"period_min_s": 1.2, "period_max_s": 3.0}


def coefficients(time, values):
    """Least-squares spline through a history."""
    history = History(SETTING_OF_ONE, KNOT_S, "m_s2")
    basis = np.stack([history.at({n: 1.0}, time)[0] for n in history.names], axis=1)
    found = np.linalg.lstsq(basis, values, rcond=None)[0]
    return dict(zip(history.names, found.tolist(), strict=True))


SETTING_OF_ONE = RunSimulator(campaign_of(ONE), campaign_of(ONE).runs[0], 4.0).setting


def their_history(peak):
    """Instants (T,) and the acceleration (T,) the independent simulator draws in this run."""
    time = np.arange(-0.8, SETTING_OF_ONE.end_s, 0.005)
    rng = np.random.default_rng(ONE["run"].seed)
    omega = 2 * pi / rng.uniform(PERIODS["period_min_s"], PERIODS["period_max_s"], 3)
    phase = rng.uniform(0.0, 2 * pi, 3)
    share = rng.uniform(0.3, 1.0, 3)
    angle = np.outer(time, omega) + phase
    return time, np.sin(angle) @ (peak * share / share.sum())


@pytest.mark.parametrize("name", ["longitudinal-pitch", "cornering-roll"])
def test_a_free_history_does_what_it_does_in_mujoco(name):
    """The spline follows sines of 1.2 s and more to 1 %; what it cannot know is how the vehicle
    swayed before the history begins."""
    hidden = truth.make_effects({name: {"peak_m_s2": 3.0, **PERIODS}})
    measured = truth.simulate_run(ATV, ONE["run"], hidden)[1]
    time, acceleration = their_history(3.0)
    own = coefficients(time, acceleration)
    model = model_of(ATV, ONE, name, {}, own=own)
    still = relative(simulated(campaign_of(ONE), model_of(ATV, ONE))["run"], measured)
    assert still > 0.01
    assert relative(simulated(campaign_of(ONE), model)["run"], measured) < 0.05 * still


def test_other_forces_need_no_new_integration(monkeypatch):
    """Where the vehicle is linear, responses to forces add up; the road is the same."""
    count = []
    integrate = abreast.integrate

    def counted(*args, **kwargs):
        count.append(1)
        return integrate(*args, **kwargs)

    monkeypatch.setattr(abreast, "integrate", counted)
    names = History(SETTING_OF_ONE, KNOT_S, "m_s2").names
    shares = np.random.default_rng(3).normal(size=len(names))
    own = dict(zip(names, shares.tolist(), strict=True))
    still = model_of(ATV, ONE, "cornering-roll", {}, own=dict.fromkeys(names, 0.0))
    swaying = model_of(ATV, ONE, "cornering-roll", {}, own=own)
    campaign = campaign_of(ONE)
    system = still.system(campaign.channels, "road")
    one, other = (RunSimulator(campaign, campaign.runs[0], 4.0) for _ in range(2))
    before, superposed = one.record(still, system), one.record(swaying, system)
    assert len(count) == 1
    integrated = other.record(swaying, system)
    assert len(count) == 2
    assert relative(before, integrated) > 0.05
    assert relative(superposed, integrated) < 1e-3 * relative(before, integrated)
