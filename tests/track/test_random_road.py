"""The random road: spectrum, coherence between wheel paths, reproducibility."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import coherence, welch
from scipy.special import gamma, kv

from wheelhop.campaign import TrackSpec
from wheelhop.track import Track, make_track

STEP = 1 / 32  # m


def road(unevenness_m3: float = 16e-6, waviness: float = 2.0, seed: float = 1.0) -> Track:
    values = {"unevenness_m3": unevenness_m3, "waviness": waviness, "seed": seed}
    return make_track(TrackSpec("iso8608", values))


def sampled(ground: Track, y: float) -> np.ndarray:
    return ground.elevation(np.arange(0.0, ground.period_m or 0.0, STEP), y)


@pytest.mark.parametrize("waviness", [1.5, 2.0, 2.6])
def test_its_spectrum_is_the_one_asked_for(waviness: float) -> None:
    # welch gives m² per cycle/m: divided by 2π it is per rad/m. Octave means of many lines and
    # averages scatter by a few per cent.
    waves_per_m, density = welch(
        sampled(road(16e-6, waviness), 0.6), 1 / STEP, nperseg=4096, window="hann"
    )
    for low in (0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2):
        octave = (waves_per_m >= low) & (waves_per_m < 2 * low)
        expected = 16e-6 * (2 * np.pi * waves_per_m[octave]) ** -waviness * 2 * np.pi
        assert np.mean(density[octave] / expected) == pytest.approx(1.0, abs=0.15)


def test_its_variance_is_the_integral_of_the_spectrum() -> None:
    z = road().elevation(np.arange(1 << 16) / 64, -0.4)
    variance = 16e-6 * (1 / (2 * np.pi * 0.01) - 1 / (2 * np.pi * 10))
    assert np.var(z) == pytest.approx(variance, rel=0.05)
    assert abs(z.mean()) < 1e-6


@pytest.mark.parametrize("waviness", [2.0, 2.5])
def test_wheel_paths_are_as_coherent_as_on_an_isotropic_surface(waviness: float) -> None:
    apart = 1.2
    waves_per_m = np.linspace(0.03, 0.6, 12)
    found = np.zeros((20, 12))
    for seed in range(20):
        ground = road(waviness=waviness, seed=float(seed))
        n, gamma2 = coherence(
            sampled(ground, apart / 2), sampled(ground, -apart / 2), 1 / STEP, nperseg=4096
        )
        found[seed] = np.interp(waves_per_m, n, gamma2)
    u, order = 2 * np.pi * waves_per_m * apart, waviness / 2
    expected = (2 ** (1 - order) / gamma(order) * u**order * kv(order, u)) ** 2
    # 15 half-overlapping Hann segments bias a low coherence up by about (1 - γ²)²/15.
    biased = expected + (1 - expected) ** 2 / 15
    np.testing.assert_allclose(found.mean(axis=0), biased, atol=0.08)


def test_the_same_seed_gives_the_same_road_and_another_seed_another() -> None:
    x = np.linspace(0, 50, 1000)
    first, again, other = (road(seed=seed).elevation(x, 0.5) for seed in (3.0, 3.0, 4.0))
    np.testing.assert_array_equal(first, again)
    assert np.abs(np.corrcoef(first, other)[0, 1]) < 0.9


def test_it_scales_with_the_root_of_its_unevenness() -> None:
    x = np.linspace(0, 50, 1000)
    np.testing.assert_allclose(
        road(64e-6).elevation(x, 0.5), 2 * road(16e-6).elevation(x, 0.5), rtol=1e-12
    )


def test_it_is_smooth_between_the_points_of_its_table() -> None:
    x = 7.0 + np.linspace(0, 1, 20001)
    bend = np.diff(road().elevation(x, 0.5), 2) / np.diff(x)[0] ** 2
    rms = np.sqrt(16e-6 * ((2 * np.pi * 10) ** 3 / 3))  # ∫ Ω⁴ S dΩ, w = 2
    assert np.abs(bend).max() < 6 * rms


def test_different_paths_in_one_call() -> None:
    x = np.linspace(0, 5, 11)
    both = road().elevation(x[:, None], [0.5, -0.5])
    np.testing.assert_array_equal(both[:, 0], road().elevation(x, 0.5))
    np.testing.assert_array_equal(both[:, 1], road().elevation(x, -0.5))
