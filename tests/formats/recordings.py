"""Recordings to write and read, small ones and any that hypothesis can think of."""

import struct

import numpy as np
from hypothesis import strategies as st

from wheelhop.formats.header import SAMPLES, sidecar
from wheelhop.logger.recording import Channel, Recording

SUFFIXES = (".csv", ".parquet", ".mf4", ".uff")
NAMES = ("A1", "A2", "A3", "A4", "B1", "B2", "B3", "B4")


def recording(rows=400, channels=3, rate_hz=100.0, gaps=((50, 60), (200, 201)), **changes):
    rng = np.random.default_rng(1)
    values = rng.normal(size=(rows, channels))
    for start, stop in gaps:
        values[start:stop] = np.nan
    facts = {
        "start_s": 0.0049609375,
        "averaging_s": 0.01,
        "start_unix_s": 1790000000.25,
        "history": ("decoded from HOP00012.HOP", 'said "no", twice: A1 × 2'),
        "notes": {"device": "7", "name with = and ü": "line\nline\t\x7f"},
    }
    return Recording(
        values=values,
        rate_hz=rate_hz,
        channels=tuple(
            Channel(name, "m/s²", name, f"ADXL-{k}", "bench-3")
            for k, name in enumerate(NAMES[:channels])
        ),
        **(facts | changes),
    )


def believed(path):
    """The header beside `path` no longer says which samples it is of."""
    lines = sidecar(path).read_text(encoding="utf-8").splitlines(keepends=True)
    kept = [line for line in lines if not line.startswith(SAMPLES)]
    assert len(kept) == len(lines) - 1
    sidecar(path).write_text("".join(kept), encoding="utf-8")


def same_bits(one, other):
    """Equal to the last bit, and all that is not a number at the same places."""
    return one.shape == other.shape and bool(
        ((one.view(np.uint64) == other.view(np.uint64)) | (np.isnan(one) & np.isnan(other))).all()
    )


def assert_same(one, other):
    """Every field of two recordings is the same."""
    assert same_bits(np.ascontiguousarray(one.values), np.ascontiguousarray(other.values))
    for field in ("rate_hz", "start_s", "averaging_s", "start_unix_s", "channels", "history"):
        assert getattr(one, field) == getattr(other, field), field
    assert dict(one.notes) == dict(other.notes)


def _float(bits):
    return struct.unpack("<d", struct.pack("<Q", bits))[0]


finite = st.integers(0, 2**64 - 1).map(_float).filter(np.isfinite)  # any bits there are
texts = st.text(st.characters(exclude_categories=("Cs",)), max_size=12)
plain_names = st.text(
    st.characters(categories=("L", "N", "P", "S"), exclude_characters=',"'), min_size=1, max_size=9
).filter(lambda name: name != "time_s")


@st.composite
def any_recording(draw):
    """A recording with whole rows missing, at least one row being there."""
    rows, channels = draw(st.integers(1, 12)), draw(st.integers(1, 3))
    flat = st.lists(finite, min_size=rows * channels, max_size=rows * channels)
    values = np.array(draw(flat), dtype=np.float64).reshape(rows, channels)
    gone = np.array(draw(st.lists(st.booleans(), min_size=rows, max_size=rows)))
    gone[draw(st.integers(0, rows - 1))] = False
    values[gone] = np.nan
    names = draw(st.lists(plain_names, min_size=channels, max_size=channels, unique=True))
    points = st.sampled_from(("", "A1", "B4", "body"))
    units = st.sampled_from(("m/s²", "code", "V", "", "weird µ²"))
    return Recording(
        values=values,
        rate_hz=draw(st.floats(1e-2, 1e4)),
        channels=tuple(
            Channel(name, draw(units), draw(points), draw(texts), draw(texts)) for name in names
        ),
        start_s=draw(st.floats(-1e3, 1e6)),
        averaging_s=draw(st.floats(0, 1)),
        start_unix_s=draw(st.none() | st.floats(0, 4e9)),
        history=tuple(draw(st.lists(texts, max_size=3))),
        notes=draw(st.dictionaries(texts, texts, max_size=3)),
    )
