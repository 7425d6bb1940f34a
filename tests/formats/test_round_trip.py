"""What is written comes back: every bit of every number, and every word about them."""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings

from tests.formats.recordings import SUFFIXES, any_recording, assert_same, believed, recording
from wheelhop.campaign.recordings import check_time, read_columns
from wheelhop.formats import ExchangeError, losses, read, write
from wheelhop.formats.header import from_text, header_of, sidecar, to_text


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_recording_comes_back_as_it_was(suffix, tmp_path):
    original, path = recording(), tmp_path / f"run{suffix}"
    write(original, path)
    assert_same(read(path), original)
    assert losses(original, suffix) == ()


@pytest.mark.parametrize("suffix", SUFFIXES)
@settings(max_examples=40)
@given(original=any_recording())
def test_any_recording_comes_back_as_it_was(suffix, original):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"run{suffix}"
        write(original, path)
        assert_same(read(path), original)


@given(original=any_recording())
def test_the_header_comes_back_as_it_was(original):
    header = from_text(to_text(original), Path("x.toml"))
    assert header.rows == len(original.values)
    assert_same(header.with_values(original.values), original)


def test_a_header_may_be_of_no_samples_but_not_of_fewer():
    empty = recording(rows=0, gaps=())
    text = to_text(empty)
    header = from_text(text, Path("x.toml"))
    assert header.rows == 0
    assert_same(header.with_values(empty.values), empty)
    with pytest.raises(ExchangeError, match="rows must be the number of samples"):
        from_text(text.replace("rows = 0", "rows = -1"), Path("x.toml"))


@pytest.mark.parametrize("version", ["2", "true", '"1"'])
def test_a_header_of_another_version_is_not_read(version):
    text = to_text(recording()).replace("format = 1", f"format = {version}")
    with pytest.raises(ExchangeError, match="format must be 1"):
        from_text(text, Path("x.toml"))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("rate_hz = 100.0", "", "rate_hz must be a number of samples per second above 0"),
        ("rate_hz = 100.0", "rate_hz = 0", "rate_hz must be a number of samples per second above"),
        ("rate_hz = 100.0", "rate_hz = inf", "rate_hz must be a finite number"),
        ("rate_hz = 100.0", f"rate_hz = 1{'0' * 400}", "rate_hz must be a finite number"),
        ("rate_hz = 100.0", "rate_hz = true", "rate_hz must be a finite number"),
        ("rate_hz = 100.0", 'rate_hz = "100"', "rate_hz must be a finite number"),
        ("rows = 400", "rows = true", "rows must be the number of samples"),
        ("history = [", "history = [1,", "history must be a list of texts"),
        ("history = [", "history = 1\nolder = [", "history must be a list of texts"),
        ("[notes]", "[notes]\nx = 1", r"\[notes\] must hold texts only"),
        ("[[channel]]\nname", "[channel]\nname", r"begin each channel with \[\[channel\]\]"),
        ('name = "A1"', "", "channel 1: name must be a text"),
        ('sensor = "ADXL-1"', "sensor = 1", "channel 2: sensor must be a text"),
        ("format = 1", "format = ", "not valid TOML"),
    ],
)
def test_what_is_wrong_in_a_header_is_named(old, new, said):
    text = to_text(recording())
    if new.startswith("[channel]"):  # one table, not a list of them
        text = text[: text.index("[[channel]]")] + '[[channel]]\nname = "A1"\n'
    assert old in text
    text = text.replace(old, new, 1)
    with pytest.raises(ExchangeError, match=f"^x.toml: {said}"):
        from_text(text, Path("x.toml"))


@pytest.mark.parametrize("notes", ["notes = 1", "channel = [1]"])
def test_a_header_has_tables_of_notes_and_channels(notes):
    with pytest.raises(ExchangeError, match=r"x\.toml: (\[notes\] must|begin each channel)"):
        from_text(f"{notes}\nformat = 1\nrows = 1\nrate_hz = 1.0\n", Path("x.toml"))


def test_a_header_holds_no_samples():
    for header in (header_of(recording()), from_text(to_text(recording()), Path("x.toml"))):
        assert header.rows == 400 and header.bare.values.shape == (0, 3)


def test_from_format_to_format_nothing_is_lost(tmp_path):
    original = recording()
    before = original
    for suffix in (*SUFFIXES, ".csv"):
        write(before, tmp_path / f"run{suffix}")
        before = read(tmp_path / f"run{suffix}")
    assert_same(before, original)


def test_a_campaign_reads_what_is_written(tmp_path):
    original = recording(gaps=())
    for suffix in (".csv", ".parquet"):
        path = tmp_path / f"run{suffix}"
        write(original, path)
        names, values = read_columns(path)
        assert names == ["time_s", "A1", "A2", "A3"]
        assert (values[:, 1:] == original.values).all()
        check_time(path, values[:, 0], 100.0)


def test_the_campaigns_of_this_repository_are_read():
    folder = Path(__file__).parents[2] / "examples/clean/runs"
    path = sorted(folder.glob("*.csv"))[0]
    names, values = read_columns(path)
    found = read(path)
    assert [channel.name for channel in found.channels] == names[1:]
    assert (found.values == values[:, 1:]).all()
    assert found.rate_hz == 100.0 and found.start_s == values[0, 0]
    assert {channel.unit for channel in found.channels} == {"m/s²"}
    assert found.channels[0].point == names[1]


def test_uff_says_what_it_cannot_hold_and_loses_only_that(tmp_path):
    original = recording(gaps=())
    values = original.values.copy()
    values[3, 1] = np.nan
    values[9, 0] = np.inf
    partly = replace(original, values=values)
    assert len(losses(partly, ".uff")) == 2
    write(partly, tmp_path / "run.uff")
    values[[3, 9]] = np.nan
    assert_same(read(tmp_path / "run.uff"), replace(partly, values=values))
    with pytest.raises(ExchangeError, match="every sample is missing"):
        write(replace(original, values=np.full((3, 3), np.nan)), tmp_path / "none.uff")
    for suffix in (".csv", ".parquet", ".mf4"):
        write(partly, tmp_path / f"run{suffix}")
        assert losses(partly, suffix) == ()


@pytest.mark.parametrize("suffix", (".csv", ".uff"))
def test_without_the_sidecar_names_units_places_and_gaps_stay(suffix, tmp_path):
    original, path = recording(), tmp_path / f"run{suffix}"
    write(original, path)
    sidecar(path).unlink()
    found = read(path)
    assert np.array_equal(found.values, original.values, equal_nan=True)
    assert found.rate_hz == original.rate_hz
    assert found.start_s == pytest.approx(original.start_s, abs=1e-6)
    for channel, was in zip(found.channels, original.channels, strict=True):
        assert (channel.name, channel.unit, channel.point) == (was.name, was.unit, was.point)
    assert "imported from" in found.history[0]


def test_rows_that_were_cut_off_leave_the_rest_in_its_place(tmp_path):
    original, path = recording(), tmp_path / "run.csv"
    write(original, path)
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join([lines[0], *lines[101:301]]))
    with pytest.raises(ExchangeError, match="delete the line samples_sha256"):
        read(path)  # they might be another recording's
    believed(path)
    found = read(path)
    assert np.array_equal(found.values, original.values[100:300], equal_nan=True)
    assert found.start_s == pytest.approx(original.time_s[100], abs=1e-12)
    assert found.history[-1] == "rows 101 to 300 of 400 read"
    path.write_text("".join(lines[:301]))
    found = read(path)
    assert np.array_equal(found.values, original.values[:300], equal_nan=True)
    assert found.start_s == original.start_s
    assert found.history[-1] == "rows 1 to 300 of 400 read"


def test_a_sidecar_of_another_file_is_noticed(tmp_path):
    write(recording(), tmp_path / "run.csv")
    write(recording(channels=2), tmp_path / "other.csv")
    sidecar(tmp_path / "other.csv").rename(sidecar(tmp_path / "run.csv"))
    with pytest.raises(ExchangeError, match=r"run\.csv\.toml: is the header of other samples"):
        read(tmp_path / "run.csv")
    believed(tmp_path / "run.csv")
    with pytest.raises(ExchangeError, match=r"run\.csv\.toml: does not describe the columns"):
        read(tmp_path / "run.csv")


def test_a_failed_export_leaves_what_was_there(tmp_path, monkeypatch):
    path = tmp_path / "run.csv"
    write(recording(), path)
    before = path.read_bytes()

    def full_disk(recording, path):
        path.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("wheelhop.formats.own_csv.save", full_disk)
    with pytest.raises(ExchangeError, match=r"run\.csv: cannot be written: No space left"):
        write(recording(rows=7, gaps=()), path)
    assert path.read_bytes() == before
    assert sorted(file.name for file in tmp_path.iterdir()) == ["run.csv", "run.csv.toml"]


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".mf4"])
def test_a_gap_of_one_channel_comes_back_as_one(suffix, tmp_path):
    """And MDF says so by the invalidation bits of that channel alone, for other programs."""
    values = recording().values.copy()
    values[300:320, 1] = np.nan
    original = replace(recording(), values=values)
    path = tmp_path / f"run{suffix}"
    write(original, path)
    assert_same(read(path), original)
    if suffix == ".mf4":
        data = path.read_bytes().replace(b"wheelhop.toml", b"wheelhop.doml")  # of others
        path.write_bytes(data)
        assert np.isnan(read(path).values).sum(axis=0).tolist() == [11, 31, 11]
