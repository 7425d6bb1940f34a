"""Time in Parquet files of others: as the mapping or the file says, or asked for."""

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from tests.formats.foreign import G
from wheelhop.formats import ExchangeError, Map, Pick, draft_mapping, read

ROWS = 300
HUNDREDTHS = np.arange(ROWS)
ZERO = np.datetime64("2026-05-01T12:00:00")


def saved(tmp_path, **columns):
    path = tmp_path / "log.parquet"
    parquet.write_table(pyarrow.table({**columns, "acc_g": HUNDREDTHS % 7 * 0.5}), path)
    return path


def assert_right(found):
    assert (found.rate_hz, len(found.values)) == (pytest.approx(100.0), ROWS)
    assert [(channel.name, channel.unit) for channel in found.channels] == [("acc", "m/s²")]
    assert found.values[:, 0] == pytest.approx(HUNDREDTHS % 7 * 0.5 * G)


@pytest.mark.parametrize(
    ("stamps", "unit"),
    [
        (10 * HUNDREDTHS, "ms"),
        (10_000 * HUNDREDTHS, "us"),
        (HUNDREDTHS / 100, "s"),
        (HUNDREDTHS / 6000, "min"),
        (ZERO + 10 * HUNDREDTHS.astype("timedelta64[ms]"), "clock"),
        ([f"12:00:{k // 100:02}.{k % 100:02}" for k in HUNDREDTHS], "clock"),
        ([f"{k // 60:02}:{k % 60:02}" for k in HUNDREDTHS], "mm:ss"),
    ],
)
def test_time_is_in_the_unit_that_the_mapping_says(stamps, unit, tmp_path):
    path = saved(tmp_path, when=stamps)
    for column in ("when", 1):
        mapping = Map(time=column, time_unit=unit)
        if unit == "mm:ss":  # of a second each
            assert read(path, mapping).rate_hz == pytest.approx(1.0)
        else:
            assert_right(read(path, mapping))


@pytest.mark.parametrize(
    ("name", "stamps"),
    [
        ("time_ms", 10 * HUNDREDTHS),
        ("elapsed_us", 10_000.0 * HUNDREDTHS),
        ("timestamp", 1762640265216 + 10 * HUNDREDTHS),
        ("anything", ZERO + 10 * HUNDREDTHS.astype("timedelta64[ms]")),
        ("at", pyarrow.array((10 * HUNDREDTHS).tolist(), pyarrow.time32("ms"))),
        ("since", 10 * HUNDREDTHS.astype("timedelta64[ms]")),
        ("time", HUNDREDTHS / 100),
    ],
)
def test_without_a_mapping_a_column_is_time_if_the_file_says_so(name, stamps, tmp_path):
    found = read(saved(tmp_path, **{name: stamps}))
    assert_right(found)
    assert any(step.startswith(f"time is {name}") for step in found.history)


def test_seconds_that_are_not_said_are_taken_for_granted_and_not_by_a_script(tmp_path):
    path = saved(tmp_path, time=HUNDREDTHS / 100)
    guess = "time is in s; acc_g is in g, by the end of its name"
    assert f"taken for granted: {guess}" in read(path).history
    with pytest.raises(ExchangeError, match=f"would have to be guessed: {guess}"):
        read(path, guess=False)
    said = Map(time="time", time_unit="s", picks=(Pick("acc_g", "acc", "g"),))
    assert_right(read(path, said, guess=False))


@pytest.mark.parametrize(
    ("name", "stamps"), [("time", 10 * HUNDREDTHS), ("count", HUNDREDTHS), ("x", HUNDREDTHS / 7)]
)
def test_what_is_not_said_is_asked_for(name, stamps, tmp_path):
    path = saved(tmp_path, **{name: stamps})
    with pytest.raises(ExchangeError, match="has no time"):
        read(path)
    assert 'rate_hz = ""' in draft_mapping(path)


def test_a_time_that_is_not_there_or_holds_no_time_is_refused(tmp_path):
    path = saved(tmp_path, when=10 * HUNDREDTHS)
    for time, said in (
        ("nope", "there is no column 'nope'; it has when, acc_g"),
        (9, "no column 9"),
    ):
        with pytest.raises(ExchangeError, match=said):
            read(path, Map(time=time, time_unit="ms"))
    with pytest.raises(ExchangeError, match="when holds numbers, not dates: give their time_unit"):
        read(path, Map(time="when", time_unit="clock"))
    with pytest.raises(ExchangeError, match="the unit of when is not said"):
        read(path, Map(time="when"))
