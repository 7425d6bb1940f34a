"""What the gate says of a rig's recordings: copies that are none, and columns that count the other
way."""

from dataclasses import replace

import numpy as np
import pytest

from tests.component import rig
from tests.component.cases import CASES, OSCILLATOR
from wheelhop.campaign import read_campaign
from wheelhop.gate import gate
from wheelhop.vehicle import read_nominal

TIME_S = np.arange(1280) / rig.RATE_HZ


@pytest.fixture(scope="module")
def damper(tmp_path_factory):
    component = CASES["digressive-damper"].component("displacement")
    folder = tmp_path_factory.mktemp("damper") / "c"
    return read_campaign(rig.make_campaign(folder, "displacement", component, seed=1, noise=0.01))


def findings(campaign):
    return [(f.kind, f.severity) for f in gate(campaign, read_nominal(campaign)).findings]


def with_pairs(campaign, pairs):
    """The campaign with these displacements and forces."""
    runs = [
        replace(run, displacement=x, force=f, record=f[:, None])
        for run, (x, f) in zip(campaign.runs, pairs, strict=False)
    ]
    return replace(campaign, runs=tuple(runs))


def cycles(count, noise_N, step_m=0.0, step_N=0.0):
    """One cycle of 50 mm, again and again, by a servo that repeats it to a micrometre."""
    rng = np.random.default_rng(4)
    x = 0.05 * np.sin(2 * np.pi * 0.2 * TIME_S) + 0.01 * np.sin(2 * np.pi * 1.1 * TIME_S)
    clean = 1e3 * x + 40.0 * np.sign(np.gradient(x))
    for _ in range(count):
        pair = x + rng.normal(0.0, 1e-6, len(x)), clean + rng.normal(0.0, noise_N, len(x))
        yield tuple(
            y if not step else step * np.round(y / step)
            for y, step in zip(pair, (step_m, step_N), strict=True)
        )


@pytest.mark.parametrize("noise_N", [0.01, 0.3, 3.0])
def test_periods_that_repeat_are_no_copies(damper, noise_N):
    """All of them move by less than 10 mm from sample to sample, and by the same."""
    assert findings(with_pairs(damper, cycles(4, noise_N))) == []


def test_nor_are_they_where_a_display_shows_no_noise(damper):
    assert findings(with_pairs(damper, cycles(4, 0.1, step_m=0.002, step_N=5.0))) == []


@pytest.mark.parametrize("digits", [12, 3])
def test_a_recording_twice_is_a_copy(damper, digits):
    """Under another name, its mean taken out, rounded otherwise."""
    pairs = list(cycles(3, 0.3))
    x, f = pairs[0]
    pairs[2] = np.round(x - x.mean(), digits + 3), np.round(f - f.mean(), digits)
    copied = with_pairs(damper, pairs)
    assert findings(copied) == [("copy", "certain")]


def test_a_stretch_of_another_run_is_a_copy(damper):
    pairs = list(cycles(3, 0.3))
    joined = [np.concatenate([a[-800:], b[:480]]) for a, b in zip(pairs[0], pairs[2], strict=True)]
    pairs[1] = tuple(joined)
    assert ("copy", "certain") in findings(with_pairs(damper, pairs[:2]))


@pytest.mark.parametrize("drive", ["displacement", "force"])
@pytest.mark.parametrize("name", CASES)
def test_a_good_rig_passes_in_silence_and_a_reversed_cell_does_not(name, drive, tmp_path):
    component = CASES[name].component(drive)
    good = read_campaign(
        rig.make_campaign(tmp_path / "c", drive, component, seed=2, noise=0.02, seconds=3.0)
    )
    assert findings(good) == []
    reversed_cell = [(run.displacement, -run.force) for run in good.runs]
    found = findings(with_pairs(good, reversed_cell))
    assert [kind for kind, _ in found] == ["sign"]


def test_a_reversed_damper_is_certain_and_a_late_spring_is_not(damper):
    """Force against velocity; a spring whose force is recorded 3 ms early gives away ω τ."""
    x, v = 0.02 * np.sin(12.0 * TIME_S), 0.24 * np.cos(12.0 * TIME_S)
    assert findings(with_pairs(damper, [(x, -900.0 * v)])) == [("sign", "certain")]
    early = 0.02 * np.sin(12.0 * (TIME_S - 0.008))
    assert findings(with_pairs(damper, [(x, 2e4 * early)])) == [("sign", "likely")]
    hardly = 0.02 * np.sin(12.0 * (TIME_S - 0.003))
    assert findings(with_pairs(damper, [(x, 2e4 * hardly)])) == []


def test_runs_that_are_reversed_alone_are_named(damper):
    runs = list(damper.runs)
    runs[3] = replace(runs[3], force=-runs[3].force, record=-runs[3].record)
    (finding,) = gate(replace(damper, runs=tuple(runs)), read_nominal(damper)).findings
    assert runs[3].id in finding.text and runs[2].id not in finding.text
    assert "change the sign" in finding.remedy


def test_a_reversed_velocity_is_named(damper):
    runs = [
        replace(run, velocity=-np.gradient(run.displacement, run.time_s)) for run in damper.runs
    ]
    (finding,) = gate(replace(damper, runs=tuple(runs)), read_nominal(damper)).findings
    assert (finding.about, finding.severity) == ("velocity_m_s", "certain")


def test_a_mass_in_resonance_gives_nothing_away(tmp_path):
    folder = rig.make_campaign(tmp_path / "c", "force", OSCILLATOR, seed=3, noise=0.01)
    assert findings(read_campaign(folder)) == []
