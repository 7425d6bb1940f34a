"""From three files of another recorder to a campaign: what can be guessed is."""

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.files import InputError
from wheelhop.vehicle import read_vehicle
from wheelhop.workbench.draft import NOT_USED, Draft
from wheelhop.workbench.kept import drop, keep, resume

NAMES = {
    **{"A1": "Acc axle FL", "A2": "Acc axle FR", "A3": "Acc axle RL", "A4": "Acc axle RR"},
    **{"B1": "Acc body FL", "B2": "Acc body FR", "B3": "Acc body RL", "B4": "Acc body RR"},
}
G = 9.80665
RATE = 100.0
REST_S, DRIVE_S = 4.0, 12.0
KNOWN = {"front_kg": 130.0, "rear_kg": 160.0, "wheelbase_m": 1.42, "track_width_m": 1.18}


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
    draft = Draft(tmp_path / "draft")
    for file in write_foreign(tmp_path):
        draft.add(file)
    draft.read()
    for piece in draft.pieces:
        piece.speed_kmph = 10.0
    draft.answers |= KNOWN
    return draft


def test_units_places_and_stretches_are_guessed(draft):
    assert [column.place for column in draft.columns] == list(NAMES)
    assert {column.unit for column in draft.columns} == {"g"}
    assert len(draft.pieces) == 3
    for piece in draft.pieces:
        assert piece.from_s == pytest.approx(REST_S, abs=1.1)
        assert piece.to_s == pytest.approx(REST_S + DRIVE_S, abs=1.1)


def test_on_a_track_that_goes_on_alike_the_steady_part_is_the_run(tmp_path):
    """Unless somebody has moved the ends; a bump, and ground without a name, are driven whole."""
    rng = np.random.default_rng(8)
    time = np.arange(3600) / RATE
    level = np.select([(time < 4) | (time > 32), (time < 8) | (time > 28)], [0.02, 1.0], 0.0)
    wave = 4.0 * np.sin(2 * np.pi * 5.2 * time) * (level == 0.0)
    rows = rng.normal(size=(len(time), 8)) * (level + 0.02)[:, None] + wave[:, None]
    file = tmp_path / "day.csv"
    head = ",".join(["time_s", *(f"{point}_m_s2" for point in NAMES)])
    np.savetxt(file, np.column_stack([time, rows]), delimiter=",", header=head, comments="")
    draft = Draft(tmp_path / "draft")
    draft.add(file)
    draft.read()
    [piece] = draft.pieces
    assert (piece.from_s, piece.to_s) == pytest.approx((4.0, 32.0), abs=1.1)
    piece.choose("washboard")
    assert (piece.from_s, piece.to_s) == pytest.approx((8.0, 28.0), abs=1.6)
    assert piece.from_s >= 8.0 and piece.to_s <= 28.0
    piece.choose("half-sine-bump")
    assert (piece.from_s, piece.to_s) == pytest.approx((4.0, 32.0), abs=1.1)
    piece.from_s = 12.0
    piece.choose("washboard")
    assert piece.from_s == 12.0


def test_the_campaign_holds_what_was_recorded(draft, tmp_path):
    for piece in draft.pieces:
        piece.choose("washboard")
        piece.track |= {"amplitude_mm": 15.0, "pitch_mm": 400.0}
        piece.speed_kmph = 7.5
    draft.better["body.mass_kg"] = 250.0
    draft.recorder |= {"averaging_ms": 6.6, "noise_rms_m_s2": 0.05}
    draft.make(tmp_path / "made", "My car")
    campaign = read_campaign(tmp_path / "made")
    assert campaign.averaging_s == pytest.approx(6.6e-3)
    assert campaign.noise_rms == 0.05
    assert [run.role for run in campaign.runs] == ["fit", "fit", "validate"]
    assert {c.name for c in campaign.channels} == set(NAMES)
    run = campaign.runs[0]
    assert run.track.values["pitch_m"] == pytest.approx(0.4)
    assert run.speed_m_s == pytest.approx(7.5 / 3.6)
    a1 = [c.point for c in campaign.channels].index("A1")
    assert run.record[:, a1].std() == pytest.approx(0.3 * G / np.sqrt(2), rel=0.02)
    vehicle = read_vehicle(tmp_path / "made/vehicle.toml")
    assert vehicle.values["body.mass_kg"] == 250.0
    assert vehicle.values["geometry.wheelbase_m"] == 1.42


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
        draft.better["body.mass_kg"] = 0.0

    def no_weight(draft):
        draft.answers["front_kg"] = None

    def in_millimetres(draft):
        draft.answers["wheelbase_m"] = 1420.0

    def no_speed(draft):
        draft.pieces[0].speed_kmph = None

    def no_wavelength(draft):
        draft.pieces[0].choose("washboard")

    def long_mean(draft):
        draft.recorder["averaging_ms"] = 500.0

    def outside(draft):
        draft.pieces[1].from_s, draft.pieces[1].to_s = 100.0, 120.0

    wrong = [long_mean, nothing_taken, one_name, slash, steep, no_mass, outside]
    return [*wrong, no_weight, in_millimetres, no_speed, no_wavelength]


@pytest.mark.parametrize("spoil", mistakes(), ids=lambda f: f.__name__)
def test_a_mistake_gets_a_line_and_leaves_nothing(draft, tmp_path, spoil):
    spoil(draft)
    with pytest.raises(CampaignError) as caught:
        draft.make(tmp_path / "made", "My car")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "made").exists()


def test_two_sensors_in_one_place_are_refused(draft, tmp_path):
    draft.columns[1].place = draft.columns[0].place
    with pytest.raises(InputError):
        draft.read()
    with pytest.raises(InputError):  # what was read before is not what the columns say now
        draft.make(tmp_path / "made", "My car")


def test_a_draft_that_was_kept_is_the_same(draft, tmp_path):
    draft.pieces[0].choose("washboard")
    draft.pieces[0].track["pitch_mm"] = 400.0
    draft.pieces[1].to_s -= 2.0
    draft.columns[3].place, draft.columns[4].unit = NOT_USED, "mg"
    draft.recorder["averaging_ms"] = 5.0
    draft.better["body.mass_kg"], draft.title = 250.0, 'Mein "Auto" \u00fc'
    keep(draft)
    again = resume(draft.folder, None)
    for name in ("files", "columns", "pieces", "answers", "better", "recorder", "title"):
        assert getattr(again, name) == getattr(draft, name), name
    again.read()
    assert again.pieces == draft.pieces

    draft.files[0].unlink()  # its runs go, the others stay
    assert len(resume(draft.folder, None).pieces) == 2
    drop(draft)
    assert not draft.folder.exists()
    keep(draft)
    assert not draft.folder.exists()


@pytest.mark.parametrize("text", ["", "{", "[]", '{"files": 3}', '{"files": [null]}'])
def test_what_is_no_draft_begins_anew(tmp_path, text):
    (tmp_path / "draft.json").write_text(text)
    assert resume(tmp_path, None).files == []


def test_what_a_file_s_name_tells_is_not_asked(tmp_path):
    for file, name in zip(
        write_foreign(tmp_path),
        ("washboard 7,5 km_h.csv", "One-sided Washboard 13kmh.csv", "Twist_9_kmh.csv"),
        strict=True,
    ):
        file.rename(tmp_path / name.replace("km_h", "kmh"))
    draft = Draft(tmp_path / "draft")
    for file in sorted(tmp_path.glob("*.csv")):
        draft.add(file)
    draft.read()
    found = {(piece.kind, piece.speed_kmph) for piece in draft.pieces}
    assert found == {("washboard", 7.5), ("one-sided-washboard", 13.0), ("chassis-twist", 9.0)}


def test_runs_join_a_campaign_or_none_does(draft, tmp_path):
    folder = tmp_path / "made"
    draft.make(folder, "My car")
    more = Draft(tmp_path / "more", folder)
    for file in write_foreign(tmp_path):
        more.add(file)
    more.read()
    for i, piece in enumerate(more.pieces):
        piece.id, piece.speed_kmph = f"again-{i}", 12.0
    more.pieces[2].id = draft.pieces[0].id  # is there already
    before = {path: path.read_bytes() for path in folder.rglob("*.*")}
    with pytest.raises(CampaignError, match="there is a run"):
        more.join(folder)
    assert {path: path.read_bytes() for path in folder.rglob("*.*")} == before
    more.pieces[2].id = "again-2"
    more.join(folder)
    assert len(read_campaign(folder).runs) == 6


@pytest.mark.skipif(not hasattr(os, "fork"), reason="a process that is killed is a fork of this")
def test_killed_while_it_joins_runs_a_campaign_has_all_of_them_or_none(draft, tmp_path):
    """Killed before and after every rename in turn."""
    folder, places = tmp_path / "campaign", {}
    draft.make(folder, "t")
    before = (folder / "campaign.toml").read_bytes()
    more = Draft(tmp_path / "more", folder)
    for file in write_foreign(tmp_path):
        more.add(file)
    more.read()
    for i, piece in enumerate(more.pieces):
        piece.id, piece.speed_kmph = f"again-{i}", 12.0
    for step in range(20):
        child = os.fork()
        if child == 0:
            rename, left = os.replace, [step]

            def killed(source, target, rename=rename, left=left):
                for last in (True, False):
                    if left[0] == 0:
                        os._exit(7)
                    left[0] -= 1
                    if last:
                        rename(source, target)

            os.replace = killed
            more.join(folder)
            os._exit(0)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        places[step] = len(read_campaign(folder).runs) - len(draft.pieces)
        assert places[step] in (0, len(more.pieces)), step
        (folder / "campaign.toml").write_bytes(before)
        if status == 0:
            break
    assert len(set(places.values())) == 2 and len(places) > len(more.pieces)


def test_a_stretch_can_be_added_by_hand(draft):
    file = draft.files[0]
    piece = draft.new_piece(file)
    span = 2 * REST_S + DRIVE_S
    assert 0 < piece.from_s < span / 2 < piece.to_s < span
    assert piece.id not in {other.id for other in draft.pieces if other is not piece}


def test_a_campaign_that_is_there_stays(draft, tmp_path):
    draft.make(tmp_path / "made", "My car")
    before = (tmp_path / "made/campaign.toml").read_bytes()
    with pytest.raises(CampaignError, match="there is a campaign already"):
        draft.make(tmp_path / "made", "Another")
    assert (tmp_path / "made/campaign.toml").read_bytes() == before


def with_unit(tmp_path, unit: str, name: str = "A1", behind: str = "{} [{}]") -> Draft:
    """A draft of one recording whose first column is in another unit than the rest."""
    file = write_foreign(tmp_path, 1)[0]
    label = behind.format(name, unit) if unit else name
    file.write_text(file.read_text().replace("Acc axle FL [g]", label, 1))
    draft = Draft(tmp_path / "draft")
    draft.add(file)
    return draft


@pytest.mark.parametrize("unit", ["mm", "deg/s", "km/h", "%", "V", "furlong", ""])
def test_a_column_in_no_unit_of_acceleration_is_never_taken_for_one(tmp_path, unit):
    """A damper's potentiometer called A1 has no place; nor has a unit that is not known."""
    draft = with_unit(tmp_path, unit)
    assert draft.columns[0].unit == unit
    proposed = {"mm": NOT_USED, "deg/s": NOT_USED, "km/h": "speed"}
    assert draft.columns[0].place == proposed.get(unit, "A1")
    draft.columns[0].place = "A1"
    with pytest.raises(CampaignError, match=r"drive 1\.csv: column A1.* unit") as caught:
        draft.read()
    assert (unit or "does not say") in str(caught.value)
    with pytest.raises(CampaignError):
        draft.make(tmp_path / "made", "My car")
    draft.columns[0].place = NOT_USED  # what the line says to do
    draft.read()
    assert len(draft.recordings[draft.files[0]].channels) == 7
    draft.columns[0].place, draft.columns[0].unit = "A1", "m/s²"  # or the user knows better
    draft.read()
    assert draft.recordings[draft.files[0]].channels[0].unit == "m/s²"


@pytest.mark.parametrize(
    ("unit", "factor"), [("m/s^2", 1.0), ("ft/s²", 0.3048), ("Gal", 0.01), ("G", G), ("m/s/s", 1.0)]
)
def test_an_acceleration_in_any_known_unit_becomes_si(tmp_path, unit, factor):
    draft = with_unit(tmp_path, unit)
    draft.read()
    found = draft.recordings[draft.files[0]]
    file = draft.files[0].read_text().splitlines()[1:]
    written = [float(line.split(";")[1].replace(",", ".")) for line in file]
    assert found.values[:, 0] == pytest.approx(factor * np.array(written))


def test_a_length_whose_name_tells_a_corner_is_a_damper_s_travel(tmp_path):
    draft = with_unit(tmp_path, "mm", "damper axle FL")
    assert draft.columns[0].place == "travel:1"
    draft.read()


def test_a_speed_that_was_measured_is_not_asked(tmp_path):
    draft = with_unit(tmp_path, "km/h", "GPS speed")
    assert draft.columns[0].place == "speed"
    draft.read()
    assert not any("speed" in gap for gap in draft.gaps())
    draft.columns[0].place = NOT_USED
    draft.read()
    assert any("speed" in gap for gap in draft.gaps())


def test_every_recording_keeps_the_unit_it_says(tmp_path):
    """The second was set to mg: its numbers are a thousand times larger, not its motion."""
    rows = "\n".join(f"{i / 100};{{}};{{}}" for i in range(2000))
    head = "Time;A1;A2\ns;{};{}\n"
    for name, unit, amplitude in (("one", "g", 1.0), ("two", "mg", 1000.0)):
        numbers = [amplitude * np.sin(0.3 * (i // 2)) for i in range(4000)]
        text = (head.format(unit, unit) + rows).format(*numbers)
        (tmp_path / f"{name}.csv").write_text(text)
    draft = Draft(tmp_path / "draft")
    for name in ("one", "two"):
        draft.add(tmp_path / f"{name}.csv")
    draft.read()
    one, two = draft.recordings.values()
    assert two.values == pytest.approx(one.values, rel=1e-9)


def test_a_recording_without_time_is_not_given_a_rate(tmp_path):
    file = tmp_path / "run.csv"
    file.write_text("A1 [g];A2 [g]\n" + "".join(f"{i % 7};{i % 5}\n" for i in range(2000)))
    draft = Draft(tmp_path / "draft")
    draft.add(file)
    assert draft.waiting == file and "no column is time" in draft.asked[0].words


def test_a_unit_of_time_that_is_not_known_is_not_taken_for_seconds(tmp_path):
    file = write_foreign(tmp_path, 1)[0]
    file.write_text(file.read_text().replace("Time [s]", "Time [ticks]"))
    draft = Draft(tmp_path / "draft")
    draft.add(file)
    assert draft.asked[0].key == "time_unit" and "ticks" in draft.asked[0].words


def test_files_that_arrive_together_are_all_added(tmp_path):
    """The page adds each file in a thread of its own; here threads change as often as they can."""
    files = write_foreign(tmp_path)
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(len(files)) as pool:
            for i in range(40):
                draft = Draft(tmp_path / f"draft-{i}")
                list(pool.map(draft.add, files))
                assert draft.files == files
    finally:
        sys.setswitchinterval(before)
