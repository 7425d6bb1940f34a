"""The recorder's filter: what it does to a sine, and how campaign.toml states it."""

import numpy as np
import pytest

from tests.campaign.build import edit, write_campaign
from wheelhop.campaign import Averaging, CampaignError, read_campaign
from wheelhop.campaign.channels import read_channels, with_filters
from wheelhop.campaign.low_pass import LowPass, responses
from wheelhop.files import parse_toml

FREQUENCY = np.linspace(0.0, 200.0, 41)


@pytest.mark.parametrize("order", [1, 2, 4, 8])
def test_a_butterworth_filter_is_as_flat_as_it_can_be(order):
    """|H|² = 1/(1 + (f/f_c)^2n), and it delays: the first order by 1/ω_c at low frequencies."""
    found = LowPass("butterworth", order, 60.0).response(FREQUENCY)
    np.testing.assert_allclose(np.abs(found) ** 2, 1 / (1 + (FREQUENCY / 60.0) ** (2 * order)))
    assert (np.diff(np.unwrap(np.angle(found))) < 0.0).all()


def test_a_bessel_filter_delays_all_alike():
    """Its group delay is flat well below the corner, where a Butterworth filter's grows."""

    def spread(kind):
        frequency = np.linspace(1.0, 40.0, 40)
        phase = np.unwrap(np.angle(LowPass(kind, 4, 60.0).response(frequency)))
        delay = -np.diff(phase) / np.diff(2 * np.pi * frequency)
        return np.ptp(delay) / delay.mean()

    assert abs(LowPass("bessel", 4, 60.0).response(np.array([60.0]))[0]) == pytest.approx(0.5**0.5)
    assert spread("bessel") < 0.01 < 0.1 < spread("butterworth")


def test_taps_alike_are_a_mean_that_comes_later():
    """Seven equal taps at 1000 Hz: the mean of seven values 1 ms apart, the middle one 3 ms ago."""
    fir = LowPass("fir", taps=(1 / 7,) * 7, rate_hz=1000.0)
    later = np.exp(-2j * np.pi * FREQUENCY * 0.003)
    np.testing.assert_allclose(
        fir.response(FREQUENCY), Averaging(0.0, 7, 0.001).kept(FREQUENCY) * later, atol=1e-12
    )


def test_forward_and_backward_delays_nothing_and_takes_twice():
    once = LowPass("butterworth", 4, 60.0).response(FREQUENCY)
    both = LowPass("butterworth", 4, 60.0, zero_phase=True).response(FREQUENCY)
    np.testing.assert_allclose(both, np.abs(once) ** 2)


def test_a_delay_turns_the_phase():
    plain, later = (
        LowPass("bessel", 2, 80.0, delay_s=s).response(FREQUENCY) for s in (0.0, 2.5e-3)
    )
    np.testing.assert_allclose(later, plain * np.exp(-2j * np.pi * FREQUENCY * 2.5e-3))


@pytest.fixture
def folder(tmp_path):
    return write_campaign(tmp_path / "c")


def stated(folder, text):
    edit(folder / "campaign.toml", "averaging_ms = 6.6", f"averaging_ms = 6.6\nfilter = {text}")
    return read_campaign(folder)


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        (
            '{ kind = "butterworth", order = 4, corner_hz = 60 }',
            LowPass("butterworth", 4, 60.0),
        ),
        (
            '{ kind = "bessel", order = 2, corner_hz = 40.5, delay_ms = 3 }',
            LowPass("bessel", 2, 40.5, delay_s=0.003),
        ),
        (
            '{ kind = "butterworth", order = 2, corner_hz = 35, zero_phase = true }',
            LowPass("butterworth", 2, 35.0, zero_phase=True),
        ),
        (
            '{ kind = "fir", taps = [0.25, 0.5, 0.25], rate_hz = 400 }',
            LowPass("fir", taps=(0.25, 0.5, 0.25), rate_hz=400.0),
        ),
    ],
)
def test_it_is_read_as_it_is_stated(folder, text, meant):
    campaign = stated(folder, text)
    assert campaign.low_pass == meant
    expected = campaign.averaging.kept(FREQUENCY) * meant.response(FREQUENCY)
    found = campaign.recorded(FREQUENCY)
    np.testing.assert_allclose(found, np.broadcast_to(expected[:, None], found.shape))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('"butterworth"', ["filter must be a table"]),
        ('{ kind = "butterwort", order = 4, corner_hz = 60 }', ["'butterworth'?"]),
        ('{ kind = "butterworth", order = 4 }', ["[filter]", "corner_hz", "missing"]),
        ('{ kind = "butterworth", order = 2.5, corner_hz = 60 }', ["order = 2.5", "whole number"]),
        ('{ kind = "butterworth", order = 40, corner_hz = 60 }', ["order = 40", "1 to 20"]),
        ('{ kind = "butterworth", order = 4, corner_hz = 0 }', ["corner_hz = 0", "greater than 0"]),
        ('{ kind = "bessel", order = 4, corner_kHz = 1 }', ["corner_kHz"]),
        ('{ kind = "bessel", order = 4, corner_hz = 60, zero_phase = "yes" }', ["true or false"]),
        ('{ kind = "fir", taps = [], rate_hz = 400 }', ["taps", "1 to 10000"]),
        ('{ kind = "fir", taps = [0, 0], rate_hz = 400 }', ["not all of them zero"]),
        ('{ kind = "fir", order = 4, taps = [1], rate_hz = 400 }', ["order"]),
    ],
)
def test_a_mistake_in_it_gets_a_line(folder, text, words):
    with pytest.raises(CampaignError) as caught:
        stated(folder, text)
    line = str(caught.value)
    assert str(folder / "campaign.toml") in line
    for word in words:
        assert word in line, line


CHANNELS = """filter = { travel = { kind = "bessel", order = 2, corner_hz = 40 } }
[channels]
B1 = { quantity = "acceleration", position = "B1", filter = FIR }
B2 = "B2"
pot = { quantity = "travel", corner = 1 }
odd = { quantity = "travel", corner = 2, filter = { kind = "none" } }
""".replace("FIR", '{ kind = "fir", taps = [0.5, 0.5], rate_hz = 200 }')
BESSEL = LowPass("bessel", 2, 40.0)


def test_channels_and_quantities_have_filters_of_their_own(tmp_path):
    """A channel's own comes before that of its quantity, and "none" is none."""
    top = parse_toml(CHANNELS, tmp_path / "campaign.toml", CampaignError)
    channels, shared = with_filters(read_channels(top).compared, top)
    fir, none = LowPass("fir", taps=(0.5, 0.5), rate_hz=200.0), LowPass("none")
    assert shared is None
    assert [c.low_pass for c in channels] == [fir, None, BESSEL, none]
    gains = responses([c.low_pass for c in channels], FREQUENCY).T
    for gain, expected in zip(gains, (fir, none, BESSEL, none), strict=True):
        np.testing.assert_allclose(gain, expected.response(FREQUENCY))
    assert str(none) == "no filter"


def test_a_filter_of_what_nothing_measures_is_named(tmp_path):
    toml = 'filter = { rate = { kind = "none" } }\n[channels]\nB1 = "B1"\n'
    top = parse_toml(toml, tmp_path / "campaign.toml", CampaignError)
    with pytest.raises(CampaignError, match=r"filter\.rate: no channel measures that: delete it"):
        with_filters(read_channels(top).compared, top)


def test_without_a_list_of_channels_a_filter_of_accelerations_is_that_of_all(folder):
    campaign = stated(folder, '{ acceleration = { kind = "bessel", order = 2, corner_hz = 40 } }')
    assert campaign.low_pass == BESSEL and "Bessel" in campaign.sampling
