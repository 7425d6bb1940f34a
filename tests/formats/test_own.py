"""CSV and Parquet: what they hold, and what is refused before anything is written."""

import os
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from threading import Barrier

import numpy as np
import pytest

from tests.formats.foreign import G, save
from tests.formats.recordings import assert_same, recording
from wheelhop.formats import ExchangeError, Map, Pick, read, write
from wheelhop.formats.error import guarded
from wheelhop.formats.header import sidecar
from wheelhop.logger.recording import Channel


def called(*names):
    few = recording(rows=3, channels=len(names), gaps=())
    return replace(few, channels=tuple(Channel(name, "m/s²") for name in names))


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
@pytest.mark.parametrize(
    ("names", "said"),
    [
        (("A1", "A1"), '2 channels are called "A1": give each a name of its own'),
        (("A1", " "), "a channel has no name: give each a name of its own"),
        (("A1", "a\nb"), "a channel has no name: give each a name of its own"),
        (("time_s",), "called|rename"),
    ],
)
def test_names_that_would_not_come_back_are_refused(names, said, suffix, tmp_path):
    with pytest.raises(ExchangeError, match=said):
        write(called(*names), tmp_path / f"run{suffix}")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["a,b", 'say "a"', " a", "a "])
def test_a_column_of_csv_cannot_be_called_anything(name, tmp_path):
    with pytest.raises(ExchangeError, match=f"cannot be called '{name}': choose another format"):
        write(called(name), tmp_path / "run.csv")
    write(called(name), tmp_path / "run.parquet")
    assert_same(read(tmp_path / "run.parquet"), called(name))


@pytest.mark.parametrize("rate", [0.0, -1.0, np.inf, np.nan])
def test_a_rate_that_is_none_is_refused(rate, tmp_path):
    wrong = recording(rows=3, gaps=())
    object.__setattr__(wrong, "rate_hz", rate)
    with pytest.raises(ExchangeError, match=f"rate_hz = {rate} cannot be written"):
        write(wrong, tmp_path / "run.csv")


def test_a_sample_in_two_seconds_is_a_rate(tmp_path):
    slow = recording(rows=3, gaps=(), rate_hz=0.5)
    write(slow, tmp_path / "run.csv")
    assert_same(read(tmp_path / "run.csv"), slow)


def test_stamps_are_written_to_the_nanosecond(tmp_path):
    write(recording(rows=3, gaps=(), rate_hz=300.0, start_s=0.0), tmp_path / "run.csv")
    rows = (tmp_path / "run.csv").read_text().splitlines()[1:]
    assert [row.split(",")[0] for row in rows] == ["0.0", "0.003333333", "0.006666667"]


def test_a_mistake_far_down_is_found_by_its_line(tmp_path):
    rows = [f"{k / 100},{k}" for k in range(5000)]
    rows[4998] = "49.98,x"
    with pytest.raises(ExchangeError, match="line 5000: A1: 'x' is not a number"):
        read(save(tmp_path, "run.csv", "\n".join(["time_s,A1", *rows])))


def test_a_name_tells_its_unit_where_the_numbers_are_in_it(tmp_path):
    """As they stay what they are, they cannot be in g under a name that says so."""
    path = save(tmp_path, "run.csv", "time_s,force_N,acc_g,A1\n0,1,2,3\n0.01,2,3,4\n")
    found = read(path)
    assert [channel.unit for channel in found.channels] == ["N", "", "m/s²"]
    assert found.values[0].tolist() == [1.0, 2.0, 3.0]


def test_parquet_of_others(tmp_path):
    """Columns that are no numbers are left out, and counted."""
    arrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    fields = [
        arrow.field("note", arrow.string()),
        arrow.field("when", arrow.float64()),
        arrow.field("x", arrow.int16(), metadata={"unit": "g"}),
        arrow.field("y", arrow.float32(), metadata={"sensor": "7"}),
    ]
    columns = [["a", "b"], [0.5, 0.51], [1, 2], [3.0, 4.0]]
    table = arrow.table(columns, schema=arrow.schema(fields))
    parquet.write_table(table, tmp_path / "run.parquet")
    found = read(tmp_path / "run.parquet", Map(time="when", picks=(Pick(3), Pick("y"))))
    assert [(c.name, c.unit) for c in found.channels] == [("x", "m/s²"), ("y", "")]
    assert found.values == pytest.approx(np.array([[G, 3.0], [2 * G, 4.0]]))
    assert (found.rate_hz, found.start_s) == (100.0, 0.5)
    slow = read(tmp_path / "run.parquet", Map(time="when", time_unit="min", picks=(Pick(3),)))
    assert (slow.rate_hz, slow.start_s) == pytest.approx((100.0 / 60, 30.0), rel=1e-5)
    with pytest.raises(ExchangeError, match="there is no column 1 of numbers"):
        read(tmp_path / "run.parquet", Map(time="when", picks=(Pick(1),)))


@pytest.mark.parametrize("before", [None, b"of the samples before"])
def test_a_header_is_as_it_was_if_its_samples_cannot_take_their_place(
    before, tmp_path, monkeypatch
):
    path, replace_file = tmp_path / "run.csv", os.replace

    def held(source, target):
        if Path(target) == path:
            raise PermissionError(13, "Permission denied")  # another program has it open
        replace_file(source, target)

    if before is not None:
        sidecar(path).write_bytes(before)
    monkeypatch.setattr(os, "replace", held)
    with pytest.raises(ExchangeError, match=r"run\.csv: cannot be written: Permission denied"):
        write(recording(rows=3, gaps=()), path)
    found = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    assert found == ({} if before is None else {sidecar(path).name: before})


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (ValueError("a\n  b"), "a b"),
        (KeyError(), "KeyError"),
        (OSError(28, "No space left on device"), "No space left on device"),
        (ValueError("x" * 1000), "x" * 160),
    ],
)
def test_what_a_library_says_is_one_short_line(error, reason):
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        with pytest.raises(ExchangeError) as caught, guarded(Path("run.mf4"), "be read"):
            warnings.warn("what a library thinks of the file", stacklevel=1)
            raise error
    assert str(caught.value) == f"run.mf4: cannot be read: {reason}"
    assert not heard


def test_files_read_side_by_side_leave_standard_output_alone():
    together = Barrier(4)

    def read_badly(i):
        together.wait()
        with pytest.raises(ExchangeError), guarded(Path(f"{i}.mf4"), "be read"):
            for _ in range(2000):
                print("what a library thinks of the file")
            raise ValueError

    before, output, filters = sys.getswitchinterval(), sys.stdout, list(warnings.filters)
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as pool:
            for _ in range(20):
                list(pool.map(read_badly, range(4)))
                assert sys.stdout is output
                assert warnings.filters == filters
    finally:
        sys.setswitchinterval(before)
        sys.stdout = output
