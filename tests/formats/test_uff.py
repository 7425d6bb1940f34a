"""Universal files, dataset 58: by SDRC's description of its records."""

from dataclasses import replace

import numpy as np
import pytest

from tests.formats.foreign import G
from tests.formats.recordings import assert_same, believed, recording
from wheelhop.formats import ExchangeError, Map, losses, read, write
from wheelhop.formats.header import sidecar
from wheelhop.logger.recording import Channel

pyuff = pytest.importorskip("pyuff")
METRIC = {"type": 164, "units_code": 1, "units_description": "SI", "temp_mode": 1}
METRIC |= {"length": 1.0, "force": 1.0, "temp": 1.0, "temp_offset": 273.15}


def function(values=(1.0, 2.0, 3.0), start=0.0, step=1 / 256, **changes):
    """A function of time as others write it."""
    same = {"type": 58, "binary": 0, "func_type": 1, "id1": "NONE", "ref_node": 0, "ref_dir": 0}
    same |= {"rsp_node": 5, "rsp_dir": 3, "abscissa_spacing": 1, "ordinate_axis_units_lab": "g"}
    same |= {"orddenom_spec_data_type": 0, "z_axis_spec_data_type": 0}
    x = start + step * np.arange(2)
    return same | {"x": x, "data": np.asarray(values, dtype=float)} | changes


def saved(tmp_path, *sets):
    path = tmp_path / "of_others.uff"
    pyuff.UFF(str(path)).write_sets(list(sets), mode="overwrite")
    return path


def functions(path):
    return [item for item in pyuff.UFF(str(path)).read_sets() if item["type"] == 58]


def names(tmp_path, *sets):
    return [channel.name for channel in read(saved(tmp_path, *sets)).channels]


def test_functions_of_others(tmp_path):
    sets = [
        function([1, 2]),
        function([3, 4], start=4 / 256),
        function(range(6), rsp_node=6, rsp_dir=-1),
    ]
    found = read(saved(tmp_path, *sets))
    assert [c.name for c in found.channels] == ["5+Z", "6-X"]
    assert (found.rate_hz, found.start_s) == (256.0, 0.0)
    assert np.flatnonzero(found.missing).tolist() == [2, 3]
    assert found.values[[0, 5]] == pytest.approx(np.array([[1, 0], [4, 5]]) * G)
    again = saved(tmp_path, *sets, function([9, 9]))
    assert read(again, Map(group="2")).values == pytest.approx(np.array([[9], [9]]) * G)


def test_pieces_that_touch_are_one_channel_and_pieces_that_overlap_are_not(tmp_path):
    late = function(start=40.0, step=0.05)
    found = read(saved(tmp_path, late, function([4, 5], start=40.15, step=0.05)))
    assert found.values[:, 0] == pytest.approx(np.arange(1, 6) * G)
    assert (found.rate_hz, found.start_s) == (20.0, 40.0)
    path = saved(tmp_path, late, function([4, 5], start=40.1, step=0.05))
    with pytest.raises(ExchangeError, match=r'"1" \(1 channels\), "2" \(1 channels\)'):
        read(path)


def test_where_a_sensor_points(tmp_path):
    """Codes of directions: record 6."""
    coded = {0: "", 1: "+X", 2: "+Y", 3: "+Z", -1: "-X", -2: "-Y", -3: "-Z"}
    sets = [function(rsp_dir=code) for code in coded]
    assert names(tmp_path, *sets) == [f"5{axis}" for axis in coded.values()]


def test_a_function_is_called_by_its_node_or_by_its_first_line(tmp_path):
    title = {"id1": "hammer, run 3"}
    assert names(tmp_path, function(**title)) == ["5+Z"]
    assert names(tmp_path, function(**title, rsp_node=0)) == ["hammer, run 3"]
    assert names(tmp_path, function(rsp_node=0)) == ["0+Z"]


def test_a_function_may_be_a_single_sample(tmp_path):
    assert read(saved(tmp_path, function([7.0]))).values == pytest.approx(7 * G)


def test_functions_that_are_not_of_time_are_left_out(tmp_path):
    assert names(tmp_path, function(func_type=0), function(func_type=4, rsp_node=6)) == ["5+Z"]
    with pytest.raises(ExchangeError, match="dataset 1: is a frequency response, no recording"):
        read(saved(tmp_path, function(func_type=4)))


def test_a_unit_that_is_not_written_is_si_if_the_file_is(tmp_path):
    """Quantities: record 9, units: dataset 164."""
    coded = {8: "m", 11: "m/s", 12: "m/s²", 13: "N", 99: ""}
    bare = {"ordinate_axis_units_lab": "NONE"}
    sets = [
        function(**bare, ordinate_spec_data_type=code, rsp_node=k)
        for k, code in enumerate(coded, start=1)
    ]
    found = read(saved(tmp_path, METRIC, *sets))
    assert [channel.unit for channel in found.channels] == list(coded.values())
    for others in ([], [METRIC | {"units_code": 2}]):
        found = read(saved(tmp_path, *others, *sets))
        assert {channel.unit for channel in found.channels} == {""}


def test_uneven_abscissas_are_laid_on_a_grid(tmp_path):
    x = np.array([0.0, 0.01, 0.02, 0.05, 0.06])
    found = read(saved(tmp_path, function(x * 100, abscissa_spacing=0, x=x, rsp_node=0, id1="B1")))
    assert (found.channels[0].name, found.channels[0].unit) == ("B1", "m/s²")
    expected = np.array([0, 1, 2, np.nan, np.nan, 5, 6]) * G
    assert found.values[:, 0] == pytest.approx(expected, nan_ok=True)


def test_of_uneven_abscissas_the_wrong_one_is_named(tmp_path):
    x = np.array([0.0, 0.01, 0.02, 0.02])
    path = saved(tmp_path, function(), function(x, abscissa_spacing=0, x=x))
    with pytest.raises(ExchangeError, match="dataset 2: sample 4: time does not rise"):
        read(path)


@pytest.mark.parametrize(("start", "step"), [(1e15, 64.0), (0.0, 1e15), (5.0, 0.0)])
def test_absurd_times_are_refused(tmp_path, start, step):
    with pytest.raises(ExchangeError, match=r"dataset 1: time from .* is no time"):
        read(saved(tmp_path, function(start=start, step=step)))


@pytest.mark.parametrize(("due", "there"), [(5, 3), (0, 3)])
def test_a_function_without_all_its_samples_is_refused(due, there, tmp_path):
    path = saved(tmp_path, function())
    text = path.read_text()
    assert text.count(f"{there:10d}         1") == 1
    path.write_text(text.replace(f"{there:10d}         1", f"{due:10d}         1"))
    with pytest.raises(ExchangeError, match=f"dataset 1: holds {there} of {due} samples"):
        read(path)


@pytest.mark.parametrize(
    ("step", "rate"), [(1 / 256, 256.0), (3e-3, 333.333), (7.69213e-3, 130.003)]
)
def test_the_rate_is_the_roundest_of_six_digits(step, rate, tmp_path):
    assert read(saved(tmp_path, function(step=step))).rate_hz == rate


def test_the_records_that_are_written(tmp_path):
    """A place of ours is a node, and an accelerometer there points up; nothing is relative to
    another node, and the abscissa is time."""
    channels = (
        Channel("A3", "m/s²", "A3", "ADXL-1", "bench-3"),
        Channel("Weg vorn", "m", "A1"),
        Channel("Kraft ~ ü", "N"),
        Channel("pedal", "m/s²"),
        Channel("battery", "V", "body"),
    )
    path = tmp_path / "run.uff"
    write(replace(recording(rows=6, channels=5, gaps=()), channels=channels), path)
    units, *found = pyuff.UFF(str(path)).read_sets()
    assert {key: units[key] for key in METRIC if key not in ("units_description", "temp_mode")} == {
        key: METRIC[key] for key in METRIC if key not in ("units_description", "temp_mode")
    }
    keys = ("func_id", "rsp_ent_name", "rsp_node", "rsp_dir", "ordinate_spec_data_type")
    assert [tuple(item[key] for key in keys) for item in found] == [
        (1, "A3", 3, 3, 12),
        (2, "A1", 1, 0, 8),
        (3, "NONE", 0, 0, 13),
        (4, "NONE", 0, 0, 12),
        (5, "body", 9, 0, 0),
    ]
    same = {"func_type": 1, "ref_node": 0, "ref_dir": 0, "abscissa_spacing": 1}
    same |= {"abscissa_spec_data_type": 17, "orddenom_spec_data_type": 0}
    same |= {"z_axis_spec_data_type": 0, "id3": "21-SEP-26 14:13:20", "num_pts": 6}
    for item in found:
        assert {key: item[key] for key in same} == same
    assert [item["id1"] for item in found] == ["A3", "Weg vorn", "Kraft ~ ?", "pedal", "battery"]
    assert (found[0]["id4"], found[0]["id5"]) == ("sensor ADXL-1", "calibration bench-3")
    assert (found[1]["id4"], found[1]["id5"]) == ("NONE", "NONE")
    assert [item["ordinate_axis_units_lab"] for item in found] == ["m/s^2", "m", "N", "m/s^2", "V"]


def test_texts_that_are_too_long_for_their_records_push_nothing_aside(tmp_path):
    """80 characters of a line, 10 of a place, 20 of a unit; beside the file all of it is kept."""
    long = Channel(*(letter * 200 for letter in "nupsc"))
    original = replace(recording(rows=6, channels=1, gaps=()), channels=(long,))
    path = tmp_path / "run.uff"
    write(original, path)
    _, _, samples = path.read_bytes().partition(b"    -1\n    58b")
    assert max(map(len, samples.split(b"\n")[:12])) <= 80
    (item,) = functions(path)
    assert item["id1"] == "n" * 80
    assert (item["id4"], item["id5"]) == (f"sensor {'s' * 73}", f"calibration {'c' * 68}")
    assert (item["rsp_ent_name"], item["ordinate_axis_units_lab"]) == ("p" * 10, "u" * 20)
    assert_same(read(path), original)


def test_without_the_sidecar_missing_rows_at_the_start_are_not_there(tmp_path):
    original, path = recording(rows=20, gaps=((0, 5), (9, 11))), tmp_path / "run.uff"
    write(original, path)
    assert_same(read(path), original)
    sidecar(path).unlink()
    found = read(path)
    assert np.array_equal(found.values, original.values[5:], equal_nan=True)
    assert found.start_s == pytest.approx(original.time_s[5], rel=1e-5)


def test_two_recordings_in_one_file_are_groups(tmp_path):
    path, other = tmp_path / "run.uff", tmp_path / "other.uff"
    write(recording(rows=8, gaps=((5, 6),)), path)
    write(recording(rows=9, gaps=((2, 4),)), other)
    path.write_bytes(path.read_bytes() + other.read_bytes())
    with pytest.raises(ExchangeError, match=r"run\.uff\.toml: is the header of other samples"):
        read(path)
    believed(path)
    with pytest.raises(ExchangeError, match=r"run\.uff\.toml: does not describe the functions"):
        read(path)
    sidecar(path).unlink()
    assert len(read(path, Map(group="1")).values) == 8
    assert len(read(path, Map(group="2")).values) == 9


def test_a_sidecar_of_another_file_is_noticed(tmp_path):
    write(recording(rows=6, gaps=()), tmp_path / "run.uff")
    write(recording(rows=6, gaps=(), channels=2), tmp_path / "other.uff")
    sidecar(tmp_path / "other.uff").rename(sidecar(tmp_path / "run.uff"))
    believed(tmp_path / "run.uff")
    with pytest.raises(ExchangeError, match=r"run\.uff\.toml: does not describe the functions"):
        read(tmp_path / "run.uff")


def test_a_file_of_ours_that_another_program_wrote_again_starts_where_it_did(tmp_path):
    """Its functions no longer say which rows they are."""
    original, path = recording(rows=20, gaps=((9, 11),)), tmp_path / "run.uff"
    original = replace(original, start_s=40.0)
    write(original, path)
    sets = [item | {"id2": "NONE", "rsp_node": 0, "binary": 0} for item in functions(path)]
    pyuff.UFF(str(path)).write_sets(sets, mode="overwrite")
    believed(path)
    found = read(path)
    assert found.values == pytest.approx(original.values, rel=1e-5, nan_ok=True)
    assert (found.rate_hz, found.start_s) == (original.rate_hz, original.start_s)


def test_what_is_lost_is_counted_in_rows():
    values = recording(rows=20, gaps=()).values.copy()
    values[[3, 5, 7], 1] = np.nan
    values[[9, 11], 0] = np.inf
    lost = losses(replace(recording(rows=20, gaps=()), values=values), ".uff")
    assert lost == (
        "rows with a value in some channels only: 5; they become gaps",
        "rows with an infinite value: 2; they become gaps",
    )


@pytest.mark.parametrize(
    ("unit", "seconds"), [("ms", 1e-3), ("s", 1.0), ("SEC", 1.0), ("NONE", 1.0)]
)
def test_the_abscissa_s_unit_counts(unit, seconds, tmp_path):
    item = function(start=0.0, step=0.008 / seconds, abscissa_axis_units_lab=unit)
    found = read(saved(tmp_path, item))
    assert found.rate_hz == pytest.approx(125.0)
    with pytest.raises(ExchangeError, match="dataset 1: its abscissa is rev, not time"):
        read(saved(tmp_path, function(abscissa_axis_units_lab="rev")))


@pytest.mark.parametrize(
    ("code", "unit", "word"),
    [(18, "Hz", "a spectrum"), (8, "mm", "a loop"), (13, "N", "a loop"), (19, "rpm", "no recor")],
)
def test_an_abscissa_that_is_no_time_is_no_recording(code, unit, word, tmp_path):
    other = function(abscissa_spec_data_type=code, abscissa_axis_units_lab=unit, rsp_node=6)
    with pytest.raises(ExchangeError, match=f"dataset 1: its abscissa is .*, not time: .*{word}"):
        read(saved(tmp_path, other))
    found = read(saved(tmp_path, function(), other))
    assert [channel.name for channel in found.channels] == ["5+Z"]
    assert any("left out: dataset 2: its abscissa is" in step for step in found.history)


DATE = {"id3": "14-JUN-25 10:00:00"}


def test_two_sensors_at_one_node_are_two_channels(tmp_path):
    """Named by their first lines; a repetition has the same ones, and is a group of its own."""
    hub, body = function(id1="Hub acc", **DATE), function(id1="Body acc", **DATE)
    assert names(tmp_path, hub, body) == ["Hub acc", "Body acc"]
    force = function(id1="Force", ordinate_axis_units_lab="N", **DATE)
    found = read(saved(tmp_path, hub, force))
    assert [(c.name, c.unit) for c in found.channels] == [("Hub acc", "m/s²"), ("Force", "N")]
    undated = [function(id1=f"Dof{k}", rsp_node=node) for k, node in enumerate((1, 2, 3, 1))]
    assert names(tmp_path, *undated) == ["Dof0", "2+Z", "3+Z", "Dof3"]
    path = saved(tmp_path, hub, body, hub, body)
    with pytest.raises(ExchangeError, match=r'"1" \(2 channels\), "2" \(2 channels\)'):
        read(path)


def test_repeated_runs_are_no_channels_of_one(tmp_path):
    """Not even if their first lines say which run they are."""
    runs = [function(id1=f"hammer, run {k}") for k in (1, 2)]
    later = [runs[0] | DATE, runs[1] | {"id3": "14-JUN-25 11:00:00"}]
    for sets in (runs, later, [*later[:1], later[1] | {"rsp_node": 6}]):
        with pytest.raises(ExchangeError, match=r'"1" \(1 channels\), "2" \(1 channels\)'):
            read(saved(tmp_path, *sets))


def test_an_abscissa_without_a_unit_must_be_called_time(tmp_path):
    nameless = {"abscissa_spec_data_type": 0, "abscissa_axis_units_lab": "NONE"}
    for label in ("Time", "NONE"):
        assert read(saved(tmp_path, function(abscissa_axis_lab=label, **nameless))).rate_hz == 256.0
    with pytest.raises(ExchangeError, match="dataset 1: its abscissa is Distance, not time"):
        read(saved(tmp_path, function(abscissa_axis_lab="Distance", **nameless)))


def test_what_is_per_force_is_no_acceleration(tmp_path):
    per = {"orddenom_axis_units_lab": "N"}
    assert read(saved(tmp_path, function(**per))).channels[0].unit == "g/N"


def test_what_points_elsewhere_than_up_is_called_so_and_sits_nowhere(tmp_path):
    named = {"rsp_node": 0, "id1": "Hub FL", "rsp_ent_name": "A1"}
    for direction, name, point in (
        (3, "Hub FL", "A1"),
        (-3, "Hub FL -Z", ""),
        (1, "Hub FL +X", ""),
    ):
        found = read(saved(tmp_path, function(rsp_dir=direction, **named)))
        assert [(c.name, c.point) for c in found.channels] == [(name, point)]
