"""What the blind benchmark's circumstances do to a campaign, and how answers are counted."""

import shutil

import numpy as np
import pytest

from benchmarks.blind.everything import COLOURED, IN_THE_FILES, STATED, colour_the_noise
from benchmarks.blind.plan import plan
from benchmarks.blind.reality import REALITY
from benchmarks.blind.recipes import RECIPES
from benchmarks.blind.score import Outcome
from tests.campaign.build import write_campaign
from tests.truth import in_band
from wheelhop.campaign import read_campaign
from wheelhop.vehicle import corner_position, read_vehicle


def spoilt(folder, kind, seed=0):
    """The campaign before and after."""
    before = read_campaign(write_campaign(folder / "before"))
    shutil.copytree(folder / "before", folder / "after")
    REALITY[kind].spoil(folder / "after", np.random.default_rng(seed))
    return before, read_campaign(folder / "after")


@pytest.mark.parametrize("kind", sorted(set(REALITY) - {"six-runs", "three-runs"}))
def test_what_a_circumstance_leaves_can_be_read(tmp_path, kind):
    _, after = spoilt(tmp_path, kind)
    assert after.runs


def test_beliefs_are_off_by_what_they_are_said_to_be(tmp_path):
    def relative(kind, number, read=lambda campaign: campaign):
        folder = tmp_path / kind
        for seed in range(8):  # a survey's error is drawn for one kind of track
            shutil.rmtree(folder, ignore_errors=True)
            before, after = (number(read(c)) for c in spoilt(folder, kind, seed))
            if before != after:
                return after / before
        return 1.0

    def vehicle(campaign):
        return read_vehicle(campaign.vehicle_file)

    def of_track(key):
        return lambda campaign: campaign.runs[0].track.values[key]

    speed = relative("speed-believed", lambda c: c.runs[0].speed_m_s)
    assert speed == pytest.approx(0.92)
    assert relative("mass-believed", lambda v: v["body.mass_kg"], vehicle) == pytest.approx(1.25)
    assert relative("amplitude-believed", of_track("amplitude_m")) == pytest.approx(1 / 1.1)
    assert relative("wavelength-believed", of_track("pitch_m")) == pytest.approx(1 / 1.01)


def test_channels_die_or_are_missing(tmp_path):
    _, dead = spoilt(tmp_path / "dead", "dead-channel")
    still = [np.ptp(run.record, axis=0) == 0.0 for run in dead.runs]
    assert all(s.sum() == 1 for s in still) and np.array_equal(still[0], still[1])
    _, four = spoilt(tmp_path / "four", "four-channels")
    assert len(four.channels) == 4


def test_coloured_noise_is_stated_in_its_sum_and_lies_low(tmp_path):
    before, after = spoilt(tmp_path, "noise-coloured")
    assert after.noise_rms == pytest.approx(np.sqrt(2.0) * before.noise_rms, rel=1e-6)
    added = np.vstack([b.record - a.record for a, b in zip(before.runs, after.runs, strict=True)])
    spectrum = np.abs(np.fft.rfft(added[: len(before.runs[0].record)], axis=0)) ** 2
    frequency = np.fft.rfftfreq(len(before.runs[0].record), 0.01)
    inside = spectrum[(frequency > 0.4) & (frequency < 30.0)].sum()
    assert spectrum[(frequency > 0.4) & (frequency < 6.0)].sum() > 0.6 * inside


@pytest.mark.parametrize("name", IN_THE_FILES)
def test_an_imperfection_of_the_files_grows_with_its_amount(tmp_path, name):
    """Twice the amount is twice as far from what was written, with the same draws."""
    before = read_campaign(write_campaign(tmp_path / "before"))
    vehicle = read_vehicle(before.vehicle_file)
    away = []
    for amount in (1.0, 2.0):
        folder = shutil.copytree(tmp_path / "before", tmp_path / f"{amount}")
        IN_THE_FILES[name](folder, np.random.default_rng(3), amount)
        away.append(numbers(name, read_campaign(folder), vehicle))
    written = numbers(name, before, vehicle)
    np.testing.assert_allclose(away[1] - written, 2.0 * (away[0] - written), rtol=1e-3, atol=2e-5)
    assert np.abs(away[0] - written).max() > 1e-4


def place_on_body(channel, vehicle):
    """Where it is said to be, m; an axle's point where the body's above it is."""
    if channel.corner is not None:
        return corner_position(vehicle.values, channel.corner)
    return channel.x_m, channel.y_m


def numbers(name, campaign, vehicle):
    """What an imperfection of the files changes."""
    if name == "scales":
        return np.concatenate([run.record.ravel() for run in campaign.runs])
    if name == "positions":
        return np.array([place_on_body(channel, vehicle) for channel in campaign.channels])
    key = {"amplitudes": "amplitude_m", "pitches": "pitch_m"}[name]
    return np.array([run.track.values[key] / 0.01 for run in campaign.runs])


def test_coloured_noise_is_more_than_is_stated(tmp_path):
    folder = write_campaign(tmp_path / "campaign")
    before = read_campaign(folder)
    colour_the_noise(folder, np.random.default_rng(1))
    after = read_campaign(folder)
    added = [in_band(b.record - a.record) for a, b in zip(before.runs, after.runs, strict=True)]
    rms = np.sqrt(np.mean([np.mean(part**2) for part in added]))
    share = rms / np.hypot(rms, before.noise_rms)
    assert share == pytest.approx(COLOURED, abs=0.02)
    whole = np.hypot(rms, before.noise_rms)
    assert after.noise_rms / whole == pytest.approx(STATED, abs=0.02)


def test_every_circumstance_has_seeds_of_its_own_for_good():
    cases = [c for c in plan(1000, 2, RECIPES.keys()) if c.kind in REALITY]
    assert len({c.seed for c in cases}) == len(cases) == 2 * len(REALITY)
    assert [c.seed for c in cases if c.kind == "codes"] == [1163, 1363]
    assert max(c.seed % 200 for c in cases) < 200
    assert {c.hidden for c in cases if c.kind == "tanh-friction"} == {("dry-friction",)}


@pytest.mark.parametrize(
    ("kind", "hidden", "verdict", "passed", "false_claim"),
    [
        ("codes", (), ("none",), True, False),
        ("codes", (), ("dry-friction",), False, True),
        ("codes", ("dry-friction",), ("dry-friction",), True, False),
        ("codes", ("dry-friction",), ("dry-friction", "sensor-gain"), False, True),
        ("codes", ("dry-friction",), ("none",), False, False),
        ("amplitude-believed", (), ("belief: amplitude of washboard tracks",), True, False),
        ("amplitude-believed", (), ("none",), True, False),
        ("amplitude-believed", (), ("belief: position of B1",), False, True),
        ("one-run", ("driver-seat",), ("unknown",), False, False),
        ("everything", ("backlash",), ("backlash", "speed-fluctuation", "unknown"), True, False),
        ("everything", ("backlash",), ("small-scale-roughness", "backlash"), False, False),
        ("everything", ("backlash",), ("backlash", "mount-bushing"), True, True),
        ("everything", (), ("none",), True, False),
        ("everything", (), ("unknown",), True, False),
        ("everything", (), ("belief: position of B1", "sensor-gain"), True, False),
        ("everything", (), ("backlash",), False, True),
    ],
)
def test_answers_are_counted(kind, hidden, verdict, passed, false_claim):
    seen = Outcome("x", kind, hidden, "atv", verdict, 0.9, (), 3.0, 1.0, 10.0)
    assert seen.passed is passed
    assert seen.is_false_claim is false_claim
