"""A log is decoded to what the logger has measured, and to nothing else."""

import tracemalloc
from argparse import Namespace
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.firmware.promises import reader
from tests.logger.session import NAMES, SESSION, blocks_of, header, random_sums, session
from wheelhop.calibration import nominal_constants, write_constants
from wheelhop.cli import decode
from wheelhop.files import InputError
from wheelhop.formats import read
from wheelhop.logger import LoggerError, correct_sensor, correct_window, read_log, survey
from wheelhop.logger.block import pack_block, pack_scans, pack_text
from wheelhop.logger.survey import Verdict

SUMS = random_sums(500)
LOST = (100, 101, 102, 300)


def decoded(log):
    """Sums by scan number, as a reader gets them from a recording."""
    recording = log.recording(by_number=True)
    sums = recording.values * log.settings.conversions
    there = np.flatnonzero(~recording.missing)
    return {int(i): tuple(sums[i].astype(int).tolist()) for i in there}


def test_every_scan_of_a_healthy_session_is_there():
    log = read_log(session(SUMS))
    assert (log.due, log.written, log.missing, log.lost) == (500, 500, 0, 0)
    assert log.damage == () and log.gaps == ()
    recording = log.recording()
    assert np.array_equal(recording.values, SUMS / 8)
    assert [channel.name for channel in recording.channels] == list(NAMES)
    assert {channel.unit for channel in recording.channels} == {"code"}
    assert recording.rate_hz == 100
    assert recording.averaging_s == pytest.approx(10e-3)
    assert recording.start_s == pytest.approx(63 / 2 * 156.25e-6)
    assert recording.start_unix_s == 1790000000
    assert recording.notes["calibration"] == "rig-7"


@pytest.mark.parametrize("channels", range(1, 9))
@pytest.mark.parametrize(("rate", "conversions"), [(100, 8), (200, 4), (400, 2)])
def test_every_setting_decodes(channels, rate, conversions):
    sums = random_sums(300, channels) // (8 // conversions)
    log = read_log(session(sums, rate_hz=rate, conversions=conversions))
    recording = log.recording()
    assert np.array_equal(recording.values * conversions, sums)
    assert recording.averaging_s == pytest.approx(1 / rate)


def test_lost_scans_are_gaps_and_never_samples():
    log = read_log(session(SUMS, lost=LOST))
    assert (log.due, log.written, log.missing, log.lost) == (500, 496, 4, 4)
    assert [(gap.first, gap.scans) for gap in log.gaps] == [(100, 3), (300, 1)]
    recording = log.recording()
    assert np.flatnonzero(recording.missing).tolist() == list(LOST)
    assert "4 of 500 scans are missing" in recording.history[1]


def test_a_damaged_block_costs_that_block():
    blocks = blocks_of(session(SUMS))
    blocks[3][100] ^= 4
    blocks[7] = bytearray(512)
    log = read_log(b"".join(blocks))
    assert [(d.offset, d.blocks, d.verdict) for d in log.damage] == [
        (3 * 512, 1, Verdict.DAMAGED),
        (7 * 512, 1, Verdict.EMPTY),
    ]
    assert log.due == 500 and log.missing == 2 * 37 and log.lost == 0
    gone = {*range(74, 111), *range(222, 259)}
    assert decoded(log) == {i: tuple(SUMS[i].tolist()) for i in set(range(500)) - gone}


def test_scans_without_a_summary_end_with_the_last_good_block():
    data = session(SUMS, close=False)
    stale = session(random_sums(2000, seed=2), session=0x000B_0001)
    log = read_log(data + stale[len(data) :])
    assert log.summary is None and log.damage == ()
    assert decoded(log) == {i: tuple(row) for i, row in enumerate(SUMS.tolist())}
    assert log.behind == len(stale) // 512 - len(data) // 512


def test_more_than_64_damaged_blocks_do_not_hide_the_rest():
    sums = random_sums(37 * 200)
    blocks = blocks_of(session(sums))
    for k in range(50, 150):
        blocks[k] = bytearray(512)
    assert read_log(b"".join(blocks)).written == 37 * 100


def test_a_log_with_a_damaged_header_needs_the_settings_of_another():
    blocks = blocks_of(session(SUMS))
    blocks[0][30] ^= 1
    data = b"".join(blocks)
    log = read_log(data)
    assert log.session == SESSION and log.written == 500
    with pytest.raises(LoggerError, match="--header-from"):
        log.recording()
    other = read_log(session(random_sums(10), session=0x000D_0001))
    log = read_log(data, header_from=other)
    assert np.array_equal(log.recording().values * 8, SUMS)
    assert log.recording().start_unix_s is None


def test_settings_of_another_width_are_noticed():
    data = bytes(512) + session(SUMS)[512:]
    other = read_log(session(random_sums(10, 3)))
    with pytest.raises(LoggerError, match="more than 3 channels"):
        read_log(data, header_from=other).recording()


def test_late_triggers_are_said():
    log = read_log(session(SUMS, late=(200, 210)))
    assert log.late == 2
    said = "late triggers: by 0.3125 ms at the end, "
    assert said + "brought to equal steps" in log.recording().history
    assert said + "rows are by number all the same" in log.recording(by_number=True).history


def test_a_part_is_the_part_of_the_whole():
    log = read_log(session(SUMS, lost=LOST))
    whole, part = log.recording(), log.recording(90, 310)
    assert np.array_equal(whole.values[90:310], part.values, equal_nan=True)
    assert part.time_s == pytest.approx(whole.time_s[90:310])


@given(st.integers(1, 40), st.data())
@settings(max_examples=60, deadline=None)
def test_how_a_file_is_read_makes_no_difference(piece, data):
    """Blocks at any place of a piece, lost scans and damage at any place of the file."""
    lost = data.draw(st.sets(st.integers(0, 499), max_size=20))
    blocks = blocks_of(session(SUMS, lost=lost))
    for k in data.draw(st.sets(st.integers(1, len(blocks) - 1), max_size=5)):
        blocks[k][data.draw(st.integers(0, 511))] ^= 1 << data.draw(st.integers(0, 7))
    raw = b"".join(blocks)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(survey, "PIECE", piece)
        log = read_log(raw)
        found = decoded(log)
    by_the_specification = reader.read_log(raw)
    assert found == by_the_specification.scans
    assert log.session == by_the_specification.session
    assert log.header == by_the_specification.header
    assert log.summary == by_the_specification.summary
    bad = {d.offset // 512 + i for d in log.damage for i in range(d.blocks)}
    assert bad == set(by_the_specification.bad)


def forged(k, **changes):
    """Block k of a session, whole but with other numbers."""
    first = 37 * (k - 1)
    numbers = {"first_scan": first, "count": 37, "payload": pack_scans(SUMS[first : first + 37])}
    return pack_block(b"D", SESSION, k, **(numbers | changes))


@pytest.mark.parametrize(
    "changes",
    [
        {"first_scan": 9000},
        {"first_scan": 111 + 70000, "lost": 70000},
        {"first_scan": 74},
        {"lost": 5},
        {"count": 38},
        {"count": 0},
        {"count": 20},
        {"late": 9},
    ],
    ids=str,
)
@pytest.mark.parametrize("k", [1, 4, 13])
def test_a_block_that_contradicts_the_others_is_no_data(changes, k):
    blocks = blocks_of(session(SUMS[: 37 * 13]))
    if "first_scan" in changes:
        changes = changes | {"first_scan": changes["first_scan"] + 37 * (k - 4)}
        changes["first_scan"] = max(changes["first_scan"], 0) + (k == 1)
    blocks[k] = forged(k, **changes)
    log = read_log(b"".join(blocks))
    for i, sums in decoded(log).items():
        assert sums == tuple(SUMS[i].tolist())
    # A last block that is too short and the summary after it: either may be the false one.
    assert log.due in ((37 * 12 + 20,) if (k, changes.get("count")) == (13, 20) else (37 * 13,))
    assert log.missing <= 37


def test_a_forged_gap_does_not_fill_the_memory():
    blocks = blocks_of(session(SUMS[:74], close=False))
    blocks[2] = forged(2, first_scan=37 + 4_000_000_000, lost=4_000_000_000)
    log = read_log(b"".join(blocks))
    with pytest.raises(LoggerError, match=r"byte 1024: .* 4000000000 scans .* 463 days"):
        log.recording()
    assert np.array_equal(log.recording(0, 37).values * 8, SUMS[:37])


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "empty"),
        (b"time_s,A1\n", "less than one block"),
        (bytes(2048), "no session"),
        (b"HOP3" + bytes(1020), "format version 3"),
    ],
    ids=["nothing", "short", "zeros", "newer"],
)
def test_what_is_no_log_is_refused_in_a_line(tmp_path, data, words):
    file = tmp_path / "HOP00001.HOP"
    file.write_bytes(data)
    with pytest.raises(LoggerError, match=words) as caught:
        read_log(file)
    assert str(file) in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "changes",
    [
        {"rate_hz": 150},
        {"conversions": 4},
        {"channels": "A B C"},
        {"channels": "- - - - - - - -"},
        {"channels": "A A - - - - - -"},
        {"rate_hz": ""},
    ],
    ids=str,
)
def test_a_header_that_makes_no_sense_is_refused(changes):
    text = pack_text(header(**changes))
    data = pack_block(b"H", SESSION, 0, payload=text) + session(SUMS)[512:]
    with pytest.raises(LoggerError, match="header"):
        read_log(data).recording()


def test_an_empty_session_has_no_scans():
    log = read_log(session(np.empty((0, 8), int)))
    assert (log.due, log.written, log.missing) == (0, 0, 0)
    assert log.recording().values.shape == (0, 8)


def test_a_long_log_needs_little_memory(tmp_path):
    file = tmp_path / "HOP00012.HOP"
    payload = pack_scans(SUMS[:37])
    with file.open("wb") as out:
        out.write(session(SUMS)[:512])
        for k in range(1, 80_001):
            first = 37 * (k - 1)
            out.write(pack_block(b"D", SESSION, k, first_scan=first, count=37, payload=payload))
    tracemalloc.start()
    try:
        total = sum(len(numbers) for numbers, _ in read_log(file).scans())
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert total == 37 * 80_000
    assert file.stat().st_size > 40e6
    assert peak < 15e6


def arguments(*files, **changes):
    values = {"files": files, "out": None, "format": None, "calibration": None, "raw": False}
    values |= {"force": False}
    values |= {"sensor_hz": None, "header_from": None, "scans": None}
    return Namespace(**(values | changes))


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_the_command_writes_a_table_with_its_history(tmp_path, capsys, suffix):
    file = tmp_path / "HOP00012.HOP"
    file.write_bytes(session(SUMS, lost=LOST))
    assert decode.run(arguments(file, out=tmp_path / f"run.{suffix}", raw=True)) == 0
    table = read(tmp_path / f"run.{suffix}")
    expected = read_log(file).recording()
    assert np.array_equal(table.values, expected.values, equal_nan=True)
    assert table.history[: len(expected.history)] == expected.history
    assert "4 missing" in capsys.readouterr().out


def test_the_command_corrects_what_is_known(tmp_path):
    file = tmp_path / "HOP00012.HOP"
    file.write_bytes(session(SUMS))
    decode.run(arguments(file, out=tmp_path, format="parquet", sensor_hz=50.0))
    table = read(tmp_path / "HOP00012.parquet")
    assert table.averaging_s == 0
    assert table.rate_hz == pytest.approx(100 / (1 - 1250e-6))
    told = " ".join(table.history)
    assert all(words in told for words in ("averaging", "50 Hz", "-1250 ppm"))


def test_a_calibration_makes_it_acceleration(tmp_path):
    file, constants_file = tmp_path / "HOP00012.HOP", tmp_path / "calibration.toml"
    file.write_bytes(session(SUMS))
    constants = replace(nominal_constants(NAMES), id="rig-7")
    write_constants(constants, constants_file)
    out = tmp_path / "run.parquet"
    decode.run(arguments(file, out=out, calibration=constants_file))
    table = read(out)
    assert {channel.unit for channel in table.channels} == {"m/s²"}
    corrected = correct_sensor(correct_window(read_log(file).recording()), 50.0)
    expected = [
        constants.of(name).gain.value * (corrected.values[:, k] - constants.of(name).offset.value)
        for k, name in enumerate(NAMES)
    ]
    assert np.allclose(table.values, np.transpose(expected), rtol=1e-5, atol=1e-3)


def test_parts_of_a_long_session_fit_together(tmp_path, monkeypatch):
    file = tmp_path / "HOP00012.HOP"
    file.write_bytes(session(SUMS, lost=LOST))
    decode.run(arguments(file, out=tmp_path / "whole.parquet", sensor_hz=50.0))
    monkeypatch.setattr(decode, "PART_SCANS", 130)
    decode.run(arguments(file, out=tmp_path / "part.parquet", sensor_hz=50.0))
    whole = read(tmp_path / "whole.parquet")
    parts = [read(path) for path in sorted(tmp_path.glob("part-*.parquet"))]
    assert len(parts) == 4
    values = np.concatenate([part.values for part in parts])
    assert np.allclose(values, whole.values, rtol=0, atol=1e-9, equal_nan=True)
    assert np.concatenate([part.time_s for part in parts]) == pytest.approx(whole.time_s)


@pytest.mark.parametrize("first", [2**32 - 100, 2**32 - 37, 2**32 - 1])
def test_scan_numbers_may_pass_two_to_the_thirty_two(first):
    """A card that was away for months: everything before the first block behind it is lost."""
    sums, healthy = random_sums(300), blocks_of(session(SUMS[:37], close=False))
    starts = range(0, 300, 37)
    for k, at in enumerate(starts):
        lost = first - 37 + (5 if k >= 4 else 0)  # and five more that are lost on the way
        number = first + at + (5 if k >= 4 else 0)
        place = {"first_scan": number % 2**32, "lost": lost % 2**32}
        rows = sums[at : at + 37]
        healthy.append(
            pack_block(b"D", SESSION, 2 + k, count=len(rows), payload=pack_scans(rows), **place)
        )
    log = read_log(b"".join(healthy))
    assert log.written == 337 and log.damage == ()
    assert log.due == first + 305
    found = np.concatenate([rows for _, rows in log.scans(first)])
    assert np.array_equal(found, sums)
    numbers = np.concatenate([numbers for numbers, _ in log.scans(first)])
    assert numbers[0] == first and set(np.diff(numbers)) == {1, 6}


def test_nothing_is_decoded_over_a_file_that_is_there(tmp_path):
    """Nor are two logs of the same name, from two cards, over each other."""
    for card in ("a", "b"):
        (tmp_path / card).mkdir()
        (tmp_path / card / "HOP00012.HOP").write_bytes(session(SUMS))
    logs, out = sorted(tmp_path.glob("*/*.HOP")), tmp_path / "out"
    with pytest.raises(LoggerError, match="two logs"):
        decode.run(arguments(*logs, out=out))
    assert not out.exists()
    decode.run(arguments(logs[0], out=out))
    table = out / "HOP00012.csv"
    table.write_text("edited")
    with pytest.raises(InputError, match="--force"):
        decode.run(arguments(logs[1], out=out))
    assert table.read_text() == "edited"
    decode.run(arguments(logs[1], out=out, force=True))
    assert len(read(table).values) == len(read_log(logs[1]).recording().values)
