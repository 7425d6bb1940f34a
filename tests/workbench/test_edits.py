"""What the page changes in a campaign's files, and what takes it back."""

import shutil
import tomllib

import pandas as pd
import pytest

from tests.workbench.conftest import workbench
from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.campaign.change import Change
from wheelhop.workbench import edits
from wheelhop.workbench.forms import as_toml, filled, of_campaign, of_runs, of_vehicle


def test_a_change_is_kept_and_taken_back(small, tmp_path, monkeypatch):
    monkeypatch.setattr(edits, "MOST", 2)
    folder = shutil.copytree(small, tmp_path / "campaign")
    campaign, before = read_campaign(folder), (folder / "vehicle.toml").read_text()
    for mass in ("250.0", "251.0", "252.0"):
        change = Change("vehicle.toml", ("body", "mass_kg"), mass)
        edits.make(campaign, f"mass {mass}", edits.planned(campaign, [change]))
    assert [edit.title for edit in edits.read_edits(folder)] == ["mass 251.0", "mass 252.0"]
    assert edits.take_back(campaign).title == "mass 252.0"
    assert "mass_kg = 251.0" in (folder / "vehicle.toml").read_text()
    for wrong in ("-1.0", '"heavy"'):
        change = Change("vehicle.toml", ("body", "mass_kg"), wrong)
        with pytest.raises(CampaignError, match="mass_kg"):
            edits.make(campaign, "wrong", edits.planned(campaign, [change]))
    wrong = Change("campaign.toml", ("band_hz",), "[30.0, 0.5]")
    with pytest.raises(CampaignError, match="band_hz"):
        edits.make(campaign, "wrong", edits.planned(campaign, [wrong]))
    assert "mass_kg = 251.0" in (folder / "vehicle.toml").read_text()
    (folder / "vehicle.toml").write_text(before)  # somebody else
    with pytest.raises(CampaignError, match="meanwhile"):
        edits.take_back(campaign)


def test_forms_write_what_was_typed(small):
    assert as_toml("7,5", is_text=False) == "7.5"
    assert as_toml("[0.5, 20]", is_text=False) == "[0.5, 20]"
    assert as_toml("unknown", is_text=False) == '"unknown"'
    assert as_toml("12", is_text=True) == '"12"' and as_toml(" ", is_text=True) == ""
    campaign = read_campaign(small)
    fields = [field for field in (*of_campaign(campaign), *of_vehicle(campaign)) if field.text]
    assert {"band_hz", "body.mass_kg"} <= {field.name for field in fields}
    for field in fields:  # what stands there is written back as it is
        file = edits.planned(campaign, [field.change(field.text)])[0]
        assert tomllib.loads(file.after) == tomllib.loads(file.before), field
    assert list(of_runs(campaign).ids) == [run.id for run in campaign.runs]


def test_a_column_of_a_spreadsheet_fills_down_and_to_the_right():
    cells = filled(("b", "speed"), ("a", "b", "c"), ("role", "speed", "kind"), "7\tx\n8\ty\n9\tz\n")
    assert cells == {
        ("b", "speed"): "7",
        ("b", "kind"): "x",
        ("c", "speed"): "8",
        ("c", "kind"): "y",
    }


def test_a_finding_is_mended_by_its_button(small, tmp_path, open_page, pictures):
    """Two sensors exchanged: the change is shown, made, and taken back; a form changes two runs."""
    folder = shutil.copytree(small, tmp_path / "campaign")
    for file in folder.glob("runs/*.csv"):
        table = pd.read_csv(file)
        table.assign(A1=table.A3, A3=table.A1).to_csv(file, index=False)
    before = (folder / "campaign.toml").read_text()
    with workbench(folder) as (address, _):
        page = open_page(address)
        page.locator("button.fix").first.click()
        page.locator(".diff ins", has_text='A1 = "A3"').wait_for()
        page.screenshot(path=pictures / "change.png")
        page.get_by_role("button", name="Make this change").click()
        page.locator(".bench-notice", has_text="done").wait_for()
        assert [c.point for c in read_campaign(folder).channels].count("A3") == 1
        page.get_by_role("button", name="Take it back").click()
        page.locator(".bench-notice", has_text="taken back").wait_for()
        assert (folder / "campaign.toml").read_text() == before

        page.get_by_role("tab", name="Files").click()
        for row in (0, 1):
            page.locator(".bench-table tbody .q-checkbox").nth(row).click()
        speed = page.get_by_label("washboard-low-slow, speed_kmph")
        page.get_by_text("2 runs chosen").wait_for()
        speed.fill("8,5")
        speed.press("Tab")
        page.get_by_text("2 changed").wait_for()
        page.screenshot(path=pictures / "files.png", full_page=True)
        page.get_by_role("button", name="Look at the change").click()
        page.get_by_role("button", name="Make this change").click()
        page.locator(".bench-notice", has_text="done").wait_for()
        assert (folder / "campaign.toml").read_text().count("speed_kmph = 8.5") == 2
