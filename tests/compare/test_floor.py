"""The noise floor, stated and estimated."""

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import read_campaign
from wheelhop.compare import compare, estimate_noise, in_band, noise_floor, relative_error
from wheelhop.compare.floor import estimate_noise_between_samples
from wheelhop.simulate import Response

ROOT = Path(__file__).parents[2]
IN_BAND = np.sqrt(604 / 1024)  # of white noise at 100 Hz, band 0.5 to 30 Hz, 1024 samples


def test_the_floor_is_the_error_of_a_model_that_leaves_only_noise(bench):
    campaign, responses = bench.campaign(
        [2.0, 3.0, 2.5, 4.0], lambda t, v: bench.noise(0.3), noise=0.3 * IN_BAND
    )
    comparison = compare(campaign, responses)
    floor = comparison.floor
    assert floor.source == "noise_rms_m_s2"
    assert comparison.error_fit == pytest.approx(floor.error_fit, rel=0.03)
    assert comparison.error_validate == pytest.approx(floor.error_validate, rel=0.03)


def test_the_floor_is_noise_over_what_was_measured_and_scales_may_add_to_it(bench):
    """noise / m, and √(noise² + (u m)²) / m, m being the rms of the records in band: a gain that
    is known to 3 % may be right, so that no part of it is in the floor."""
    noise, doubt = 0.4, 0.03
    campaign, responses = bench.campaign([2.0, 3.0], lambda t, v: bench.noise(0.3), noise=noise)
    channels = tuple(replace(c, scale_uncertainty=doubt) for c in campaign.channels)
    campaign = replace(campaign, channels=channels)
    squares = []
    for run in campaign.runs:
        lines = np.fft.rfft(run.record, axis=0)
        frequency = np.fft.rfftfreq(len(run.record), 0.01)
        lines[(frequency < 0.5) | (frequency > 30.0)] = 0.0
        squares.append(np.mean(np.fft.irfft(lines, len(run.record), axis=0) ** 2))
    floor = noise_floor(campaign, in_band(campaign, responses))
    for found, expected, square in (
        (floor.error, floor.expected, np.mean(squares)),
        (floor.error_fit, floor.expected_fit, squares[0]),
        (floor.error_validate, floor.expected_validate, squares[1]),
    ):
        assert found == pytest.approx(noise / np.sqrt(square), rel=1e-6)
        assert expected == pytest.approx(np.hypot(found, doubt), rel=1e-6)
    assert floor.scales == pytest.approx(doubt, rel=1e-9)
    assert floor.is_stated and floor.tolerance == 0.05
    assert floor.pooled_rms == pytest.approx(noise)
    only = replace(campaign, runs=campaign.runs[:1])
    alone = noise_floor(only, in_band(only, responses[:1]))
    assert np.isnan(alone.error_validate) and alone.error == floor.error_fit


def test_of_what_is_not_predicted_no_noise_is_estimated(bench):
    campaign, responses = bench.campaign([2.0] * 4, lambda t, v: bench.noise(0.2), noise=None)
    for response in responses:
        response.record[:, 3] = np.nan
    floor = noise_floor(campaign, in_band(campaign, responses))
    assert np.flatnonzero(np.isnan(floor.noise_rms)).tolist() == [3]
    assert floor.pooled_rms == pytest.approx(0.2 * IN_BAND, rel=0.15)
    assert not floor.is_stated and floor.tolerance == 0.15 and floor.scales == 0.0


def test_a_tenth_of_runs_and_band_where_nothing_moves_shows_the_noise(bench):
    """Rough ground fills the band in all five runs but for the upper half of it in one."""

    def motion(time, speed):
        lines = np.fft.rfft(bench.noise(5.0), axis=0)
        if speed == 1.0:
            lines[np.fft.rfftfreq(len(time), 0.01) > 14.0] = 0.0
        return np.fft.irfft(lines, len(time), axis=0)

    campaign, _ = bench.campaign(
        [1.0, 2.0, 2.0, 2.0, 2.0], lambda t, v: bench.noise(0.2), noise=None, motion=motion
    )
    unknown = [Response(r.id, np.zeros_like(r.record), None) for r in campaign.runs]
    estimate = estimate_noise(in_band(campaign, unknown))
    np.testing.assert_allclose(estimate, 0.2 * IN_BAND, rtol=0.25)


@pytest.mark.parametrize("kind", ["washboard", "unknown"])
def test_an_estimate_finds_the_noise_of_each_channel_under_a_wrong_model(bench, kind):
    rms = np.linspace(0.05, 0.4, 8)
    campaign, responses = bench.campaign(
        [1.0, 1.2, 1.5, 1.9, 2.4, 3.0],
        lambda t, v: bench.noise(1.0) * rms + 0.5 * bench.motion(t, v),
        noise=None,
        kind=kind,
    )
    estimate = estimate_noise(in_band(campaign, responses))
    np.testing.assert_allclose(estimate, rms * IN_BAND, rtol=0.2)


@pytest.mark.parametrize("factor", [3.0, 1e-6])
def test_the_estimate_scales_with_the_signals_and_the_floor_has_no_unit(bench, factor):
    campaign, responses = bench.campaign([2.0, 3.0], lambda t, v: bench.noise(0.1), noise=None)
    once = noise_floor(campaign, in_band(campaign, responses))
    runs = tuple(replace(r, record=factor * r.record) for r in campaign.runs)
    other = [replace(r, record=factor * r.record) for r in responses]
    scaled = noise_floor(campaign, in_band(replace(campaign, runs=runs), other))
    np.testing.assert_allclose(scaled.noise_rms, factor * once.noise_rms, rtol=1e-9)
    assert scaled.error == pytest.approx(once.error, rel=1e-9)


@pytest.mark.parametrize(
    ("n", "band"),
    [
        (200, (0.5, 30.0)),
        (200, (20.0, 28.0)),
        (60, (1.0, 5.0)),
        (40, (2.0, 3.0)),
        (100, (20.0, 20.4)),
    ],
)
def test_short_records_and_narrow_bands_still_give_an_estimate(bench, n, band):
    """The fewest quiet lines of one record are too quiet by chance, by less than two."""
    campaign, responses = bench.campaign(
        [2.0] * 8, lambda t, v: bench.noise(0.1, (n, 8)), noise=None, n=n
    )
    records = in_band(replace(campaign, band_hz=band), responses)
    estimate = estimate_noise(records)
    assert np.all(np.isfinite(estimate)) and np.all(estimate > 0.0)
    assert np.isfinite(estimate_noise(records[:1])).all()  # a tenth of one run's parts is one
    share = records[0].band.count / n  # of white noise
    assert 0.5 < np.sqrt(np.mean(estimate**2) / share) / 0.1 < 1.5


@pytest.mark.parametrize("band", [(0.5, 30.0), (0.5, 15.0), (15.0, 45.0)])
def test_white_noise_alone_is_found_in_any_band(bench, band):
    """Of which a band holds the share of the frequencies in it."""
    still = np.zeros((1024, 8))
    campaign, responses = bench.campaign(
        [2.0] * 8, lambda t, v: bench.noise(0.2), noise=None, motion=lambda t, v: still
    )
    records = in_band(replace(campaign, band_hz=band), responses)
    found = np.sqrt(np.mean(estimate_noise(records) ** 2))
    assert found == pytest.approx(0.2 * np.sqrt((band[1] - band[0]) / 50.0), rel=0.12)


def test_noise_between_samples_is_found_under_smooth_motion(bench):
    """Each channel's own, though one moves far more than another."""
    rms = np.linspace(0.05, 0.4, 8)
    time = np.arange(4000) / 100.0
    wave = np.sin(2 * np.pi * 1.5 * time)[:, None] * np.linspace(8.0, 1.0, 8)
    records = [wave + bench.noise(1.0, (4000, 8)) * rms for _ in range(3)]
    found = estimate_noise_between_samples(records, share=0.6)
    assert found == pytest.approx(np.sqrt(0.6 * np.mean(rms**2)), rel=0.3)
    assert estimate_noise_between_samples(records, share=0.15) == pytest.approx(0.5 * found)


def test_of_a_slow_wave_next_to_nothing_is_taken_for_noise():
    """Differences of fourth order hold (2 sin(π f / rate))⁸ of its variance, of white noise 70
    times."""
    time = np.arange(5000) / 100.0
    for frequency in (5.0, 10.0):
        wave = np.sqrt(2.0) * np.sin(2 * np.pi * frequency * time)[:, None]
        passed = (2.0 * np.sin(np.pi * frequency / 100.0)) ** 8
        found = estimate_noise_between_samples([wave], share=0.6)
        assert found == pytest.approx(np.sqrt(0.6 * passed / 70.0), rel=0.02)


@pytest.mark.parametrize("share", [0.02, 0.06, 0.3, 0.7, 1.0])
def test_how_long_it_was_quiet_does_not_matter_to_the_noise_between_samples(bench, share):
    record = bench.noise(0.2, (20000, 4))
    record[round(share * 20000) :] *= 50.0
    assert estimate_noise_between_samples([record], share=1.0) == pytest.approx(0.2, rel=0.1)


def test_noise_between_samples_is_that_of_the_quietest_pieces(bench):
    records = [bench.noise(0.2, (5000, 4)) for _ in range(2)]
    quiet = estimate_noise_between_samples(records, share=1.0)
    assert quiet == pytest.approx(0.2, rel=0.25)
    assert estimate_noise_between_samples([bench.noise(0.2, (40, 400))], share=1.0) == (
        pytest.approx(0.2, rel=0.1)  # a record shorter than a piece is one
    )
    records[0][:4200] *= 50.0
    records[1][:4200] *= 50.0
    assert estimate_noise_between_samples(records, share=1.0) == pytest.approx(0.2, rel=0.25)


def test_half_a_second_of_quiet_now_and_then_is_enough(bench):
    """At 100 Hz, a quarter of the time."""
    record = bench.noise(0.2, (5000, 4))
    record[(np.arange(5000) + 8) % 250 > 62] *= 50.0
    assert estimate_noise_between_samples([record], share=1.0) == pytest.approx(0.2, rel=0.25)


TRUTHS = sorted((ROOT / "tests" / "data" / "open_truth").glob("*.toml"))


@pytest.mark.parametrize("truth", TRUTHS, ids=[path.stem for path in TRUTHS])
def test_the_noise_of_an_open_campaign_is_found_without_being_told(truth):
    # No model at all (a response of zero): what the recordings alone give away.
    campaign = replace(read_campaign(ROOT / "examples" / truth.stem), noise_rms=None)
    responses = [Response(r.id, np.zeros_like(r.record), None) for r in campaign.runs]
    records = in_band(campaign, responses)
    floor = noise_floor(campaign, records)
    assert floor.source == "estimated"
    true = tomllib.loads(truth.read_text())
    pooled = np.sqrt(np.mean(floor.noise_rms**2))
    assert pooled == pytest.approx(true["noise_rms_in_band_m_s2"], rel=0.15)
    each = np.array([true["noise"][channel.name] for channel in campaign.channels])
    np.testing.assert_allclose(floor.noise_rms, each * IN_BAND, rtol=0.2)
    assert relative_error(records) == pytest.approx(1.0)
