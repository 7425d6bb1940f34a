"""What is left is the sensors' own noise, more of it than stated, or something that is missing."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal, stats

from tests import truth
from tests.diagnose.cases import LIBRARY
from tests.diagnose.test_score import noise, rung
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import diagnose
from wheelhop.diagnose.posterior import noisier_sensors
from wheelhop.diagnose.score import by_chance
from wheelhop.fit import louder
from wheelhop.vehicle import read_nominal


def test_noise_that_is_alike_in_every_run_is_noise():
    """One set of records in ten has a chance of a tenth or less."""
    rng, tries = np.random.default_rng(1), 200
    chances = [noisier_sensors(rung(noise(rng), own=0), 1.0) for _ in range(tries)]
    rare = sum(chance <= 0.1 for chance in chances)
    assert abs(rare - 0.1 * tries) <= 3 * np.sqrt(0.09 * tries)


@pytest.mark.parametrize("coloured", [False, True])
def test_sensors_a_fifth_noisier_than_stated(coloured):
    """More than the stated noise leaves, whether white or with twice the power at low frequency;
    nor need the channels be alike."""
    rng = np.random.default_rng(2)
    signals = [1.2 * one * [1.0, 1.2] for one in noise(rng)]
    if coloured:
        signals = [signal.lfilter([1.0], [1.0, -0.3], one, axis=0) for one in signals]
    left = rung(signals, own=0)
    assert by_chance(left, 1.0) < 1e-9
    assert noisier_sensors(left, 1.0) > 0.05


def test_what_is_stronger_in_one_run_than_in_others_is_no_noise():
    """A sine of a tenth of one run's power; all is 1.7 % more than noise."""
    signals = noise(np.random.default_rng(3))
    time_s = np.arange(len(signals[0])) / 100.0
    signals[2] = signals[2] + 0.45 * np.sin(2.0 * np.pi * 7.0 * time_s)[:, None]
    assert noisier_sensors(rung(signals, own=0), 1.0) < 1e-3


@pytest.mark.parametrize("frequencies", [(3, 8, 13, 18, 23, 28), (4, 12, 4, 12, 4, 12)])
def test_what_moves_through_the_band_with_the_speed_is_no_noise(frequencies):
    """Of the same power in every run, at other frequencies: at six speeds, or at two of which one
    is three times the other and both leave what they bring in the lower half of the band."""
    signals = noise(np.random.default_rng(4))
    time_s = np.arange(len(signals[0])) / 100.0
    for one, frequency_hz in zip(signals, frequencies, strict=True):
        one += 0.5 * np.sin(2.0 * np.pi * frequency_hz * time_s)[:, None]
    assert noisier_sensors(rung(signals, own=0), 1.0) < 1e-3


def test_sensors_three_times_as_noisy_as_stated_are_not_believed():
    assert noisier_sensors(rung(noise(np.random.default_rng(5), 3.0), own=0), 1.0) < 0.01


def test_one_run_does_not_tell():
    signals = noise(np.random.default_rng(6))[:1]
    assert noisier_sensors(rung(signals, own=0), 1.0) == 0.0


def test_the_stated_noise_is_as_sure_as_eight_data_would_make_it():
    """χ² of eight data over its mean falls short of one over the ratio as often."""
    drawn = stats.chi2.rvs(8, size=20000, random_state=7) / 8.0
    for ratio in (0.5, 1.0, 1.3, 2.0):
        assert louder(ratio) == pytest.approx(np.mean(drawn <= 1.0 / ratio), abs=0.01)


def test_noise_stated_a_fifth_too_low_is_no_unknown(tmp_path):
    """It is more than the floor's uncertainty, and as strong in every run."""
    folder = truth.make_campaign(
        tmp_path, seed=101, effects={}, noise_rms=0.25, short=True, seconds=6.4, draft=True
    )
    campaign = read_campaign(folder)
    assert campaign.noise_rms is not None
    quieter = replace(campaign, noise_rms=0.8 * campaign.noise_rms)
    library = {name: LIBRARY[name] for name in ("dry-friction", "driver-seat")}
    found = diagnose(quieter, read_nominal(campaign), library, jobs=1)
    assert found.ladder[-1].above_floor
    assert found.verdict == ("none",)
    assert found.confidence > 0.5
    assert any("more of it than stated" in line for line in found.explanation)
