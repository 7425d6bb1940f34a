"""Frequency responses estimated from runs, where the answer is known."""

import numpy as np
import pytest

from wheelhop.campaign import CampaignError
from wheelhop.identify import Spectra, frf

GAIN = np.array([[1.0, 0.5j], [-0.3, 2.0 - 1.0j]])


def runs(output_noise=0.0, input_noise=0.0, count=80, seed=0):
    rng = np.random.default_rng(seed)

    def noise(size):
        return size * (
            rng.standard_normal((count, 60, 2)) + 1j * rng.standard_normal((count, 60, 2))
        )

    y = noise(1.0)
    x = y @ GAIN.T
    omega = np.linspace(1.0, 100.0, 60)
    return Spectra(("a",) * count, omega, y + noise(input_noise), x + noise(output_noise), 200)


@pytest.mark.parametrize("kind", ["H1", "H2", "Hv"])
def test_without_noise_all_agree_and_are_coherent(kind):
    found = frf([runs()], kind)
    assert np.allclose(found.matrix, GAIN)
    assert np.allclose(found.coherence, 1.0)


def test_noise_biases_each_the_way_it_must():
    """H1 is right with noise on outputs, H2 with noise on inputs, Hv with the same on both."""

    def off(kind, made):
        return np.abs(frf([made], kind).matrix.mean(axis=0) - GAIN).max()

    outputs, inputs = runs(output_noise=0.5), runs(input_noise=0.5)
    both = runs(output_noise=0.5, input_noise=0.5)
    assert off("H1", outputs) < 0.03 < off("H2", outputs)
    assert off("H2", inputs) < 0.03 < off("H1", inputs)
    assert off("Hv", both) < 0.06 < min(off("H1", both), off("H2", both))


def test_standard_error_and_coherence_are_those_of_repeated_experiments():
    found = [frf([runs(output_noise=0.5, seed=seed)]) for seed in range(30)]
    spread = np.mean([np.abs(one.matrix - GAIN) ** 2 / 2 for one in found], axis=(0, 1))
    claimed = np.mean([one.standard_error**2 for one in found], axis=(0, 1))
    assert np.sqrt(spread / claimed) == pytest.approx(np.ones((2, 2)), abs=0.1)
    truth = (np.abs(GAIN) ** 2).sum(axis=1) / ((np.abs(GAIN) ** 2).sum(axis=1) + 0.25)
    assert np.mean([one.coherence for one in found], axis=(0, 1)) == pytest.approx(truth, abs=0.01)


def test_what_cannot_be_estimated_is_one_line():
    with pytest.raises(CampaignError, match="1 samples for 2 inputs"):
        frf([runs(count=1)], lines=1)
    with pytest.raises(CampaignError, match="odd number"):
        frf([runs()], lines=4)
    wide = runs()
    wide = Spectra(wide.runs, wide.omega, wide.inputs, wide.outputs[:, :, :1], 200)
    with pytest.raises(CampaignError, match="as many outputs"):
        frf([wide], "H2")
