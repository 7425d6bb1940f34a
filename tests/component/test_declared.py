"""What [component] says of spring, damper and mass, and sensors that nobody has zeroed."""

from dataclasses import replace

import numpy as np
import pytest

from tests.component import rig
from tests.component.cases import diagnosed
from tests.component.rig import Component
from tests.component.test_read import edit
from wheelhop.api import compare
from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.diagnose import fit_baseline
from wheelhop.fit import vehicle_parameters
from wheelhop.vehicle import read_nominal

KEYS = ("mass_kg", "stiffness_N_m", "damping_N_s_m")
NO_SPRING = 1e-300


def made(folder, drive, component, said, **more):
    """A campaign whose [component] says these of the three."""
    nominal = "\n".join(f"{key} = {value}" for key, value in zip(KEYS, said, strict=True))
    rig.make_campaign(folder, drive, component, seed=3, noise=0.002, nominal=nominal, **more)
    return read_campaign(folder)


def free_of(campaign):
    return {
        f.name.removeprefix("component.")
        for f in vehicle_parameters(campaign, read_nominal(campaign))
    }


def fitted(campaign):
    return fit_baseline(campaign, read_nominal(campaign), jobs=1, progress=lambda text: None).rung


@pytest.mark.parametrize("gone", KEYS)
def test_a_part_that_is_none_stays_none(gone, tmp_path):
    """Whatever least squares would find for it in a force that is not linear."""
    said = ['"none"' if key == gone else '"unknown"' for key in KEYS]
    numbers = {"coulomb_N": 200.0, "joint_N_m": 2e5}
    hidden = Component(hidden="dry-friction", numbers=numbers)
    campaign = made(tmp_path / "c", "displacement", hidden, said)
    assert free_of(campaign) == set(KEYS) - {gone}
    values = fitted(campaign).model.values
    assert values[f"component.{gone}"] == 0.0
    unknown = made(tmp_path / "u", "displacement", hidden, ['"unknown"'] * 3)
    assert free_of(unknown) == set(KEYS)


def test_unknown_is_what_zero_was(tmp_path):
    zero, word = (
        read_nominal(made(tmp_path / name, "displacement", Component(), [said] * 3))
        for name, said in (("zero", "0.0"), ("word", '"unknown"'))
    )
    assert zero.values == word.values and zero.uncertainty == word.uncertainty


MISTAKES = {
    "a word that is none of these": ('"unknown"', '"nothing"', ["mass_kg", "none", "unknown"]),
    "an uncertainty of nothing": (
        'stiffness_N_m = "none"',
        'stiffness_N_m = "none"\nstiffness_N_m_uncertainty = 3.0',
        ["stiffness_N_m_uncertainty", "has no uncertainty"],
    ),
    "nothing at all": ('mass_kg = "unknown"', 'mass_kg = "massless"', ["all", "nothing is left"]),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_mistakes_are_a_line(name, tmp_path):
    said = ('"unknown"', '"none"', '"none"')
    made(tmp_path / "c", "displacement", Component(), said)
    old, new, words = MISTAKES[name]
    edit(tmp_path / "c" / "campaign.toml", old, new)
    with pytest.raises(CampaignError) as error:
        read_campaign(tmp_path / "c")
    line = str(error.value)
    assert line.isprintable() and all(word in line for word in words), line


@pytest.mark.parametrize("spring", ['"none"', '"unknown"'])
def test_a_load_cell_that_is_not_zeroed_moves_nothing_but_its_own_number(spring, tmp_path):
    """m ẍ + c ẋ = F + F₀ of a carriage without a spring: all but F₀ as if the cell were zeroed, and
    F₀ of each run, those held out included."""
    component = Component(mass_kg=5.0, stiffness_N_m=NO_SPRING, damping_N_s_m=120.0)
    campaign = made(tmp_path / "c", "force", component, (4.0, spring, 150.0), only="random")
    off = {run.id: 3.0 + i for i, run in enumerate(campaign.runs)}
    runs = tuple(replace(run, force=run.force + off[run.id]) for run in campaign.runs)
    rung = fitted(replace(campaign, runs=runs))
    assert rung.model.values["component.mass_kg"] == pytest.approx(5.0, rel=0.01)
    assert rung.model.values["component.damping_N_s_m"] == pytest.approx(120.0, rel=0.02)
    found = {run_id: -own["offset_N"] for run_id, own in rung.model.runs.items()}
    assert found == pytest.approx(off, abs=0.3)
    assert rung.error < 0.01


def test_a_rack_has_no_spring(tmp_path):
    """Friction and damping alone, long strokes held out: a spring invented on short ones would
    pull there."""
    numbers = {"coulomb_N": 60.0, "joint_N_m": 4e5}
    rack = Component(0.0, NO_SPRING, 250.0, hidden="dry-friction", numbers=numbers)
    none, unknown = (
        made(tmp_path / name.strip('"'), "displacement", rack, ('"none"', name, 200.0))
        for name in ('"none"', '"unknown"')
    )
    assert "stiffness_N_m" not in free_of(none)
    assert fitted(unknown).model.values["component.stiffness_N_m"] > 100.0
    assert np.isfinite(fitted(none).error)


def test_friction_on_a_rack_is_friction(tmp_path):
    """Not a fluid that yields, though that comes near it, and to first order bristles that stick
    look twice as good as the joint that slips."""
    numbers = {"coulomb_N": 58.0, "joint_N_m": 2.9e5}
    rack = Component(0.0, NO_SPRING, 250.0, hidden="dry-friction", numbers=numbers)
    said = "\n".join(f"{key} = {v}" for key, v in zip(KEYS, ('"none"', 0.0, 200.0), strict=True))
    folder = rig.make_campaign(
        tmp_path / "c", "displacement", rack, seed=0, noise=0.01, nominal=said
    )
    found = diagnosed(folder)
    assert found.verdict == ("dry-friction",)
    assert found.ladder[-1].parameters["dry-friction.strut_N"][0] == pytest.approx(58.0, rel=0.02)


class Hung(Component):
    """One on which a weight hangs that no load cell shows; displacement counts from where it rests,
    1.75 mm below."""

    REST = 1.75e-3

    def law(self):
        force = super().law()
        return lambda x, v: force(x + self.REST, v) - force(self.REST, 0.0)


@pytest.mark.parametrize(("said", "least", "most"), [("unknown", 0.0, 1.2), ("none", 3.0, 50.0)])
def test_a_weight_that_hangs_on_a_spring_that_bends_is_found(said, least, most, tmp_path):
    """Where the campaign says so; else the law is about another rest and leaves what is even."""
    hung = Hung(5.0, 20000.0, 120.0, hidden="cubic-spring", numbers={"cubic_N_m3": 1e8})
    folder = rig.make_campaign(
        tmp_path / "c", "force", hung, seed=3, noise=0.01, only="random", seconds=3.0
    )
    edit(folder / "campaign.toml", "[component]", f'[component]\npreload = "{said}"')
    found = compare(folder, add=["progressive-spring"], jobs=1, progress=False)
    assert least < found.error / found.floor < most
    alike = folder / "campaign.toml"
    edit(alike, 'drive = "force"', 'drive = "displacement"')
    edit(alike, "noise_rms_m", "noise_rms_N")
    if said == "unknown":
        with pytest.raises(CampaignError, match="preload: of an imposed displacement"):
            read_campaign(folder)
