"""What is read: plain files, and no more of them than the memory holds."""

import math
import os
import socket
import sys
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tests.formats.recordings import recording
from wheelhop.calibration import read_constants
from wheelhop.campaign import CampaignError
from wheelhop.campaign.curves import read_curve
from wheelhop.campaign.recordings import read_columns
from wheelhop.effects import load_effects
from wheelhop.files import InputError, read_text
from wheelhop.files import read as files_read
from wheelhop.formats import draft_mapping, read_mapping, write
from wheelhop.formats import read as read_recording
from wheelhop.formats.parquet import read_table
from wheelhop.frame.bdf import read_bdf
from wheelhop.frame.f06 import read_f06
from wheelhop.identify.steps_file import read_steps
from wheelhop.logger import read_log
from wheelhop.logger.card import find_sessions
from wheelhop.logger.flash import check_hex
from wheelhop.material.read import read_rig_data
from wheelhop.track.surveyed import read_survey
from wheelhop.vehicle import read_vehicle

READERS = {
    "vehicle.toml": read_vehicle,
    "map.toml": read_mapping,
    "calibration.toml": read_constants,
    "effects.py": load_effects,
    "column.csv": read_columns,
    "column.parquet": read_columns,
    "column.mf4": read_columns,
    "x.csv": read_recording,
    "x.txt": draft_mapping,
    "x.lvm": read_recording,
    "x.uff": read_recording,
    "x.tdms": read_recording,
    "x.mf4": read_recording,
    "x.parquet": read_recording,
    "x.hop": read_recording,
    "log.hop": read_log,
    "card.img": find_sessions,
    "rig.csv": read_rig_data,
    "rig.parquet": read_rig_data,
    "road.csv": read_survey,
    "road.crg": read_survey,
    "road.rdf": read_survey,
    "frame.bdf": lambda path: read_bdf(path, "mm-t-s"),
    "frame.f06": lambda path: read_f06(path, ["1"]),
    "steps.csv": read_steps,
    "logger.hex": check_hex,
    "curve.csv": lambda path: read_curve(path, {}),
}
WATCHED: list[str] = []
"""What must not be opened while a test runs: to open a pipe waits, to read a device has no end."""


def _watch(event, arguments):
    if event == "open" and WATCHED and str(arguments[0]) in WATCHED:
        raise AssertionError(f"{arguments[0]} was opened")


sys.addaudithook(_watch)


@pytest.fixture(params=["device", "pipe", "socket", "folder"])
def special(request, tmp_path):
    """A function that gives such a thing a name."""

    def made(name):
        path = tmp_path / name
        if request.param == "device":
            path.symlink_to("/dev/zero")
        elif request.param == "pipe":
            os.mkfifo(path)
        elif request.param == "socket":
            with socket.socket(socket.AF_UNIX) as one:
                one.bind(str(path))
        else:
            path.mkdir()
        return path

    return made


@pytest.mark.skipif(os.name == "nt", reason="pipes with names, sockets and devices are Unix")
@pytest.mark.parametrize("name", READERS)
def test_what_is_no_plain_file_is_refused_before_it_is_opened(name, special, monkeypatch):
    path = special(name)
    monkeypatch.setattr(sys.modules[__name__], "WATCHED", [str(path), str(path.resolve())])
    with pytest.raises(InputError) as raised:
        READERS[name](path)
    line = str(raised.value)
    assert str(path) in line and ("not a file" in line or "no such file" in line)


@pytest.fixture
def free(monkeypatch):
    """A function that says how much memory is free."""

    def said(count):
        monkeypatch.setattr(files_read, "free_bytes", lambda: count)

    return said


class Counted:
    """A file that counts what is asked of it."""

    def __init__(self, file):
        self.file, self.asked = file, 0

    def __enter__(self):
        return self

    def __exit__(self, *raised):
        self.file.close()

    def fileno(self):
        return self.file.fileno()

    def read(self, count=-1):
        self.asked += math.inf if count < 0 else count
        return self.file.read(count)


@pytest.fixture
def opened(monkeypatch):
    """The files that were opened to be read."""
    files = []

    def open_counted(path, mode="r", *options, **more):
        if mode != "rb":
            return real(path, mode, *options, **more)
        files.append(Counted(real(path, mode, *options, **more)))
        return files[-1]

    real = Path.open
    monkeypatch.setattr(Path, "open", open_counted)
    return files


TEXTS = [
    name for name in READERS if not name.endswith((".parquet", ".mf4", ".tdms", ".hop", ".img"))
]


@pytest.mark.parametrize("name", [name for name in TEXTS if name not in ("effects.py", "x.uff")])
def test_a_text_that_takes_more_than_is_free_is_not_read(name, tmp_path, free, opened):
    path = tmp_path / name
    path.write_text("time_s,A1\n" * 1000)
    free(100_000.0)
    with pytest.raises(InputError, match=r"takes about .* GB of memory, and .* free: cut it"):
        READERS[name](path)
    assert max(file.asked for file in opened) <= 8  # first bytes tell MDF from text


@pytest.mark.parametrize("name", ["vehicle.toml", "column.csv", "x.csv", "rig.csv", "road.csv"])
def test_a_text_with_a_hole_is_read_no_farther_than_the_hole(name, tmp_path, free, opened):
    """Two gigabytes that are no bytes on the disk."""
    path = tmp_path / name
    path.write_text("time_s,A1\n0.0,1.0\n")
    os.truncate(path, 2 << 30)
    free(math.inf)
    with pytest.raises(InputError, match="byte 18 is zero"):
        READERS[name](path)
    assert 0 < max(file.asked for file in opened) <= files_read.PIECE_BYTES


@pytest.mark.parametrize("zeros", [1, 700, 3 << 20])
def test_room_that_a_logger_had_reserved_behind_its_text_is_left_out(zeros, tmp_path):
    path = tmp_path / "x.csv"
    path.write_bytes(b"time_s,A1\n0.00,1\n0.01,2\n" + bytes(zeros))
    found = read_recording(path)
    assert found.values.tolist() == [[1.0], [2.0]]
    assert any(f"that was reserved: {zeros}; left out" in step for step in found.history)
    path.write_bytes(path.read_bytes() + b"0.02,3\n")
    with pytest.raises(InputError, match="byte 24 is zero"):
        read_recording(path)


def test_utf_16_has_zero_bytes_and_is_text(tmp_path):
    (tmp_path / "x.csv").write_bytes("time_s,A1\n0.00,1\n0.01,2\n".encode("utf-16"))
    assert read_recording(tmp_path / "x.csv").values.tolist() == [[1.0], [2.0]]
    with pytest.raises(InputError, match="not UTF-8"):
        read_text(tmp_path / "x.csv")


def test_a_packed_table_is_weighed_by_what_it_says_it_holds(tmp_path, free, monkeypatch):
    """Two million equal rows are some kilobytes on the disk."""
    path, rows = tmp_path / "x.parquet", 2_000_000
    pq.write_table(pa.table({"time_s": pa.repeat(0.0, rows), "A1": pa.repeat(1.0, rows)}), path)
    assert path.stat().st_size < 100_000
    monkeypatch.setattr(pq.ParquetFile, "read", None)
    free(2 * rows * 3 * 8.0 - 1)
    for reader in (read_columns, read_recording, read_table):
        with pytest.raises(InputError, match=r"x.parquet: takes about 0\.096 GB"):
            reader(path)


def test_a_text_in_a_packed_table_is_kept_once(tmp_path):
    path = tmp_path / "x.parquet"
    pq.write_table(pa.table({"note": pa.array(["long " * 2000] * 10_000)}), path)
    assert read_table(path).nbytes < 100_000  # 100 MB if each row had its own
    with pytest.raises(CampaignError, match="column note holds string, not numbers"):
        read_columns(path)


def tdms(path):
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(path) as writer:
        values = recording(rows=1000).values[:, 0].copy()
        writer.write_segment([nptdms.ChannelObject("car", "A1", values)])


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".mf4", ".uff", ".tdms"])
def test_a_recording_is_read_where_there_is_room_and_refused_where_there_is_none(
    suffix, tmp_path, free
):
    path = tmp_path / f"x{suffix}"
    tdms(path) if suffix == ".tdms" else write(recording(rows=1000), path)
    free(1e9)
    mapping = tmp_path / "map.toml"
    mapping.write_text("format = 1\nrate_hz = 100.0\n")
    mapped = read_mapping(mapping) if suffix == ".tdms" else None
    assert len(read_recording(path, mapped).values) == 1000
    free(20_000.0)
    with pytest.raises(InputError, match=r"takes about .* GB of memory"):
        read_recording(path, mapped)


def test_what_is_free_is_what_the_system_says(tmp_path, monkeypatch):
    there = files_read.free_bytes()
    assert 1e7 < there < 1e14
    for name, text in (("LIMIT", "3000000\n"), ("USED", "1000000\n")):
        (tmp_path / name).write_text(text)
        monkeypatch.setattr(files_read, name, tmp_path / name)
    assert files_read.free_bytes() == 2e6
    (tmp_path / "LIMIT").write_text("max\n")
    assert files_read.free_bytes() > 2e6
