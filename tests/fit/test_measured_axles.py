"""What measured axles get wrong, and what the vehicle hands on of it to the body."""

from dataclasses import replace

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import ATV, CHANNELS, campaign_of
from wheelhop.campaign import TrackSpec
from wheelhop.compare.band import InBand
from wheelhop.fit import Workshop
from wheelhop.fit.measured_axles import led_astray
from wheelhop.simulate import Model, folded_power

SAMPLES, NOISE = 2048, 0.1
SHARE = (30.0 - 0.5) / 50.0  # of white noise lies in band
AXLES = [i for i, channel in enumerate(CHANNELS) if channel.is_axle]
BODY = [i for i in range(8) if i not in AXLES]


def campaign_with(record, channels=CHANNELS):
    run = truth.Run(truth.Track("flat", {}), 4.0, 0.0, np.arange(SAMPLES) / 100.0)
    campaign = campaign_of({"run": run}, {"run": record}, noise_rms=NOISE, channels=channels)
    return replace(campaign, runs=(replace(campaign.runs[0], track=TrackSpec("unknown", {})),))


def at_bench(record, channels=CHANNELS):
    """A run of which nobody knows the track."""
    model = Model(dict(ATV), (), {"run": {}})
    return Workshop(campaign_with(record, channels), model, jobs=1).benches["run"]


def noise(seed):
    """As much of it in band as is stated."""
    return NOISE / np.sqrt(SHARE) * np.random.default_rng(seed).normal(size=(SAMPLES, 8))


def added(bench):
    """What axles add to the variance of each datum, in units of the sensors' (f, body): to its
    real part as to its imaginary one."""
    real, imaginary = np.split(bench.doubt[:, bench.predicted] ** 2 - 1.0, 2)
    np.testing.assert_array_equal(real, imaginary)
    return real


def test_what_is_folded_into_axles_counts_with_the_square_of_its_size():
    """Motion near half the sample rate, of which a part comes from beyond."""
    rng = np.random.default_rng(2)
    lines = np.fft.rfft(rng.normal(size=(SAMPLES, 8)), axis=0)
    lines[np.fft.rfftfreq(SAMPLES, 0.01) < 25.0] = 0.0
    motion, quiet = np.fft.irfft(lines, SAMPLES, axis=0), noise(3)
    least = added(at_bench(quiet)).mean()
    once, twice = (added(at_bench(quiet + k * motion)).mean() - least for k in (10.0, 20.0))
    assert once > 100.0 * least
    assert twice == pytest.approx(4.0 * once, rel=0.05)


@pytest.mark.parametrize("band_hz", [(1.0, 4.0), (4.0, 12.0)])
def test_what_the_body_is_handed_on_is_what_it_does_when_driven_by_noise(band_hz):
    """In time, once the start is forgotten: white records are simulated, and the variance of what
    the body's sensors would have recorded of them is as much as is said."""
    model = Model(dict(ATV), (), {"run": {}})
    band, moved, said = InBand(SAMPLES, 100.0, band_hz), 0.0, 0.0
    for seed in range(4):
        record = NOISE * np.random.default_rng(seed).normal(size=(SAMPLES, 8))
        workshop = Workshop(campaign_with(record), model, jobs=1)
        (bench,) = workshop.benches.values()
        system = workshop.systems(model)["axles"]
        body = band.signal(bench.simulator.record(model, system))[512:-128, BODY]
        moved = moved + body.var(axis=0) / NOISE**2
        inside = np.isin(bench.band.frequency_hz, band.frequency_hz)
        said = said + 2.0 * added(bench)[inside].sum(axis=0) / SAMPLES
    assert (moved / said).mean() == pytest.approx(1.0, abs=0.1)


def test_channels_may_stand_in_any_order():
    """Each axle is heard where it is, whichever column it has."""
    record = noise(4) * np.linspace(1.0, 50.0, 8)
    order = np.random.default_rng(5).permutation(8)
    plain, mixed = (
        at_bench(record[:, places], tuple(CHANNELS[i] for i in places)).doubt
        for places in (np.arange(8), order)
    )
    np.testing.assert_allclose(mixed, plain[:, order], rtol=1e-9)


def test_axles_are_led_astray_as_far_as_they_are_uncertain():
    """The same each time, other runs otherwise, and the body's records never."""
    campaign = campaign_with(noise(6))
    (run,) = campaign.runs
    wrong = led_astray(campaign, run).record
    np.testing.assert_array_equal(wrong, led_astray(campaign, run).record)
    np.testing.assert_array_equal(wrong[:, BODY], run.record[:, BODY])
    assert (wrong - run.record)[:, AXLES].std(axis=0).min() > NOISE
    other = led_astray(campaign, replace(run, id="other")).record
    one, another = ((record - run.record)[:, AXLES].ravel() for record in (wrong, other))
    assert abs(np.corrcoef(one, another)[0, 1]) < 0.1


def test_axles_are_led_astray_most_where_most_is_folded():
    """Near half the sample rate, whence it comes down: as much at every frequency as is said."""
    falling = 1e3 / np.maximum(np.fft.rfftfreq(SAMPLES, 0.01), 1.0) ** 2
    rng = np.random.default_rng(7)
    lines = falling[:, None] * (rng.normal(size=(len(falling), 8, 2)) @ [1.0, 1.0j])
    campaign = campaign_with(100.0 * np.fft.irfft(lines, SAMPLES, axis=0))
    (run,) = campaign.runs
    added = (led_astray(campaign, run).record - run.record)[:, AXLES]
    power = (np.abs(np.fft.rfft(added, axis=0)) ** 2).mean(axis=1)
    low, high = power[20:200].mean(), power[-180:-1].mean()
    frequency = np.array([5.0, 47.0])

    def recorded(f):
        return campaign.recorded(f)[:, AXLES]

    folded = folded_power(run.record[:, AXLES], 100.0, recorded, NOISE, frequency)
    said = NOISE**2 + folded.mean(axis=1)
    assert said[1] > 3.0 * said[0]
    assert high / low == pytest.approx(said[1] / said[0], rel=0.2)
