"""Binary and LabVIEW files of other programs beside what they must give, and ours before theirs."""

from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from tests.formats.foreign import LVM, ONE, G, save
from tests.formats.recordings import recording
from wheelhop.formats import ExchangeError, Map, read, write
from wheelhop.logger.recording import Channel


def test_lvm_with_one_x_column_takes_the_exact_step(tmp_path):
    text = LVM.format(x_columns="One") + ONE.format(second=40.0).replace("40.", "40,")
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
    text = LVM.format(x_columns="One") + ONE.format(second=40.0).replace("40.", "40,")
    text = text.replace("X_Value\tA1", "Zeit\tA1").replace("7,812500E-3", "0,000000E0")
    found = read(save(tmp_path, "run.lvm", text))
    assert found.rate_hz == pytest.approx(128.0, rel=1e-4)
    assert [channel.name for channel in found.channels] == ["A1", "Aufbau"]


def test_lvm_with_an_odd_step_keeps_it_though_stamps_are_rounded(tmp_path):
    """To six decimals the stamps would do for 130 Hz as well."""
    text = LVM.format(x_columns="One") + ONE.format(second=40.0).replace("40.", "40,")
    text = text.replace("7,812500E-3", "7,692130E-3")
    text = text.replace("0,007812", "0,007692").replace("0,015625", "0,015384")
    found = read(save(tmp_path, "run.lvm", text))
    assert found.rate_hz == pytest.approx(1.0 / 7.69213e-3, rel=1e-12)


def test_lvm_of_one_channel(tmp_path):
    text = LVM.format(x_columns="One") + ONE.format(second=40.0).replace("40.", "40,")
    rows = [line.split("\t") for line in text.splitlines()]
    alone = "\n".join("\t".join(row[:2]) for row in rows)
    found = read(save(tmp_path, "run.lvm", alone))
    assert found.rate_hz == 128.0
    assert found.values.tolist() == [[0.5 * G], [-1.5 * G], [2.5 * G]]


def test_lvm_segments_are_joined_by_their_clock(tmp_path):
    step = 0.0078125
    parts = [
        ONE.format(second=s).replace("40.", "40,") for s in (40.0, 40 + 3 * step, 40 + 8 * step)
    ]
    path = save(tmp_path, "run.lvm", LVM.format(x_columns="One") + "\n".join(parts))
    found = read(path)
    assert found.values.shape == (11, 2)
    assert np.flatnonzero(found.missing).tolist() == [6, 7]
    assert found.history[-1] == "samples missing in the time stamps: 2, in gaps: 1; left empty"
    second = read(path, Map(group="2"))
    assert second.values.shape == (3, 2)
    same = save(tmp_path, "same.lvm", LVM.format(x_columns="One") + "\n".join(parts[:1] * 2))
    with pytest.raises(ExchangeError, match=r'choose with group = … in a mapping from "1" \(2'):
        read(same)


def test_lvm_without_x_and_with_many_x(tmp_path):
    none = ONE.format(second=40.0).replace("0,000000\t0,5", "\t0,5")
    none = none.replace("0,007812\t-", "\t-").replace("0,015625\t2", "\t2")
    found = read(save(tmp_path, "no.lvm", LVM.format(x_columns="No") + none))
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


def test_tdms_waveforms(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    path = tmp_path / "run.tdms"
    start = datetime(2026, 5, 1, 12, tzinfo=UTC)

    def wave(group, name, values, step, unit):
        timing = {"wf_increment": step, "wf_start_offset": 0.25, "unit_string": unit}
        timing["wf_start_time"] = np.datetime64(start.replace(tzinfo=None))
        return nptdms.ChannelObject(group, name, np.asarray(values), properties=timing)

    one = [wave("car", "A1", [1.0, 2.0], 0.005, "g"), wave("car", "B1", [3, 4], 0.005, "m/s^2")]
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(one)
        writer.write_segment(
            [wave("car", "A1", [5.0], 0.005, "g"), wave("car", "B1", [6], 0.005, "")]
        )
    found = read(path)
    assert found.values == pytest.approx(np.array([[G, 3], [2 * G, 4], [5 * G, 6]]))
    assert (found.rate_hz, found.start_s) == (200.0, 0.25)
    assert found.start_unix_s == start.timestamp()
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment([*one, wave("engine", "rpm", [700.0], 1.0, "1/min")])
    with pytest.raises(ExchangeError, match=r'"car" \(2 channels\), "engine" \(1 channels\)'):
        read(path)
    assert read(path, Map(group="car")).values.shape == (2, 2)


def test_mdf_of_others_with_two_rates_and_invalid_samples(tmp_path):
    asammdf = pytest.importorskip("asammdf")
    path = tmp_path / "ecu.mf4"
    fast, slow = np.arange(20) * 0.005 + 0.1, np.arange(5) * 0.02
    raw = np.arange(20, dtype=np.int16)
    bits = np.arange(20) == 7
    signals = [
        asammdf.Signal(raw, fast, name="A1", unit="mg", invalidation_bits=bits),
        asammdf.Signal(raw * 2.0, fast, name="state", unit="V"),
    ]
    with asammdf.MDF(version="4.10") as mdf:
        mdf.append(signals, common_timebase=True)
        mdf.append([asammdf.Signal(np.arange(5.0), slow, name="speed", unit="km/h")])
        mdf.save(path)
    with pytest.raises(ExchangeError, match="not sampled together: choose with group"):
        read(path)
    found = read(path, Map(group="0"))
    assert found.rate_hz == 200.0 and found.start_s == 0.1
    assert np.flatnonzero(found.missing).tolist() == [7]
    assert found.values[3] == pytest.approx([3e-3 * G, 6.0])
    speed = read(path, Map(group="1"))
    assert speed.values[:, 0] == pytest.approx(np.arange(5) / 3.6)
    assert speed.channels[0].unit == "m/s"


def test_uff_of_others_in_text(tmp_path):
    pyuff = pytest.importorskip("pyuff")
    path = tmp_path / "modal.uff"
    x = np.arange(6) / 256

    def function(node, direction, start, values):
        return {
            "type": 58,
            "binary": 0,
            "func_type": 1,
            "id1": "NONE",
            "rsp_node": node,
            "rsp_dir": direction,
            "ref_node": 0,
            "ref_dir": 0,
            "abscissa_spacing": 1,
            "x": x[:2] + start,
            "data": np.asarray(values, dtype=float),
            "ordinate_spec_data_type": 12,
            "ordinate_axis_units_lab": "g",
            "orddenom_spec_data_type": 0,
            "z_axis_spec_data_type": 0,
        }

    sets = [function(5, 3, 0.0, [1, 2]), function(5, 3, x[4], [3, 4]), function(6, -1, 0, range(6))]
    pyuff.UFF(str(path)).write_sets(sets, mode="overwrite")
    found = read(path)
    assert [c.name for c in found.channels] == ["5+Z", "6-X"]
    assert found.rate_hz == 256.0
    assert np.flatnonzero(found.missing).tolist() == [2, 3]
    assert found.values[[0, 5]] == pytest.approx(np.array([[1, 0], [4, 5]]) * G)
    again = [*sets, function(5, 3, 0.0, [9, 9])]
    pyuff.UFF(str(path)).write_sets(again, mode="overwrite")
    assert read(path, Map(group="2")).values == pytest.approx(np.array([[9], [9]]) * G)


def test_uff_says_where_a_sensor_points_and_what_it_measures(tmp_path):
    """Codes of directions and of the quantity: SDRC's description of dataset 58, records 6 and
    9."""
    pyuff = pytest.importorskip("pyuff")
    path, coded = tmp_path / "codes.uff", {1: "+X", 2: "+Y", 3: "+Z", -1: "-X", -2: "-Y", -3: "-Z"}
    same = {"type": 58, "binary": 0, "func_type": 1, "id1": "NONE", "rsp_node": 5, "ref_node": 0}
    same |= {"ref_dir": 0, "abscissa_spacing": 1, "x": np.arange(3) / 256, "data": np.arange(3.0)}
    same |= {"ordinate_axis_units_lab": "g"}
    same |= {"orddenom_spec_data_type": 0, "z_axis_spec_data_type": 0}
    pyuff.UFF(str(path)).write_sets([same | {"rsp_dir": code} for code in coded], mode="overwrite")
    assert [c.name for c in read(path).channels] == [f"5{axis}" for axis in coded.values()]
    quantities = {"m": 8, "m/s": 11, "m/s²": 12, "N": 13}
    channels = tuple(Channel(f"c{code}", unit) for unit, code in quantities.items())
    write(replace(recording(channels=4, gaps=()), channels=channels), tmp_path / "quantities.uff")
    written = pyuff.UFF(str(tmp_path / "quantities.uff")).read_sets()
    found = [s["ordinate_spec_data_type"] for s in written if s["type"] == 58]
    assert found == list(quantities.values())


@pytest.mark.parametrize(("start", "step"), [(2e15, 64.0), (0.0, 2e15), (5.0, 0.0)])
def test_uff_of_absurd_times_is_refused(tmp_path, start, step):
    pyuff = pytest.importorskip("pyuff")
    path = tmp_path / "absurd.uff"
    function = {"type": 58, "binary": 0, "func_type": 1, "id1": "B1", "rsp_node": 0, "rsp_dir": 0}
    function |= {"ref_node": 0, "ref_dir": 0, "abscissa_spacing": 1, "data": np.arange(3.0)}
    function |= {"x": start + step * np.arange(3), "ordinate_axis_units_lab": "m/s^2"}
    function |= {"orddenom_spec_data_type": 0, "z_axis_spec_data_type": 0}
    pyuff.UFF(str(path)).write_sets([function], mode="overwrite")
    with pytest.raises(ExchangeError, match=r"dataset 1: time from .* is no time"):
        read(path)


def test_uff_with_uneven_abscissas_is_laid_on_a_grid(tmp_path):
    pyuff = pytest.importorskip("pyuff")
    path = tmp_path / "uneven.unv"
    x = np.array([0.0, 0.01, 0.02, 0.05, 0.06])
    function = {"type": 58, "binary": 0, "func_type": 1, "id1": "B1", "x": x, "data": x * 100}
    function |= {"rsp_node": 0, "rsp_dir": 0, "ref_node": 0, "ref_dir": 0, "abscissa_spacing": 0}
    function |= {"orddenom_spec_data_type": 0, "z_axis_spec_data_type": 0}
    function |= {"ordinate_axis_units_lab": "m/s^2"}
    pyuff.UFF(str(path)).write_sets([function], mode="overwrite")
    found = read(path)
    assert (found.channels[0].name, found.channels[0].unit) == ("B1", "m/s²")
    assert found.values[:, 0] == pytest.approx([0, 1, 2, np.nan, np.nan, 5, 6], nan_ok=True)


def test_a_tdms_whose_end_is_missing_says_so(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    path = tmp_path / "run.tdms"
    timing = {"wf_increment": 0.01, "wf_start_offset": 0.0}
    channel = nptdms.ChannelObject("car", "A1", np.arange(100.0), properties=timing)
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment([channel])
    path.write_bytes(path.read_bytes()[:-80])
    found = read(path)
    assert found.values[:, 0].tolist() == list(range(90))
    assert any("less data than expected" in step for step in found.history)


def test_what_is_written_is_what_other_programs_read(tmp_path):
    """asammdf, pyuff and pyarrow as judges, without our reader."""
    original = recording()
    asammdf, pyuff = pytest.importorskip("asammdf"), pytest.importorskip("pyuff")
    parquet = pytest.importorskip("pyarrow.parquet")
    for suffix in (".mf4", ".uff", ".parquet"):
        write(original, tmp_path / f"run{suffix}")
    with asammdf.MDF(tmp_path / "run.mf4") as mdf:
        signal = mdf.get("A2")
        there = ~original.missing
        assert (signal.samples == original.values[there, 1]).all()
        assert signal.timestamps == pytest.approx(original.time_s[there])
        assert signal.unit == "m/s²" and "ADXL-1" in signal.comment
        assert mdf.header.start_time.timestamp() == original.start_unix_s
    sets = pyuff.UFF(str(tmp_path / "run.uff")).read_sets()
    units, functions = sets[0], sets[1:]
    assert units["units_code"] == 1 and len(functions) == 3 * 3
    last = functions[2]
    assert (last["rsp_ent_name"], last["rsp_node"], last["rsp_dir"]) == ("A1", 1, 3)
    assert (last["data"] == original.values[201:, 0]).all()
    assert last["abscissa_min"] == pytest.approx(original.time_s[201], rel=1e-5)
    table = parquet.read_table(tmp_path / "run.parquet")
    assert table.column_names == ["time_s", "A1", "A2", "A3"]
    assert np.array_equal(table["A3"].to_numpy(), original.values[:, 2], equal_nan=True)
    assert table.schema.field("A3").metadata[b"unit"].decode() == "m/s²"
