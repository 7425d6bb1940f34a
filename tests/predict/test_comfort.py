"""ISO 2631-1: the weighting is the standard's table, figures are those of closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.predict.comfort import comfort, weighted, wk

# ISO 2631-1:1997, table 3, Wk in thousandths, at the rounded centres of third-octaves.
CENTRES_HZ = tuple(
    base * 10**decade
    for decade in (-1, 0, 1, 2)
    for base in (1, 1.25, 1.6, 2, 2.5, 3.15, 4, 5, 6.3, 8)
)
TABLE = (
    *(31.2, 48.6, 79.0, 121, 182, 263, 352, 418, 459, 477, 482, 484, 494, 531, 631, 804, 967),
    *(1039, 1054, 1036, 988, 902, 768, 636, 513, 405, 314, 246, 186, 132, 88.7, 54.0, 28.5, 15.2),
    *(7.90, 3.98, 1.95),
)


def test_the_weighting_is_that_of_the_standards_table():
    assert 1000 * abs(wk(CENTRES_HZ[: len(TABLE)])) == pytest.approx(np.array(TABLE), rel=0.003)


def test_a_sine_comes_out_with_its_gain():
    rate_hz, f = 1000.0, 8.0
    time_s = np.arange(20_000) / rate_hz
    felt = weighted(3.0 * np.sin(2 * np.pi * f * time_s), rate_hz)[5000:15_000]
    found = comfort(felt, rate_hz)
    amplitude = 3.0 * abs(wk(f))
    assert found.rms_m_s2 == pytest.approx(amplitude / np.sqrt(2), rel=1e-3)
    # The mean of sin^4 is 3/8, over 10 s.
    assert found.vdv_m_s1_75 == pytest.approx(amplitude * (3 / 8 * 10.0) ** 0.25, rel=1e-3)


def test_the_loggers_nyquist_frequency_cuts_what_lies_above():
    time_s = np.arange(10_000) / 1000.0
    fast = np.sin(2 * np.pi * 60.0 * time_s)
    whole, cut = weighted(fast, 1000.0), weighted(fast, 1000.0, 50.0)
    assert np.std(cut[2000:-2000]) < 0.01 * np.std(whole[2000:-2000])


@given(st.floats(0.1, 10.0), st.integers(0, 50))
def test_figures_grow_with_the_motion(factor, seed):
    felt = np.random.default_rng(seed).normal(size=500)
    one, more = comfort(felt, 100.0), comfort(factor * felt, 100.0)
    assert more.rms_m_s2 == pytest.approx(factor * one.rms_m_s2)
    assert more.vdv_m_s1_75 == pytest.approx(factor * one.vdv_m_s1_75)
