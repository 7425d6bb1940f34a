"""A real sensor against a real reference on a shaker."""

import datetime as dt
from pathlib import Path

import numpy as np
import pytest

from wheelhop.calibration.conditions import Conditions
from wheelhop.calibration.shaker.comparison import compare_with_reference
from wheelhop.formats import read
from wheelhop.logger.recording import Channel, Recording

FOLDER = Path(__file__).parents[1] / "data/accelerometer-calibration"
DAY = dt.date(2026, 1, 1)


def sweep(name, **conditions):
    values = read(FOLDER / f"sweep-{name}hz.parquet").values
    reference, sensor = (
        Recording(values[:, [k]], 400.0, (Channel(word, "m/s²"),))
        for k, word in enumerate(("reference", "sensor"))
    )
    known = Conditions("real", DAY, DAY, reference_expanded=0.01, **conditions)
    return compare_with_reference(reference, sensor, known)


@pytest.mark.parametrize("name", ["0-5", "0-10"])
def test_the_gain_is_one_and_the_clocks_are_0_38_s_apart(name):
    found = sweep(name)
    (channel,) = found.channels
    assert channel.gain.value == pytest.approx(1.00, abs=0.05)
    assert -found.offset_s.value == pytest.approx(0.38, abs=0.03)
    points = channel.points
    band = (points.frequency_hz > 1.8) & (points.frequency_hz < 10.0) & (points.coherence > 0.99)
    size = np.abs(points.ratio[band])
    assert band.sum() >= 10 and size.min() > 0.95 and size.max() < 1.055


@pytest.mark.parametrize("name", ["0-1", "0-5", "0-10"])
def test_below_0_8_hz_it_calls_them_unusable_itself(name):
    try:
        found = sweep(name)
    except ValueError:
        assert name == "0-1"  # one band is left of it: too little to compare clocks by
        return
    low, _ = found.channels[0].usable_hz
    assert low == pytest.approx(0.8, abs=0.1)
    assert any(f"unusable below {low:.2g} Hz" in line for line in found.findings)


@pytest.mark.parametrize("name", ["0-5", "0-10"])
def test_with_the_high_pass_that_it_suspects_it_is_one_from_1_hz_on(name):
    plain = sweep(name)
    assert any("as if the reference had a high-pass at 0." in line for line in plain.findings)
    told = sweep(name, high_pass_hz=0.6)
    points = told.channels[0].points
    band = (points.frequency_hz > 1.4) & (points.frequency_hz < 10.0) & (points.coherence > 0.98)
    np.testing.assert_allclose(np.abs(points.ratio[band]), 1.0, atol=0.05)
