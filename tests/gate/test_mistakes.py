"""What users do wrong is named before anything is fitted, and what is right is left alone."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.mistakes.planted import MISTAKES
from wheelhop.campaign import TrackSpec, read_campaign
from wheelhop.gate import gate, to_json
from wheelhop.vehicle import read_nominal

EXAMPLES = Path(__file__).parents[2] / "examples"
KEPT = (
    *("washboard-low-slow", "washboard-high-fast", "herringbone-low-fast", "herringbone-high-slow"),
    *("chassis-twist-low-fast", "chassis-twist-medium-fast", "one-sided-washboard-high"),
    "one-sided-washboard-low",
)


@pytest.fixture(scope="module")
def clean():
    campaign = read_campaign(EXAMPLES / "clean")
    runs = tuple(run for run in campaign.runs if run.id in KEPT)
    return replace(campaign, runs=runs), read_nominal(campaign)


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_named(clean, name):
    kinds, plant = MISTAKES[name]
    found = gate(*plant(*clean, np.random.default_rng(1))).findings
    named = [finding for finding in found if finding.kind in kinds.split()]
    assert named, [finding.kind for finding in found]
    for finding in named:
        assert finding.when == "before" and finding.about and finding.remedy.endswith(".")
        assert finding.text.endswith(".") and finding.text.isprintable()


@pytest.mark.parametrize("example", sorted(p.parent.name for p in EXAMPLES.glob("*/campaign.toml")))
def test_good_campaigns_pass_in_silence(example):
    campaign = read_campaign(EXAMPLES / example)
    gated = gate(campaign, read_nominal(campaign))
    assert {f.kind for f in gated.findings} <= {"thinned"}
    assert gated.campaign is campaign or gated.findings


def test_what_users_may_well_have_is_no_mistake(clean):
    """Offsets, a gain of 8 %, a sensor upside down in nobody's eyes: no fewer runs, no word."""
    campaign, vehicle = clean
    runs = tuple(
        replace(run, record=1.08 * run.record + 0.4, speed_m_s=0.95 * run.speed_m_s)
        for run in campaign.runs
    )
    assert gate(replace(campaign, runs=runs), vehicle).findings == ()


@pytest.mark.parametrize("copied", [False, True])
def test_wheels_that_move_alike_are_no_copy(clean, copied):
    """On a washboard both front wheels do the same, a thousand times the noise: what tells two
    sensors from one is their noise, at frequencies where nothing moves."""
    campaign, vehicle = clean
    rng = np.random.default_rng(7)

    def alike(run):
        lines = np.fft.rfft(run.record, axis=0)
        lines[len(lines) // 3 :] = 0.0
        moved = 30.0 * np.fft.irfft(lines, len(run.record), axis=0)
        record = moved + rng.normal(0.0, 0.05, moved.shape)
        left = record if copied else moved + rng.normal(0.0, 0.05, moved.shape)
        record[:, 1] = left[:, 0]
        return replace(run, record=record)

    runs = tuple(alike(run) for run in campaign.runs)
    found = gate(replace(campaign, runs=runs), vehicle).findings
    assert ("same-signal" in [finding.kind for finding in found]) is copied


def on_both_fronts(campaign, moves, noises):
    """The campaign where both front axles record one motion, m/s², each with its own noise."""
    rng = np.random.default_rng(8)

    def alike(run):
        record = run.record.copy()
        moved = moves(rng, len(record))
        record[:, :2] = moved[:, None] + noises(rng, len(record))
        return replace(run, record=record)

    return replace(campaign, runs=tuple(alike(run) for run in campaign.runs))


def test_two_sensors_are_told_where_noise_shows_at_few_frequencies(clean):
    """A rough road moves both front wheels alike over six sevenths of the spectrum."""

    def moves(rng, n):
        lines = np.fft.rfft(rng.normal(0.0, 10.0, n))
        lines[6 * len(lines) // 7 :] = 0.0
        return np.fft.irfft(lines, n)

    campaign, vehicle = clean
    rough = on_both_fronts(campaign, moves, lambda rng, n: rng.normal(0.0, 0.05, (n, 2)))
    assert "same-signal" not in [f.kind for f in gate(rough, vehicle).findings]


def test_one_sensor_on_two_inputs_is_found_though_each_input_has_noise(clean):
    """The noise of a conversion is a fifth of the sensor's own, which both inputs share."""

    def moves(rng, n):
        lines = np.fft.rfft(rng.normal(0.0, 10.0, n))
        lines[len(lines) // 3 :] = 0.0
        return np.fft.irfft(lines, n) + rng.normal(0.0, 0.05, n)

    campaign, vehicle = clean
    wired = on_both_fronts(campaign, moves, lambda rng, n: rng.normal(0.0, 0.0095, (n, 2)))
    assert "same-signal" in [f.kind for f in gate(wired, vehicle).findings]


def test_a_silent_channel_is_left_out(clean):
    campaign, vehicle = clean
    runs = tuple(
        replace(run, record=np.where(np.arange(8) == 2, 0.25, run.record)) for run in campaign.runs
    )
    gated = gate(replace(campaign, runs=runs), vehicle)
    name = campaign.channels[2].name
    assert any(f.kind == "stuck" and f"the channel {name}" in f.text for f in gated.findings)
    assert [c.name for c in gated.campaign.channels] == [
        c.name for c in campaign.channels if c.name != name
    ]
    for run, cut in zip(campaign.runs, gated.campaign.runs, strict=True):
        assert np.array_equal(cut.record, np.delete(run.record, 2, axis=1))


def test_a_channel_silent_in_one_run_costs_that_run_only(clean):
    campaign, vehicle = clean
    first, *others = campaign.runs
    stuck = replace(first, record=np.where(np.arange(8) == 2, 0.25, first.record))
    gated = gate(replace(campaign, runs=(stuck, *others)), vehicle)
    assert any(f.kind == "stuck" and first.id in f.text for f in gated.findings)
    assert gated.campaign.runs == tuple(others)
    assert gated.campaign.channels == campaign.channels


@pytest.mark.parametrize("factor", [1.0, 3.6, 0.9])
def test_the_rear_axle_follows_the_front_one_on_any_road(clean, factor):
    """Nobody surveyed the road; what A1 and A2 met, A3 and A4 meet a wheelbase later."""
    campaign, vehicle = clean
    rng, rate, n = np.random.default_rng(3), 100.0, 2000
    runs = []
    for i, kmph in enumerate((14.0, 18.0, 22.0)):
        lag = round(vehicle["geometry.wheelbase_m"] / (kmph / 3.6) * rate)
        road = np.repeat(rng.normal(size=(n + lag, 2)), 2, axis=1)
        axles = np.column_stack([road[lag:, 0], road[lag:, 2], road[:n, 0], road[:n, 2]])
        record = np.zeros((n, 8))
        for c, channel in enumerate(campaign.channels):
            own = axles if channel.is_axle else axles.cumsum(axis=0) * 0.1
            record[:, c] = own[:, int(channel.point[1]) - 1] + rng.normal(size=n)
        time_s = np.arange(n) / rate
        track = TrackSpec("unknown", {})
        runs.append(
            replace(
                campaign.runs[0],
                id=f"road-{i}",
                record=record,
                time_s=time_s,
                speed_m_s=kmph / 3.6 / factor,
                track=track,
            )
        )
    found = gate(replace(campaign, runs=tuple(runs), noise_rms=None), vehicle).findings
    said = [f.text for f in found if f.kind == "speed"]
    assert bool(said) == (factor == 3.6), [f.text for f in found]
    assert all("metres per second" in text for text in said)


def test_the_json_has_the_fields_agreed_on(clean):
    kinds, plant = MISTAKES["records in g"]
    (finding, *_) = to_json(gate(*plant(*clean, np.random.default_rng(1))).findings)
    assert {"when", "about", "text", "remedy", "severity"} <= finding.keys()
    assert finding["kind"] == kinds
