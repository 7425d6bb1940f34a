"""On a road nobody knows measured travel drives the body, and its accelerations and rates judge."""

from dataclasses import replace

import pytest

from tests import truth
from tests.diagnose.cases import CASES, baseline_of, diagnosed, found_in
from wheelhop.campaign import CampaignError

FINE = tuple(
    replace(sensor, noise_rms=5e-5) if sensor.quantity == "travel" else sensor
    for sensor in truth.SENSORS
)
"""Potentiometers as good as these are: 0.05 mm in band."""


def made(folder, hidden, sensors=FINE, seed=101):
    """The same short runs; campaign.toml says nothing of their tracks."""
    folder = truth.make_campaign(
        folder, seed=seed, effects=hidden, short=True, seconds=4.8, draft=True, sensors=sensors
    )
    truth.forget_tracks(folder)
    return folder


def assert_expected(diagnosis):
    floor = diagnosis.ladder[-1].comparison.floor
    assert diagnosis.ladder[-1].rung.error_validate <= 1.1 * floor.expected_validate


def test_struts_are_told_without_a_track(tmp_path):
    """Springs and dampers per mass, as travel and acceleration show them directly."""
    folder = made(tmp_path, {})
    fitted = baseline_of(folder).rung.fit
    true, found = truth.read_truth(folder).vehicle, fitted.model.values
    for name in ("stiffness_N_m", "damping_N_s_m"):
        for end in ("front", "rear"):
            key = f"suspension.{end}.{name}"
            per_mass = found[key] / found["body.mass_kg"]
            assert per_mass == pytest.approx(true[key] / true["body.mass_kg"], rel=0.02)
    assert not any(free.name.startswith("wheel") for free in fitted.shared)


def test_nothing_is_missing(tmp_path):
    diagnosis = diagnosed(made(tmp_path, {}))
    assert diagnosis.verdict == ("none",)
    assert diagnosis.confidence > 0.9
    assert_expected(diagnosis)


def test_noisy_pots_find_no_physics_in_what_channels_err_together(tmp_path):
    """Noise of 0.2 mm moves the whole body: what rolls it freely would explain that."""
    diagnosis = diagnosed(made(tmp_path, {}, truth.SENSORS, seed=204))
    assert diagnosis.verdict == ("none",)
    assert diagnosis.confidence > 0.9


@pytest.mark.parametrize(
    "name", [pytest.param("digressive-damper", marks=pytest.mark.slow), "bump-stop"]
)
def test_a_law_of_the_struts_is_named(name, tmp_path):
    """A stop's clearance counts from where struts rest, which travel about its mean tells by what
    the stop does."""
    diagnosis = diagnosed(made(tmp_path, CASES[name].hidden))
    assert diagnosis.verdict == (name,)
    assert_expected(diagnosis)
    found = found_in(diagnosis, name)
    if name == "bump-stop":
        assert found["stiffness_N_m"] == pytest.approx(3e4, rel=0.15)
        assert found["clearance_m"] == pytest.approx(0.02, abs=0.006)
    else:
        assert found["front_loss"] == pytest.approx(0.6, rel=0.1)
        assert found["knee_m_s"] == pytest.approx(0.15, rel=0.1)


@pytest.mark.parametrize(
    ("sensors", "line"),
    [
        (
            FINE[1:],
            "so measured travel must drive the model, but no channel shows it at S1; describe",
        ),
        (FINE[:4], "no channel on the body"),
    ],
    ids=["no pot at one corner", "pots alone"],
)
def test_what_cannot_be_compared_is_said(sensors, line, tmp_path):
    with pytest.raises(CampaignError, match=line):
        baseline_of(made(tmp_path, {}, sensors))
