"""Text of other recorders, and what a mapping makes of it."""

from pathlib import Path

import numpy as np
import pytest

from tests.formats.foreign import GERMAN, G, save
from tests.formats.recordings import recording
from wheelhop.formats import ExchangeError, Map, Pick, draft_mapping, read, read_mapping, write


def test_a_csv_from_a_german_logger(tmp_path):
    path = save(tmp_path, "fahrt.csv", GERMAN, "cp1252")
    mapping = save(
        tmp_path,
        "map.toml",
        """
        format = 1
        separator = ";"
        decimal = ","
        header_row = 2
        units_row = 3
        time = "Zeit"
        [[channel]]
        column = "Achse vl"
        name = "A1"
        point = "A1"
        sensor = "17"
        [[channel]]
        column = 3
        name = "body"
        scale = 2.0
        offset = -1.0
        unit = "mm/s2"
        """,
    )
    found = read(path, read_mapping(mapping))
    assert [c.name for c in found.channels] == ["A1", "body"]
    assert {c.unit for c in found.channels} == {"m/s²"}
    assert (found.channels[0].point, found.channels[0].sensor) == ("A1", "17")
    assert found.rate_hz == 100.0 and found.start_s == 0.0
    assert found.values[:, 0] == pytest.approx(np.array([1.5, 2.5, 3.5, 4.5]) * G)
    assert found.values[:, 1] == pytest.approx((np.array([-0.25, -0.5, -0.75, -1]) * 2 - 1) / 1e3)
    assert found.history == (
        "imported from fahrt.csv (text)",
        "A1: g × 9.80665 = m/s²",
        "body: × 2 + -1 = mm/s2, mm/s2 × 0.001 = m/s²",
    )


DRAFTED = {
    "german": (GERMAN, "cp1252", G),
    "units behind names": (
        "time [ms],A1 [g],B2 (m/s^2)\n0,1.5,-0.25\n10,2.5,-0.5\n20,3.5,-0.75\n30,4.5,-1\n",
        "utf-8",
        G,
    ),
    "quoted": (
        '"t","A1 / g","note"\r\n"0.00","1.5","a, b"\r\n"0.01","2.5",""\r\n'
        '"0.02","3.5",""\r\n0.03,4.5,\r\n',
        "utf-16",
        G,
    ),
    "blanks": ("# by numpy\n# t A1 z\n0 1.5 7\n0.01 2.5 7\n0.02 3.5 7\n0.03 4.5 8\n", "utf-8", 1.0),
    "dates": (
        "date\tacc_mg\n2026-05-01 12:00:00.000\t1.5\n2026-05-01 12:00:00.010\t2.5\n"
        "2026-05-01 12:00:00.020\t3.5\n2026-05-01 12:00:00.030\t4.5\n",
        "utf-8",
        G / 1e3,
    ),
    "no names": ("0;1,5;3\n0,01;2,5;3\n0,02;3,5;4\n0,03;4,5;5\n", "utf-8", 1.0),
}


@pytest.mark.parametrize(("text", "encoding", "factor"), DRAFTED.values(), ids=DRAFTED)
def test_the_draft_of_a_mapping_reads_the_file_it_was_made_for(text, encoding, factor, tmp_path):
    path = save(tmp_path, "run.csv", text, encoding)
    with pytest.raises(ExchangeError, match=r"wheelhop import run\.csv --draft"):
        read(path)
    draft = draft_mapping(path)
    if 'time_unit = ""' in draft:  # a column without a name: it may be anything that rises
        draft = draft.replace('time_unit = ""', 'time_unit = "s"')
    found = read(path, read_mapping(save(tmp_path, "map.toml", draft)))
    assert found.values[:, 0] == pytest.approx(factor * np.array([1.5, 2.5, 3.5, 4.5]))
    assert (found.rate_hz, found.start_s) == (100.0, 0.0)


def test_columns_of_one_name_are_kept_apart_by_unit_or_number(tmp_path):
    path = save(tmp_path, "run.csv", "t;acc;acc;pot;pot\ns;g;g;V;mm\n0;1,5;3;1;1\n0,01;2,5;3;1;1\n")
    found = read(path, read_mapping(save(tmp_path, "map.toml", draft_mapping(path))))
    assert [(channel.name, channel.unit) for channel in found.channels] == [
        ("acc (g) (column 2)", "m/s²"),
        ("acc (g) (column 3)", "m/s²"),
        ("pot (V)", "V"),
        ("pot (mm)", "m"),
    ]
    assert found.values[:, 2:] == pytest.approx(np.array([[1.0, 0.001], [1.0, 0.001]]))
    twice = draft_mapping(path).replace("pot (V)", "pot").replace("pot (mm)", "pot")
    with pytest.raises(ExchangeError, match='2 channels are called "pot": name them apart'):
        read(path, read_mapping(save(tmp_path, "twice.toml", twice)))


def test_without_a_column_of_time_the_mapping_gives_the_rate(tmp_path):
    path = save(tmp_path, "run.txt", "1,5 2\n2,5 3\n4 5\n")
    found = read(path, Map(separator=None, decimal=",", header_row=0, rate_hz=50.0))
    assert found.rate_hz == 50.0 and found.values.tolist() == [[1.5, 2], [2.5, 3], [4, 5]]
    assert found.start_s == 0.0  # nothing is said of another instant
    with pytest.raises(ExchangeError, match="has no time: give time or rate_hz"):
        read(path, Map(separator=None, decimal=",", header_row=0))


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("time_s,A1\n0,1\n0.01,x\n", "line 3: A1: 'x' is not a number"),
        ("time_s,A1\n0,1\n0.01,1_0\n", "line 3: A1: '1_0' is not a number"),
        ("time_s,A1\n0,1\n0.01\n", "line 3 has 1 values, line 1 names 2"),
        ("time_s,A1\n0,1\n0.01,2\n0.01,3\n", "line 4: time does not rise, from 0.01 to 0.01"),
        ("time_s,A1\n0,1\n0.01,2\n0.02,2\n0.0345,3\n", r"line 5: time jumps .* 1\.45 steps"),
        ("time_s,A1\n0,1\n0.01,2\n0.02,2\n1e9,3\n", "line 5: 1e[+]11 samples are missing"),
        ("time_s,A1\n0,1\nnan,2\n", "line 3: nan is no time"),
        ("time_s,A1\n0,1\n", "line 2: a single time stamp has no rate"),
        ("time_s,A1\n", "holds no samples"),
        ("time_s\n0\n1\n", "holds no channels of numbers"),
        ('time_s,A1\n0,"1\n1,2\n2,3\n', "a quote is opened and not closed"),
        ("time_s,A1,A1\n0,1,2\n1,2,3\n", "line 1: a column name appears twice"),
        ("", "what its columns are must be said in a mapping"),
    ],
)
def test_what_is_wrong_is_found_by_its_line(text, line, tmp_path):
    path = save(tmp_path, "run.csv", text)
    with pytest.raises(ExchangeError, match=line) as caught:
        read(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("formt = 1", "unknown key 'formt'"),
        ("format = 2", "format = 1 is missing"),
        ("format = true", "format = 1 is missing"),
        ('format = 1\nseparator = "x"', "separator must be"),
        ('format = 1\ndecimal = "x"', "decimal must be"),
        ('format = 1\nthousands = "."\ndecimal = "."', "thousands must be"),
        ('format = 1\nrate_hz = ""\ntime_unit = ""', "still to be answered: time_unit .*; rate_hz"),
        ("format = 1\nheader_row = [1, 0]", "header_row must hold the numbers of lines"),
        ('format = 1\ntime_unit = "weeks"', 'time_unit = "weeks" is not known'),
        ("format = 1\nrate_hz = -1", "rate_hz must be above 0"),
        ("format = 1\nheader_row = -1", "header_row must be the number of a line"),
        ("format = 1\n[[channel]]\nname = 'A1'", r"\[\[channel\]\] 1: column is missing"),
        ("format = 1\n[[channel]]\ncolumn = 1\nscale = 'g'", "1: scale must be a number"),
        ("format = 1\nchannel = 3", r"begin each channel with \[\[channel\]\]"),
        ("format = 1\n[[channel]]\ncolumn = 1\noffset = inf", "1: offset must be a finite number"),
        ("format = 1\n[[channel]]\ncolumn = 1\noffset = nan", "1: offset must be a finite number"),
        (f"format = 1\nrate_hz = 1{'0' * 400}", "rate_hz must be a finite number"),
        ("format = 1\n[[channel]]\ncolumn = 1\nscale = 1.1e300", "scale must be a finite number"),
        (
            "format = 1\n[[channel]]\ncolumn = true",
            "1: column must be a name in quotes, or a number",
        ),
        ("format = 1\ntime = 1.5", "time must be a name in quotes, or a number"),
        (
            "format = 1\n[[channel]]\ncolumn = 1\nunits = 'g'",
            "1: unknown key 'units'; known: column",
        ),
        ("format = ", "not valid TOML"),
    ],
)
def test_a_wrong_mapping_is_one_line(line, complaint, tmp_path):
    path = save(tmp_path, "map.toml", line)
    with pytest.raises(ExchangeError, match=complaint) as caught:
        read_mapping(path)
    assert str(caught.value).startswith(str(path))


def test_a_mapping_says_what_it_says_and_nothing_else(tmp_path):
    assert read_mapping(save(tmp_path, "short.toml", "format = 1")) == Map()
    text = """format = 1
        separator = "tab"
        decimal = ","
        encoding = "cp1252"
        header_row = 3
        units_row = 4
        first_row = 7
        time = 2
        time_unit = "ms"
        rate_hz = 50
        group = "car"
        [[channel]]
        column = 3
        name = "A1"
        unit = "g"
        point = "A2"
        sensor = "17"
        calibration = "bench"
        scale = 1e300
        offset = -2
        """
    assert read_mapping(save(tmp_path, "map.toml", text)) == Map(
        "\t",
        ",",
        "cp1252",
        header_row=3,
        units_row=4,
        first_row=7,
        time=2,
        time_unit="ms",
        rate_hz=50.0,
        group="car",
        picks=(Pick(3, "A1", "g", "A2", "17", "bench", 1e300, -2.0),),
    )


@pytest.mark.parametrize(
    ("pick", "complaint"),
    [
        (Pick("B9"), 'there is no column "B9"; it has A1'),
        (Pick(9), "there is no column 9 of numbers"),
    ],
)
def test_a_mapping_that_does_not_fit_says_what_there_is(pick, complaint, tmp_path):
    path = tmp_path / "run.mf4"
    write(recording(), path)
    with pytest.raises(ExchangeError, match=complaint):
        read(path, Map(picks=(pick,)))


def test_a_mapping_renames_and_chooses_in_any_format(tmp_path):
    original = recording()
    for suffix in (".csv", ".parquet", ".mf4", ".uff"):
        path = tmp_path / f"run{suffix}"
        write(original, path)
        found = read(path, Map(picks=(Pick("A3", name="B1", point="B1"), Pick("A1", scale=-1.0))))
        assert [(c.name, c.point, c.sensor) for c in found.channels] == [
            ("B1", "B1", "ADXL-2"),
            ("A1", "A1", "ADXL-0"),
        ]
        expected = original.values[:, [2, 0]] * [1.0, -1.0]
        assert np.array_equal(found.values, expected, equal_nan=True)
        assert found.history[:2] == original.history and found.averaging_s == 0.01


@pytest.mark.parametrize("name", ["run.xyz", "run", "none.csv"])
def test_a_file_that_is_not_there_or_not_known(name, tmp_path):
    with pytest.raises(ExchangeError, match=r"no format known here|there is no such file"):
        read(tmp_path / name)
    assert not list(Path(tmp_path).iterdir())


@pytest.mark.parametrize("name", ["drive.xlsx", "drive.XLS", "drive.ods"])
def test_a_spreadsheet_has_a_sentence_of_its_own(name, tmp_path):
    (tmp_path / name).write_bytes(b"PK")
    with pytest.raises(ExchangeError, match=r"spreadsheet: save the sheet as CSV .* --draft"):
        read(tmp_path / name)


def test_formats_that_are_only_read(tmp_path):
    with pytest.raises(ExchangeError, match=r"is read, not written: choose \.csv, \.parquet"):
        write(recording(), tmp_path / "run.tdms")
