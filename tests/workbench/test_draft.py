"""From three files of another recorder to a campaign: what can be guessed is."""

from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.files import InputError
from wheelhop.workbench.draft import NOT_USED, Draft

NAMES = {
    **{"A1": "Acc axle FL", "A2": "Acc axle FR", "A3": "Acc axle RL", "A4": "Acc axle RR"},
    **{"B1": "Acc body FL", "B2": "Acc body FR", "B3": "Acc body RL", "B4": "Acc body RR"},
}
G = 9.80665
RATE = 100.0
REST_S, DRIVE_S = 4.0, 12.0


def write_foreign(folder: Path, count: int = 3) -> list[Path]:
    """Drives between two rests, in g, decimal commas, other names than ours."""
    rng = np.random.default_rng(3)
    files = []
    for i in range(count):
        n = round((2 * REST_S + DRIVE_S) * RATE)
        time = np.arange(n) / RATE
        driven = (time > REST_S) & (time < REST_S + DRIVE_S)
        wave = np.sin(2 * np.pi * (3 + i) * time)[:, None] * np.linspace(0.3, 1, 8)
        values = rng.normal(0, 0.003, (n, 8)) + driven[:, None] * wave
        head = "Time [s];" + ";".join(f"{name} [g]" for name in NAMES.values())
        rows = [
            ";".join(f"{x:.5f}".replace(".", ",") for x in (t, *row))
            for t, row in zip(time, values, strict=True)
        ]
        file = folder / f"drive {i + 1}.csv"
        file.write_text("\n".join([head, *rows]) + "\n")
        files.append(file)
    return files


@pytest.fixture
def draft(tmp_path) -> Draft:
    draft = Draft()
    for file in write_foreign(tmp_path):
        draft.add(file)
    draft.read()
    return draft


def test_units_places_and_stretches_are_guessed(draft):
    assert [column.place for column in draft.columns] == list(NAMES)
    assert {column.unit for column in draft.columns} == {"g"}
    assert len(draft.pieces) == 3
    for piece in draft.pieces:
        assert piece.from_s == pytest.approx(REST_S, abs=1.1)
        assert piece.to_s == pytest.approx(REST_S + DRIVE_S, abs=1.1)


def test_the_campaign_holds_what_was_recorded(draft, tmp_path):
    for piece in draft.pieces:
        piece.choose("washboard")
        piece.track |= {"amplitude_mm": 15.0, "pitch_mm": 400.0}
        piece.speed_kmph = 7.5
    draft.vehicle["body.mass_kg"] = 250.0
    draft.make(tmp_path / "made", "My car")
    campaign = read_campaign(tmp_path / "made")
    assert [run.role for run in campaign.runs] == ["fit", "fit", "validate"]
    assert {c.name for c in campaign.channels} == set(NAMES)
    run = campaign.runs[0]
    assert run.track.values["pitch_m"] == pytest.approx(0.4)
    assert run.speed_m_s == pytest.approx(7.5 / 3.6)
    a1 = [c.point for c in campaign.channels].index("A1")
    assert run.record[:, a1].std() == pytest.approx(0.3 * G / np.sqrt(2), rel=0.02)
    assert "mass_kg = 250.0" in (tmp_path / "made/vehicle.toml").read_text()


def test_a_column_that_is_not_used_is_no_channel(draft, tmp_path):
    draft.columns[3].place = NOT_USED
    draft.read()
    draft.make(tmp_path / "made", "My car")
    assert len(read_campaign(tmp_path / "made").channels) == 7


def mistakes():
    def nothing_taken(draft):
        for piece in draft.pieces:
            piece.taken = False

    def one_name(draft):
        for piece in draft.pieces:
            piece.id = "drive"

    def slash(draft):
        draft.pieces[1].id = "../drive"

    def steep(draft):
        draft.pieces[2].choose("washboard")
        draft.pieces[2].track |= {"amplitude_mm": 500.0, "pitch_mm": 100.0}

    def no_mass(draft):
        draft.vehicle["body.mass_kg"] = 0.0

    def outside(draft):
        draft.pieces[1].from_s, draft.pieces[1].to_s = 100.0, 120.0

    return [nothing_taken, one_name, slash, steep, no_mass, outside]


@pytest.mark.parametrize("spoil", mistakes(), ids=lambda f: f.__name__)
def test_a_mistake_gets_a_line_and_leaves_nothing(draft, tmp_path, spoil):
    spoil(draft)
    with pytest.raises(CampaignError) as caught:
        draft.make(tmp_path / "made", "My car")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "made").exists()


def test_two_sensors_in_one_place_are_refused(draft):
    draft.columns[1].place = draft.columns[0].place
    with pytest.raises(InputError):
        draft.read()


def test_a_campaign_that_is_there_stays(draft, tmp_path):
    draft.make(tmp_path / "made", "My car")
    before = (tmp_path / "made/campaign.toml").read_bytes()
    with pytest.raises(CampaignError, match="there is a campaign already"):
        draft.make(tmp_path / "made", "Another")
    assert (tmp_path / "made/campaign.toml").read_bytes() == before
