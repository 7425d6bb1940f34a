"""Text in columns, as a mapping says: its columns, its rows and its times."""

import numpy as np
import pytest

from tests.formats.foreign import G, save
from wheelhop.formats import ExchangeError, Map, Pick, read

SEMI = Map(separator=";", rate_hz=50.0)


def found(tmp_path, text, mapping=SEMI):
    return read(save(tmp_path, "run.txt", text), mapping)


def refused(tmp_path, text, mapping=SEMI):
    """What is said of a file that cannot be read."""
    with pytest.raises(ExchangeError) as caught:
        found(tmp_path, text, mapping)
    line = str(caught.value)
    assert line.startswith(f"{tmp_path / 'run.txt'}: ") and "\n" not in line
    return line.removeprefix(f"{tmp_path / 'run.txt'}: ")


def test_units_stand_behind_names_or_below_them(tmp_path):
    assert found(tmp_path, "A1 [g];B1\n1;2\n").values.tolist() == [[G, 2.0]]
    below = Map(separator=";", rate_hz=50.0, units_row=2)
    recording = found(tmp_path, "A1 [g];B1\nm/s^2;[g]\n1;2\n", below)
    assert recording.values.tolist() == [[1.0, 2 * G]]


@pytest.mark.parametrize(
    "text", ["x;y\n1;2;\n3;4;\n", "x;y;\n1;2;\n3;4;\n", "x;y;\n1;2\n3;4\n", "x;y\n1;2\n3;4; \n"]
)
def test_a_separator_may_end_a_line(text, tmp_path):
    recording = found(tmp_path, text)
    assert [channel.name for channel in recording.channels] == ["x", "y"]
    assert recording.values.tolist() == [[1.0, 2.0], [3.0, 4.0]]


@pytest.mark.parametrize(("row", "count"), [("3", 1), ("3;4;5", 3), ("3;4;;", 4)])
def test_a_line_of_another_length_is_found_by_its_number(row, count, tmp_path):
    assert refused(tmp_path, f"x;y\n1;2\n{row}\n5;6\n") == f"line 3 has {count} values, not 2"


def test_columns_without_names_have_numbers(tmp_path):
    """Those of one row of numbers, and those under a blank line."""
    unnamed = Map(separator=";", header_row=0, rate_hz=50.0)
    assert [c.name for c in found(tmp_path, "1;2\n", unnamed).channels] == ["column 1", "column 2"]
    assert [c.name for c in found(tmp_path, "\n1;2\n").channels] == ["column 1", "column 2"]
    picked = Map(separator=";", header_row=0, rate_hz=50.0, picks=(Pick(2, name="A1"),))
    assert found(tmp_path, "1;2\n", picked).values.tolist() == [[2.0]]


def test_a_file_that_is_too_short_says_so(tmp_path):
    assert refused(tmp_path, "x;y\n") == "has 1 lines, the numbers begin at 2"


@pytest.mark.parametrize("column", ["z", 0, 3, -1])
def test_a_column_that_is_not_there_is_refused_with_those_that_are(column, tmp_path):
    said = f"there is no column {column!r}; it has t, x"
    assert refused(tmp_path, "t;x\n0;1\n", Map(separator=";", time=column)) == said
    picked = Map(separator=";", rate_hz=50.0, picks=(Pick("x"), Pick(column)))
    assert refused(tmp_path, "t;x\n0;1\n", picked) == said


def test_rows_without_any_value_are_none_where_time_is_a_column(tmp_path):
    """Nobody knows when they were; without a column of time they are samples that are missing."""
    timed = Map(separator=";", time="t")
    assert len(found(tmp_path, "t;x\n0;1\n0.01;2\n;\n0.02;3\n", timed).values) == 3
    assert np.isnan(found(tmp_path, "A1;B1\n1;2\n;\n5;6\n").values[1]).all()
    assert refused(tmp_path, "t;x\n;\n;\n", timed) == "holds no samples: all its rows are empty"
    assert refused(tmp_path, "t;x\n0;1\n;2\n0.02;3\n", timed) == "line 3: t: has no time"


def test_a_file_of_nothing_but_time_is_refused(tmp_path):
    said = "has no columns of numbers beside time: t, note"
    assert refused(tmp_path, "t;note\n0;a\n1;b\n", Map(separator=";", time="t")) == said


@pytest.mark.parametrize(
    ("unit", "rate"), [("s", 0.1), ("ms", 100.0), ("us", 1e5), ("min", 1 / 600)]
)
def test_stamps_are_in_the_unit_that_the_mapping_says(unit, rate, tmp_path):
    mapping = Map(separator=";", time="t", time_unit=unit)
    recording = found(tmp_path, "t;x\n0;1\n10;2\n20;3\n", mapping)
    assert recording.rate_hz == pytest.approx(rate, rel=1e-6)
    assert [channel.name for channel in recording.channels] == ["x"]


CLOCK = Map(separator=";", time="t", time_unit="clock")


@pytest.mark.parametrize(
    ("first", "second", "since"),
    [
        ("2026-05-01 12:00:00.00", "2026-05-01 12:00:00.01", None),
        ("2026-05-01T12:00:00.00Z", "2026-05-01T12:00:00.01Z", 1777636800.0),
        ("2026-05-01T12:00:00.00+02:00", "2026-05-01T12:00:00.01+02:00", 1777629600.0),
        ("23:59:59.98", "23:59:59.99", None),
        ("12:00:00.00+02:00", "12:00:00.01+02:00", None),  # of a day that nobody knows
    ],
)
def test_dates_are_instants_if_they_name_their_zone(first, second, since, tmp_path):
    recording = found(tmp_path, f"t;x\n{first};1\n{second};2\n", CLOCK)
    assert (recording.rate_hz, recording.start_s) == (100.0, 0.0)
    assert recording.start_unix_s == since


def test_dates_with_and_without_a_zone_do_not_mix(tmp_path):
    text = "t;x\n2026-05-01T12:00:00Z;1\n2026-05-01T12:00:01;2\n"
    assert refused(tmp_path, text, CLOCK) == "line 3: only some of the times have a time zone"
    said = refused(tmp_path, text.replace("2026-05-01T12:00:01", "noon"), CLOCK)
    assert said.startswith("line 3: 'noon' is no time: write 2026-05-01 12:34:56.789")


@pytest.mark.parametrize("cell", ["", "NaN", "n/a", "-", "NULL", "#N/A"])
def test_an_empty_cell_is_a_gap_of_its_channel_alone_and_said(cell, tmp_path):
    recording = found(tmp_path, f"A1;B1\n1;2\n{cell};4\n5;6\n")
    assert recording.values[:, 1].tolist() == [2.0, 4.0, 6.0]
    assert np.flatnonzero(np.isnan(recording.values[:, 0])).tolist() == [1]
    assert recording.history[-1] == "A1: rows without a value of its own: 1; left empty"


def test_a_column_without_a_value_is_not_a_channel(tmp_path):
    """Else no row would be left."""
    mapping = Map(separator=";", rate_hz=50.0, picks=(Pick("A1"), Pick("B1")))
    said = "B1 has no samples: leave it out with a mapping"
    assert refused(tmp_path, "A1;B1\n1;-\n3;-\n", mapping) == said
