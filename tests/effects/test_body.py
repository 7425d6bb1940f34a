"""Driver, engine and frame: dynamic stiffness by hand, and the line the engine leaves."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests import truth
from tests.simulate.setup import ATV, CHANNELS, EFFECTS, campaign_of, model_of, simulated
from tests.truth.closed_form import matrices
from wheelhop.effects import OwnValues, RunSetting
from wheelhop.simulate import Model, frequency_response

SETTING = RunSetting("run", 4.0, -4.0, 0.0, 5.0, True)


def system_with(name, theta, values=ATV):
    model = Model({**values, **{f"{name}.{k}": v for k, v in theta.items()}}, (EFFECTS[name],))
    return model.system(CHANNELS, "road")


def by_hand(values, frequency, extra_stiffness):
    """Accelerations (8, 4) per ground height; `extra_stiffness` (7, 7) is added to the car's."""
    mass, damping, stiffness = matrices(values)
    omega = 2 * pi * frequency
    ground = np.zeros((7, 4), dtype=complex)
    for i, end in enumerate(("front", "front", "rear", "rear")):
        ground[3 + i, i] = (
            values[f"wheel.{end}.tyre_stiffness_N_m"]
            + 1j * omega * values[f"wheel.{end}.tyre_damping_N_s_m"]
        )
    dynamic = stiffness + 1j * omega * damping - omega**2 * mass + extra_stiffness
    q = np.linalg.solve(dynamic, ground)
    ahead, half = values["geometry.cg_to_front_axle_m"], values["geometry.track_width_m"] / 2
    behind = values["geometry.wheelbase_m"] - ahead
    points = np.zeros((8, 7))
    for i, (x, y) in enumerate([(ahead, half), (ahead, -half), (-behind, half), (-behind, -half)]):
        points[i, :3], points[4 + i, 3 + i] = [1.0, -x, y], 1.0
    return -(omega**2) * points @ q


seats = st.fixed_dictionaries(
    {
        "mass_kg": st.floats(10.0, 120.0),
        "freq_hz": st.floats(1.0, 12.0),
        "zeta": st.floats(0.05, 1.0),
        "x_m": st.floats(-0.5, 0.5),
    }
)


@given(seats, st.floats(0.5, 30.0))
def test_driver_seat_is_an_apparent_mass(theta, frequency):
    """In place of the mass m the body feels m (k + iωc)/(k − ω²m + iωc) at the seat."""
    m, omega, natural = theta["mass_kg"], 2 * pi * frequency, 2 * pi * theta["freq_hz"]
    spring = m * natural**2 + 2j * theta["zeta"] * m * natural * omega
    apparent = m * spring / (spring - omega**2 * m)
    seat = np.array([1.0, -theta["x_m"], ATV["driver.y_m"], 0, 0, 0, 0])
    extra = -(omega**2) * (apparent - m) * np.outer(seat, seat)
    found = frequency_response(system_with("driver-seat", theta), frequency)[0]
    np.testing.assert_allclose(found, by_hand(ATV, frequency, extra), rtol=1e-6, atol=1e-6)


def test_driver_seat_locked_is_the_vehicle_of_the_file():
    theta = {"mass_kg": 70.0, "freq_hz": 2000.0, "zeta": 0.3, "x_m": -0.1}
    found = frequency_response(system_with("driver-seat", theta), 8.0)[0]
    np.testing.assert_allclose(found, by_hand(ATV, 8.0, np.zeros((7, 7))), rtol=1e-3, atol=1e-2)


def test_driver_seat_sits_where_the_vehicle_says():
    values = ATV | {"driver.y_m": 0.3}
    theta = {"mass_kg": 70.0, "freq_hz": 3.0, "zeta": 0.3, "x_m": 0.0}
    symmetric = frequency_response(system_with("driver-seat", theta), 3.0)[0]
    beside = frequency_response(system_with("driver-seat", theta, values), 3.0)[0]
    together = np.ones(4)
    np.testing.assert_allclose((symmetric @ together)[0], (symmetric @ together)[1], rtol=1e-9)
    left, right = (beside @ together)[:2]
    assert abs(left - right) > 0.05 * abs(left)


@pytest.mark.parametrize(("stated", "away"), [({"driver.x_m": 0.2}, 0.3), ({}, np.inf)])
def test_a_driver_sits_where_he_is_said_to_or_nearly(stated, away):
    """A payload on springs at the tail is none; if nothing is said of him he may sit anywhere."""
    vehicle = {key: value for key, value in ATV.items() if key != "driver.x_m"} | stated
    *_, place = EFFECTS["driver-seat"].parameters_for(vehicle, CHANNELS)
    (begun,) = place.starts
    assert begun == stated.get("driver.x_m", 0.0)
    assert (place.lower, place.upper) == (begun - away, begun + away)


@given(st.floats(3.0, 40.0), st.floats(0.005, 0.4), st.floats(2e-3, 5e-2))
def test_frame_twist_alone_has_its_frequency_and_damping(frequency, zeta, participation):
    """With springs next to nothing the mode is free: its pole is ω (−ζ + i √(1 − ζ²))."""
    soft = {key: value * (1e-6 if "stiffness" in key or "damping" in key else 1.0)
            for key, value in ATV.items()}  # fmt: skip
    theta = {"participation_1_kg": participation, "freq_hz": frequency, "zeta": zeta}
    poles = system_with("frame-twist", theta, soft).poles()
    expected = 2 * pi * frequency * complex(-zeta, np.sqrt(1 - zeta**2))
    assert min(abs(poles - expected)) < 1e-3 * abs(expected)


@given(st.floats(3.0, 40.0), st.floats(2e-3, 2e-2), st.floats(1.0, 30.0))
def test_frame_twist_moves_the_corners_by_plus_and_minus_the_mode(frequency, participation, f):
    """Eliminating the mode: the four strut forces act on it with + − − +, and so it answers."""
    theta = {"participation_1_kg": participation, "freq_hz": frequency, "zeta": 0.05}
    system = system_with("frame-twist", theta)
    shape = system.output[:4, -1]
    np.testing.assert_allclose(shape, [1.0, -1.0, -1.0, 1.0])
    assert not system.output[4:, -1].any()
    assert system.mass[-1, -1] == pytest.approx(1 / participation)
    np.testing.assert_allclose(system.mass[-1, :-1], 0.0)
    struts = sum(2 * ATV[f"suspension.{end}.stiffness_N_m"] for end in ("front", "rear"))
    own = (2 * pi * frequency) ** 2 / participation
    assert system.stiffness[-1, -1] == pytest.approx(own + struts)


def test_frame_twist_leaves_the_middle_of_the_wheelbase_alone():
    """A sensor there, whatever its side, moves with the rigid body only."""
    middle = ATV["geometry.cg_to_front_axle_m"] - ATV["geometry.wheelbase_m"] / 2
    channels = [type(CHANNELS[0])("dash", "body-xy", middle, 0.4)]
    model = Model(
        {
            **ATV,
            "frame-twist.participation_1_kg": 0.02,
            "frame-twist.freq_hz": 9.0,
            "frame-twist.zeta": 0.05,
        },
        (EFFECTS["frame-twist"],),
    )
    assert model.system(channels, "road").output[0, -1] == pytest.approx(0.0, abs=1e-12)


TIME = np.arange(400) / 100.0
UNEVEN = {
    name: truth.Run(truth.Track(kind, size), speed, 36.0, TIME)
    for name, kind, size, speed in (
        ("twist", "chassis-twist", {"amplitude_mm": 150.0, "pitch_mm": 2000.0}, 4.2),
        ("herringbone", "herringbone", {"amplitude_mm": 20.0, "pitch_mm": 800.0}, 5.1),
        ("one side", "one-sided-washboard", {"amplitude_mm": 20.0, "pitch_mm": 600.0}, 3.6),
    )
}


@pytest.fixture(scope="module")
def twisted():
    """By how much a frame that twists changes all records, in band: a column of numbers."""
    campaign = campaign_of(UNEVEN)
    rigid = simulated(campaign, model_of(ATV, UNEVEN))

    def change(freq_hz, zeta, participation):
        theta = {"freq_hz": freq_hz, "zeta": zeta, "participation_1_kg": participation}
        soft = simulated(campaign, model_of(ATV, UNEVEN, "frame-twist", theta))
        return np.concatenate([truth.in_band(soft[k] - rigid[k]).ravel() for k in UNEVEN])

    return change


@pytest.mark.parametrize("freq_hz", [3.5, 4.5, 7.0, 9.5, 14.0, 22.0, 40.0])
def test_a_frames_mode_resembles_itself_from_some_start(twisted, freq_hz):
    """Below its resonance a mode pushes as it pulls above: begun on the wrong side the best it can
    do is not to be there."""
    starts = EFFECTS["frame-twist"].parameters_for(ATV, CHANNELS)[1].starts
    whole = twisted(freq_hz, 0.03, 0.01)
    faint = np.array([twisted(start, 0.05, 1e-4) for start in starts])
    alike = faint @ whole / np.linalg.norm(faint, axis=1) / np.linalg.norm(whole)
    assert alike.max() > 0.7


@given(st.floats(5.0, 40.0), st.floats(-100.0, 100.0), st.floats(-100.0, 100.0))
def test_engine_vibration_is_a_harmonic_force_locked_to_time(frequency, cosine, sine):
    effect, time = EFFECTS["engine-vibration"], np.linspace(0.0, 2.0, 400)
    theta = {"freq_hz": frequency, "cos_m_s2": cosine, "sin_m_s2": sine}
    (history,) = effect.forces(theta, SETTING, time, *np.zeros((2, len(time), 4)))
    amplitude, phase = np.hypot(cosine, sine), np.arctan2(sine, cosine)
    since = time - (SETTING.record_start_s + SETTING.end_s) / 2
    np.testing.assert_allclose(
        history, amplitude * np.cos(2 * pi * frequency * since - phase), atol=1e-9
    )
    summary = effect.summary([OwnValues(SETTING, {**ATV, **theta})] * 2)
    assert summary["force_N"] == pytest.approx(ATV["body.mass_kg"] * amplitude)
    assert summary["spread_fraction"] == summary["wander_fraction"] == 0.0


@settings(max_examples=20)
@given(st.floats(5.0, 40.0), st.floats(-0.1, 0.1), st.integers(0, 2**32 - 1))
def test_the_force_turns_with_an_engine_whose_speed_wanders(frequency, excess, seed):
    """The angle it turns by is 2π times the integral of its own frequency."""
    effect, rng = EFFECTS["engine-vibration"], np.random.default_rng(seed)
    time = np.linspace(SETTING.record_start_s, SETTING.end_s, 20_000)
    history = [p.name for p in effect.per_run(SETTING) if p.name.startswith("coefficient")]
    theta = {"freq_hz": frequency, "excess": excess}
    theta |= dict(zip(history, rng.normal(0.0, 0.01, len(history)), strict=True))
    parts = [
        effect.forces({**theta, part: 1.0}, SETTING, time, *np.zeros((2, len(time), 4)))[0]
        for part in ("cos_m_s2", "sin_m_s2")
    ]
    angle = np.unwrap(np.arctan2(parts[1], parts[0]))
    own_hz = np.gradient(angle, time) / (2 * pi)
    np.testing.assert_allclose(np.hypot(*parts), 1.0)
    summary = effect.summary(
        [OwnValues(SETTING, {**ATV, **theta, "cos_m_s2": 1.0, "sin_m_s2": 0.0})]
    )
    wander = own_hz / frequency - 1.0 - excess
    assert np.sqrt(np.var(wander)) == pytest.approx(summary["wander_fraction"], rel=0.05)


@settings(max_examples=10)
@given(st.floats(6.0, 30.0), st.integers(0, 2**32 - 1))
def test_an_engine_that_idles_unsteadily_is_followed(frequency, seed):
    """Five runs up to 16 % apart, wandering by 1.6 % in 3 to 8 s: the fit may begin near its
    phase all along, in noise as large as the line."""
    effect, rng = EFFECTS["engine-vibration"], np.random.default_rng(seed)
    time, residuals, angles = np.arange(1024) / 100.0, {}, {}
    for i in range(5):
        period, own = rng.uniform(3.0, 8.0), frequency * (1 + rng.uniform(-0.08, 0.08))
        wander = 0.016 * np.sqrt(2) * period / (2 * pi) * np.cos(2 * pi * time / period)
        angles[f"run {i}"] = 2 * pi * own * (time + wander) + rng.uniform(0.0, 2 * pi)
        line = np.cos(angles[f"run {i}"])[:, None] * rng.choice([-1.0, 1.0], 8)
        residuals[f"run {i}"] = rng.normal(size=(1024, 8)) + np.sqrt(2) * line
    probe = Records(residuals)
    shapes = effect.shape_starts(probe)[0]
    assert shapes["freq_hz"] == pytest.approx(frequency, rel=0.12)
    for run in probe.settings:
        theta = {**shapes, **effect.run_starts(probe, run, shapes)[0]}
        cosine, sine = (
            effect.forces({**theta, part: 1.0}, run, time, *np.zeros((2, len(time), 4)))[0]
            for part in ("cos_m_s2", "sin_m_s2")
        )
        away = np.exp(1j * angles[run.run_id]) * (cosine - 1j * sine)
        away = np.angle(away * np.conj(away.mean()))
        assert np.sqrt(np.mean(away**2)) < 0.7  # a turn lost or gained would be 1.8


def test_engine_vibration_pushes_at_the_engine():
    system = system_with("engine-vibration", {"freq_hz": 20.0})
    expected = [1.0, -ATV["engine.x_m"], ATV["engine.y_m"], 0, 0, 0, 0]
    np.testing.assert_allclose(system.force[:, 0], ATV["body.mass_kg"] * np.array(expected))


class Records:
    """Residuals of some runs, as an effect's probe sees them."""

    def __init__(self, residuals, rate_hz=100.0):
        self._residuals, self._rate = residuals, rate_hz

    @property
    def settings(self):
        return [RunSetting(name, 4.0, -4.0, 0.0, 10.0, True) for name in self._residuals]

    def time_s(self, run_id):
        return np.arange(len(self._residuals[run_id])) / self._rate

    def measured(self, run_id):
        return self._residuals[run_id]

    def modelled(self, run_id, changes):
        return np.zeros_like(self._residuals[run_id])


@settings(max_examples=20)
@given(st.floats(3.0, 40.0), st.integers(0, 2**32 - 1))
def test_engine_vibration_finds_its_line_in_noise(frequency, seed):
    """Lines of one frequency and any phase, half as strong as the noise, in three runs."""
    rng = np.random.default_rng(seed)
    time = np.arange(1024) / 100.0
    residuals = {
        f"run {i}": rng.normal(size=(1024, 8))
        + 0.5 * np.cos(2 * pi * frequency * time + rng.uniform(0, 2 * pi))[:, None]
        for i in range(3)
    }
    starts = EFFECTS["engine-vibration"].shape_starts(Records(residuals))
    assert starts[0]["freq_hz"] == pytest.approx(frequency, abs=0.05)
