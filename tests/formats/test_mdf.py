"""MDF 4: blocks by the published layout (ASAM MDF 4.1), damaged where a reader would be led astray;
and what other programs find in a file of ours, or we in theirs."""

import struct
from dataclasses import replace

import numpy as np
import pytest

from tests.formats.foreign import G
from tests.formats.recordings import recording
from wheelhop.formats import ExchangeError, Map, read, write
from wheelhop.formats.header import to_text
from wheelhop.formats.registry import load

asammdf = pytest.importorskip("asammdf")
ROWS = 400
TYPE, BIT, OFFSET, COUNT, FLAGS, LOST = "B0", "B3", "I4", "I8", "I12", "I16"
"""Fields of a channel, behind its links: kind, first bit, first byte, bits, flags, invalidation."""


@pytest.fixture(scope="module")
def healthy(tmp_path_factory):
    path = tmp_path_factory.mktemp("mdf") / "run.mf4"
    write(recording(), path)
    return path.read_bytes()


def blocks(data, kind):
    """Where the fields of each block of a kind begin, in the order of the file."""
    at = data.find(kind)
    while at >= 0:
        (links,) = struct.unpack_from("<Q", data, at + 16)
        yield at + 24 + 8 * links
        at = data.find(kind, at + 1)


def channels(data):
    """The fields of each channel, by the first byte of its values."""
    return sorted(blocks(data, b"##CN"), key=lambda at: struct.unpack_from("<I", data, at + 4))


def damaged(data, at, field, change):
    """One field is another; unsigned, of one byte (B), four (I) or eight (Q)."""
    kind, offset = f"<{field[0]}", at + int(field[1:])
    (value,) = struct.unpack_from(kind, data, offset)
    broken = bytearray(data)
    struct.pack_into(kind, broken, offset, change(value))
    return bytes(broken)


def refused(tmp_path, data):
    path = tmp_path / "run.mf4"
    path.write_bytes(data)
    with pytest.raises(ExchangeError) as caught:
        read(path)
    return str(caught.value).removeprefix(f"{path}: ")


def test_a_channel_that_lies_outside_its_record_is_refused(healthy, tmp_path):
    last = channels(healthy)[-1]
    said = "is damaged: channel A3 lies outside its records"
    for field in (OFFSET, BIT, COUNT):
        assert refused(tmp_path, damaged(healthy, last, field, lambda value: value + 1)) == said
    (group,) = blocks(healthy, b"##CG")
    (spare,) = struct.unpack_from("<I", healthy, group + 28)
    assert spare == 1
    assert refused(tmp_path, damaged(healthy, last, LOST, lambda bit: 8 * spare)) == said


def test_more_samples_than_a_file_can_hold_are_refused(healthy, tmp_path):
    """Deflate makes a thousandth of them at best."""
    (group,) = blocks(healthy, b"##CG")
    most = 1032 * len(healthy) // 33
    said = "is damaged: it is too short for the samples it promises"
    for cycles in (most + 1, 1_000 * most):
        assert refused(tmp_path, damaged(healthy, group, "Q8", lambda _, n=cycles: n)) == said


@pytest.mark.parametrize(("which", "kind"), [(0, 3), (-1, 6)])
def test_what_is_counted_is_not_looked_for_in_a_record(which, kind, healthy, tmp_path):
    """Time or values that are a sample's number are not stored."""
    at = channels(healthy)[which]
    data = damaged(damaged(healthy, at, TYPE, lambda _: kind), at, OFFSET, lambda old: old + 64)
    (tmp_path / "run.mf4").write_bytes(data)
    (table,) = load(tmp_path / "run.mf4")
    assert [channel.name for channel in table.channels] == ["A1", "A2", "A3"]
    assert len(table.values) == ROWS


def test_what_others_find_in_a_file_of_ours(tmp_path):
    path = tmp_path / "run.mf4"
    write(replace(recording(rows=9, gaps=()), start_unix_s=None), path)
    assert b"[[channel]]" in path.read_bytes()  # its header can be read with any editor
    with asammdf.MDF(path) as mdf:
        assert len(mdf.groups) == 1 and mdf.version == "4.10"
        assert mdf.header.start_time.timestamp() == 0.0  # nobody knows when
    assert read(path).start_unix_s is None


def test_groups_of_the_same_time_are_one_and_texts_are_left_out(tmp_path):
    path, time_s = tmp_path / "ecu.mf4", np.arange(4) / 100
    gear = np.array([b"one", b"two", b"two", b"one"])
    with asammdf.MDF(version="4.10") as mdf:
        for name, samples in (("A1", np.arange(4.0)), ("gear", gear), ("B1", np.arange(4))):
            mdf.append([asammdf.Signal(samples, time_s, name=name, unit="g", encoding="utf-8")])
        mdf.save(path)
    found = read(path)
    assert [channel.name for channel in found.channels] == ["A1", "B1"]
    assert found.values == pytest.approx(np.arange(4)[:, np.newaxis] * [G, G])


def test_a_header_that_describes_other_channels_is_noticed(tmp_path):
    path, time_s = tmp_path / "run.mf4", np.arange(4) / 100
    text = to_text(recording(rows=4, gaps=(), channels=2)).encode()
    for names, later in ((("A1", "B1"), 0.0), (("A1", "A2"), 1.0)):
        with asammdf.MDF(version="4.10") as mdf:
            for k, name in enumerate(names):
                mdf.append([asammdf.Signal(np.arange(4.0), time_s + k * later, name=name)])
            mdf.attach(text, file_name="wheelhop.toml", mime="text/toml")
            mdf.save(path, overwrite=True)
        with pytest.raises(ExchangeError, match=r"its wheelhop\.toml does not describe its chan"):
            read(path)


@pytest.mark.parametrize(("kind", "axis"), [(2, "an angle"), (3, "a distance"), (4, "an index")])
def test_a_master_that_is_no_time_is_refused(tmp_path, kind, axis):
    """Radians, metres and numbers were taken for seconds."""
    path = tmp_path / "run.mf4"
    samples, at = np.arange(4.0), np.arange(4) / 100
    master = ("position", kind)
    signal = asammdf.Signal(samples, at, name="A1", unit="g", master_metadata=master)
    with asammdf.MDF(version="4.10") as mdf:
        mdf.append([signal])
        mdf.save(path)
    with pytest.raises(ExchangeError, match=f"group 0 is sampled over {axis}, not over time"):
        read(path)


def test_what_is_sampled_over_time_is_read_beside_what_is_not(tmp_path):
    path, at = tmp_path / "run.mf4", np.arange(4) / 100
    with asammdf.MDF(version="4.10") as mdf:
        for name, kind in (("A1", 1), ("B1", 3)):
            master = ("master", kind)
            mdf.append([asammdf.Signal(np.arange(4.0), at, name=name, master_metadata=master)])
        mdf.save(path)
    found = read(path)
    assert ([channel.name for channel in found.channels], found.rate_hz) == (["A1"], 100.0)
    assert "left out: group 1 is sampled over a distance, not over time" in found.history


def test_samples_that_are_only_counted_have_no_rate(healthy, tmp_path):
    """The master is an ordinary channel: asammdf makes seconds of the samples' numbers."""
    data = damaged(healthy, channels(healthy)[0], TYPE, lambda _: 0)
    data = data.replace(b"wheelhop.toml", b"wheelhop.doml")  # of others
    said = (
        "has no time (the samples of group 0 are only counted): give time or rate_hz in a mapping"
    )
    assert refused(tmp_path, data) == said
    assert read(tmp_path / "run.mf4", Map(rate_hz=50.0)).rate_hz == 50.0


@pytest.mark.parametrize("version", ["3.10", "3.30"])
@pytest.mark.parametrize("suffix", [".mdf", ".dat", ".mf4"])
def test_mdf_3_is_read_under_each_of_its_suffixes(version, suffix, tmp_path):
    path, at = tmp_path / "ecu.mdf", np.arange(300) / 100
    signals = [asammdf.Signal(np.arange(300.0), at, name=name, unit="g") for name in ("A1", "B1")]
    with asammdf.MDF(version=version) as mdf:
        mdf.append(signals)
        mdf.save(path)
    path = path.rename(path.with_suffix(suffix))
    found = read(path)
    assert [(channel.name, channel.unit) for channel in found.channels] == [
        ("A1", "m/s²"),
        ("B1", "m/s²"),
    ]
    assert (found.rate_hz, len(found.values)) == (100.0, 300)
    with pytest.raises(ExchangeError, match="has its own time: leave time = 'nope' out"):
        read(path, Map(time="nope"))


def test_the_unit_of_a_master_counts(tmp_path):
    path = tmp_path / "run.mf4"
    for unit, step in (("ms", 10.0), ("s", 0.01)):
        master = asammdf.Signal(np.arange(4.0), step * np.arange(4), name="A1")
        with asammdf.MDF(version="4.10") as mdf:
            mdf.append([master])
            mdf.groups[0].channels[0].unit = unit
            mdf.save(path, overwrite=True)
        assert read(path).rate_hz == pytest.approx(100.0)
