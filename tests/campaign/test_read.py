"""What a good campaign folder means: units, defaults, order, and that nothing is lost."""

import json
import math
import pickle
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.campaign.build import POINTS, ROWS, acceleration, csv_text, edit, write_campaign
from tests.work import calls
from wheelhop.campaign import Channel, TrackSpec, read_campaign

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture
def folder(tmp_path):
    return write_campaign(tmp_path / "c")


def test_everything_arrives_in_si(folder):
    campaign = read_campaign(folder)
    assert campaign.title == "two runs"
    assert campaign.vehicle_file == folder / "vehicle.toml"
    assert (campaign.sample_rate_hz, campaign.band_hz) == (100.0, (0.5, 30.0))
    assert campaign.averaging_s == pytest.approx(6.6e-3)
    assert campaign.noise_rms == 0.12
    slow, fast = campaign.runs
    assert (slow.id, slow.role, fast.id, fast.role) == ("slow", "fit", "fast", "validate")
    assert (campaign.fit_runs, campaign.validate_runs) == ((slow,), (fast,))
    assert fast.speed_m_s == pytest.approx(10.0)
    assert slow.track == TrackSpec("washboard", {"amplitude_m": 0.015, "pitch_m": 0.4})
    assert slow.time_s == pytest.approx(np.arange(ROWS) / 100.0)
    assert np.array_equal(slow.record, acceleration(1))
    assert np.array_equal(fast.record, acceleration(2))


def test_without_a_noise_line_the_floor_is_unknown_and_sampling_ideal(folder):
    edit(folder / "campaign.toml", "averaging_ms = 6.6\nnoise_rms_m_s2 = 0.12\n", "")
    campaign = read_campaign(folder)
    assert campaign.noise_rms is None
    assert campaign.averaging_s == 0.0


def test_a_window_of_three_periods_may_be_written_with_a_few_digits(folder):
    """3000/97 = 30.92783…"""
    edit(folder / "campaign.toml", "sample_rate_hz = 100", "sample_rate_hz = 97")
    edit(folder / "campaign.toml", "averaging_ms = 6.6", "averaging_ms = 30.9279")
    for run in (folder / "runs").glob("*.csv"):
        head, *rows = run.read_text().splitlines()
        rows = [f"{i / 97},{row.split(',', 1)[1]}" for i, row in enumerate(rows)]
        run.write_text("\n".join([head, *rows]) + "\n")
    assert read_campaign(folder).averaging_s == pytest.approx(3 / 97, rel=1e-12)


def test_channels_default_to_the_eight_points_in_column_order(folder):
    channels = read_campaign(folder).channels
    assert [channel.name for channel in channels] == list(POINTS)
    assert [channel.corner for channel in channels] == [0, 1, 2, 3, 0, 1, 2, 3]
    assert [channel.is_axle for channel in channels] == [False] * 4 + [True] * 4


def test_named_channels_select_place_and_follow_the_columns(folder):
    places = '[channels]\nA4 = "A4"\nB2 = [0.35, -0.2]\nB1 = "body"\n\n[[run]]'
    edit(folder / "campaign.toml", "[[run]]", places)
    campaign = read_campaign(folder)
    b1, b2, a4 = campaign.channels
    assert b1 == Channel("B1", "body")
    assert b2 == Channel("B2", "body-xy", 0.35, -0.2)
    assert a4 == Channel("A4", "A4")
    assert (b1.corner, b2.corner, a4.corner) == (None, None, 3)
    assert np.array_equal(campaign.runs[0].record, acceleration(1)[:, [0, 1, 7]])


def test_columns_are_found_by_name_in_every_run(folder):
    order = [7, 0, 6, 1, 5, 2, 4, 3]
    names = ("A4", "B1", "A3", "B2", "A2", "B3", "A1", "B4")
    (folder / "runs/fast.csv").write_text(csv_text(acceleration(2)[:, order], names))
    assert np.array_equal(read_campaign(folder).runs[1].record, acceleration(2))


def test_excel_line_ends_and_byte_order_mark_change_nothing(folder):
    for file in (folder / "campaign.toml", folder / "runs/slow.csv"):
        file.write_bytes(b"\xef\xbb\xbf" + file.read_bytes().replace(b"\n", b"\r\n"))
    assert np.array_equal(read_campaign(folder).runs[0].record, acceleration(1))


def test_parquet_holds_the_same_as_csv(folder):
    arrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    columns = dict(zip(POINTS, acceleration(1).T, strict=True))
    table = arrow.table({"time_s": np.arange(ROWS) / 100.0, **columns})
    parquet.write_table(table, folder / "runs/slow.parquet")
    edit(folder / "campaign.toml", "runs/slow.csv", "runs/slow.parquet")
    assert np.array_equal(read_campaign(folder).runs[0].record, acceleration(1))


def test_arrays_are_read_only_and_a_campaign_survives_a_trip_to_another_process(folder):
    campaign = read_campaign(folder)
    with pytest.raises(ValueError, match="read-only"):
        campaign.runs[0].record[0, 0] = 0.0
    copy = pickle.loads(pickle.dumps(campaign))
    assert np.array_equal(copy.runs[1].record, campaign.runs[1].record)


TRACKS = {
    'kind = "one-sided-washboard"\namplitude_mm = 10\npitch_mm = 500': {
        "amplitude_m": 0.01,
        "pitch_m": 0.5,
    },
    'kind = "herringbone"\namplitude_mm = 10\npitch_mm = 500': {
        "amplitude_m": 0.01,
        "pitch_m": 0.5,
        "angle_rad": math.radians(20.0),
    },
    'kind = "chassis-twist"\namplitude_mm = 150\npitch_mm = 2000\nlateral_offset_mm = -100': {
        "amplitude_m": 0.15,
        "pitch_m": 2.0,
        "width_m": 4.0,
        "lateral_offset_m": -0.1,
    },
    'kind = "sine-sweep"\namplitude_mm=5\npitch_start_mm=2000\npitch_end_mm=300\nlength_mm=3e4': {
        "amplitude_m": 0.005,
        "pitch_start_m": 2.0,
        "pitch_end_m": 0.3,
        "length_m": 30.0,
    },
    'kind = "half-sine-bump"\namplitude_mm = 50\nlength_mm = 900\nside = "left"': {
        "amplitude_m": 0.05,
        "length_m": 0.9,
        "side": "left",
    },
    'kind = "step-bump"\nheight_mm = 30\nwidth_mm = 50': {
        "height_m": 0.03,
        "width_m": 0.05,
        "side": "both",
    },
    'kind = "iso8608"\nunevenness_m3 = 16e-6\nwaviness = 2\nseed = 7': {
        "unevenness_m3": 16e-6,
        "waviness": 2.0,
        "seed": 7.0,
    },
    'kind = "flat"': {},
    'kind = "unknown"': {},
}


@pytest.mark.parametrize("text", TRACKS)
def test_every_kind_of_track_in_si_with_its_defaults(folder, text):
    with (folder / "campaign.toml").open("a") as file:
        runs = (
            '\n[[run]]\nid = "x"\nfile = "runs/x.csv"\nrole = "fit"\nspeed_kmph = 0\n[run.track]\n'
        )
        file.write(runs + text)
    (folder / "runs/x.csv").write_text(csv_text(acceleration(3)))
    track = read_campaign(folder).runs[-1].track
    assert f'"{track.kind}"' in text
    assert track.values == pytest.approx(TRACKS[text])


def test_a_profile_is_an_absolute_path_inside_the_folder(folder):
    (folder / "road.csv").write_text("x_m,left_m,right_m\n")
    old = 'track.kind = "washboard"\ntrack.amplitude_mm = 15\ntrack.pitch_mm = 400'
    edit(folder / "campaign.toml", old, 'track.kind = "profile"\ntrack.file = "road.csv"')
    track = read_campaign(folder).runs[0].track
    assert track == TrackSpec("profile", {"file": str((folder / "road.csv").resolve())})


@pytest.mark.parametrize(("rate_hz", "decimals"), [(128.0, 3), (120.0, 3), (400.0, 4), (30.0, 2)])
def test_rounded_time_stamps_are_uniform_enough(folder, rate_hz, decimals):
    edit(folder / "campaign.toml", "sample_rate_hz = 100.0", f"sample_rate_hz = {rate_hz}")
    edit(folder / "campaign.toml", "[0.5, 30.0]", "[0.5, 10.0]")
    for seed, name in enumerate(("slow", "fast"), start=1):
        rows = [
            f"{i / rate_hz:.{decimals}f}," + ",".join(map(str, row))
            for i, row in enumerate(np.tile(acceleration(seed), (4, 1)))
        ]
        header = csv_text(acceleration(1)).split("\n")[0]
        (folder / f"runs/{name}.csv").write_text("\n".join([header, *rows]))
    assert len(read_campaign(folder).runs[0].time_s) == 4 * ROWS


@pytest.mark.parametrize("name", sorted(p.parent.name for p in EXAMPLES.glob("*/campaign.toml")))
def test_the_examples_are_valid(name):
    campaign = read_campaign(EXAMPLES / name)
    assert len(campaign.runs) >= 8
    assert len({run.record.shape for run in campaign.runs}) == 1
    assert all(np.isfinite(run.record).all() for run in campaign.runs)


def test_reading_is_not_what_a_user_waits_for():
    """18 runs of 1024 samples: what is done for each sample is done by arrays."""
    read_campaign(EXAMPLES / "clean")
    assert calls(read_campaign, EXAMPLES / "clean") < 18 * 8 * 1024


def test_recordings_of_runs_left_out_are_not_read(folder):
    (folder / "runs/fast.csv").write_text("no recording\n")
    assert [run.id for run in read_campaign(folder, skip=["fast"]).runs] == ["slow"]


def test_runs_may_be_listed_without_their_samples(folder):
    (folder / "runs/fast.csv").write_text("no recording\n")
    campaign = read_campaign(folder, unread=lambda runs: [run.id for run in runs[1:]])
    slow, fast = campaign.runs
    assert (slow.id, fast.id) == ("slow", "fast")
    assert len(slow.time_s) > 0
    assert fast.record.shape == (0, len(campaign.channels)) and len(fast.time_s) == 0


def test_of_very_many_runs_it_is_said_how_far_reading_is(folder):
    toml, slow = folder / "campaign.toml", (folder / "runs/slow.csv").read_text()
    head, rows = slow.split("\n", 1)
    run = '[[run]]\nid = "{0}"\nfile = "runs/{0}.csv"\nrole = "fit"\nspeed_kmph = 5\n'
    for i in range(250):
        (folder / f"runs/{i}.csv").write_text(f"{head}\n{rows.replace(',', f',{i}', 1)}")
        edit(toml, "[[run]]", f'{run.format(i)}track.kind = "flat"\n\n[[run]]')
    said = []
    read_campaign(folder, progress=said.append)
    assert said[-1] == "reading recording 200 of 252"


names = st.text(
    st.characters(categories=("L", "N", "P", "S", "Zs"), exclude_characters=',"\\'), min_size=1
).filter(lambda name: name == name.strip() and name != "time_s" and name.isprintable())
finite = st.floats(-1e6, 1e6)
lengths_mm = st.floats(1.0, 100.0)


@st.composite
def recordings(draw):
    """Channels with their places, and the values of two runs."""
    channels = draw(st.lists(names, min_size=1, max_size=5, unique=True))
    places = st.sampled_from(["A1", "A4", "B2", "B3", "body"]) | st.tuples(finite, finite)
    where = {name: draw(places) for name in channels}
    # Two different ones: the same samples cannot be fitted and judge the fit.
    seeds = draw(st.lists(st.integers(0, 2**32), min_size=2, max_size=2, unique=True))
    values = [np.random.default_rng(s).normal(size=(220, len(channels))) * 10.0 for s in seeds]
    return where, values


@settings(max_examples=40)
@given(
    recordings(),
    names,
    st.one_of(st.just(0.0), st.floats(0.01, 200.0)),
    st.floats(0.1, 20.0),
    st.floats(1.0, 10.0),
    st.floats(20.0, 5000.0),
)
def test_what_is_written_is_what_is_read(data, title, speed_kmph, low, amplitude_mm, ratio):
    where, values = data
    pitch_mm = ratio * amplitude_mm
    quoted = {name: json.dumps(name, ensure_ascii=False) for name in where}
    lines = ["format = 1", f"title = {json.dumps(title, ensure_ascii=False)}"]
    lines += ["sample_rate_hz = 100", f"band_hz = [{low!r}, 49.0]", "[channels]"]
    lines += [f"{quoted[name]} = {json.dumps(place)}" for name, place in where.items()]
    for index, role in enumerate(("fit", "validate")):
        lines += ["[[run]]", f'id = "{index}"', f'file = "{index}.csv"', f'role = "{role}"']
        lines += [f"speed_kmph = {speed_kmph!r}", 'track.kind = "washboard"']
        lines += [f"track.amplitude_mm = {amplitude_mm!r}", f"track.pitch_mm = {pitch_mm!r}"]
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        (folder / "vehicle.toml").touch()
        (folder / "campaign.toml").write_text("\n".join(lines), encoding="utf-8")
        for index in (0, 1):
            text = csv_text(values[index], tuple(where))
            (folder / f"{index}.csv").write_text(text, encoding="utf-8")
        campaign = read_campaign(folder)
    assert campaign.title == title
    assert campaign.band_hz == (low, 49.0)
    for channel, (name, place) in zip(campaign.channels, where.items(), strict=True):
        assert channel.name == name
        assert place == channel.point or place == (channel.x_m, channel.y_m)
    for run, expected in zip(campaign.runs, values, strict=True):
        assert np.array_equal(run.record, expected)
        assert run.speed_m_s == pytest.approx(speed_kmph / 3.6)
        assert run.track.values["pitch_m"] == pytest.approx(pitch_mm / 1e3)
