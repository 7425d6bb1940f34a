"""Faults of the instrument: what they do to the channels, and to no other."""

from itertools import combinations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tests.simulate.setup import ATV, CHANNELS, EFFECTS
from wheelhop.campaign import Channel
from wheelhop.effects import Switch

NAMES = [c.name for c in CHANNELS]
RECORD = np.random.default_rng(2).normal(size=(40, 8))


@given(st.sampled_from(NAMES), st.floats(-0.9, 4.0))
def test_sensor_gain_scales_one_channel(name, error):
    effect, i = EFFECTS["sensor-gain"].with_choice(name), NAMES.index(name)
    found = effect.sense({"error": error}, RECORD, CHANNELS, 100.0)
    np.testing.assert_allclose(found[:, i], (1 + error) * RECORD[:, i])
    np.testing.assert_array_equal(np.delete(found, i, 1), np.delete(RECORD, i, 1))


def test_sensor_gain_never_inverts():
    """An inverted channel is another effect, so the gain stays above zero."""
    (error,) = EFFECTS["sensor-gain"].with_choice("B1").parameters_for(ATV, CHANNELS)
    assert error.lower > -1.0


@given(st.sampled_from(NAMES))
def test_sensor_polarity_inverts_one_channel(name):
    effect, i = EFFECTS["sensor-polarity"].with_choice(name), NAMES.index(name)
    found = effect.sense({"wrong": 1.0}, RECORD, CHANNELS, 100.0)
    np.testing.assert_allclose(found[:, i], -RECORD[:, i], atol=1e-14)
    np.testing.assert_array_equal(np.delete(found, i, 1), np.delete(RECORD, i, 1))


@given(st.sampled_from(list(combinations(range(8), 2))))
def test_sensor_polarity_swaps_two_channels(pair):
    i, j = pair
    effect = EFFECTS["sensor-polarity"].with_choice(f"{NAMES[i]}/{NAMES[j]}")
    found = effect.sense({"wrong": 1.0}, RECORD, CHANNELS, 100.0)
    expected = RECORD.copy()
    expected[:, [i, j]] = RECORD[:, [j, i]]
    np.testing.assert_allclose(found, expected, atol=1e-14)


@given(
    st.lists(st.text("aé/. ", min_size=1, max_size=3), min_size=8, max_size=8, unique=True)
    | st.permutations(["a", "b", "a/b", "a//b", "/", "//", "b/a", "a/"])
)
def test_sensor_polarity_takes_no_name_apart(names):
    """Each choice is one channel inverted, or one pair swapped, and no two are the same."""
    channels = [Channel(name, "A1") for name in names]
    effect = EFFECTS["sensor-polarity"]
    choices = effect.choices(channels)
    made = [
        effect.with_choice(choice).sense({"wrong": 1.0}, RECORD, channels, 100.0)
        for choice in choices
    ]
    assert choices[:8] == names and len(set(choices)) == 8 + 28
    for i, found in enumerate(made[:8]):
        np.testing.assert_array_equal(np.delete(found, i, 1), np.delete(RECORD, i, 1))
        np.testing.assert_allclose(found[:, i], -RECORD[:, i])
    for (i, j), found in zip(combinations(range(8), 2), made[8:], strict=True):
        expected = RECORD.copy()
        expected[:, [i, j]] = RECORD[:, [j, i]]
        np.testing.assert_allclose(found, expected, atol=1e-14)


def test_sensor_polarity_tries_every_channel_and_every_pair():
    choices = EFFECTS["sensor-polarity"].choices(CHANNELS)
    assert len(set(choices)) == len(choices) == 8 + 28
    (wrong,) = EFFECTS["sensor-polarity"].with_choice("B1").parameters_for(ATV, CHANNELS)
    assert isinstance(wrong, Switch)  # nothing is fitted: a cable is right or wrong
    assert EFFECTS["sensor-gain"].choices(CHANNELS) == NAMES


def test_what_came_just_before_and_after_is_all_a_restored_mount_lacks():
    """Cut from a longer record, the foot's motion comes back but for the two jumps at its ends."""
    rate_hz, n, around = 100.0, 1000, 2000
    rng, mount = np.random.default_rng(4), EFFECTS["sensor-mount"].with_choice("A1")
    theta = {"loose": 1.0, "freq_hz": 24.5, "zeta": 0.03}
    frequency_hz = np.fft.rfftfreq(n + 2 * around, 1 / rate_hz)
    foot = np.fft.rfft(rng.normal(size=n + 2 * around)) * (np.abs(frequency_hz - 20) < 19)
    ratio = frequency_hz / theta["freq_hz"]
    damper = 1 + 2j * theta["zeta"] * ratio
    inside = slice(around, around + n)
    truth, measured = (
        np.fft.irfft(s)[inside, None] for s in (foot, foot * damper / (damper - ratio**2))
    )

    of_axle = [c for c in CHANNELS if c.name == "A1"]

    def restored(**jumps):
        return mount.restore(theta | jumps, measured, of_axle, rate_hz)[:, 0]

    begun = restored()
    wrong = truth[:, 0] - begun
    known = np.stack([restored(before_m_s2=1.0), restored(after_m_s2=1.0)], axis=1) - begun[:, None]
    left = wrong - known @ np.linalg.lstsq(known, wrong, rcond=None)[0]
    assert np.abs(wrong).max() > 0.5 * truth.std()
    assert np.sum(left**2) < 0.02 * np.sum(wrong**2)
