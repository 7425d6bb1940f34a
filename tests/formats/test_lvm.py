"""LabVIEW measurements: by "Specification for the LabVIEW Measurement File (.lvm)", NI."""

import re

import numpy as np
import pytest

from tests.formats.foreign import LVM, ONE, G, save
from wheelhop.formats import ExchangeError, Map, read

STEP = 0.0078125


def part(second=40.0):
    """A segment of three rows that begins at this second."""
    return ONE.format(second=second).replace("40.", "40,")


def lvm(*parts, x_columns="One"):
    return LVM.format(x_columns=x_columns) + "\n".join(parts)


def without_x(second=40.0):
    return re.sub(r"\n0,0\d+\t", "\n\t", part(second))


def going_on(start, second=40.0):
    """A segment whose X does not begin at 0."""
    text = part(second).replace("0,0000000000000000E+0", f"{start}".replace(".", ","))
    for row, x in ((2, "0,015625"), (1, "0,007812"), (0, "0,000000")):
        text = text.replace(f"\n{x}", f"\n{start + row * STEP:.6f}".replace(".", ","))
    return text


def test_lvm_with_one_x_column_takes_the_exact_step(tmp_path):
    text = lvm(part())
    found = read(save(tmp_path, "run.lvm", text))
    assert found.rate_hz == 128.0
    assert found.values.tolist() == [[0.5 * G, 1.25], [-1.5 * G, 1.5], [2.5 * G, 1.75]]
    assert [(c.name, c.unit, c.point) for c in found.channels] == [
        ("A1", "m/s²", "A1"),
        ("Aufbau", "V", ""),
    ]
    assert found.notes["operator"] == "somebody" and found.notes["date"] == "2024/02/19"


def test_lvm_has_its_time_in_the_first_column_whatever_that_is_called(tmp_path):
    """With a step that is not known, as others write it."""
    text = lvm(part())
    text = text.replace("X_Value\tA1", "Zeit\tA1").replace("7,812500E-3", "0,000000E0")
    found = read(save(tmp_path, "run.lvm", text))
    assert found.rate_hz == pytest.approx(128.0, rel=1e-4)
    assert [channel.name for channel in found.channels] == ["A1", "Aufbau"]


def test_lvm_with_an_odd_step_keeps_it_though_stamps_are_rounded(tmp_path):
    """To six decimals the stamps would do for 130 Hz as well. They begin where the header says."""
    text = lvm(part())
    text = text.replace("7,812500E-3", "7,692130E-3")
    text = text.replace("0,007812", "2,007692").replace("0,015625", "2,015384")
    text = text.replace("0,000000\t", "2,000000\t").replace("0,0000000000000000E+0", "2,0")
    found = read(save(tmp_path, "run.lvm", text))
    assert found.rate_hz == pytest.approx(1.0 / 7.69213e-3, rel=1e-12)
    assert found.start_s == 2.0


def test_lvm_of_one_channel(tmp_path):
    text = lvm(part())
    rows = [line.split("\t") for line in text.splitlines()]
    alone = "\n".join("\t".join(row[:2]) for row in rows)
    found = read(save(tmp_path, "run.lvm", alone))
    assert found.rate_hz == 128.0
    assert found.values.tolist() == [[0.5 * G], [-1.5 * G], [2.5 * G]]


def test_lvm_segments_are_joined_by_their_clock(tmp_path):
    path = save(tmp_path, "run.lvm", lvm(part(), part(40 + 3 * STEP), part(40 + 8 * STEP)))
    found = read(path)
    assert found.values.shape == (11, 2) and found.start_s == 0.0
    assert found.notes["time"] == "09:51:40,000000"  # of the first
    assert np.flatnonzero(found.missing).tolist() == [6, 7]
    assert found.history[-1] == "samples missing in the time stamps: 2, in gaps: 1; left empty"
    second = read(path, Map(group="2"))
    assert second.values.shape == (3, 2)


def test_lvm_without_x_and_with_many_x(tmp_path):
    found = read(save(tmp_path, "no.lvm", lvm(without_x(), x_columns="No")))
    assert found.rate_hz == 128.0 and found.values.shape == (3, 2)
    many = """\
Channels;2;;;
Samples;3;;3;
X_Dimension;Time;;Time;
Y_Unit_Label;Volts;;g;
X0;0.5;;0.5;
Delta_X;0.1;;0.1;
***End_of_Header***;;;;
X_Value;Voltage;X_Value;B1;Comment
0.5;1;0.5;2;
0.6;3;0.6;4;so
0.7;5;0.7;6;
"""
    head = LVM.format(x_columns="Multi").replace("\t", ";").replace("Separator;,", "Separator;.")
    head = head.replace("Separator;Tab", "Separator;Semicolon")
    found = read(save(tmp_path, "many.lvm", head + many))
    assert found.rate_hz == 10.0 and found.start_s == 0.5
    assert found.values.tolist() == [[1, 2 * G], [3, 4 * G], [5, 6 * G]]
    assert [c.unit for c in found.channels] == ["V", "m/s²"]


def refused(tmp_path, text, mapping=None):
    """What is said of a file that cannot be read."""
    path = save(tmp_path, "run.lvm", text)
    with pytest.raises(ExchangeError) as caught:
        read(path, mapping)
    line = str(caught.value)
    assert line.startswith(f"{path}: ") and "\n" not in line
    return line.removeprefix(f"{path}: ")


@pytest.mark.parametrize(
    ("mark", "name"), [(",", "Comma"), (";", "SEMICOLON"), (" ", "Space"), ("|", "Pipe"), ("|", "")]
)
def test_cells_are_separated_as_the_header_says(mark, name, tmp_path):
    """By a name that is known, or by what stands behind the word."""
    text = lvm(part()).replace(",", ".").replace("Tab", name).replace("\t", mark)
    found = read(save(tmp_path, "run.lvm", text))
    assert found.rate_hz == 128.0 and found.values[:, 1].tolist() == [1.25, 1.5, 1.75]


def test_without_a_word_on_separators_they_are_tabs(tmp_path):
    found = read(save(tmp_path, "run.lvm", lvm(part()).replace("Separator\tTab\n", "")))
    assert found.values[:, 1].tolist() == [1.25, 1.5, 1.75]


def test_stamps_hold_where_the_step_of_the_header_contradicts_them(tmp_path):
    text = lvm(part()).replace("0,007812", "0,010000").replace("0,015625", "0,020000")
    assert read(save(tmp_path, "run.lvm", text)).rate_hz == 100.0


@pytest.mark.parametrize("step", ["", "0,0", "1E15", "none"])
def test_without_x_and_with_no_step_the_user_gives_the_rate(step, tmp_path):
    text = lvm(without_x(), x_columns="No").replace("7,812500E-3", step)
    assert refused(tmp_path, text) == "has no time: give time or rate_hz in a mapping"
    found = read(tmp_path / "run.lvm", Map(rate_hz=50.0))
    assert (found.rate_hz, found.start_s) == (50.0, 0.0)


def test_segments_without_time_are_not_joined_at_a_rate_of_nobody_s(tmp_path):
    text = lvm(without_x(), without_x(41.0), x_columns="No").replace("7,812500E-3", "")
    said = "has neither X nor Delta_X: give rate_hz and group in a mapping"
    assert refused(tmp_path, text) == said
    assert read(tmp_path / "run.lvm", Map(rate_hz=50.0, group="2")).rate_hz == 50.0


@pytest.mark.parametrize(("said", "start"), [("", 0.0), ("1E15", 0.0), ("0,25", 0.25)])
def test_samples_begin_at_x0_or_at_0(said, start, tmp_path):
    text = lvm(without_x(), x_columns="No").replace("0,0000000000000000E+0", said)
    assert read(save(tmp_path, "run.lvm", text)).start_s == start


def test_units_and_names_may_be_missing(tmp_path):
    text = lvm(part()).replace("Y_Unit_Label\tg\tVolts\t", "Y_Unit_Label\tg")
    found = read(save(tmp_path, "run.lvm", text.replace("A1", "")))
    assert [(c.name, c.unit) for c in found.channels] == [("column 2", "m/s²"), ("Aufbau", "")]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("-1,5", "x", "line 25: A1: 'x' is not a number"),
        ("\t-1,5\t1,50\tbump", "", "line 25 has 1 values, not 3"),
        ("7,812500E-3\t7,812500E-3", "", "line 25: time does not rise, from 0.02 to 0.007812 s"),
        ("LabVIEW", "LabWINDOWS", "line 1 must begin with LabVIEW Measurement"),
    ],
)
def test_what_is_wrong_is_found_by_its_line(old, new, said, tmp_path):
    text = lvm(part()).replace(old, new)
    if "rise" in said:
        text = text.replace("\n0,000000", "\n0,020000")
    assert refused(tmp_path, text).startswith(said)


def test_a_header_that_nothing_follows_is_found_by_its_line(tmp_path):
    header, _, _ = lvm(part()).partition("X_Value\t")
    assert refused(tmp_path, header) == "line 22: no columns are named behind this header"


def test_a_segment_without_samples_is_found_by_its_line(tmp_path):
    empty, _, _ = part().partition("\n0,000000\t")
    said = "the segment that begins here has no samples"
    assert refused(tmp_path, lvm(empty)) == f"line 14: {said}"
    assert refused(tmp_path, lvm(part(), empty)) == f"line 28: {said}"


def test_segments_whose_x_goes_on_need_no_clock(tmp_path):
    text = lvm(part(), going_on(3 * STEP), going_on(8 * STEP)).replace("Time\t", "When\t")
    found = read(save(tmp_path, "run.lvm", text))
    assert np.flatnonzero(found.missing).tolist() == [6, 7] and found.rate_hz == 128.0
    jumping = lvm(part(), going_on(3.4 * STEP)).replace("7,812500E-3\t7,812500E-3", "")
    assert refused(tmp_path, jumping).startswith("row 4: time jumps from 0.015625 to 0.026562 s")


def test_x_that_begins_anew_may_begin_later(tmp_path):
    """By less than a segment: then it does not go on."""
    found = read(save(tmp_path, "run.lvm", lvm(part(), going_on(STEP, 40 + 8 * STEP))))
    assert np.flatnonzero(found.missing).tolist() == [3, 4, 5, 6, 7, 8]


def test_what_is_marked_as_special_is_not_read(tmp_path):
    special = "***Start_Special***\nOperator\tnobody\n***End_Special***\nProject\tsprings\n***End"
    found = read(save(tmp_path, "run.lvm", lvm(part()).replace("***End", special, 1)))
    assert found.notes["operator"] == "somebody" and found.notes["project"] == "springs"


def test_segments_of_one_sample_each_are_joined(tmp_path):
    """As a loop writes them; each is told by its clock alone."""
    alone = [part(40 + k * STEP).partition("0,007812\t-")[0] for k in range(4)]
    found = read(save(tmp_path, "run.lvm", lvm(*alone)))
    assert (found.rate_hz, found.start_s) == (128.0, 0.0)
    assert found.values.tolist() == [[0.5 * G, 1.25]] * 4 and not found.missing.any()
    assert "holds groups" in refused(tmp_path, lvm(alone[0], alone[0]))


@pytest.mark.parametrize(
    "second",
    [
        part(),  # at the same time
        part(40 + 1.5 * STEP),  # begins before the one before has ended
        part(39.0),
        part(41.0).replace("A1", "A2"),
        part(41.0).replace("7,812500E-3\t7,812500E-3", "3,906250E-3\t3,906250E-3"),
        part(41.0).replace("Time\t09", "Time\tat 9"),  # nobody knows when
    ],
)
def test_segments_that_do_not_follow_each_other_are_groups(second, tmp_path):
    said = 'not sampled together: choose with group = … in a mapping from "1" (2 channels), "2" (2'
    assert said in refused(tmp_path, lvm(part(), second))


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("X_Dimension\tTime\tTime", "X_Dimension\tFrequency\tFrequency", "a spectrum"),
        ("X_Dimension\tTime\tTime", "X_Dimension\tTime\t\nX_Unit_Label\tHz\tHz", "a spectrum"),
        ("X_Dimension\tTime\tTime", "X_Dimension\tLength\t\nX_Unit_Label\tmm\tmm", "no recording"),
    ],
)
def test_x_that_is_no_time_is_no_recording(old, new, word, tmp_path):
    assert old in lvm(part())
    said = refused(tmp_path, lvm(part()).replace(old, new))
    assert "not time: this is" in said and word in said


def test_the_unit_of_x_counts(tmp_path):
    text = lvm(part()).replace("X_Dimension", "X_Unit_Label\tms\tms\t\nX_Dimension")
    path = save(tmp_path, "run.lvm", text)
    with pytest.raises(ExchangeError, match="the file says 128000 Hz, at which"):
        read(path)
    assert read(path, Map(rate_hz=128_000.0)).rate_hz == 128_000.0
