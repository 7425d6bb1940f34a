"""Speeds that change along the track: closed forms, and a run that is found again."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.campaign.course import Course
from wheelhop.cli.check import _print_known
from wheelhop.cli.main import main
from wheelhop.cli.output import open_console
from wheelhop.fit import find_start
from wheelhop.gate import gate
from wheelhop.predict import Case, read_drives, read_speeds
from wheelhop.vehicle import read_vehicle

VEHICLE = Path(__file__).parents[2] / "examples/clean/vehicle.toml"
SPEEDS = st.lists(st.floats(0.5, 30.0), min_size=2, max_size=6)


def course(kmph, spacing=7.0):
    return Course.of([(spacing * i, v) for i, v in enumerate(kmph)])


def test_where_speed_grows_with_the_way_the_way_grows_exponentially():
    """v = v₀ + a x: x = v₀ (e^{aT} − 1)/a, up to 20 m; then on at the speed reached."""
    found = Course.of([(0.0, 7.2), (20.0, 14.4)])  # 2 and 4 m/s: a = 0.1 1/s
    end = np.log(2.0) / 0.1
    np.testing.assert_allclose(found.place([0.0, 3.0, end]), [0, 20 * np.expm1(0.3), 20.0])
    np.testing.assert_allclose(found.place([-2.0, end + 1.5]), [-4.0, 26.0])
    assert found.mean_m_s == pytest.approx(20.0 / end)


@given(SPEEDS)
def test_place_and_time_are_inverses_and_speed_is_the_rate(kmph):
    found = course(kmph)
    x = np.linspace(-10.0, 7.0 * len(kmph) + 10.0, 200)
    time = found.time(x)
    assert (np.diff(time) > 0.0).all()
    np.testing.assert_allclose(found.place(time), x, atol=1e-8)
    h = 1e-4
    inner = time[1:-1]
    rate = (found.place(inner + h) - found.place(inner - h)) / (2 * h)
    np.testing.assert_allclose(rate, found.speed(x[1:-1]), rtol=0.02, atol=1e-3)


def test_a_course_at_one_speed_is_a_run_at_that_speed():
    vehicle = read_vehicle(VEHICLE)
    steady = read_drives(["half-sine-bump:amplitude_mm=40:length_mm=900"], [9.0])
    (flat,) = read_drives(
        ["half-sine-bump:amplitude_mm=40:length_mm=900"], read_speeds(["0:9,10:9"])
    )
    records = [
        Case(vehicle, (), (drive,), seconds=4.0).record(0, 100.0, 0.01) for drive in (*steady, flat)
    ]
    np.testing.assert_allclose(records[1], records[0], atol=1e-9)


def test_a_faster_vehicle_meets_the_waves_faster():
    """On a washboard the axles go up and down at v(x)/L: cycles are counted."""
    vehicle = read_vehicle(VEHICLE)
    (drive,) = read_drives(["washboard:amplitude_mm=10:pitch_mm=1000"], read_speeds(["0:5,30:18"]))
    motion = Case(vehicle, (), (drive,), seconds=12.0).motion(0)
    height, time = motion.height[:, 0], motion.time_s
    crossings = time[1:][(height[1:] > 0.0) & (height[:-1] <= 0.0) & (time[1:] > 0.0)]
    waves = np.arange(len(crossings) - 1)
    x = drive.course.place(crossings - 1.5)  # it reaches the course 1.5 s into the record
    np.testing.assert_allclose(np.diff(x)[waves], 1.0, atol=0.02)
    assert np.diff(crossings)[-1] < 0.5 * np.diff(crossings)[0]


def test_a_campaign_says_its_courses_and_a_fit_finds_where_they_began(tmp_path):
    words = ["--tracks", "washboard/low", "--speed", "0:6,20:13", "--noise", "0.02"]
    assert main(["simulate", str(VEHICLE), *words, "--out", str(tmp_path / "made")]) == 0
    campaign = read_campaign(tmp_path / "made")
    (run,) = campaign.runs
    assert run.course == Course.of([(0.0, 6.0), (20.0, 13.0)])
    vehicle = read_vehicle(campaign.vehicle_file)
    case = Case(vehicle, (), read_drives(["washboard/low"], read_speeds(["0:6,20:13"])))
    model = case.nominal
    found = find_start(campaign, run, model, model.system(campaign.channels, "road"))
    assert found["speed_m_s"] / run.speed_m_s == pytest.approx(1.0, abs=0.004)
    assert found["start_m"] == pytest.approx(run.course.place(-1.5), abs=0.05)


@pytest.mark.parametrize(
    "along", ["[[0, 5]]", "[[0, 5], [0, 6]]", "[[0, 5], [9, 0]]", "5.0", '[["a", 5], [2, 5]]']
)
def test_a_course_that_cannot_be_driven_is_a_line(along, tmp_path):
    words = ["--tracks", "washboard/low", "--speed", "8", "--seconds", "2"]
    folder = tmp_path / "made"
    assert main(["simulate", str(VEHICLE), *words, "--out", str(folder)]) == 0
    file = folder / "campaign.toml"
    text = file.read_text(encoding="utf-8")
    changed = text.replace("speed_kmph = 8.0", f"speed_kmph = 8.0\nspeed_along = {along}")
    file.write_text(changed, encoding="utf-8")
    with pytest.raises(CampaignError, match="speed_along") as error:
        read_campaign(folder)
    assert "\n" not in str(error.value)


@pytest.fixture(scope="module")
def slow(tmp_path_factory):
    """Two seconds at 8 km/h."""
    folder = tmp_path_factory.mktemp("slow") / "made"
    words = ["--tracks", "washboard/low", "--speed", "8", "--seconds", "2"]
    assert main(["simulate", str(VEHICLE), *words, "--out", str(folder)]) == 0
    return folder


def with_gps(made, folder, kmph, channel="", run=""):
    """The campaign with what a GPS shows, from its first sample to its last, in m/s."""
    shutil.copytree(made, folder)
    toml, (recording,) = folder / "campaign.toml", (folder / "runs").glob("*.csv")
    head, *rows = recording.read_text(encoding="utf-8").splitlines()
    names = head.split(",")[1:]
    shown = np.linspace(*kmph, len(rows)) / 3.6
    rows = [f"{row},{speed:.5f}" for row, speed in zip(rows, shown, strict=True)]
    recording.write_text("\n".join([f"{head},gps", *rows]) + "\n", encoding="utf-8")
    listed = "".join(f'{name} = "{name}"\n' for name in names)
    listed += f'gps = {{ quantity = "speed"{channel} }}\n'
    text = toml.read_text(encoding="utf-8").replace("speed_kmph = 8.0", f"speed_kmph = 8.0{run}")
    toml.write_text(text.replace("[[run]]", f"[channels]\n{listed}\n[[run]]", 1), encoding="utf-8")
    return folder


def test_a_channel_of_speed_says_how_a_known_track_was_driven(slow, tmp_path, capsys):
    own = ", scale_uncertainty = 0.01, noise_rms_m_s = 0.2"
    start = "\nstart_m = 3.5\nstart_m_uncertainty = 0.4"
    folder = with_gps(slow, tmp_path / "gps", (6.0, 10.8), own, start)
    (run,) = read_campaign(folder).runs
    assert run.speed_m_s == pytest.approx(8.4 / 3.6, rel=1e-4)
    assert run.start_m == (3.5, 0.4)
    driven = run.driven
    assert (driven.stated_m_s, driven.uncertainty, driven.noise_rms) == (8.0 / 3.6, 0.01, 0.2)
    assert driven.faster(run.time_s[-1]) == pytest.approx(10.8 / 8.4, rel=1e-4)
    _print_known(read_campaign(folder), open_console())
    assert capsys.readouterr().out == "speed     as gps shows it, in 1 of 1 runs\n"
    unknown = re.sub(r"track\..*", "", (folder / "campaign.toml").read_text(encoding="utf-8"))
    unknown = unknown.replace("start_m = 3.5", 'track.kind = "unknown"\nstart_m = 3.5')
    (folder / "campaign.toml").write_text(unknown, encoding="utf-8")
    (run,) = read_campaign(folder).runs
    assert (run.driven, run.speed_m_s) == (None, 8.0 / 3.6)


def test_a_channel_of_speed_in_another_unit_is_named(slow, tmp_path):
    for kmph, seems in (((28.0, 29.6), "in km/h"), ((7.6, 9.2), ""), ((15.0, 15.0), "1.88 times")):
        campaign = read_campaign(with_gps(slow, tmp_path / str(kmph[0]), kmph))
        found = [f for f in gate(campaign, read_vehicle(VEHICLE)).findings if "gps" in f.about]
        assert [seems in f.text and f.kind == "units" for f in found] == [True] * bool(seems)


@pytest.mark.parametrize(
    ("kmph", "run", "said"),
    [
        ((0.0, 0.0), "", "channel gps shows speeds"),
        ((-3.0, 20.0), "", "channel gps shows speeds"),
        ((8.0, 8.0), "\nspeed_along = [[0, 5], [9, 6]]", "delete one"),
        ((8.0, 8.0), "\nstart_m = 4.0", "start_m_uncertainty"),
        ((8.0, 8.0), "\nstart_m_uncertainty = 0.4", "start_m"),
    ],
)
def test_speeds_and_starts_that_cannot_be_are_a_line(kmph, run, said, slow, tmp_path):
    with pytest.raises(CampaignError, match=said) as error:
        read_campaign(with_gps(slow, tmp_path / "gps", kmph, run=run))
    assert "\n" not in str(error.value)
