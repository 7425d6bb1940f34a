"""The draft of a mapping: what a file looks like, for the user to correct."""

import pytest

from tests.formats.foreign import GERMAN, G, save
from tests.formats.test_lvm import lvm, part, without_x
from wheelhop.formats import ExchangeError, draft_mapping, read, read_mapping

HEAD = """\
# How to read {0}, guessed from its look: correct it, then
#     wheelhop import --map THIS.toml {0}
# Delete the channels that are not wanted. point is A1 … A4 (axles), B1 … B4 or body.
# A channel is column × scale + offset, in unit: add scale = … and offset = … as needed.
format = 1
"""


def draft(tmp_path, text, name="run.txt"):
    """The draft without its head, which is the same for all."""
    found = draft_mapping(save(tmp_path, name, text))
    assert found.startswith(HEAD.format(name))
    return found.removeprefix(HEAD.format(name))


def layout(tmp_path, text):
    """Keys of a draft before its channels, and the columns that are channels."""
    head, *channels = draft(tmp_path, text).split("[[channel]]")
    said = dict(
        line.split("  #")[0].split(" = ") for line in head.split("\n") if line[:1] not in ("", "#")
    )
    return said, [channel.split("\n")[1].removeprefix("column = ") for channel in channels]


def test_all_of_a_draft(tmp_path):
    assert (
        draft(tmp_path, GERMAN.replace("Aufbau", "A2"))
        == """\
separator = ";"
decimal = ","
header_row = 2  # the line that names the columns, 0: none
units_row = 3  # the line with their units, 0: none
first_row = 4  # the line of the first numbers
time = "Zeit"
time_unit = "s"
# left out: Bemerkung, no numbers

[[channel]]
column = "Achse vl"
name = "Achse vl"
unit = "g"  # × 9.80665 = m/s²
point = "A1"  # by its name: is it so?

[[channel]]
column = "A2"
name = "A2"
unit = "m/s²"
point = "A2"
"""
    )


def test_the_draft_of_a_file_that_tells_its_channels(tmp_path):
    """The first of its groups, and a number where a name is not enough."""
    text = lvm(part(), part(39.0)).replace("A1", "axle FL")
    rest = """\

[[channel]]
column = {1}
name = "axle FL"
unit = "g"  # × 9.80665 = m/s²
point = "{0}"{3}

[[channel]]
column = {2}
name = "{4}"
unit = "Volts"
point = ""
"""
    group = 'group = "1"  # one of "1", "2"\n'
    guessed = rest.format("A1", '"axle FL"', '"Aufbau"', "  # by its name: is it so?", "Aufbau")
    assert draft(tmp_path, text, "run.lvm") == group + guessed
    alone = lvm(part()).replace("A1", "axle FL")
    assert draft(tmp_path, alone, "run.lvm") == guessed
    twice = text.replace("Aufbau", "axle FL")
    by_number = rest.format("A1", "1", "2", "  # by its name: is it so?", "axle FL (Volts)")
    by_number = by_number.replace('"axle FL"', '"axle FL (g)"')
    assert draft(tmp_path, twice, "run.lvm") == group + by_number
    timeless = lvm(without_x(), x_columns="No").replace("7,812500E-3", "")
    rate = 'rate_hz = ""  # the file has no time: how many samples has a second?\n\n[[chan'
    assert draft(tmp_path, timeless, "run.lvm").startswith(rate)


def test_without_channels_there_is_no_draft(tmp_path):
    with pytest.raises(ExchangeError, match=r"run\.lvm: holds no channels of numbers"):
        draft(tmp_path, lvm(), "run.lvm")


def test_a_point_is_guessed_for_accelerometers_alone(tmp_path):
    """And said beside a channel that may be one, once its unit is known."""
    text = "t;axle FL [km/h];axle FR;axle RL [g]\n0;1;3;2\n1;2;2;2\n2;5;3;2\n"
    found = draft(tmp_path, text)
    points = [line.split('"')[1] for line in found.split("\n") if line.startswith("point")]
    assert points == ["", "", "A3"]
    assert 'point = ""  # A2 by its name, once its unit is said' in found
    assert 'unit = "km/h"  # × 0.277778 = m/s' in found and "# not said: g, m/s²?" in found


@pytest.mark.parametrize(
    ("text", "header", "units", "first"),
    [
        ("1;2\n3;5\n4;3\n", 0, 0, 1),
        ("x;y\n1;2\n3;5\n4;3\n", 1, 0, 2),
        ("x;y\ng;V\n1;2\n3;5\n4;3\n", 1, 2, 3),
        ("[g];[V]\n1;2\n3;5\n4;3\n", 0, 1, 2),
        ("drive;12\nx;y\n(g);(V)\n;\n1;2\n3;5\n4;3\n", 2, 3, 5),
        ("Serial,1,2,3\nx;y;z\n0,5;1,5;3,5\n0,6;1,2;3,4\n0,9;1,6;3,9\n", 2, 0, 3),
    ],
)
def test_lines_are_counted_as_an_editor_does(text, header, units, first, tmp_path):
    said, columns = layout(tmp_path, text)
    assert columns[:1] == (['"x"'] if header else ["1"])
    assert (said["header_row"], said["units_row"], said["first_row"]) == (
        *(str(header), str(units), str(first)),
    )


@pytest.mark.parametrize(
    "name",
    ["time", "Time_stamp", "TIMESTAMP", "X_Value", "Zeit [s]", "t (s)", "time / s", "time_s"],
)
def test_time_is_known_by_its_name(name, tmp_path):
    said, columns = layout(tmp_path, f"x;{name}\n1;0\n2;0.01\n1;0.02\n")
    assert said["time"] == f'"{name}"' and columns == ['"x"']
    assert said["time_unit"] == '"s"'


@pytest.mark.parametrize("rows", ["0;9\n10;8\n20;7\n", "5;9\n6;8\n7;7\n", "0;9\n0.01;8\n0.02;7\n"])
def test_what_only_rises_evenly_is_asked_about(rows, tmp_path):
    """It may be a distance, a ramp or a counter."""
    said, columns = layout(tmp_path, f"rises;falls\n{rows}")
    assert (said["time"], said["time_unit"]) == ('"rises"', '""')
    assert columns == ['"falls"']
    said, columns = layout(tmp_path, f"rises;falls\nV;V\n{rows}")
    assert "time" not in said and said["rate_hz"] == '""'  # volts are no time
    assert columns == ['"rises"', '"falls"']


def test_a_unit_of_time_that_is_not_known_is_asked_for(tmp_path):
    said, _ = layout(tmp_path, "x;time [ticks]\n1;0\n")
    assert said["time_unit"] == '""'
    mapping = save(tmp_path, "map.toml", draft_mapping(tmp_path / "run.txt"))
    with pytest.raises(ExchangeError, match=r"map\.toml: still to be answered: time_unit = … .*ms"):
        read_mapping(mapping)


def test_a_unit_that_is_not_known_is_said_to_stay(tmp_path):
    found = draft(tmp_path, "t;pot FL [turns];yaw [degs]\n0;1;3\n1;2;3\n2;5;3\n")
    assert 'unit = "turns"  # not known here: it stays as it is' in found
    assert "unit = \"degs\"  # not known here: it stays as it is, did you mean 'deg/s'?" in found
    assert found.count('point = ""') == 2


def test_a_file_of_two_rows_without_time_asks_for_the_rate(tmp_path):
    said, columns = layout(tmp_path, "temperature;x\n1;3\n2;4\n")
    assert said["rate_hz"] == '""' and "time" not in said
    assert columns == ['"temperature"', '"x"']


def test_columns_without_a_name_of_their_own_are_told_by_number(tmp_path):
    assert layout(tmp_path, "x;y;x;\n1;3;2;1\n2;1;7;5\n")[1] == ["1", '"y"', "3", "4"]


def test_a_single_column_of_numbers_has_a_draft(tmp_path):
    """Nothing but its rate is missing."""
    text = "acc [g]\n1.5\n-0.5\n2.5\n"
    said, columns = layout(tmp_path, text)
    assert (said["rate_hz"], said["first_row"], columns) == ('""', "2", ['"acc [g]"'])
    answered = draft_mapping(tmp_path / "run.txt").replace('rate_hz = ""', "rate_hz = 50")
    mapping = read_mapping(save(tmp_path, "map.toml", answered))
    found = read(tmp_path / "run.txt", mapping)
    assert found.values[:, 0] == pytest.approx([1.5 * G, -0.5 * G, 2.5 * G])


def test_more_than_half_of_a_row_are_numbers(tmp_path):
    assert layout(tmp_path, "x;1;2\ny;3;2\n")[1] == ["2", "3"]
    with pytest.raises(ExchangeError, match="no columns of numbers"):
        draft(tmp_path, "x;1;y;2\nx;3;z;2\n")


@pytest.mark.parametrize(
    "text", ["Dear all,\n\n5\nis what I found, \nin all, yours\n", "words\n", "", "\n" * 9]
)
def test_prose_has_no_draft(text, tmp_path):
    with pytest.raises(ExchangeError, match="no columns of numbers are found in its first 200"):
        draft(tmp_path, text)


def test_two_hundred_lines_are_looked_at(tmp_path):
    numbers = "1;2\n" * 3
    assert layout(tmp_path, "words\n" * 199 + numbers)[0]["first_row"] == "200"
    with pytest.raises(ExchangeError, match="first 200 lines"):
        draft(tmp_path, "words\n" * 200 + numbers)
