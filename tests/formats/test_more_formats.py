"""MATLAB, HDF5, enDAQ, ROS bags, MCAP, AiM and VBOX: files of the layouts their users make."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy import io

from tests.formats.foreign import G, save
from tests.formats.logged import units_of
from wheelhop.formats import ExchangeError, Map, read, understand

ROWS = 400
TIME_S = np.arange(ROWS) / 200.0
WAVE = np.sin(5.0 * TIME_S)


def matlab(tmp_path, **variables):
    path = tmp_path / "run.mat"
    io.savemat(path, variables, oned_as="column")
    return path


def hdf5(tmp_path, fill, name="run.h5"):
    import h5py

    path = tmp_path / name
    with h5py.File(path, "w") as file:
        fill(file)
    return path


def test_a_workspace_of_vectors_beside_their_time(tmp_path):
    path = matlab(tmp_path, t=TIME_S, FrontLeft=WAVE, two=np.column_stack([WAVE, -WAVE]), k=3.0)
    found = read(path)
    assert found.rate_hz == 200.0 and [c.name for c in found.channels] == [
        "FrontLeft",
        "two 1",
        "two 2",
    ]
    assert np.array_equal(found.values, np.column_stack([WAVE, WAVE, -WAVE]))
    assert "taken for granted: t is in s" in found.history
    with pytest.raises(ExchangeError, match="would have to be guessed: t is in s"):
        read(path, guess=False)


def test_a_name_of_a_variable_is_no_unit(tmp_path):
    """z_g was a ground's height, found in a repository, and no acceleration."""
    assert units_of(read(matlab(tmp_path, t=TIME_S, z_g=WAVE))) == {"z_g": ""}


def test_a_struct_with_its_rate_and_unit(tmp_path):
    path = matlab(tmp_path, run={"acc": WAVE, "Fs": 200.0, "units": "g"})
    found = read(path)
    assert found.rate_hz == 200.0 and "200 Hz: Fs says 200 Hz" in found.history
    assert found.values[:, 0] == pytest.approx(WAVE * G)
    assert read(matlab(tmp_path, acc=WAVE, dt=0.005)).rate_hz == 200.0


def test_a_rate_that_the_stamps_belie_is_asked(tmp_path):
    path = matlab(tmp_path, t=TIME_S, acc=WAVE, fs=100.0)
    asked = understand(path).questions
    assert [q.key for q in asked] == ["rate_hz"]
    assert "fs says 100 Hz, the stamps go at 200 Hz" in asked[0].words
    with pytest.raises(ExchangeError, match=r"has no time .fs says 100 Hz"):
        read(path)
    assert read(path, Map(rate_hz=200.0)).rate_hz == 200.0


def test_a_matrix_without_time_is_asked_for_its_rate(tmp_path):
    path = matlab(tmp_path, data=np.column_stack([WAVE, -WAVE]))
    assert [q.key for q in understand(path).questions] == ["rate_hz"]
    assert read(path, Map(rate_hz=50.0)).values.shape == (ROWS, 2)
    path = matlab(tmp_path, tt=TIME_S, data=WAVE)  # rises evenly, but is not called time
    assert "tt rises evenly by 0.005: if it is time" in understand(path).questions[0].words
    assert read(path, Map(time="tt", time_unit="s")).rate_hz == 200.0


def test_pictures_and_single_numbers_in_a_workspace_are_no_channels(tmp_path):
    wide, picture = np.zeros((ROWS, 256)), np.zeros((ROWS, 257))
    found = read(matlab(tmp_path, t=TIME_S, wide=wide, picture=picture, gains=np.ones(2)))
    assert len(found.channels) == 256
    path = matlab(tmp_path, three=np.array([1.0, 5.0, 2.0]), gains=np.ones(2))
    assert read(path, Map(rate_hz=10.0)).values.shape == (3, 1)


def test_spectra_in_a_workspace_are_no_recordings(tmp_path):
    path = matlab(tmp_path, frf={"frequency": np.arange(50.0), "h": np.arange(50.0) ** 2})
    with pytest.raises(ExchangeError, match="frequency rises evenly, in Hz: this is a spectrum"):
        read(path)


def test_structs_of_two_clocks_are_groups_and_one_by_resampling(tmp_path):
    slow = {"t": TIME_S[::20], "v": TIME_S[::20] * 2.0}
    path = matlab(tmp_path, imu={"t": TIME_S, "acc": WAVE}, gps=slow)
    with pytest.raises(ExchangeError, match=r'"imu" .*"gps".*, or resample_hz = … takes every'):
        read(path)
    found = read(path, Map(resample_hz=200.0))
    assert [c.name for c in found.channels] == ["acc", "v"]
    assert np.array_equal(found.values[:, 0], WAVE)
    assert found.values[:381, 1] == pytest.approx(2.0 * TIME_S[:381])


def test_hdf5_with_units_and_rates_in_attributes(tmp_path):
    def fill(file):
        file["front"] = WAVE
        file["front"].attrs["unit"] = "g"
        file["front"].attrs["sample_rate"] = 200.0

    found = read(hdf5(tmp_path, fill))
    assert found.rate_hz == 200.0 and found.values[:, 0] == pytest.approx(WAVE * G)


def test_hdf5_that_would_have_to_be_scaled_is_raw_in_no_unit(tmp_path):
    """As netCDF packs numbers; what is 1, or 0 to be added, changes nothing."""
    for attributes, unit in (
        ({"scale_factor": 0.001}, ""),
        ({"add_offset": 3.0}, ""),
        ({"gain": 1.0, "offset": 0.0}, "m/s²"),
    ):

        def fill(file, attributes=attributes):
            file["A1"] = np.where(np.arange(ROWS) == 7, 9, np.arange(ROWS) % 5)
            file["A1"].attrs.update({"unit": "g", "Fs": 200.0, "_FillValue": 9, **attributes})

        found = read(hdf5(tmp_path, fill))
        assert units_of(found) == {"A1": unit}
        assert np.flatnonzero(np.isnan(found.values[:, 0])).tolist() == [7]
        told = any("not applied: the values are raw, in an unknown" in s for s in found.history)
        assert told == (unit == "")


def test_two_rates_of_hdf5_are_asked_about(tmp_path):
    def fill(file):
        for name, rate in (("A1", 200.0), ("B1", 100.0)):
            file[name] = WAVE
            file[name].attrs["fs"] = rate

    asked = understand(hdf5(tmp_path, fill)).questions
    assert [q.words for q in asked] == [
        "no column is time; A1.fs says 200 Hz and B1.fs says 100 Hz"
    ]


def test_a_counter_beside_a_rate_keeps_its_gaps(tmp_path):
    sample = np.concatenate([np.arange(100), np.arange(130, ROWS + 30)])
    found = read(matlab(tmp_path, sample=1.0 * sample, acc=WAVE, fs=200.0))
    assert (found.rate_hz, len(found.values), int(found.missing.sum())) == (200.0, ROWS + 30, 30)


def test_a_rate_of_no_suspension_beside_the_numbers_is_asked_about(tmp_path):
    """A dt of 10 is one in ms."""
    asked = understand(matlab(tmp_path, acc=WAVE, dt=10.0)).questions
    assert [q.words for q in asked] == ["no column is time; dt says 0.1 Hz"]


def test_hdf5_of_records_by_their_fields(tmp_path):
    """As loggers of wireless sensors write them: counter, timestamp, x."""
    kinds = [("counter", "u1"), ("timestamp", "u8"), ("x", "f8")]
    rows = np.array([(k % 256, 5 * k, x) for k, x in enumerate(WAVE)], dtype=kinds)
    path = hdf5(tmp_path, lambda file: file.create_dataset("acceleration", data=rows))
    asked = understand(path).questions
    assert [q.key for q in asked] == ["rate_hz"] and "unit of timestamp is not said" in asked[
        0
    ].words
    found = read(path, Map(time="timestamp", time_unit="ms"))
    assert found.rate_hz == 200.0
    assert found.values[:, [c.name for c in found.channels].index("x")] == pytest.approx(WAVE)


def test_matlab_7_3_is_hdf5_with_rows_across(tmp_path):
    def fill(file):
        for name, values in (("t", TIME_S), ("acc", WAVE)):
            file[name] = values[None, :]
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
        file["title"] = np.array([[104], [105], [33]], dtype="u2")
        file["title"].attrs["MATLAB_class"] = np.bytes_("char")
        file.create_group("#refs#")["a"] = np.arange(7.0)

    plain = hdf5(tmp_path, fill).read_bytes()
    path = tmp_path / "run.mat"
    header = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512, b"\0")
    path.write_bytes(plain)
    found = read(path)
    assert found.rate_hz == 200.0 and [c.name for c in found.channels] == ["acc"]
    assert found.values[:, 0] == pytest.approx(WAVE)
    with pytest.raises(ExchangeError, match="cannot be read as MATLAB"):
        path.write_bytes(header)
        read(path)


VBO = """\
File created on 12/05/2016 @ 10:12:13

[header]
satellites
time
latitude
longitude
velocity kmh
heading
height m
vertical velocity m/s
Z_Accel
Damper_FL

[channel units]
g
mm

[comments]
Copyright 2016 Racelogic
Log Rate (Hz) : 100.00

[column names]
sats time lat long velocity heading height vertvel Z_Accel Damper_FL

[data]
"""


def vbo_rows(count=300, hours=10, decimal="."):
    since = [59 * 60 + 58 + k / 100 for k in range(count)]
    rows = (
        f"008 {hours + int(s // 3600):02d}{int(s % 3600 // 60):02d}{s % 60:06.3f}"
        f" +03119.09973 -00058.49277 {36 + k % 10:07.3f} {90.0:06.2f} +00100.00 +000.100"
        f" {WAVE[k]:+.5E} {10 * WAVE[k]:+.5E}"
        for k, s in enumerate(since)
    )
    return "\n".join(rows).replace(".", decimal) + "\n"


@pytest.mark.parametrize("decimal", [".", ","])
def test_vbox_across_the_hour(decimal, tmp_path):
    found = read(save(tmp_path, "lap.vbo", VBO + vbo_rows(decimal=decimal)))
    assert found.rate_hz == 100.0 and not found.missing.any()
    assert units_of(found) == {
        "sats": "", "lat": "", "long": "", "velocity": "m/s", "heading": "", "height": "m",
        "vertvel": "m/s", "Z_Accel": "m/s²", "Damper_FL": "m",
    }  # fmt: skip
    assert found.values[0, 3] == pytest.approx(10.0)
    assert found.values[:, 7] == pytest.approx(WAVE[:300] * G, abs=1e-3)
    assert found.values[:, 8] == pytest.approx(WAVE[:300] * 0.01, abs=1e-6)
    assert found.notes["created"] == "12/05/2016 @ 10:12:13"


def test_units_of_vbox_that_fit_no_columns_are_nobodys(tmp_path):
    """The unit of the first of the two is blank, or that of the last: nobody knows."""
    for said in ("[channel units]\nmm\n\n", "[channel units]\ng\nmm\n%\n"):
        text = VBO.replace("[channel units]\ng\nmm\n", said)
        units = units_of(read(save(tmp_path, "lap.vbo", text + vbo_rows())))
        assert units["Z_Accel"] == units["Damper_FL"] == ""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[header]\ntime\n", r"has no section \[data\]"),
        (VBO + vbo_rows(5) + "008 110000\n", f"line {VBO.count(chr(10)) + 6} has 2 values, not 10"),
        ("[column names]\nsats lat\n[data]\n8 51\n", "has no column time among sats, lat"),
    ],
)
def test_a_vbo_that_is_none_says_so(text, words, tmp_path):
    with pytest.raises(ExchangeError, match=words):
        read(save(tmp_path, "lap.vbo", text))


def imu_bag(folder, jitter_ns=0):
    """A ROS 2 bag with an IMU at 200 Hz and a voltage at 10 Hz, each on its clock."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS2_HUMBLE)
    kinds = types.types
    imu, number = kinds["sensor_msgs/msg/Imu"], kinds["std_msgs/msg/Float64"]
    vector, turn = kinds["geometry_msgs/msg/Vector3"], kinds["geometry_msgs/msg/Quaternion"]
    head, when = kinds["std_msgs/msg/Header"], kinds["builtin_interfaces/msg/Time"]
    nine = np.zeros(9)
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        feel = writer.add_connection("/imu", imu.__msgtype__, typestore=types)
        volts = writer.add_connection("/battery", number.__msgtype__, typestore=types)
        for k, value in enumerate(WAVE):
            at = 1_700_000_000_000_000_000 + 5_000_000 * k + jitter_ns * (k % 3)
            stamp = when(sec=at // 10**9, nanosec=at % 10**9)
            message = imu(
                head(stamp, "imu"), turn(0.0, 0.0, 0.0, 1.0), nine,
                vector(0.1, 0.2, 0.3), nine, vector(0.0, 0.0, 9.81 + value), nine,
            )  # fmt: skip
            writer.write(feel, at + 700_000, types.serialize_cdr(message, imu.__msgtype__))
            if k % 20 == 0:
                data = types.serialize_cdr(number(12.0 + k / 1000), number.__msgtype__)
                writer.write(volts, at, data)
    return next(folder.glob("*.mcap"))


def test_a_ros_bag_by_topic_or_resampled(tmp_path):
    path = imu_bag(tmp_path / "bag")
    with pytest.raises(ExchangeError, match=r'choose with group .* "/imu" .*, or resample_hz'):
        read(path)
    found = read(path, Map(group="/imu"))
    assert found.rate_hz == 200.0 and found.start_unix_s == 1_700_000_000.0
    units = units_of(found)
    assert units["linear_acceleration.z"] == "m/s²" and units["angular_velocity.x"] == "rad/s"
    assert units["orientation.w"] == "" and not any("covariance" in name for name in units)
    up = [c.name for c in found.channels].index("linear_acceleration.z")
    assert found.values[:, up] == pytest.approx(9.81 + WAVE)
    whole = read(path, Map(resample_hz=200.0))
    volts = whole.values[:, [c.name for c in whole.channels].index("data")]
    assert volts[:381] == pytest.approx(12.0 + np.arange(381) / 1000)


def test_stamps_of_a_bag_that_jitter_are_asked_about(tmp_path):
    path = imu_bag(tmp_path / "bag", jitter_ns=2_000_000)
    answered = understand(path, {"resample_hz": "200"})
    assert not answered.questions
    found = read(path, answered.mapping())
    up = [c.name for c in found.channels].index("linear_acceleration.z")
    rows_s = found.time_s
    assert found.values[:, up] == pytest.approx(9.81 + np.sin(5.0 * rows_s), abs=0.02)


def test_mcap_of_json_messages(tmp_path):
    from mcap.writer import Writer

    path = tmp_path / "run.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("pot", "jsonschema", b'{"type": "object"}')
        pot = writer.register_channel("/pot", "json", schema)
        for k, value in enumerate(WAVE):
            lists = {"raw": [k, 2 * k], "few": 32 * [0.0], "scan": 33 * [0.0]}
            data = json.dumps({"travel": value, "name": "fl", **lists}).encode()
            writer.add_message(pot, 10**18 + 5_000_000 * k, data, 10**18 + 5_000_000 * k)
        writer.finish()
    found = read(path)
    assert found.rate_hz == 200.0
    names = [c.name for c in found.channels]
    assert names == ["travel", "raw[0]", "raw[1]", *(f"few[{k}]" for k in range(32))]
    assert np.array_equal(found.values[:, 0], WAVE)
    assert "time is the time of logging" in found.history


def test_a_bag_that_is_none_is_one_line(tmp_path):
    for name in ("run.mcap", "run.bag", "run.db3", "run.h5", "run.mat", "run.ide", "run.xrk"):
        path = tmp_path / name
        path.write_bytes(b"no such thing" * 40)
        with pytest.raises(ExchangeError) as raised:
            read(path)
        assert "\n" not in str(raised.value) and name in str(raised.value)


def test_aim_channels_with_their_clocks(tmp_path, monkeypatch):
    """In the library's own class, as it gives what a logger wrote."""
    import libxrk
    import pyarrow as pa

    def channel(name, unit, step_ms, values):
        codes = pa.array(np.arange(len(values)) * step_ms, pa.int64())
        field = pa.field(name, pa.float32(), metadata={b"units": unit})
        schema = pa.schema([pa.field("timecodes", pa.int64()), field])
        return pa.table([codes, pa.array(values, pa.float32())], schema=schema)

    channels = {
        "VerticalAcc": channel("VerticalAcc", b"g", 5, WAVE),
        "FL_Pot": channel("FL_Pot", b"mm", 5, -WAVE),
        "GPS Speed": channel("GPS Speed", b"m/s", 40, np.full(50, 20.0)),
    }
    log = libxrk.base.LogFile(channels, pa.table({}), {}, "run.xrk")
    monkeypatch.setattr(libxrk, "aim_xrk", lambda name: log)
    path = tmp_path / "run.xrk"
    path.write_bytes(b"<hCNF")
    found = read(path, Map(resample_hz=200.0))
    assert units_of(found) == {"VerticalAcc": "m/s²", "FL_Pot": "m", "GPS Speed": "m/s"}
    assert found.values[:, 0] == pytest.approx(WAVE * G, abs=1e-5)
    assert found.values[:393, 2] == pytest.approx(20.0)
    assert [c.name for c in read(path, Map(group="VerticalAcc")).channels] == [
        "VerticalAcc",
        "FL_Pot",
    ]


def test_endaq_channels_with_their_clocks():
    """A recording of the maker's own tests, of an accelerometer and a barometer."""
    path = Path(__file__).parents[1] / "data" / "endaq" / "test.ide"
    found = read(path)
    units = units_of(found)
    assert [units[name] for name in ("X", "Y", "Z")] == ["m/s²"] * 3
    assert found.rate_hz == 1000.0 and len(found.values) == 1000


@pytest.mark.parametrize("name", ["run.ld", "run.drk", "run.vbb", "run.dxd"])
def test_what_is_not_read_says_how_it_is_exported(name, tmp_path):
    path = tmp_path / name
    path.write_bytes(b"@\0\0\0")
    with pytest.raises(ExchangeError, match=r"choose .*, and import what that writes"):
        read(path)
