"""What the start offers: campaigns opened lately, examples, and folders to look into."""

import shutil

import pytest

from tests.workbench.conftest import workbench
from wheelhop.files import InputError
from wheelhop.workbench import places


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    return tmp_path / "home"


def campaigns(folder, count):
    for i in range(count):
        (folder / f"c{i:02d}").mkdir(parents=True)
        (folder / f"c{i:02d}/campaign.toml").touch()
    return sorted(folder.iterdir())


def test_what_was_opened_lately_comes_first_and_what_is_gone_goes(tmp_path, home):
    assert places.recent() == []
    opened = campaigns(tmp_path / "campaigns", 14)
    for folder in (*opened, opened[3]):
        places.remember(folder)
    found = places.recent()
    assert found[:3] == [opened[3], opened[13], opened[12]] and len(found) == 12
    shutil.rmtree(opened[13])
    assert opened[13] not in places.recent()
    (home / "wheelhop/recent.json").write_text("{nonsense")
    assert places.recent() == []


def test_folders_of_a_place(tmp_path, monkeypatch):
    campaigns(tmp_path / "x", 2)
    (tmp_path / "x/another").mkdir()
    (tmp_path / "x/.hidden").mkdir()
    assert [f.name for f in places.folders(tmp_path / "x")] == ["c00", "c01", "another"]
    many = tmp_path / "many"
    for i in range(501):
        (many / str(i)).mkdir(parents=True)
    assert len(places.folders(many)) == 500
    with pytest.raises(InputError):
        places.folders(tmp_path / "none")


def test_an_example_of_a_wheel_is_copied_once(tmp_path, home, monkeypatch):
    [example] = campaigns(tmp_path / "packed", 1)
    monkeypatch.setattr(places, "PACKED", example.parent)
    copy = places.to_open(example)
    assert copy == home / "wheelhop/examples/c00" and (copy / "campaign.toml").is_file()
    (copy / "session.toml").touch()
    assert places.to_open(example) == copy and (copy / "session.toml").is_file()
    assert places.to_open(tmp_path) == tmp_path


def test_a_campaign_is_found_by_looking_and_remembered(small, tmp_path, open_page, pictures):
    home = tmp_path / "home"
    shutil.copytree(small, home / "cars/mine")
    with workbench(home=home) as (address, _):
        page = open_page(address)
        page.screenshot(path=pictures / "start.png", full_page=True)
        page.get_by_role("button", name="Look for it").click()
        page.get_by_role("button", name="cars").click()
        page.screenshot(path=pictures / "folders.png")
        page.get_by_role("button", name="mine").click()
        page.get_by_role("tab", name="Overview").wait_for()
        page.get_by_role("button", name="Close").click()
        page.get_by_role("button", name="mine", exact=True).wait_for()
