"""Binary files of other programs beside what they must give, and ours before theirs."""

import numpy as np
import pytest

from tests.formats.foreign import G
from tests.formats.recordings import recording
from wheelhop.formats import ExchangeError, Map, read, write


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
