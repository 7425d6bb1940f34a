"""Damaged files: a recording or one line, whatever the bytes are.

WHEELHOP_FUZZ=N tries N damaged files of each format in place of a few.
"""

import gc
import os

import numpy as np
import pytest

from tests.formats.foreign import GERMAN, LVM, ONE
from tests.formats.recordings import recording
from wheelhop.formats import ExchangeError, Map, draft_mapping, read, read_mapping, write
from wheelhop.formats.header import sidecar
from wheelhop.logger.recording import Recording

TRIES = int(os.environ.get("WHEELHOP_FUZZ", "120"))
MAPPING = """\
format = 1
separator = ";"
decimal = ","
header_row = 2
units_row = 3
time = "Zeit"
[[channel]]
column = "Achse vl"
name = "A1"
scale = 2.0
"""
SPLICES = (b"nan", b"-1", b"1e999", b"\x00" * 8, b"\xff" * 8, b"\n", b",", b'"', b"[", b"    -1\n")


@pytest.fixture(autouse=True)
def quick_collection():
    """Reading damaged MDF collects garbage: not all of this session's each time."""
    gc.freeze()
    yield
    gc.unfreeze()


def damage(data: bytes, rng: np.random.Generator) -> bytes:
    """A few wrong bits, bytes, cuts, copies or insertions."""
    broken = bytearray(data)
    for _ in range(rng.integers(1, 5)):
        at = int(rng.integers(0, len(broken) + 1))
        length = int(rng.integers(0, 40))
        kind = rng.integers(0, 6)
        if kind == 0 and at < len(broken):
            broken[at] ^= 1 << int(rng.integers(0, 8))
        elif kind == 1 and at < len(broken):
            broken[at] = int(rng.integers(0, 256))
        elif kind == 2:
            del broken[at : at + length]
        elif kind == 3:
            broken[at:at] = broken[int(rng.integers(0, len(broken) + 1)) :][:length]
        elif kind == 4:
            broken[at:at] = SPLICES[int(rng.integers(0, len(SPLICES)))]
        elif rng.integers(0, 4) == 0:
            del broken[at:]
    return bytes(broken)


def tdms(path):
    nptdms = pytest.importorskip("nptdms")
    values = np.arange(20.0)
    timing = {"wf_increment": 0.01, "wf_start_offset": 0.0, "unit_string": "g"}
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment([nptdms.ChannelObject("car", "A1", values, properties=timing)])


def make(path):
    """A small healthy file."""
    if path.suffix == ".tdms":
        tdms(path)
    elif path.suffix == ".lvm":
        second = ONE.format(second=40.0234375)
        text = LVM.format(x_columns="One") + ONE.format(second=40.0) + "\n" + second
        path.write_text(text.replace("40.", "40,"))
    elif path.suffix == ".txt":
        path.write_bytes(GERMAN.encode("cp1252"))
    else:
        write(recording(rows=12, channels=2, gaps=((4, 6),)), path)


def check(path, seed, act):
    try:
        found = act()
    except ExchangeError as error:
        assert "\n" not in str(error) and str(path.parent) in str(error), seed
    else:
        if isinstance(found, Recording):
            assert found.values.dtype == np.float64 and len(found.channels) > 0, seed
            assert found.rate_hz > 0 and len(found.time_s) == len(found.values), seed


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".mf4", ".uff", ".tdms", ".lvm", ".txt"])
def test_a_damaged_file_gives_a_line_or_a_recording(suffix, tmp_path):
    path = tmp_path / f"run{suffix}"
    make(path)
    mapping = read_mapping(written(tmp_path / "map.toml", MAPPING)) if suffix == ".txt" else None
    healthy = path.read_bytes()
    assert isinstance(read(path, mapping), Recording)
    for seed in range(TRIES):
        path.write_bytes(damage(healthy, np.random.default_rng(seed)))
        check(path, seed, lambda: read(path, mapping))


@pytest.mark.parametrize("suffix", [".csv", ".uff"])
def test_a_damaged_sidecar_gives_a_line_or_a_recording(suffix, tmp_path):
    path = tmp_path / f"run{suffix}"
    make(path)
    healthy = sidecar(path).read_bytes()
    for seed in range(TRIES):
        sidecar(path).write_bytes(damage(healthy, np.random.default_rng(seed)))
        check(path, seed, lambda: read(path))


def test_a_damaged_mapping_gives_a_line_or_a_mapping(tmp_path):
    path = tmp_path / "map.toml"
    make(tmp_path / "run.txt")
    for seed in range(TRIES):
        path.write_bytes(damage(MAPPING.encode(), np.random.default_rng(seed)))
        check(path, seed, lambda: read(tmp_path / "run.txt", read_mapping(path)))


def test_a_draft_of_anything_is_a_line_or_a_mapping_that_can_be_read(tmp_path):
    path = tmp_path / "run.txt"
    for seed in range(TRIES):
        rng = np.random.default_rng(seed)
        path.write_bytes(damage(GERMAN.encode("cp1252"), rng))

        def draft() -> Map:
            return read_mapping(written(tmp_path / "map.toml", draft_mapping(path)))

        check(path, seed, draft)


def written(path, text):
    path.write_text(text, encoding="utf-8")
    return path
