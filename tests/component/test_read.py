"""A component's folder on disk: read as the format says, every mistake one line."""

import re

import numpy as np
import pytest

from tests.campaign.build import edit
from tests.component.rig import Component, make_campaign
from wheelhop.campaign import CampaignError, ComponentCampaign, RigRun, read_campaign
from wheelhop.vehicle import read_nominal


@pytest.fixture
def folder(tmp_path):
    return make_campaign(tmp_path / "c", "displacement", Component(), seed=1, noise=0.01)


def complaint(folder):
    with pytest.raises(CampaignError) as caught:
        read_campaign(folder)
    return str(caught.value)


def test_what_is_read(folder):
    campaign = read_campaign(folder)
    assert isinstance(campaign, ComponentCampaign)
    assert campaign.drive == "displacement"
    assert [(c.name, c.quantity, c.unit) for c in campaign.channels] == [("force", "force", "N")]
    assert campaign.noise_key == "noise_rms_N" and campaign.noise_rms > 0
    assert campaign.uncertainty["stiffness_N_m"] == 0.3 * campaign.nominal["stiffness_N_m"]
    assert campaign.uncertainty["mass_kg"] == 0.0
    table = np.loadtxt(campaign.runs[0].file, delimiter=",", skiprows=1)
    for run in campaign.runs:
        assert isinstance(run, RigRun) and run.velocity is None
        np.testing.assert_array_equal(run.record[:, 0], run.force)
    np.testing.assert_array_equal(campaign.runs[0].displacement, table[:, 1])
    with pytest.raises(ValueError, match="read-only"):
        campaign.runs[0].force[0] = 0.0


def test_an_imposed_force_measures_displacement(tmp_path):
    component = Component(5.0, 20000.0, 120.0)
    folder = make_campaign(tmp_path / "c", "force", component, seed=1, noise=0.01)
    campaign = read_campaign(folder)
    assert (campaign.channels[0].unit, campaign.noise_key) == ("m", "noise_rms_m")
    decay = campaign.runs[-1]
    assert not decay.force.any()
    np.testing.assert_array_equal(decay.record[:, 0], decay.displacement)


def test_a_recorded_velocity_is_used(folder):
    file = folder / "runs" / "random-3mm.csv"
    lines = file.read_text().splitlines()
    file.write_text(
        "\n".join([lines[0] + ",velocity_m_s", *(line + ",0.25" for line in lines[1:])]) + "\n"
    )
    run = next(run for run in read_campaign(folder).runs if run.id == "random-3mm")
    assert (run.velocity == 0.25).all()


def test_an_uncertainty_of_its_own(folder):
    edit(folder / "campaign.toml", "[component]", "[component]\nstiffness_N_m_uncertainty = 123.0")
    found = read_nominal(read_campaign(folder))
    assert found.uncertainty["component.stiffness_N_m"] == 123.0


MISTAKES = {
    "drive missing": ('drive = "displacement"\n', "", ["'drive' is missing", "'force'"]),
    "drive unknown": ('"displacement"', '"speed"', ["drive = 'speed'", "displacement, force"]),
    "noise of the other": ("noise_rms_N", "noise_rms_m", ["noise_rms_m"]),
    "noise of a vehicle": ("noise_rms_N", "noise_rms_m_s2", ["noise_rms_m_s2", "noise_rms_N"]),
    "unknown key": ("[component]", "[component]\nspring = 3", ["[component]", "unknown key"]),
    "wrong unit": ("stiffness_N_m =", "stiffness_N_mm =", ["stiffness_N_mm", "newtons per metre"]),
    "key of a vehicle": ("[component]", 'vehicle = "v"\n[component]', ["unknown key 'vehicle'"]),
    "negative": ("mass_kg = 0", "mass_kg = -1", ["mass_kg = -1", "below 0"]),
    "no uncertainty": ("relative_uncertainty = 0.3\n", "", ["'relative_uncertainty' is missing"]),
    "speed of a run": ('role = "fit"', 'role = "fit"\nspeed_kmph = 3', ["'speed_kmph'"]),
    "no component": (r"(?s)\[component\].*?(?=\[\[run)", "", ["'component' is missing"]),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_mistakes_in_campaign_toml(folder, name):
    old, new, words = MISTAKES[name]
    file = folder / "campaign.toml"
    text = file.read_text()
    changed = re.sub(old if name == "no component" else re.escape(old), new, text, count=1)
    assert changed != text
    file.write_text(changed)
    line = complaint(folder)
    assert line.isprintable() and str(file) in line
    assert all(word in line for word in words), line


def test_mistakes_in_recordings(folder):
    file = folder / "runs" / "random-3mm.csv"
    text = file.read_text()
    file.write_text(text.replace("displacement_m", "displacement_mm", 1))
    assert all(word in complaint(folder) for word in (str(file), "unexpected", "displacement_mm"))
    file.write_text(text.replace("force_N", "velocity_m_s", 1))
    assert "column force_N is missing" in complaint(folder)
    still = [",".join((*line.split(",")[:2], "7")) for line in text.splitlines()[1:]]
    file.write_text("\n".join([text.splitlines()[0], *still]) + "\n")
    assert "force_N never changes" in complaint(folder)


def test_a_massless_component_has_no_mass_to_be_found(folder):
    """0 means not known: there least squares finds some mass in the noise."""
    edit(folder / "campaign.toml", "mass_kg = 0", 'mass_kg = "massless"')
    nominal = read_nominal(read_campaign(folder))
    assert nominal.values["component.mass_kg"] == nominal.uncertainty["component.mass_kg"] == 0.0
    edit(folder / "campaign.toml", 'mass_kg = "massless"', "mass_kg = 0.0")
    assert read_nominal(read_campaign(folder)).uncertainty["component.mass_kg"] > 0.0


def test_a_force_needs_something_to_move(tmp_path):
    component = Component(5.0, 20000.0, 120.0)
    folder = make_campaign(tmp_path / "c", "force", component, seed=1, noise=0.01)
    edit(folder / "campaign.toml", "mass_kg = ", 'mass_kg = "massless" # ')
    assert "mass_kg: an imposed force moves a mass" in complaint(folder)


def test_a_stroke_may_be_shorter_than_a_drive(folder):
    for run in (folder / "runs").iterdir():
        run.write_text("\n".join(run.read_text().splitlines()[:90]) + "\n")
    run = read_campaign(folder).runs[0]
    assert run.time_s[-1] < 0.4
