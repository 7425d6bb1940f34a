"""Kinds of files that once came in silently wrong, of each a small one as its logger writes it and
three more: the draft is imported as it is, or says what has to be answered or why it is refused."""

from math import sin

import numpy as np
import pytest

from tests.formats.foreign import G, save
from wheelhop.formats import ExchangeError, Map, draft_mapping, parse_mapping, read

ROWS = 300
WAVE = [sin(0.2 * k) for k in range(ROWS)]
HUNDREDTHS = np.arange(ROWS)
EPOCH_MS = 1762640265216  # 2025-11-08T22:17:45.216Z
SPEED = 1 / 3.6


def lines(head, row, separator=",", decimal=".", quote="", without=()):
    """A text: its head, and `row(k)` cells of the rows that were written."""
    rows = (
        separator.join(f"{quote}{cell}{quote}".replace(".", decimal) for cell in row(k))
        for k in range(ROWS)
        if k not in without
    )
    return "\n".join([head, *rows]) + "\n"


def wave(k, scale=1.0, digits=4):
    return f"{scale * WAVE[k]:.{digits}f}"


def clock(since, form="{m:02}:{s:05.2f}"):
    """Stamps from `since` seconds of the day on, at 100 Hz."""

    def row(k):
        seconds = since + k / 100
        h, m = int(seconds // 3600), int(seconds // 60)
        return [form.format(h=h, m=m % 60, M=m, s=seconds % 60), wave(k)]

    return row


def counted(first, *others):
    return lambda k: [str(first + k), *others, wave(k)]


def millis(start=0):
    return lambda k: [str(start + 10 * k), wave(k)]


LATE = ["Time (s),GPS Speed (km/h),Acc (g)", "Time (s),Acc (g),GPS Speed (km/h)"]
DYNO = "Timestamp,Force (V),Force (N),Displacement (V),Displacement (mm)"
ISO = "2025-11-14 19:48:{s:09.6f}"
DE = {"decimal": ",", "quote": '"'}
PICOQUAKE = "# Config: data_rate = 2000.0 Hz, filter = 488 Hz, acc_range = 4 g\n"
GAP = {"without": range(200, 230)}


def late(k, order=1, until=80):
    speed = "" if k < until else f"{20 + k / 100:.2f}"
    return [f"{k / 100:.2f}", *[speed, wave(k)][::order]]


def dyno(k):
    stamp = ISO.format(s=5 + round(k / 300, 6))
    return [stamp, wave(k, 0.01, 6), wave(k), "5.18", wave(k, 10)]


TEXTS = {
    "mm:ss": [
        (lines("Time,az [g]", clock(0)), 100, {"az": G}),
        (lines("Zeit;az [g]", clock(59), ";", ","), 100, {"az": G}),
        (lines("Lap time\taz [g]", clock(3598.5, "{m}:{s:06.3f}"), "\t"), 100, {"az": G}),
        (lines("Time,az [g]", clock(36000, "{h:02}:{m:02}:{s:05.2f}")), 100, {"az": G}),
    ],
    "a counter is no time": [
        (lines(PICOQUAKE + "count,a_z", counted(0)), 2000, {"a_z": 1.0}),
        (lines("Sample rate,1.6,kHz\nSample,az [g]", counted(1)), 1600, {"az": G}),
        (lines("Abtastrate: 0,5 kHz\nNr;az [g]", counted(5), ";", ","), 500, {"az": G}),
        (lines("index,az [g]", counted(0)), "rate_hz", {}),
    ],
    "a counter with gaps": [
        (lines("Sampling freqeuncy: 500 Hz\nno,az [g]", counted(1), **GAP), 500, {"az": G}),
        (lines("fs = 250 Hz\nseq\taz [g]", counted(7), "\t", **GAP), 250, {"az": G}),
        (lines("Scan interval: 5 ms\nscan;az [g]", counted(0), ";", ",", **GAP), 200, {"az": G}),
        (lines("frame,az [g]", counted(0), **GAP), "rate_hz", {}),
    ],
    "names that differ by their units": [
        (lines(DYNO, dyno), 300, {"Force (V)": 0.01, "Force (N)": 1.0, "Displacement (mm)": 0.01}),
        (
            lines("time [s],F [N],F [V]", lambda k: [f"{k / 100:.2f}", wave(k), wave(k, 2)]),
            *(100, {"F (N)": 1.0, "F (V)": 2.0}),
        ),
        (
            lines("time [s],x,x\n,mm,V", lambda k: [f"{k / 100:.2f}", wave(k), wave(k, 2)]),
            *(100, {"x (mm)": 0.001, "x (V)": 2.0}),
        ),
        (
            lines("time [s],x [mm],x [mm]", lambda k: [f"{k / 100:.2f}", wave(k), wave(k, 2)]),
            *(100, {"x (mm) (column 2)": 0.001, "x (mm) (column 3)": 0.002}),
        ),
    ],
    "milliseconds in the header": [
        (lines("Elapsed [ms],A1 (g)", millis()), 100, {"A1": G}),
        (lines("elapsed_ms;A1 (g)", millis(1000), ";", ","), 100, {"A1": G}),
        (lines("millis\tA1 (g)", millis(), "\t"), 100, {"A1": G}),
        (lines("Elapsed,A1 (g)", millis()), "time_unit", {}),
    ],
    "since 1970": [
        (lines("time,az [g]", millis(EPOCH_MS)), 100, {"az": G}),
        (
            lines("time,az [g]", lambda k: [f"{EPOCH_MS + 10 * k}000000", wave(k)]),
            *(100, {"az": G}),
        ),
        (
            lines("ts;az [g]", lambda k: [f"{EPOCH_MS / 1000 + k / 100:.3f}", wave(k)], ";", ","),
            *("time_unit", {}),
        ),
        (lines("timestamp|az [g]", millis(EPOCH_MS), "|"), 100, {"az": G}),
    ],
    "a channel that begins later": [
        (lines(LATE[0], late), 100, {"Acc": G}),
        (lines(LATE[1], lambda k: late(k, -1)), 100, {"Acc": G}),
        (lines(LATE[0].replace(",", ";"), late, ";", ","), 100, {"Acc": G}),
        (lines(LATE[1], lambda k: late(k, -1, 299)), 100, {"Acc": G}),
    ],
    "quoted decimal commas": [
        (lines('"Time","AccZ"\n"s","g"', millis(), **DE), "time_unit", {}),  # 10 s a step
        (lines('"Time","AccZ"\n"ms","g"', millis(), **DE), 100, {"AccZ": G}),
        (lines('"t [s]","z [g]"', lambda k: [f"{k / 50:.2f}", wave(k)], **DE), 50, {"z": G}),
        (lines("Time [s],AccZ [g]", lambda k: [f"{k / 100:.2f}", wave(k)], **DE), 100, {"AccZ": G}),
    ],
    "units of loggers": [
        (lines(f"Time (s),A ({unit})", lambda k: [f"{k / 100:.2f}", wave(k)]), 100, {"A": factor})
        for unit, factor in (
            *(("G", G), ("m/s/s", 1.0), ("lbs", 4.4482216152605), ("in/s", 0.0254)),
            *(("MPH", 0.44704), ("Km/h", SPEED), ("inch", 0.0254), ("ft-lb", 1.3558179483314)),
        )
    ],
}


@pytest.mark.parametrize(
    ("kind", "number"), [(kind, k) for kind, cases in TEXTS.items() for k in range(len(cases))]
)
def test_the_draft_of_a_text_imports_as_it_is_or_says_what_must_be_answered(kind, number, tmp_path):
    text, rate_hz, channels = TEXTS[kind][number]
    path = save(tmp_path, "run.csv", text)
    draft = draft_mapping(path)
    if isinstance(rate_hz, str):
        with pytest.raises(ExchangeError, match=f"still to be answered: {rate_hz}"):
            parse_mapping(draft, path)
        return
    found = read(path, parse_mapping(draft, path))
    gap = 30 if "gaps" in kind else 0
    assert (found.rate_hz, len(found.values)) == (pytest.approx(rate_hz), ROWS)
    assert int(np.isnan(found.values).all(axis=1).sum()) == gap
    if kind == "since 1970":
        assert found.start_unix_s == pytest.approx(EPOCH_MS / 1000, abs=1e-3)
    values = dict(zip([channel.name for channel in found.channels], found.values.T, strict=True))
    for name, scale in channels.items():
        there = ~np.isnan(values[name])
        assert there.sum() == ROWS - gap
        assert values[name][there] == pytest.approx(np.array(WAVE)[there] * scale, abs=1e-4 * G)


def in_parquet(stamps, **mapping):
    def make(tmp_path):
        import pyarrow
        from pyarrow import parquet

        table = pyarrow.table({"when": stamps, "A1": pyarrow.array(WAVE)})
        parquet.write_table(table, tmp_path / "log.parquet")
        return tmp_path / "log.parquet", Map(time="when", **mapping)

    return make


def in_tdms(**properties):
    def make(tmp_path):
        nptdms = pytest.importorskip("nptdms")
        about = {"wf_increment": 0.01, "wf_start_offset": 0.0, "unit_string": "g", **properties}
        with nptdms.TdmsWriter(tmp_path / "run.tdms") as writer:
            writer.write_segment([nptdms.ChannelObject("car", "A1", np.array(WAVE), about)])
        return tmp_path / "run.tdms", None

    return make


def in_mdf(version="4.10", suffix=".mf4", kind=1):
    def make(tmp_path):
        asammdf = pytest.importorskip("asammdf")
        master = ("master", kind)
        signal = asammdf.Signal(
            np.array(WAVE), HUNDREDTHS / 100, name="A1", unit="g", master_metadata=master
        )
        path = tmp_path / ("ecu.mf4" if version[0] == "4" else "ecu.mdf")
        with asammdf.MDF(version=version) as mdf:
            mdf.append([signal])
            mdf.save(path)
        return path.rename(path.with_suffix(suffix)), None

    return make


def in_uff(*sets, step=0.01):
    def make(tmp_path):
        pyuff = pytest.importorskip("pyuff")
        same = {"type": 58, "binary": 0, "func_type": 1, "ref_node": 0, "ref_dir": 0, "rsp_node": 1}
        same |= {"rsp_dir": 3, "abscissa_spacing": 1, "ordinate_axis_units_lab": "g"}
        same |= {"orddenom_spec_data_type": 0, "z_axis_spec_data_type": 0, "id1": "Hub acc"}
        same |= {"x": step * HUNDREDTHS, "data": np.array(WAVE)}
        path = tmp_path / "run.uff"
        pyuff.UFF(str(path)).write_sets([same | one for one in sets], mode="overwrite")
        return path, None

    return make


UNKNOWN = {"NI_Number_Of_Scales": 1, "NI_Scaling_Status": "unscaled"}
SPECTRUM, LOOP = "this is a spectrum", "this is a loop"
STAMPS = (np.datetime64("2026-05-01T12:00:00") + 10 * HUNDREDTHS.astype("timedelta64[ms]")).tolist()
FORCE = {"id1": "Force", "ordinate_axis_units_lab": "N"}
PACKED = {
    "the mapping's unit of time in Parquet": [
        (in_parquet(10 * HUNDREDTHS, time_unit="ms"), {"A1": 1.0}),
        (in_parquet(10_000 * HUNDREDTHS, time_unit="us"), {"A1": 1.0}),
        (in_parquet(STAMPS, time_unit="clock"), {"A1": 1.0}),
        (in_parquet(HUNDREDTHS, time_unit="sample", rate_hz=100.0), {"A1": 1.0}),
    ],
    "an x of TDMS that is no time": [
        (in_tdms(wf_xunit_string="Hz"), SPECTRUM),
        (in_tdms(wf_xname="Frequency"), SPECTRUM),
        (in_tdms(wf_xunit_string="mm"), LOOP),
        (in_tdms(wf_xunit_string="ms", wf_increment=10.0), {"A1": G}),
    ],
    "a scaling of TDMS that is not known": [
        *(
            (in_tdms(**UNKNOWN, **{"NI_Scale[0]_Scale_Type": kind}), {"A1": 1.0})
            for kind in ("PieceWisePolynomial", "Rosette", "Map")
        ),
        (in_tdms(NI_Number_Of_Scales=0), {"A1": G}),
    ],
    "a master of MDF that is no time": [
        (in_mdf(kind=2), "sampled over an angle"),
        (in_mdf(kind=3), "sampled over a distance"),
        (in_mdf(kind=4), "sampled over an index"),
        (in_mdf(kind=1), {"A1": G}),
    ],
    "MDF 3": [
        (in_mdf(version, suffix), {"A1": G})
        for version in ("3.00", "3.30")
        for suffix in (".mdf", ".dat")
    ],
    "the unit of an abscissa in UFF": [
        (in_uff({"abscissa_axis_units_lab": "ms"}, step=10.0), {"1+Z": G}),
        (in_uff({"abscissa_axis_units_lab": "SEC"}), {"1+Z": G}),
        (in_uff({"abscissa_axis_units_lab": "us"}, step=1e4), {"1+Z": G}),
        (in_uff({"abscissa_axis_units_lab": "rev"}), "abscissa is rev, not time"),
    ],
    "two sensors at one node": [
        (in_uff({}, {"id1": "Body acc"}, {"rsp_node": 2}), {"Hub acc": G, "Body acc": G}),
        (in_uff({}, FORCE, {"rsp_node": 2}), {"Hub acc": G, "Force": 1.0}),
        (in_uff({}, {"id1": "x"}, {"id1": "y"}, {"rsp_node": 2}), {"Hub acc": G, "x": G, "y": G}),
        (in_uff({}, {}), "were not sampled together"),  # two runs
    ],
}


@pytest.mark.parametrize(
    ("kind", "number"), [(kind, k) for kind, cases in PACKED.items() for k in range(len(cases))]
)
def test_a_packed_file_comes_in_right_or_not_at_all(kind, number, tmp_path):
    make, due = PACKED[kind][number]
    path, mapping = make(tmp_path)
    if isinstance(due, str):
        with pytest.raises(ExchangeError, match=due):
            read(path, mapping)
        return
    found = read(path, mapping or parse_mapping(draft_mapping(path), path))
    assert (found.rate_hz, len(found.values)) == (pytest.approx(100.0), ROWS)
    values = dict(zip([channel.name for channel in found.channels], found.values.T, strict=True))
    for name, scale in due.items():
        assert values[name] == pytest.approx(np.array(WAVE) * scale, abs=1e-4 * G)
