"""Every channel counts in units of its noise."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wheelhop.api import compare as compare_folder
from wheelhop.campaign import Channel
from wheelhop.compare import InBand, compare, to_json, weighed
from wheelhop.simulate import Response

ROOT = Path(__file__).parents[2]
UNITS = {"acceleration": "m/s²", "travel": "m", "rate": "rad/s", "force": "N"}
NOISE = {"acceleration": 0.1, "travel": 2e-4, "rate": 0.005, "force": 20.0}
KINDS = ("travel", "acceleration", "acceleration", "rate", "force", "travel")
POINTS = ("S1", "B1", "B2", "pitch", "S3", "S2")


def mixed(bench, stated):
    """A campaign of several quantities, and a model that leaves nothing but their noise."""
    size = np.array([NOISE[kind] for kind in KINDS])
    share = np.sqrt(604 / 1024)  # of white noise that is in band
    campaign, responses = bench.campaign(
        [2.0, 3.0, 2.5, 4.0],
        lambda t, v: size / share * bench.noise(1.0, (len(t), len(KINDS))),
        points=POINTS,
        noise=stated.get("acceleration"),
        motion=lambda t, v: 20.0 * size * bench.motion(t, v, len(KINDS)),
    )
    channels = tuple(
        Channel(f"{kind} {i}", point, quantity=kind, unit=UNITS[kind])
        if kind == "acceleration"
        else Channel(
            f"{kind} {i}", point, quantity=kind, unit=UNITS[kind], noise_rms=stated.get(kind)
        )
        for i, (kind, point) in enumerate(zip(KINDS, POINTS, strict=True))
    )
    return weighed(replace(campaign, channels=channels)), responses


def test_accelerations_alone_are_left_as_they_are(bench):
    campaign, _ = bench.campaign([2.0], lambda t, v: bench.noise(0.1))
    assert weighed(campaign) is campaign
    assert (campaign.noise_scale == 1.0).all()


def test_stated_noise_is_what_channels_count_by(bench):
    campaign, _ = mixed(bench, NOISE)
    expected = [NOISE[kind] / NOISE["acceleration"] for kind in KINDS]
    np.testing.assert_allclose(campaign.noise_scale, expected, rtol=1e-12)


def test_noise_nobody_states_is_estimated_of_each_quantity(bench):
    """Sixteen parts of a single channel tell its noise to a tenth; two channels, to less."""
    campaign, _ = mixed(bench, {})
    expected = [NOISE[kind] / NOISE["acceleration"] for kind in KINDS]
    np.testing.assert_allclose(campaign.noise_scale, expected, rtol=0.25)


def test_noise_stated_of_one_quantity_is_kept_where_others_are_estimated(bench):
    campaign, _ = mixed(bench, {"travel": 1e-3})
    scale = dict(zip(KINDS, campaign.noise_scale, strict=True))
    assert scale["travel"] == pytest.approx(1e-3 / 0.1, rel=0.15)
    assert scale["force"] == pytest.approx(200.0, rel=0.15)
    assert {channel.quantity for channel in campaign.unstated} == {"acceleration", "rate", "force"}


def test_a_noisier_channel_of_the_same_quantity_counts_less(bench):
    campaign, _ = bench.campaign([2.0], lambda t, v: bench.noise(0.1), noise=0.1)
    channels = (replace(campaign.channels[0], noise_rms=0.3), *campaign.channels[1:])
    scale = weighed(replace(campaign, channels=channels)).noise_scale
    np.testing.assert_allclose(scale, [3.0, *[1.0] * 7])


def test_the_error_is_over_all_channels_in_units_of_their_noise(bench):
    """E² = Σ (r/σ)² / Σ (y/σ)², by hand; and of every quantity by itself."""
    campaign, responses = mixed(bench, NOISE)
    found = compare(campaign, responses)
    sigma = np.array([NOISE[kind] for kind in KINDS])
    residual, measured = np.zeros(len(KINDS)), np.zeros(len(KINDS))
    for run, response in zip(campaign.runs, responses, strict=True):
        if run.role == "validate":
            band = InBand(len(run.time_s), 100.0, campaign.band_hz)
            residual += (band.coefficients(run.record - response.record) ** 2).sum(axis=0)
            measured += (band.coefficients(run.record) ** 2).sum(axis=0)
    whole = np.sqrt((residual / sigma**2).sum() / (measured / sigma**2).sum())
    assert found.error_validate == pytest.approx(whole, rel=1e-12)
    assert found.floor.error_validate == pytest.approx(whole, rel=0.05)
    assert found.breakdown.total.ratio == pytest.approx(1.0, rel=0.03)
    assert [each.quantity for each in found.by_quantity] == [
        *("acceleration", "travel", "rate", "force")
    ]
    for each in found.by_quantity:
        of_it = np.array([kind == each.quantity for kind in KINDS])
        alone = np.sqrt(residual[of_it].sum() / measured[of_it].sum())
        assert each.error_validate == pytest.approx(alone, rel=1e-12)
        assert each.floor_validate == pytest.approx(alone, rel=0.06)
        assert each.noise_rms == pytest.approx(NOISE[each.quantity])
        assert each.unit == UNITS[each.quantity]


def test_figures_are_in_the_channels_own_units(bench):
    campaign, responses = mixed(bench, NOISE)
    found = compare(campaign, responses)
    table = found.residuals("run")
    travel, force = table.xs("travel 0", level="channel"), table.xs("force 4", level="channel")
    assert set(travel["unit"]) == {"m"} and set(force["unit"]) == {"N"}
    np.testing.assert_allclose(travel["residual_rms"], NOISE["travel"], rtol=0.1)
    np.testing.assert_allclose(travel["noise_rms"], NOISE["travel"], rtol=1e-9)
    np.testing.assert_allclose(force["residual_rms"], NOISE["force"], rtol=0.1)
    height = {f.channel: f.measured_peak.height for f in found.figures if f.run_id == "run-0"}
    assert height["travel 0"] / height["force 4"] == pytest.approx(1e-5, rel=0.05)
    assert set(found.agreement()["unit"]) == set(UNITS.values())
    plain = to_json(found)
    assert plain["floor"]["noise_rms_m"] == {
        name: pytest.approx(2e-4) for name in ("travel 0", "travel 5")
    }
    assert plain["floor"]["noise_rms_N"] == {"force 4": pytest.approx(20.0)}
    assert [each["unit"] for each in plain["quantities"]] == ["m/s²", "m", "rad/s", "N"]


def test_another_unit_of_length_changes_nothing(bench):
    """Travel and its noise in millimetres: the same errors."""
    campaign, responses = mixed(bench, NOISE)
    factor = np.array([1e3 if kind == "travel" else 1.0 for kind in KINDS])
    channels = tuple(
        replace(c, noise_rms=c.noise_rms and c.noise_rms * k)
        for c, k in zip(campaign.channels, factor, strict=True)
    )
    runs = tuple(replace(run, record=run.record * factor) for run in campaign.runs)
    other = weighed(replace(campaign, channels=channels, runs=runs))
    scaled = [Response(r.run_id, r.record * factor, r.position_m) for r in responses]
    here, there = compare(campaign, responses), compare(other, scaled)
    assert there.error_validate == pytest.approx(here.error_validate, rel=1e-9)
    assert there.floor.error == pytest.approx(here.floor.error, rel=1e-9)


def test_a_quantity_is_quiet_where_it_is_quiet_itself(bench):
    """Travel is large below 10 Hz, accelerations above: nowhere are both at rest."""
    size = np.array([0.1, 2e-4])
    share = np.sqrt(604 / 1024)

    def move(time, speed):
        slow, fast = np.linspace(1.0, 9.0, 60), np.linspace(11.0, 29.0, 140)
        waves = [
            np.cos(2 * np.pi * np.outer(time, hz) + 7.0 * hz).sum(axis=1) for hz in (fast, slow)
        ]
        return 30.0 * size * np.stack(waves, axis=1)

    campaign, responses = bench.campaign(
        [2.0, 3.0, 2.5, 4.0],
        lambda t, v: size / share * bench.noise(1.0, (len(t), 2)) + 0.3 * move(t, v),
        points=("B1", "S1"),
        noise=None,
        motion=move,
    )
    pot = replace(campaign.channels[1], quantity="travel", unit="m")
    campaign = weighed(replace(campaign, channels=(campaign.channels[0], pot)))
    np.testing.assert_allclose(campaign.noise_scale, [1.0, 2e-3], rtol=0.25)
    found = compare(campaign, responses).floor.of_channels
    np.testing.assert_allclose(found, size, rtol=0.25)


def test_of_accelerations_alone_the_error_is_that_of_the_records_as_they_are():
    """An example, to the last bit: E = √(Σ r²/Σ y²) in m/s², and no table by quantity."""
    found = compare_folder(ROOT / "examples" / "clean").comparison
    assert found.by_quantity == () and "quantities" not in to_json(found)
    residual = measured = 0.0
    for record in found.records:
        band = record.band
        np.testing.assert_array_equal(record.measured, band.coefficients(record.run.record))
        residual += float(np.sum(record.residual**2))
        measured += float(np.sum(record.measured**2))
    assert found.breakdown.total.error == pytest.approx(np.sqrt(residual / measured), rel=1e-12)
    np.testing.assert_array_equal(found.floor.of_channels, np.full(8, 0.098))
