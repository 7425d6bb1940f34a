"""Recordings become a campaign that reads back; what fails leaves everything as it was."""

import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.campaign.write import NewRun, add_run, cut, new_campaign
from wheelhop.cli.main import main
from wheelhop.formats import write
from wheelhop.logger.recording import Channel, Recording
from wheelhop.vehicle import read_nominal

POINTS = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")
WASHBOARD = {"kind": "washboard", "amplitude_mm": 15, "pitch_mm": 400}

SPECIMEN = """format = 1
name = "mount"
model = "generalized-maxwell"
band_hz = [1.0, 30.0]
times_s = [0.02]

[parameters]
E_inf = 8e4
E1 = 6e4
"""


def recording_of(names=POINTS, rows=1024, rate_hz=100.0, unit="m/s²") -> Recording:
    values = np.random.default_rng(1).normal(0, 3, (rows, len(names)))
    return Recording(values, rate_hz, tuple(Channel(n, unit) for n in names), averaging_s=0.01)


def run_of(name="slow", role="fit", **changes) -> NewRun:
    return NewRun(**{"id": name, "role": role, "speed_kmph": 7.5, "track": WASHBOARD} | changes)


def content(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture
def folder(tmp_path):
    new_campaign(tmp_path / "c", "our car", recording_of(), {})
    return tmp_path / "c"


def test_a_speed_that_a_channel_measures_need_not_be_said(folder, tmp_path):
    """It is the mean over the run, 5 m/s of 1 to 9; without such a channel it is asked for."""
    names = (*POINTS, "gps")
    channels = tuple(Channel(n, "m/s" if n == "gps" else "m/s²") for n in names)
    recording = replace(recording_of(names), channels=channels)
    recording.values[:, 8] = np.linspace(1.0, 9.0, len(recording.values))
    new_campaign(tmp_path / "gps", "our car", recording, {"gps": "speed"})
    add_run(tmp_path / "gps", recording, run_of(speed_kmph=None))
    assert "speed_kmph = 18.0\n" in (tmp_path / "gps/campaign.toml").read_text(encoding="utf-8")
    with pytest.raises(CampaignError, match=r"run slow: no channel tells its speed: .*speed-kmph"):
        add_run(folder, recording_of(), run_of(speed_kmph=None))


def test_a_campaign_of_two_runs_reads_back(folder):
    recording = recording_of()
    add_run(folder, recording, run_of())
    add_run(folder, cut(recording, 2.0, 6.0), run_of("fast", "validate", speed_kmph=20.0))
    campaign = read_campaign(folder)
    assert campaign.title == "our car" and campaign.averaging_s == 0.01
    assert [(run.id, run.role) for run in campaign.runs] == [("slow", "fit"), ("fast", "validate")]
    slow, fast = campaign.runs
    assert slow.track.values == {"amplitude_m": 0.015, "pitch_m": 0.4}
    assert np.allclose(slow.record, recording.values, rtol=1e-5)
    assert np.allclose(fast.record, recording.values[200:601], rtol=1e-5)
    assert read_nominal(campaign)["body.mass_kg"] > 0


def test_folders_and_files_may_be_names(folder):
    second = str(folder.with_name("second"))
    new_campaign(second, "second", recording_of(), {}, str(folder / "vehicle.toml"))
    assert add_run(second, recording_of(), run_of()) == Path(second, "runs", "slow.csv")
    assert [run.id for run in read_campaign(second).runs] == ["slow"]


@pytest.mark.parametrize("inside", ["mount.toml", "specimens/mount.toml"])
def test_the_specimen_a_vehicle_stands_on_comes_along(tmp_path, folder, inside):
    there = tmp_path / "other"
    (there / inside).parent.mkdir(parents=True)
    (there / inside).write_text(SPECIMEN)
    numbers = (folder / "vehicle.toml").read_text()
    (there / "vehicle.toml").write_text(f'mount = "{inside}"\n{numbers}')
    new_campaign(tmp_path / "d", "t", recording_of(), {}, there / "vehicle.toml")
    assert (tmp_path / "d" / inside).read_text() == SPECIMEN
    add_run(tmp_path / "d", recording_of(), run_of())
    values = read_nominal(read_campaign(tmp_path / "d")).values
    assert values["mount.stiffness_N_m"] == pytest.approx(8e4, rel=0.01)


@pytest.mark.parametrize("named", ["nowhere.toml", "../mount.toml"])
def test_a_vehicle_without_its_specimen_begins_no_campaign(tmp_path, folder, named):
    (tmp_path / "mount.toml").write_text(SPECIMEN)
    there = tmp_path / "other"
    there.mkdir()
    numbers = (folder / "vehicle.toml").read_text()
    (there / "vehicle.toml").write_text(f'mount = "{named}"\n{numbers}')
    with pytest.raises(CampaignError, match="mount"):
        new_campaign(tmp_path / "d", "t", recording_of(), {}, there / "vehicle.toml")
    assert not (tmp_path / "d").exists()


def test_a_sample_no_accelerometer_measures_is_refused(folder):
    good = recording_of()
    add_run(folder, good, run_of())
    for size in (2e6, 1e160):
        values = good.values.copy()
        values[7, 3] = -size
        with pytest.raises(CampaignError, match="no accelerometer"):
            add_run(folder, replace(good, values=values), run_of("broken"))
    assert len(read_campaign(folder).runs) == 1


def test_sensors_elsewhere_must_say_where_they_are(tmp_path):
    dash = recording_of(("A1", "A2", "dash", "imu"))
    with pytest.raises(CampaignError, match=r"dash: where does it sit\? --place dash= "):
        new_campaign(tmp_path / "c", "t", dash, {"imu": "body"})
    new_campaign(tmp_path / "c", "t", dash, {"imu": "body", "dash": [0.35, 0.0]})
    add_run(tmp_path / "c", dash, run_of())
    places = {c.name: c.point for c in read_campaign(tmp_path / "c").channels}
    assert places == {"A1": "A1", "A2": "A2", "dash": "body-xy", "imu": "body"}


def test_places_that_names_tell_come_as_the_answer_to_copy(tmp_path):
    """All in one go: of eight channels nobody wants to be asked eight times."""
    named = recording_of(("FL", "FR", "RL", "RR", "hub FL", "hub FR", "hub RL", "hub RR"))
    with pytest.raises(CampaignError) as asked:
        new_campaign(tmp_path / "c", "t", named, {})
    options = re.search(r"\? as their names say, (.*) \(", str(asked.value))[1]
    words = ["campaign", "new", str(tmp_path / "c"), str(tmp_path / "r.csv"), "--title", "t"]
    write(named, tmp_path / "r.csv")
    assert main([*words, *shlex.split(options)]) == 0
    add_run(tmp_path / "c", named, run_of())
    points = [channel.point for channel in read_campaign(tmp_path / "c").channels]
    assert points == list(POINTS)


def test_a_clock_that_was_corrected_gives_an_odd_rate(tmp_path):
    late = recording_of(rate_hz=99.7312)
    new_campaign(tmp_path / "c", "t", late, {})
    add_run(tmp_path / "c", late, run_of())
    assert read_campaign(tmp_path / "c").sample_rate_hz == 99.7312


BAD_RUNS = {
    "misspelt track": (run_of(track={"kind": "washbord"}), recording_of(), "washboard"),
    "missing key": (run_of(track={"kind": "washboard"}), recording_of(), "amplitude_mm"),
    "unknown role": (run_of(role="test"), recording_of(), "fit"),
    "first to validate": (run_of(role="validate"), recording_of(), "--role fit"),
    "id that is a path": (run_of("../x"), recording_of(), "letters, digits"),
    "codes": (run_of(), recording_of(unit="code"), "--calibration"),
    "too short": (run_of(), recording_of(rows=50), "at least 2 s"),
    "another rate": (run_of(), recording_of(rate_hz=200.0), "sample_rate_hz"),
    "a channel too few": (run_of(), recording_of(POINTS[:7]), "A4 is missing"),
}


@pytest.mark.parametrize("case", BAD_RUNS)
def test_what_fails_leaves_everything_as_it_was(case, folder):
    run, recording, words = BAD_RUNS[case]
    before = content(folder)
    with pytest.raises(CampaignError, match=words):
        add_run(folder, recording, run)
    assert content(folder) == before


def test_a_gap_is_named_with_its_time_and_can_be_cut_off(folder):
    recording = recording_of()
    recording.values[700] = np.nan
    with pytest.raises(CampaignError, match=r"1 samples are missing, the first at 7\.000 s"):
        add_run(folder, recording, run_of())
    add_run(folder, cut(recording, None, 6.99), run_of())
    assert len(read_campaign(folder).runs[0].time_s) == 700


def test_nothing_is_overwritten(folder):
    add_run(folder, recording_of(), run_of())
    before = content(folder)
    with pytest.raises(CampaignError, match="another --id"):
        add_run(folder, recording_of(), run_of())
    with pytest.raises(CampaignError, match="campaign already"):
        new_campaign(folder, "t", recording_of(), {})
    assert content(folder) == before


@given(low=st.floats(-5, 15), high=st.floats(-5, 15))
def test_cutting_keeps_samples_at_their_instants(low, high):
    recording = recording_of(rows=800)
    wanted = (recording.time_s >= low - 1e-9) & (recording.time_s <= high + 1e-9)
    if not wanted.any():
        with pytest.raises(CampaignError, match="outside"):
            cut(recording, low, high)
        return
    piece = cut(recording, low, high)
    assert np.array_equal(piece.values, recording.values[wanted])
    assert np.allclose(piece.time_s, recording.time_s[wanted], rtol=0, atol=1e-9)
    assert piece.history[-1].startswith("cut to")


@pytest.mark.parametrize("by_hand", [False, True])
def test_a_run_is_added_once_whoever_wrote_the_others(folder, by_hand):
    for name in ("one", "two"):
        add_run(folder, recording_of(), run_of(name))
    toml = folder / "campaign.toml"
    if by_hand:  # another order, other quotes
        text = toml.read_text().replace(
            'id = "one"\nfile = "runs/one.csv"', "file = 'runs/one.csv'"
        )
        toml.write_text(text.replace('role = "fit"', 'role = "fit"\nid = "one"', 1))
    before = toml.read_text()
    for name in ("one", "two"):
        with pytest.raises(CampaignError, match=f"there is a run '{name}'"):
            add_run(folder, recording_of(), run_of(name))
    assert toml.read_text() == before
    toml.write_text(before.replace("runs/two.csv", "runs/three.csv"))
    (folder / "runs/two.csv").rename(folder / "runs/three.csv")
    with pytest.raises(CampaignError, match="there is a run 'three'"):
        add_run(folder, recording_of(), run_of("three"))


@pytest.mark.parametrize(
    ("unit", "said"),
    [("code", "--nominal"), ("%", "is in %"), ("m", "is in m,"), ("", "does not say its unit")],
)
def test_advice_for_a_unit_is_one_that_helps(folder, unit, said):
    """Constants make accelerations of codes, and of nothing else: with --nominal it was the same
    advice again."""
    with pytest.raises(CampaignError, match="channel B1") as caught:
        add_run(folder, recording_of(unit=unit), run_of("more"))
    assert said in str(caught.value)
    assert ("--nominal" in str(caught.value)) == (unit == "code")


@pytest.mark.parametrize(
    ("unit", "place", "said"),
    [
        ("m", "A1", "it is good as travel:1"),
        ("m/s", "B1", "it is good as speed"),
        ("m", "speed", "a campaign takes m/s"),
        ("", "A1", "does not say its unit"),
        ("%", "A1", "is in %, a campaign takes m/s²"),
    ],
)
def test_a_campaign_begins_with_no_channel_that_it_would_never_take(unit, place, said, tmp_path):
    named = recording_of(("FL", "B2"), unit=unit)
    channels = (named.channels[0], replace(named.channels[1], unit="m/s²"))
    like = replace(named, channels=channels)
    with pytest.raises(CampaignError, match="channel FL") as caught:
        new_campaign(tmp_path / "c", "t", like, {"FL": place})
    assert said in str(caught.value) and not (tmp_path / "c").exists()
    if unit == "m" and place == "A1":
        new_campaign(tmp_path / "c", "t", like, {"FL": "travel:1"})
