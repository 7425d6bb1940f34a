"""Late, clipped and loosely mounted channels: what the instrument makes of known signals."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.signal import butter, sosfiltfilt

from tests.simulate.setup import ATV, CHANNELS, EFFECTS
from wheelhop.effects import RunSetting, Switch

NAMES = [c.name for c in CHANNELS]
RATE = 100.0
TIME = np.arange(600) / RATE
INSIDE = slice(150, 450)
"""Far from the ends, where no filter can know what came before."""

channels = st.sampled_from(NAMES)
frequencies = st.floats(0.5, 30.0)


@given(frequencies, st.floats(-2e-3, 2e-3))
def test_each_column_is_read_later_than_the_one_before(frequency, delay):
    phase = 2 * np.pi * frequency * TIME
    record = np.repeat(np.cos(phase)[:, None], 8, axis=1)
    found = EFFECTS["sensor-skew"].sense({"delay_s": delay}, record, CHANNELS, RATE)
    for j in range(8):
        expected = np.cos(phase + 2 * np.pi * frequency * j * delay)
        np.testing.assert_allclose(found[INSIDE, j], expected[INSIDE], atol=0.01)


@given(st.integers(0, 2**32 - 1), st.floats(0.1, 3.0), st.sampled_from([*NAMES, "all"]))
def test_clipping_leaves_what_is_within_the_range_and_holds_the_rest_at_it(seed, limit, channel):
    record = np.random.default_rng(seed).normal(size=(50, 8))
    theta = {"clips": 1.0, "limit_m_s2": limit}
    found = EFFECTS["sensor-clipping"].with_choice(channel).sense(theta, record, CHANNELS, RATE)
    for i, name in enumerate(NAMES):
        if channel in (name, "all"):
            inside = np.abs(record[:, i]) <= limit
            np.testing.assert_allclose(found[inside, i], record[inside, i])
            np.testing.assert_allclose(found[~inside, i], limit * np.sign(record[~inside, i]))
        else:
            np.testing.assert_array_equal(found[:, i], record[:, i])


def read(effect, theta, frequency, column):
    """Amplitude and phase of the channel's reading of a sine of amplitude 1."""
    record = np.zeros((len(TIME), 8))
    record[:, column] = np.cos(2 * np.pi * frequency * TIME)
    found = effect.sense(theta, record, CHANNELS, RATE)
    basis = np.exp(2j * np.pi * frequency * TIME[INSIDE])
    matrix = np.stack([basis.real, -basis.imag], axis=1)
    cosine, sine = np.linalg.lstsq(matrix, found[INSIDE, column], rcond=None)[0]
    np.testing.assert_array_equal(np.delete(found, column, 1), 0.0)
    return complex(cosine, sine)


@given(channels, st.floats(1.0, 30.0), st.floats(12.0, 90.0), st.floats(0.1, 0.7))
def test_a_mount_transmits_as_a_mass_on_a_spring(channel, frequency, resonance, zeta):
    """|H|² = (1 + (2ζr)²) / ((1 − r²)² + (2ζr)²) (Rao, eq. 3.68), the sensor lagging."""
    theta = {"loose": 1.0, "freq_hz": resonance, "zeta": zeta}
    effect = EFFECTS["sensor-mount"].with_choice(channel)
    found = read(effect, theta, frequency, NAMES.index(channel))
    r = frequency / resonance
    power = (1 + (2 * zeta * r) ** 2) / ((1 - r**2) ** 2 + (2 * zeta * r) ** 2)
    assert abs(found) ** 2 == pytest.approx(power, rel=0.02)
    assert found.imag < 1e-3


@settings(max_examples=15)
@given(st.floats(8.0, 60.0), st.floats(0.01, 0.9), st.floats(0.5, 30.0), st.floats(0.0, 6.0))
def test_a_mount_moves_as_its_equation_says_from_the_first_sample_on(resonance, zeta, f, phase):
    """Beside a fine integration of r″ + 2ζω r′ + ω² r = −a; the sensor reads a + r″."""
    own, rate, time = 2 * np.pi * resonance, 1000.0, np.arange(1000) / 1000.0
    record = np.zeros((len(time), 8))
    record[:, 2] = np.cos(2 * np.pi * f * time + phase)
    theta = {"loose": 1.0, "freq_hz": resonance, "zeta": zeta}
    found = EFFECTS["sensor-mount"].with_choice("B3").sense(theta, record, CHANNELS, rate)[:, 2]

    def motion(t, state):
        foot = np.cos(2 * np.pi * f * t + phase)
        return state[1], -2 * zeta * own * state[1] - own**2 * state[0] - foot

    solved = solve_ivp(motion, (0.0, 1.0), (0.0, 0.0), t_eval=time, rtol=1e-8, atol=1e-12)
    reading = -2 * zeta * own * solved.y[1] - own**2 * solved.y[0]
    np.testing.assert_allclose(found[:-20], reading[:-20], atol=0.01 * np.abs(reading).max())


@settings(max_examples=30)
@given(st.floats(12.0, 60.0), st.floats(0.01, 0.3), st.floats(-9.0, 9.0), st.floats(-9.0, 9.0))
def test_a_mount_that_was_struck_before_rings_down_and_its_foot_stands_still(f, zeta, cosine, sine):
    effect, rate = EFFECTS["sensor-mount"].with_choice("B3"), 1000.0
    theta = {"loose": 1.0, "freq_hz": f, "zeta": zeta}
    theta |= {"ring_cos_m_s2": cosine, "ring_sin_m_s2": sine}
    since = np.arange(-200, 1000) / rate
    ring = effect.lingering(theta, since, CHANNELS)
    if cosine == sine == 0.0:
        assert ring is None
        return
    reading, damped = ring[:, 2], 2 * np.pi * f * np.sqrt(1 - zeta**2)
    assert not np.delete(ring, 2, axis=1).any() and not reading[:200].any()
    after = np.clip(since, 0.0, None)
    turning = cosine * np.cos(damped * after) + sine * np.sin(damped * after)
    np.testing.assert_allclose(
        reading[200:], (np.exp(-zeta * 2 * np.pi * f * after) * turning)[200:], atol=1e-9
    )
    foot = effect.restore(theta, ring[200:], CHANNELS, rate)[:, 2]
    assert np.abs(foot[100:-100]).max() < 0.02 * np.hypot(cosine, sine)


def test_a_mount_is_stiff_below_and_gives_way_above_its_resonance():
    effect = EFFECTS["sensor-mount"].with_choice("A1")
    theta = {"loose": 1.0, "freq_hz": 15.0, "zeta": 0.05}
    assert read(effect, theta, 1.0, 4) == pytest.approx(1.0, abs=0.01)
    assert abs(read(effect, theta, 15.0, 4)) == pytest.approx(10.0, rel=0.03)
    assert abs(read(effect, theta, 30.0, 4)) < 0.4


@settings(max_examples=10)
@given(st.floats(12.0, 45.0), st.floats(0.01, 0.3), st.integers(0, 2**32 - 1))
def test_what_a_mount_hides_of_its_foot_lies_at_the_ends_of_the_record(resonance, zeta, seed):
    """Motion up to 30 Hz, sampled at 100: but for a tenth of a second at each end, where what the
    mount did before and after counts, the foot is known to a tenth."""
    rate, time = 2000.0, np.arange(20000) / 2000.0
    white = np.random.default_rng(seed).normal(size=len(time))
    slow = butter(6, (1.0, 30.0), "bandpass", fs=rate, output="sos")
    record = np.zeros((len(time), 8))
    record[:, 4] = sosfiltfilt(slow, white)
    effect = EFFECTS["sensor-mount"].with_choice("A1")
    theta = {"loose": 1.0, "freq_hz": resonance, "zeta": zeta}
    sensed = effect.sense(theta, record, CHANNELS, rate)[10000::20]
    foot = record[10000::20, 4]
    error = (effect.restore(theta, sensed, CHANNELS, 100.0)[:, 4] - foot) / foot.std()
    assert error[10:-10].std() < 0.1
    assert np.abs(error[[0, -1]]).max() > error[10:-10].std()


class Records:
    """One run, measured and modelled, as an effect's probe sees it."""

    channels = CHANNELS
    settings = (RunSetting("run", 4.0, -4.0, 0.0, 6.0, True),)

    def __init__(self, measured, modelled):
        self._measured, self._modelled = measured, modelled

    def time_s(self, run_id):
        return TIME

    def recorded(self, run_id):
        return self._measured

    def measured(self, run_id):
        return self._measured

    def modelled(self, run_id, changes):
        return self._modelled


@settings(max_examples=20)
@given(channels, st.floats(12.0, 45.0), st.floats(0.03, 0.3), st.integers(0, 2**32 - 1))
def test_the_resonance_is_found_in_what_one_channel_adds(channel, resonance, zeta, seed):
    """Measured over modelled, a tenth of noise: the fit may begin within 15 % of the resonance."""
    rng, i = np.random.default_rng(seed), NAMES.index(channel)
    true = rng.normal(size=(len(TIME), 8))
    effect = EFFECTS["sensor-mount"].with_choice(channel)
    theta = {"loose": 1.0, "freq_hz": resonance, "zeta": zeta}
    measured = effect.sense(theta, true, CHANNELS, RATE) + 0.1 * rng.normal(size=true.shape)
    (start,) = effect.shape_starts(Records(measured, true))
    assert start["freq_hz"] == pytest.approx(resonance, rel=0.15)
    (other,) = effect.with_choice(NAMES[i - 1]).shape_starts(Records(measured, true))
    assert other["freq_hz"] > 100.0  # nothing there: as stiff as can be


def test_a_channel_that_drives_the_model_is_tried_at_several_resonances():
    """Nothing is said of it, so nothing tells the resonance; what a mount does to the body grows
    with 1/f²: no resonance in band is further than a factor of two from the next, in that."""
    nothing = np.zeros((len(TIME), 8))
    effect = EFFECTS["sensor-mount"].with_choice("A3")
    starts = [s["freq_hz"] for s in effect.shape_starts(Records(nothing, nothing))]
    for resonance in np.geomspace(9.0, 60.0, 50):
        assert np.abs(np.log2(np.square(starts) / resonance**2)).min() < 1.0


def test_the_range_is_the_largest_reading():
    record = np.clip(np.random.default_rng(4).normal(size=(len(TIME), 8)), -1.5, 1.5)
    record[7, 0] = 9.0
    for channel, expected in (("A2", 1.5), ("B1", 9.0), ("all", 9.0)):
        effect = EFFECTS["sensor-clipping"].with_choice(channel)
        assert effect.shape_starts(Records(record, record)) == [{"limit_m_s2": expected}]


def test_faults_of_one_channel_are_tried_on_every_channel():
    assert EFFECTS["sensor-mount"].choices(CHANNELS) == NAMES
    assert EFFECTS["sensor-clipping"].choices(CHANNELS) == [*NAMES, "all"]
    for name in ("sensor-mount", "sensor-clipping"):
        form = EFFECTS[name].with_choice("B1")
        switches = [p for p in form.parameters_for(ATV, CHANNELS) if isinstance(p, Switch)]
        assert len(switches) == 1  # loose or not: only the resonance, the range are fitted


def test_one_channel_alone_has_nobody_to_be_late_for():
    assert EFFECTS["sensor-skew"].parameters_for(ATV, CHANNELS[:1]) == ()
