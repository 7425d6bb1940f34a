"""Tables as loggers write them: names, units, gaps, what stands around the rows, and numbers."""

import numpy as np
import pytest

from tests.formats.foreign import G, save
from tests.formats.logged import ROWS, WAVE, drafted, table, units_of
from wheelhop.formats import ExchangeError, Map, Pick, draft_mapping, read, understand

TIMED = "Time (s),GPS Speed (km/h),Acc (g),Acc2 (g)"


def rows(count=ROWS, cell=lambda k, n: f"{WAVE[k]:.4f}", columns=3, separator=","):
    """Lines of a time in seconds at 100 Hz and other cells."""
    return [
        separator.join([f"{k / 100:.2f}", *(cell(k, n) for n in range(columns))])
        for k in range(count)
    ]


def text(*lines):
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("late", [0, 1, 2])
@pytest.mark.parametrize("first", [1, 80, 299])
def test_a_channel_that_begins_later_moves_no_header(late, first, tmp_path):
    """Whichever column it is in: the rows without its values are its own gaps."""

    def cell(k, n):
        return "" if n == late and k < first else f"{WAVE[k]:.4f}"

    found = drafted(tmp_path, text(TIMED, *rows(cell=cell)))
    assert units_of(found) == {"GPS Speed": "m/s", "Acc": "m/s²", "Acc2": "m/s²"}
    assert (found.rate_hz, len(found.values)) == (100.0, ROWS)
    assert np.isnan(found.values).sum(axis=0).tolist() == [first * (n == late) for n in range(3)]


def test_a_channel_at_a_lower_rate_has_gaps_of_its_own(tmp_path):
    found = drafted(
        tmp_path, text(TIMED, *rows(cell=lambda k, n: "1.5" if n or k % 10 == 0 else ""))
    )
    assert np.isnan(found.values).sum(axis=0).tolist() == [270, 0, 0]
    assert "GPS Speed: rows without a value of its own: 270; left empty" in found.history


@pytest.mark.parametrize(
    "heads",
    [
        ("Time,Acc,Pot", "s,g,mm"),
        ("Time,Acc,Pot", "[s],[g],[mm]"),
        ("Time,Acc,Pot", "(s),(g),(mm)", ""),
        ("Venue,Test", "Driver,A,,,Engine", "", "Time,Acc,Pot", "s,g,mm", "", ""),
        ("# Time,Acc,Pot", "# s,g,mm"),
        ("Time [s],Acc [g],Pot [mm]",),
        ("Time / s,Acc / g,Pot / mm",),
        ('"Time, s","Acc, g","Pot, mm"',),
        ("Front,Front,Front", "Time [s],Acc [g],Pot [mm]"),
        ("Log of 3 laps", "Serial,17,2", "Time,Acc,Pot", "sec,G,mm"),
        ("Time,Acc,Pot", "s,g,mm", "-,-,-"),
    ],
)
def test_names_and_units_are_found_above_the_rows(heads, tmp_path):
    found = drafted(tmp_path, text(*heads, *rows(columns=2)))
    assert units_of(found) == {"Acc": "m/s²", "Pot": "m"}
    assert (found.rate_hz, len(found.values)) == (100.0, ROWS)


def test_names_in_two_lines_are_joined_where_one_does_not_tell_them_apart(tmp_path):
    heads = ("Time,Front left,Front right,Rear left", "s,Acc,Acc,Acc", "s,g,g,g")
    found = drafted(tmp_path, text(*heads, *rows()))
    assert list(units_of(found)) == ["Front left Acc", "Front right Acc", "Rear left Acc"]
    assert "header_row = [1, 2]" in draft_mapping(tmp_path / "run.csv")


@pytest.mark.parametrize(
    "below", [("",), ("End of file",), ("", "Laps;3", "*** closed ***"), ("2.99",), ("3.00,0.1",)]
)
def test_what_stands_below_the_table_is_left_out_and_said(below, tmp_path):
    found = drafted(tmp_path, text(TIMED, *rows(), *below))
    assert len(found.values) == ROWS
    left_out = [step for step in found.history if "below the table: left out" in step]
    assert len(left_out) == (below != ("",))


def test_names_that_are_repeated_and_blank_lines_are_no_rows(tmp_path):
    lines = rows()
    lines[100:100] = [TIMED]
    lines[200:200] = ["", "# marker: kerb"]
    found = drafted(tmp_path, text(TIMED, *lines))
    assert (len(found.values), found.missing.any()) == (ROWS, False)
    assert "line 102: names repeated; left out" in found.history
    assert "line 203: a remark; left out" in found.history


def test_a_second_table_in_the_file_is_not_left_out_in_silence(tmp_path):
    other = ("Lap,Time (s),Best (s)", *rows(40, columns=2))
    found = drafted(tmp_path, text(TIMED, *rows(50), *other))
    assert "line 53 begins another table, below the one that ends in line 51" in found
    early = text("a,b,c,d", *rows(50), TIMED, *rows())
    assert "line 52 begins something else than the rows above it" in drafted(tmp_path, early)


@pytest.mark.parametrize("cell", ["ERR", "1.2.3", "#VALUE!", "1.5 km/h"])
def test_a_cell_that_is_no_number_is_found_by_its_line(cell, tmp_path):
    lines = rows()
    lines[150] = f'1.50,"{cell}",0.1,0.1'
    found = drafted(tmp_path, text(TIMED, *lines))
    assert isinstance(found, str) and "line 152: GPS Speed (km/h): " in found


def test_room_behind_the_text_is_left_out(tmp_path):
    path = save(tmp_path, "run.csv", text(TIMED, *rows()))
    path.write_bytes(path.read_bytes() + bytes(4000))
    assert len(read(path, Map(time="Time (s)")).values) == ROWS
    assert "header_row = 1 " in draft_mapping(path)


@pytest.mark.parametrize(
    ("separator", "quote", "written", "value"),
    [
        (",", '"', "1234,5", 1234.5),
        (";", "", "1234,5", 1234.5),
        (";", "", "1.234,5", 1234.5),
        (";", "", "1234.5", 1234.5),
        (",", '"', "1,234.5", 1234.5),
        (";", "", "1 234,5", 1234.5),
        (";", "", "1'234.5", 1234.5),
        (";", "", "1.234.567,25", 1234567.25),
        (";", "", "1,2345E3", 1234.5),
        (",", "", "-1.2345e+3", -1234.5),
        (",", "", "1.234", 1.234),
    ],
)
def test_decimal_signs_and_thousands_are_told_from_the_column(
    separator, quote, written, value, tmp_path
):
    """Of the column itself: the time, in whole milliseconds, tells nothing."""
    lines = [f"{quote}{10 * k}{quote}{separator}{quote}{written}{quote}" for k in range(20)]
    head = f"Time [ms]{separator}F [N]"
    found = drafted(tmp_path, text(head, *lines))
    assert found.values[:, 0] == pytest.approx(value)


@pytest.mark.parametrize(
    ("separator", "cells", "asked"),
    [
        (";", ("1,234", "2,345"), "'1,234' may be 1.234 or a thousand as much"),
        (";", ("1.234", "2.345"), "'1.234' may be 1.234 or a thousand as much"),
        ("\t", ("1.234", "0,5"), "some columns have decimal points, others decimal commas"),
        (";", ("1.25", "0,5"), "some columns have decimal points, others decimal commas"),
    ],
)
def test_numbers_that_can_be_read_in_two_ways_are_asked_about(separator, cells, asked, tmp_path):
    columns = separator.join(cells)
    lines = [f"{10 * k}{separator}{columns}" for k in range(20)]
    found = drafted(tmp_path, text(separator.join(["Time [ms]", "F [N]", "x [mm]"]), *lines))
    assert "still to be answered: decimal = …" in found
    if "1.234" not in cells or "0,5" not in cells:
        assert asked in draft_mapping(tmp_path / "run.csv")


@pytest.mark.parametrize(
    ("cell", "mapping"),
    [("1.234", {"decimal": ","}), ("1.23.4", {"decimal": ",", "thousands": "."}),
     ("12.34,5", {"decimal": ",", "thousands": "."}), ("1,5", {})],
)  # fmt: skip
def test_a_number_against_the_marks_of_the_mapping_is_refused(cell, mapping, tmp_path):
    path = save(tmp_path, "run.txt", f"x;y\n1;2\n{cell};3\n")
    with pytest.raises(ExchangeError, match=f"line 3: x: '{cell}' is not a number"):
        read(path, Map(separator=";", rate_hz=50.0, **mapping))


@pytest.mark.parametrize("head", ["t,x\n", ""])
def test_commas_between_and_inside_of_numbers_without_quotes_are_refused(head, tmp_path):
    found = drafted(tmp_path, head + text(*(f"0,{k:02},1,{k:02}5" for k in range(30))))
    assert "commas stand between the columns and inside the numbers: save it" in found


@pytest.mark.parametrize(
    ("unit", "kept", "factor"),
    [
        ("G", "m/s²", G), ("m/s/s", "m/s²", 1.0), ("m/sec^2", "m/s²", 1.0), ("M/S2", "m/s²", 1.0),
        ("m·s⁻²", "m/s²", 1.0), ("ft/s/s", "m/s²", 0.3048), ("lbs", "N", 4.4482216152605),
        ("in/s", "m/s", 0.0254), ("MPH", "m/s", 0.44704), ("Km/h", "m/s", 1 / 3.6),
        ("Inch", "m", 0.0254), ("MM", "m", 1e-3), ("Nm", "N m", 1.0),
        ("deg/s", "rad/s", np.pi / 180),
        ("°/s", "rad/s", np.pi / 180), ("%", "%", 1.0), ("bar", "Pa", 1e5), ("°C", "°C", 1.0),
        ("rpm", "rad/s", np.pi / 30), ("FT/SEC", "m/s", 0.3048), ("kN", "N", 1e3),
        ("kn", "m/s", 1852 / 3600),
        ("psi", "Pa", 6894.757293168),
    ],
)  # fmt: skip
def test_units_as_loggers_spell_them(unit, kept, factor, tmp_path):
    for head in (f"Time (s),x ({unit})", f"Time [s],x [{unit}]", f"Time,x\ns,{unit}"):
        found = drafted(tmp_path, table(lambda k: f"{k / 100:.2f}", head))
        assert units_of(found) == {"x": kept}
        assert found.values[7, 0] == pytest.approx(factor * float(f"{WAVE[7]:.4f}"))


@pytest.mark.parametrize("unit", ["gs", "turns", "MV", "counts", "KN", "gal", "mPa", "nm"])
def test_a_unit_that_is_not_known_stays_unknown_and_has_no_place(unit, tmp_path):
    found = drafted(tmp_path, table(lambda k: f"{k / 100:.2f}", f"Time [s],A1 [{unit}]"))
    assert units_of(found) == {"A1": unit} and found.channels[0].point == ""
    path = tmp_path / "run.csv"
    placed = Map(time="Time [s]", picks=(Pick(f"A1 [{unit}]", point="A1"),))
    with pytest.raises(ExchangeError, match=f"is in {unit}, which is not known, and so cannot be"):
        read(path, placed)
    said = Map(time="Time [s]", picks=(Pick(2, unit="g", point="A1"),))
    assert read(path, said).channels[0].point == "A1"


def test_names_that_differ_by_their_units_alone_stay_apart(tmp_path):
    head = "Timestamp,Force (V),Force (N),Displacement (V),Displacement (mm)"
    stamps = [f"2025-11-14 19:48:05.{round(k * 1e6 / 300):06}" for k in range(300)]
    lines = [f"{stamp},0.1,{20 + k / 10},5.18,{50 + k / 10}" for k, stamp in enumerate(stamps)]
    found = drafted(tmp_path, text(head, *lines))
    assert units_of(found) == {
        "Force (V)": "V", "Force (N)": "N", "Displacement (V)": "V", "Displacement (mm)": "m",
    }  # fmt: skip
    assert found.rate_hz == pytest.approx(300.0) and len(found.values) == 300


@pytest.mark.parametrize("line", ["Max,1.2", "Scale,0.001", "Range,100"])
def test_numbers_between_the_names_and_the_rows_are_no_names_and_a_guess(line, tmp_path):
    body = "".join(f"{k / 100:.2f},{k % 7}.5\n" for k in range(300))
    found = drafted(tmp_path, f"Time,az\ns,g\n{line}\n{body}")
    assert units_of(found) == {"az": "m/s²"} and len(found.values) == 300
    said = understand(tmp_path / "run.csv").guesses
    assert said == (f"line 3 is not applied to the rows: {line}",)


@pytest.mark.parametrize(("head", "rows"), [("0,1,2", 300), ("1,2,3", 300), ("0,1,3", 301)])
def test_numbers_that_count_the_columns_are_no_samples(head, rows, tmp_path):
    """As pandas writes a table without names."""
    body = "".join(f"{k % 5}.5,{k % 3}.5,{k % 7}.5\n" for k in range(300))
    found = drafted(tmp_path, f"Sample rate: 100 Hz\n{head}\n{body}")
    assert len(found.values) == rows
    guessed = understand(tmp_path / "run.csv").guesses
    assert guessed == (("line 2 names the columns, by numbers",) if rows == 300 else ())


def test_the_minus_of_typesetters_is_one(tmp_path):
    body = "".join(f"{k / 100:.2f},−{k % 7}.5\n" for k in range(300))
    assert drafted(tmp_path, f"Time [s],az [m/s2]\n{body}").values[1, 0] == -1.5


@pytest.mark.parametrize("cell", ["(0.5)", "0.5-", "OFF"])
def test_a_column_of_numbers_and_others_is_left_out_with_a_word(cell, tmp_path):
    rows = (f"{k / 100:.2f},1.5,{cell if k % 4 > 1 else '0.5'}\n" for k in range(300))
    found = drafted(tmp_path, f"Time [s],ay [g],az [g]\n{''.join(rows)}")
    assert list(units_of(found)) == ["ay"]
    said = understand(tmp_path / "run.csv").guesses
    assert said == (f"az [g] is left out: '{cell}' is no number",)


def test_blanks_do_not_separate_what_semicolons_do(tmp_path):
    body = "".join(f"Jun 05, 2025 10:20:{k / 100:05.2f} AM;0.5\n" for k in range(300))
    assert "no columns of numbers are found" in drafted(tmp_path, f"Time;az [g]\n{body}")


@pytest.mark.parametrize(
    ("head", "units", "guess"),
    [
        ("Time [s],az [mg]", "s,g", "az [mg] is in g, as line 2 says"),
        ("Time [ms],az [g]", "s,g", "Time [ms] is in s, as line 2 says"),
        ("Time [sec],az [G]", "s,g", None),
    ],
)
def test_a_line_of_units_that_belies_the_names_is_a_guess(head, units, guess, tmp_path):
    found = drafted(tmp_path, text(head, units, *rows(columns=1)))
    assert found.rate_hz == 100.0 and found.values[1, 0] == pytest.approx(0.1987 * G)
    assert understand(tmp_path / "run.csv").guesses == ((guess,) if guess else ())
