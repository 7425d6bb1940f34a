"""Schemas say what readers accept: they are traced from them, and hold for files that are there."""

import datetime
import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

from wheelhop.campaign import read_campaign
from wheelhop.cli.main import main
from wheelhop.files import InputError
from wheelhop.files.schemas import names, schema
from wheelhop.vehicle import read_vehicle

ROOT = Path(__file__).parents[2]
FILES = [
    *((path, "campaign") for path in sorted(ROOT.glob("examples/*/campaign.toml"))),
    *((path, "vehicle") for path in sorted(ROOT.glob("examples/*/vehicle.toml"))),
    (ROOT / "examples/vehicles/mounts.toml", "vehicle"),
    (ROOT / "tests/data/friction-damper/campaign.toml", "component"),
]


def validator(name):
    return jsonschema.Draft202012Validator(json.loads(schema(name)))


def plain(value):
    """Days as JSON has them."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [plain(item) for item in value]
    return value.isoformat() if isinstance(value, datetime.date) else value


@pytest.fixture
def make(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    import make_schemas

    return make_schemas


def test_the_schemas_and_the_page_are_what_the_readers_ask_for(make):
    for path, text in make.files(make.traced()).items():
        assert path.read_text(encoding="utf-8") == text, f"{path}: run docs/make_schemas.py"


def test_every_key_says_what_it_means(make):
    for name, found in make.traced().items():
        assert make.undescribed(found) == [], f"say it in docs/keys.toml, [{name}]"


@pytest.mark.parametrize("name", names())
def test_every_schema_is_one(name):
    jsonschema.Draft202012Validator.check_schema(json.loads(schema(name)))


@pytest.mark.parametrize(("path", "name"), FILES, ids=lambda each: str(each)[-40:])
def test_files_that_are_read_fit_their_schema(path, name):
    document = plain(tomllib.loads(path.read_text(encoding="utf-8")))
    assert [error.message for error in validator(name).iter_errors(document)] == []


def test_what_is_written_fits_its_schema(tmp_path, make):
    """A vehicle of `wheelhop new`, constants, a fitted model."""
    words = ["--front-kg", "130", "--rear-kg", "160", "--wheelbase-m", "1.4"]
    assert main(["new", str(tmp_path / "car"), *words, "--track-width-m", "1.2"]) == 0
    vehicle = tomllib.loads((tmp_path / "car/vehicle.toml").read_text())
    validator("vehicle").validate(vehicle)
    import schema_documents

    validator("calibration").validate(plain(tomllib.loads(schema_documents.CALIBRATION)))


BROKEN = {
    "mass_kg = 251.0": "mass_kg = -251.0",
    "wheelbase_m = 1.42": 'wheelbase_m = "1.42"',
    "relative_uncertainty = 0.1": "relative_uncertainty = 0.0",
    'name = "all keys"': "",
    "modes = 2": "mode = 2",
    "cg_height_m = 0.5": "",
}


@pytest.mark.parametrize("whole", BROKEN)
def test_what_a_reader_refuses_of_a_single_key_the_schema_refuses_too(tmp_path, make, whole):
    import schema_documents

    make._prepare(tmp_path)
    text = schema_documents.VEHICLE
    assert text.count(whole) >= 1
    (tmp_path / "vehicle.toml").write_text(text)
    read_vehicle(tmp_path / "vehicle.toml")
    validator("vehicle").validate(tomllib.loads(text))
    broken = text.replace(whole, BROKEN[whole], 1)
    (tmp_path / "vehicle.toml").write_text(broken)
    with pytest.raises(InputError):
        read_vehicle(tmp_path / "vehicle.toml")
    assert not validator("vehicle").is_valid(tomllib.loads(broken))


def test_a_campaign_s_misspelt_key_is_refused_by_both(tmp_path):
    text = (ROOT / "examples/clean/campaign.toml").read_text()
    for name in ("runs", "vehicle.toml"):
        (tmp_path / name).symlink_to(ROOT / "examples/clean" / name)
    (tmp_path / "campaign.toml").write_text(text.replace("speed_kmph", "speed_kmh"))
    with pytest.raises(InputError, match=r"speed_kmph \(not speed_kmh\)"):
        read_campaign(tmp_path)
    assert not validator("campaign").is_valid(
        tomllib.loads(text.replace("speed_kmph", "speed_kmh"))
    )


def test_the_command_prints_them(capsys):
    assert main(["schema"]) == 0
    assert capsys.readouterr().out.split() == names()
    assert main(["schema", "vehicle.toml"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "vehicle.toml"
    assert main(["schema", "vehicel"]) == 2
    assert "did you mean 'vehicle'" in capsys.readouterr().err
