"""One screen that tells the truth about a log."""

from argparse import Namespace

import numpy as np
import pytest

from tests.logger.session import SESSION, blocks_of, random_sums, session
from wheelhop.cli import info
from wheelhop.logger import describe, read_log, recover
from wheelhop.logger.block import DATA, SUMMARY, SUPPLY, pack_block, pack_text

SUMS = random_sums(500)


def line(text, title):
    """What stands behind a title."""
    (found,) = [row for row in text.splitlines() if row.startswith(f"  {title:<12}")]
    return found[14:]


def test_a_healthy_log():
    text = describe(read_log(session(SUMS)))
    assert text.startswith("log: session 12 of logger 3, firmware 1.0.0\n")
    assert line(text, "scans") == "500 due, 500 written, 0 missing"
    assert line(text, "start") == "2026-09-21 14:13:20 UTC"
    assert line(text, "duration") == "5.00 s, 100 scans a second"
    assert line(text, "clock") == "-1250 ppm"
    assert line(text, "card") == "longest stall 41 ms, memory 5 of 45 scans, 0 errors"
    assert "!" not in text
    assert max(map(len, text.splitlines())) < 100


@pytest.mark.parametrize(
    ("continues", "told"),
    [("000B1234", "with HOP00011.HOP, after a reset or a full file"), ("?", None), ("", None)],
)
def test_a_file_that_goes_on_with_another_says_so(continues, told):
    text = describe(read_log(session(SUMS, continues=continues)))
    assert line(text, "goes on") == told if told else "goes on" not in text


def test_lost_and_damaged_scans_are_told_apart():
    blocks = blocks_of(session(SUMS, lost=[100, 101, 400]))
    blocks[9][77] ^= 2
    text = describe(read_log(b"".join(blocks)))
    assert line(text, "scans").endswith("40 missing: 3 lost by the logger, 37 damaged since")
    assert "3 gaps:" in text and "2 scans from 100 on at 1.00 s" in text
    assert "1 block from byte 4608 on: damaged" in text


def test_ranges_are_those_of_the_samples():
    sums = SUMS.copy()
    sums[:5, 2] = 8 * 1023
    text = describe(read_log(session(sums)))
    row = next(row for row in text.splitlines() if row.startswith("  B3")).split()
    codes = sums[:, 2] / 8
    found = np.array(row[1:4], float)
    assert found == pytest.approx([codes.min(), codes.mean(), codes.max()], abs=0.006)
    assert row[4:] == ["5", "scans", "clipped"]


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (session(SUMS, close=False), "not closed"),
        (session(SUMS, late=[3]), "late triggers: scans at the end are 0.15625 ms late"),
        (session(SUMS, config_errors=2), "2 lines of HOP.CFG"),
        (session(SUMS, close=False)[:-100], "412 bytes behind the last whole block"),
        (bytes(512) + session(SUMS)[512:], "header is damaged"),
    ],
    ids=["open", "late", "config", "cut", "header"],
)
def test_what_should_be_known_is_said(data, words):
    warned = [row for row in describe(read_log(data)).splitlines() if row.startswith("  ! ")]
    assert any(words in row for row in warned)


def test_a_name_that_belongs_to_another_session_is_noticed(tmp_path, capsys):
    for name, suspicious in [("HOP00012.HOP", False), ("HOP00013.HOP", True), ("x.HOP", False)]:
        (tmp_path / name).write_bytes(session(SUMS))
        assert info.run(Namespace(files=[tmp_path / name], header_from=None, json=None)) == 0
        assert ("the name says session 13" in capsys.readouterr().out) == suspicious


def test_a_log_whose_header_is_only_numbers_of_another_kind_is_described_all_the_same():
    text = b"rate_hz=x\nunix_s=1e300\nclock_ppm=nan\nsupply_mv=-\nchannels=A B\n"
    data = pack_block(b"H", SESSION, 0, payload=text) + session(SUMS)[512:]
    told = describe(read_log(data))
    assert line(told, "rate") == "unknown"
    assert "is no date" in line(told, "start")


def with_supply(readings, **ends):
    """A log of 60 scans with blocks about its supply, before its last data block."""
    first, second, *rest = blocks_of(session(random_sums(60)))[:3]
    blocks = [first, second]
    for scan, mv in readings:
        text = pack_text({"supply_mv": mv, "scan": scan})
        blocks.append(pack_block(SUPPLY, SESSION, len(blocks), first_scan=37, payload=text))
    scans = bytes(rest[0][24:510])
    blocks.append(pack_block(DATA, SESSION, len(blocks), first_scan=37, count=23, payload=scans))
    if ends:
        text = pack_text({"due": 60, "written": 60, "lost": 0, **ends})
        blocks.append(pack_block(SUMMARY, SESSION, len(blocks), first_scan=60, payload=text))
    return b"".join(map(bytes, blocks))


def test_a_sag_of_the_supply_is_told_in_a_sentence():
    sagged = read_log(with_supply([(16, 2950), (48, 3300)], supply_mv=3290, lowest_mv=2950))
    assert sagged.missing == 0 and not sagged.damage
    assert sagged.lowest_supply == (16, 2950)
    text = describe(sagged)
    assert "3300 mV, 3290 mV, lowest 2950 mV" in text
    assert "! the sensors' supply fell from 3300 to 2950 mV (-11 %) at 0.16 s" in text


def test_a_sag_is_told_of_a_log_that_was_not_closed_and_by_its_summary_alone():
    assert "to 2950 mV (-11 %) at 0.16 s" in describe(read_log(with_supply([(16, 2950)])))
    assert "to 3000 mV (-9 %) in between" in describe(read_log(with_supply([], lowest_mv=3000)))
    steady = describe(read_log(with_supply([], supply_mv=3300, lowest_mv=3290)))
    assert "lowest 3290 mV" in steady and "fell" not in steady


def test_a_recovered_copy_still_knows_of_the_sag(tmp_path):
    image = tmp_path / "card.img"
    image.write_bytes(with_supply([(16, 2950)]))
    (copy,) = recover(image, tmp_path / "out")
    assert read_log(copy.path).lowest_supply == (-1, 2950)
