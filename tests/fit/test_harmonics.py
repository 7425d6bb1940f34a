"""Where a run stands on waves: records that are one line of the linear model, to the last digit."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import ATV, CHANNELS, campaign_of, model_of
from wheelhop.fit import find_start
from wheelhop.fit.placement import _drive, _speeds, _wavelength
from wheelhop.simulate import frequency_response
from wheelhop.vehicle import behind_m, wheels

TIME = 3.0 + np.arange(1000) / 100.0  # a record may begin at any time
PITCH, NOMINAL = 0.8, 4.0
MODEL = model_of(ATV, {})
SYSTEM = MODEL.system(CHANNELS, "road")


def campaign_with(record=None, nominal=NOMINAL, pitch=PITCH):
    track = truth.Track("washboard", {"amplitude_mm": 10.0, "pitch_mm": 1000.0 * pitch})
    run = truth.Run(track, nominal, 0.0, TIME, averaging_s=0.12)  # long means: half is left
    return campaign_of({"run": run}, None if record is None else {"run": record})


RUN = campaign_with().runs[0]


def record_of(speed, start, harmonic, pitch=PITCH):
    """What the linear model makes of a sine of so many waves per pitch, 1 mm."""
    frequency = harmonic * speed / pitch
    behind = np.array([behind_m(ATV, i) for i in wheels(ATV)])
    response = frequency_response(SYSTEM, frequency)[0] @ np.exp(
        -2j * np.pi * harmonic * behind / pitch
    )
    response = response * campaign_with().averaging.kept(np.array([frequency]))[0]
    phase = 2.0 * np.pi * harmonic * (start + speed * TIME) / pitch
    return 1e-3 * np.real(response * np.exp(1j * phase)[:, None])


@pytest.fixture
def sines(monkeypatch):
    """Ground of one harmonic under all wheels, on every track."""

    def laid(harmonic, pitch=PITCH):
        def envelopes(model, track, x):
            return 1e-3 * np.cos(2.0 * np.pi * harmonic * x / pitch)[:, None] * np.ones(4)

        monkeypatch.setattr("wheelhop.fit.placement._envelopes", envelopes)

    return laid


@pytest.mark.parametrize("harmonic", [1, 2, 3])
def test_speed_and_start_are_found_by_any_of_three_harmonics(sines, harmonic):
    """Of speeds and starts that are tried, exactly the one that was driven."""
    sines(harmonic)
    speed, start = _speeds(RUN, PITCH)[7], 37.0 / 64.0 * PITCH
    campaign = campaign_with(record_of(speed, start, harmonic))
    found = find_start(campaign, campaign.runs[0], MODEL, SYSTEM)
    assert found["speed_m_s"] == pytest.approx(speed)
    waves = (found["start_m"] - start) * harmonic / PITCH
    assert abs(waves - round(waves)) < 0.02


def test_a_line_counts_for_what_it_takes_out_of_the_record(sines):
    """One that the model gives half as much power again, but of which there are only eight tenths:
    that is 0.8² of it, and less than the first; of nine tenths it is more."""
    sines(2)
    speeds = _speeds(RUN, PITCH)
    power = np.array([np.sum(record_of(speed, 0.0, 2) ** 2) for speed in speeds])
    far = np.abs(speeds - speeds[:, None]) > 0.3
    ratio = np.where(far, power / power[:, None], 0.0)
    true, other = np.unravel_index(np.argmin(np.abs(ratio - 1.5)), ratio.shape)
    assert ratio[true, other] == pytest.approx(1.5, abs=0.05)
    start = 11.0 / 64.0 * PITCH
    record = record_of(speeds[true], start, 2) + 0.8 * record_of(speeds[other], 0.2, 2)
    campaign = campaign_with(record)
    found = find_start(campaign, campaign.runs[0], MODEL, SYSTEM)
    assert found["speed_m_s"] == pytest.approx(speeds[true])
    waves = (found["start_m"] - start) * 2.0 / PITCH
    assert abs(waves - round(waves)) < 0.05
    record = record_of(speeds[true], start, 2) + 0.9 * record_of(speeds[other], 0.2, 2)
    campaign = campaign_with(record)
    found = find_start(campaign, campaign.runs[0], MODEL, SYSTEM)
    assert found["speed_m_s"] == pytest.approx(speeds[other])


def test_a_run_that_answers_less_than_the_model_is_placed_all_the_same(sines):
    """As over waves as long as a tyre's contact patch, which the rigid wheel of the model follows:
    no speed is preferred because the model expects less of it."""
    sines(2)
    speeds, start = _speeds(RUN, PITCH), 37.0 / 64.0 * PITCH
    strongest = speeds[np.argmax([np.sum(record_of(speed, 0.0, 2) ** 2) for speed in speeds])]
    campaign = campaign_with(0.1 * record_of(strongest, start, 2))
    found = find_start(campaign, campaign.runs[0], MODEL, SYSTEM)
    assert found["speed_m_s"] == pytest.approx(strongest)
    waves = (found["start_m"] - start) * 2.0 / PITCH
    assert abs(waves - round(waves)) < 0.02


def test_some_channels_are_enough(sines):
    """If the others say nothing, or nothing that is true."""
    sines(1)
    speed, start = _speeds(RUN, PITCH)[20], 11.0 / 64.0 * PITCH
    record = record_of(speed, start, 1)
    record[:, 1:] = 100.0 * record_of(4.2, 0.3, 1)[:, 1:]
    campaign = campaign_with(record)
    found = find_start(campaign, campaign.runs[0], MODEL, SYSTEM, channels=[0])
    assert found == pytest.approx({"speed_m_s": speed, "start_m": start})


def test_a_constant_offset_is_no_vibration(sines):
    sines(1)
    speed, start = _speeds(RUN, PITCH)[20], 11.0 / 64.0 * PITCH
    campaign = campaign_with(record_of(speed, start, 1) + 1e3)
    found = find_start(campaign, campaign.runs[0], MODEL, SYSTEM)
    assert found == pytest.approx({"speed_m_s": speed, "start_m": start})


def test_walking_pace_is_a_drive(sines):
    """Anything that moves has begun somewhere; what stands has not."""
    sines(2, 0.25)
    (run,) = campaign_with(nominal=0.6, pitch=0.25).runs
    speed = _speeds(run, 0.25)[3]
    campaign = campaign_with(record_of(speed, 0.1, 2, 0.25), nominal=0.6, pitch=0.25)
    found = find_start(campaign, campaign.runs[0], MODEL, SYSTEM)
    assert found["speed_m_s"] == pytest.approx(speed)
    standing = replace(campaign.runs[0], speed_m_s=0.0)
    assert find_start(campaign, standing, MODEL, SYSTEM) == {}


@pytest.mark.parametrize("wavelength", [0.3, 0.8, 2.5])
def test_speeds_are_tried_so_closely_that_no_wave_is_missed(wavelength):
    """Within a fifth of the nominal one: over the record two neighbours slip by a sixth of a wave
    at most, and one speed less would be too few."""
    speeds = _speeds(RUN, wavelength)
    assert (speeds[0], speeds[-1]) == pytest.approx((0.8 * NOMINAL, 1.2 * NOMINAL))
    duration = TIME[-1] - TIME[0]
    waves = (speeds[-1] - speeds[0]) * duration / wavelength
    assert waves / (len(speeds) - 1) <= 1.0 / 6.0 < waves / (len(speeds) - 2)
    np.testing.assert_allclose(np.diff(speeds), np.diff(speeds)[0])


def test_waves_are_counted_if_there_are_more_than_two():
    """Else, and where speed changes, the shape counts."""
    distance = NOMINAL * (TIME[-1] - TIME[0])
    assert _wavelength(RUN, 0.49 * distance) == 0.49 * distance
    assert _wavelength(RUN, 0.5 * distance) is None
    assert _wavelength(RUN, 0.6 * distance) is None
    assert _wavelength(RUN, None) is None
    assert _wavelength(replace(RUN, course=SimpleNamespace()), PITCH) is None


def test_a_drive_is_as_long_as_its_way_takes():
    """At a speed, or along a course that is faster throughout."""
    until, at = _drive(RUN, 5.0, -10.0, 40.0)
    assert until == pytest.approx(10.0)
    np.testing.assert_allclose(at(np.array([0.0, 4.0, 10.0])), [-10.0, 10.0, 40.0])
    course = SimpleNamespace(time=lambda x: x**2 / 100.0, place=lambda t: 10.0 * np.sqrt(t))
    until, at = _drive(replace(RUN, course=course), 5.0, 10.0, 40.0)
    assert until == pytest.approx((16.0 - 1.0) / 1.25)
    np.testing.assert_allclose(at(np.array([0.0, until])), [10.0, 40.0])
    assert at(np.array(4.0)) == pytest.approx(10.0 * np.sqrt(1.0 + 5.0))
