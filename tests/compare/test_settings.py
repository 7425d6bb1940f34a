"""Settings over one course: on cars that share no code, what differs is named, and the same setting
driven twice is not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.compare.other_car import RATE_HZ, Car, bumps, rough
from wheelhop.campaign import Campaign, CampaignError, Channel, Run, TrackSpec
from wheelhop.compare.decays import decays
from wheelhop.compare.settings import (
    _band_power,
    _jackknifed,
    _of_drives,
    _segments,
    band_edges,
    compare_settings,
)
from wheelhop.compare.settings_words import NO_DIAGNOSIS, sentences, to_frame, to_json

BAND_HZ = (0.8, 30.0)
DRAWN = 40


def campaign_of(drives, speed_m_s=5.0, band_hz=BAND_HZ):
    """Records (n,), each with the setting it was driven with."""
    unknown = TrackSpec("unknown", {})
    runs = []
    for i, (setting, record) in enumerate(drives):
        time_s = np.arange(len(record)) / RATE_HZ
        parts = (f"run-{i}", Path(f"{i}.csv"), "fit", speed_m_s, unknown, time_s, record[:, None])
        runs.append(Run(*parts, setting=setting))
    return Campaign(
        folder=Path(),
        title="settings",
        vehicle_file=Path("vehicle.toml"),
        sample_rate_hz=RATE_HZ,
        band_hz=band_hz,
        averaging_s=0.0,
        noise_rms=None,
        channels=(Channel("imu", "body"),),
        runs=tuple(runs),
    )


def driven(seed, dampers, seconds=30.0, held=0.03):
    """A drawn car over one rough course with each of these dampers, at a speed held by hand."""
    rng = np.random.default_rng(seed)
    car, speed = Car.drawn(rng), rng.uniform(4.0, 12.0)
    ground = rough(rng, 1.1 * speed * (seconds + 4.0) + 20.0)
    drives = [
        (name, car.drive(ground, speed * (1 + held * rng.normal()), seconds, rng, damper))
        for name, damper in dampers
    ]
    return campaign_of(drives)


def claims(found):
    return [d for d in found.differences if d.differs]


def test_of_drawn_cars_the_same_setting_seldom_differs_and_another_does():
    false, right = 0, 0
    for seed in range(DRAWN):
        campaign = driven(seed, (("a", 1.0), ("again", 1.0), ("hard", 2.5)))
        found = compare_settings(campaign)
        false += any(d.setting == "again" for d in claims(found))
        right += any(d.setting == "hard" for d in claims(found))
    assert false <= 0.05 * DRAWN
    assert right >= 0.9 * DRAWN


def test_repeated_drives_show_smaller_differences():
    """Of 1.7 times the damping."""
    once = thrice = 0
    for seed in range(8):
        names = (("a", 1.0), ("b", 1.7))
        campaign = driven(seed, names * 3)
        thrice += bool(claims(compare_settings(campaign)))
        once += bool(claims(compare_settings(replace(campaign, runs=campaign.runs[:2]))))
    assert thrice >= 6 and thrice > once


def test_drives_that_differ_more_than_a_speed_explains_widen_the_interval():
    """Another road in between: the same setting twice is not a difference."""
    one, other = (driven(seed, (("a", 1.0), ("b", 1.0)), held=0.0) for seed in (3, 4))
    louder = [replace(run, id=f"{run.id}-2", record=2.0 * run.record) for run in other.runs]
    mixed = replace(one, runs=(*one.runs, *louder))
    widths = [
        np.mean([d.high_db - d.low_db for d in compare_settings(campaign).differences])
        for campaign in (one, mixed)
    ]
    assert widths[1] > 1.5 * widths[0]


def test_a_louder_setting_is_louder_by_as_much_everywhere():
    campaign = driven(5, (("a", 1.0), ("b", 1.0)), seconds=60.0, held=0.0)
    first = campaign.runs[0]
    loud = replace(campaign.runs[1], record=4.0 * first.record)
    found = compare_settings(replace(campaign, runs=(first, loud)))
    assert all(d.differs for d in found.differences)
    powers = [d.power_db for d in found.differences]
    np.testing.assert_allclose(powers, 20 * np.log10(4.0), rtol=1e-9)
    said = sentences(found)
    assert said[0].startswith("b against a: up to 12.0\u00a0dB more from 0.8 to 30 Hz")
    assert said[-1] == NO_DIAGNOSIS
    back = compare_settings(replace(campaign, runs=(first, loud)), "b")
    assert [d.power_db for d in back.differences] == pytest.approx([-p for p in powers])


def test_another_speed_moves_a_power_law_by_its_exponent():
    """P ~ f^−4 at a speed higher by e: every band's power changes by 4 e."""
    frequency = np.arange(0.0, 50.0, 0.01)
    density = np.zeros_like(frequency)
    density[1:] = frequency[1:] ** -4.0
    edges = np.array([1.0, 2.0, 4.0, 8.0])
    variance = _of_drives(frequency, [np.array([density] * 9)], edges, 0.03)
    np.testing.assert_allclose(np.sqrt(variance), 4 * 0.03, rtol=0.1)


def test_the_speed_that_hands_hold_is_allowed_for():
    """Of a spectrum without slope power follows speed: half a decibel at 3 %, of both drives."""
    rng = np.random.default_rng(2)
    long = [(name, rng.normal(size=100_000)) for name in ("a", "b")]
    widths = [d.high_db - d.low_db for d in compare_settings(campaign_of(long)).differences[7:-1]]
    expected = 2 * 2.9 * np.sqrt(2) * 0.03 * 10 / np.log(10)
    np.testing.assert_allclose(widths, expected, rtol=0.3)


def test_speeds_that_are_stated_apart_are_allowed_for():
    campaign = driven(6, (("a", 1.0), ("b", 1.0)), held=0.0)
    runs = (campaign.runs[0], replace(campaign.runs[1], speed_m_s=6.0))
    found = compare_settings(replace(campaign, runs=runs))
    assert found.speed_apart == pytest.approx(0.2)
    alike = compare_settings(campaign)
    for wide, narrow in zip(found.differences, alike.differences, strict=True):
        assert wide.high_db - wide.low_db > narrow.high_db - narrow.low_db
    assert "20 % apart" in " ".join(sentences(found))


def test_segments_tell_how_much_a_level_varies():
    """The variance of the logarithm of a white record's band power, over many records."""
    rng, edges = np.random.default_rng(1), np.array([1.0, 4.0, 12.0, 30.0])
    levels, told = [], []
    for _ in range(300):
        campaign = campaign_of([("a", rng.normal(size=3000))])
        frequency, density = _segments(campaign, campaign.runs[0])
        powers = _band_power(frequency, density[:, 0], edges)
        levels.append(np.log(powers.mean(axis=0)))
        told.append(_jackknifed(powers))
    np.testing.assert_allclose(np.mean(told, axis=0), np.var(levels, axis=0), rtol=0.3)


def test_density_holds_the_power_of_the_record():
    rng = np.random.default_rng(3)
    campaign = campaign_of([(name, rng.normal(size=20_000)) for name in ("a", "b")])
    spectrum = compare_settings(campaign).spectra[0]
    assert spectrum.rms == pytest.approx(np.sqrt((30.0 - 0.8) / 50.0), rel=0.03)
    inside = (spectrum.low < 0.02) & (spectrum.high > 0.02)
    assert np.mean(inside) > 0.85
    assert spectrum.density.mean() == pytest.approx(0.02, rel=0.03)


def test_bands_are_thirds_where_they_are_resolved():
    edges = band_edges((0.5, 30.0))
    assert edges[0] == 0.5 and edges[-1] == 30.0
    assert (np.diff(edges) >= 0.25 - 1e-12).all()
    wide = edges[1:-1] / edges[:-2]
    np.testing.assert_allclose(wide[edges[:-2] > 2.0], 10**0.1, rtol=1e-9)


def test_a_free_part_tells_the_damping():
    """After a bump a body swings out."""
    ratios, counts = [], []
    for seed in range(16):
        rng = np.random.default_rng(seed)
        car, speed = Car.drawn(rng), rng.uniform(3.0, 8.0)
        over = {
            name: decays(car.drive(ground, speed, 30.0, rng), RATE_HZ, 0.8)
            for name, ground in (
                ("bumps", bumps(speed, 30.0)),
                ("rough", rough(rng, 1.1 * speed * 34.0 + 20.0)),
            )
        }
        counts.append((len(over["bumps"]), len(over["rough"])))
        if over["bumps"]:
            told = np.mean([damping for _, damping in over["bumps"]])
            ratios.append(told / car.body_damping())
    bumpy, random = np.array(counts).T
    assert (bumpy > 0).sum() >= 6 and bumpy.max() <= 3
    assert random.sum() <= 2
    assert np.median(ratios) == pytest.approx(1.0, abs=0.15)


def test_a_decaying_wave_is_read():
    time_s = np.arange(3000) / RATE_HZ - 8.0
    pole = 2 * np.pi * 1.6 * (-0.2 + 1j * np.sqrt(1 - 0.2**2))
    record = np.where(time_s > 0, np.real(np.exp(pole * np.maximum(time_s, 0.0) + 0.4j)), 0.0)
    ((frequency_hz, damping),) = decays(record, RATE_HZ, 0.8)[:1]
    assert frequency_hz == pytest.approx(1.6, rel=0.06)
    assert damping == pytest.approx(0.2, rel=0.3)  # what is in band begins before the wave does


def test_what_cannot_be_compared_is_one_line():
    rng = np.random.default_rng(4)
    record = rng.normal(size=3000)
    with pytest.raises(CampaignError, match='1 setting is stated: write setting = "…"'):
        compare_settings(campaign_of([("a", record), ("", record)]))
    campaign = campaign_of([("a", record), ("b", record)])
    with pytest.raises(CampaignError, match='no setting "c": choose from a, b'):
        compare_settings(campaign, "c")
    other = replace(campaign.runs[1], track=TrackSpec("washboard", {"amplitude_m": 0.01}))
    with pytest.raises(CampaignError, match='"run-1" is over another track than "run-0"'):
        compare_settings(replace(campaign, runs=(campaign.runs[0], other)))


@pytest.mark.parametrize("seconds, enough", [(11.25, True), (11.2, False)])
def test_so_much_record_is_needed(seconds, enough):
    """Eight segments of two waves of 0.8 Hz, half overlapping: 11.25 s."""
    rng = np.random.default_rng(5)
    count = round(seconds * RATE_HZ)
    campaign = campaign_of([(name, rng.normal(size=count)) for name in ("a", "b")])
    if enough:
        assert len(compare_settings(campaign).differences) == len(band_edges(BAND_HZ)) - 1
    else:
        with pytest.raises(CampaignError, match=r"11 s are needed where the band begins at 0\.8"):
            compare_settings(campaign)


def test_json_and_table_hold_the_same():
    found = compare_settings(driven(7, (("a", 1.0), ("hard", 2.5))))
    plain, table = to_json(found), to_frame(found)
    assert plain["format"] == 1 and plain["settings"] == ["a", "hard"]
    assert [d["differs"] for d in plain["differences"]] == table["differs"].tolist()
    assert len(plain["spectra"][0]["density"]) == len(plain["spectra"][0]["frequency_hz"])
