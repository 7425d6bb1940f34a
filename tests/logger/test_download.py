"""Downloads: the file that gets its name is the card's, whatever happened on the way."""

import subprocess
import sys

import pytest

from tests.firmware.promises.reader import read_log
from tests.patience import wait_until
from wheelhop.cli.download import choose
from wheelhop.hil_sim.double import DoubleFaults, SerialDouble
from wheelhop.logger import LoggerError
from wheelhop.logger.block import BLOCK_BYTES, DATA, HEADER, SUMMARY, pack_block
from wheelhop.logger.download import Downloader
from wheelhop.logger.link import connect

FACTOR = 20.0
NAME = "HOP00001.HOP"
SESSION = 0x1_0777


def log_bytes(blocks, session=SESSION):
    """A log of so many blocks."""
    kinds = [HEADER, *[DATA] * (blocks - 2), SUMMARY]
    return b"".join(
        pack_block(kind, session, k, payload=bytes([k % 251 + 1]) * 486)
        for k, kind in enumerate(kinds)
    )


@pytest.fixture
def card(tmp_path):
    folder = tmp_path / "card"
    folder.mkdir()
    (folder / NAME).write_bytes(log_bytes(150))
    return folder


@pytest.fixture
def out(tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    return folder


def fetch(double, out, progress=lambda done, size: None):
    """Download the first file."""
    downloader = Downloader(connect(double.url), patience_s=20.0)
    try:
        return downloader.download(NAME, downloader.link.files()[NAME], out, progress)
    finally:
        downloader.close()


def test_a_file_arrives_as_it_is_on_the_card(card, out):
    told = []
    with SerialDouble(card=card, factor=FACTOR) as double:
        one = fetch(double, out, lambda done, size: told.append((done, size)))
        again = fetch(double, out)
    assert one.path == out / NAME and one.path.read_bytes() == (card / NAME).read_bytes()
    assert (one.size, one.damaged, one.fresh) == (150 * 512, 0, True)
    assert told[-1] == (one.size, one.size) and told == sorted(told)
    assert again.path == one.path and not again.fresh
    assert [path.name for path in out.iterdir()] == [NAME]


def test_a_session_recorded_by_the_logger_arrives(card, out):
    (card / NAME).unlink()
    with SerialDouble(card=card, factor=FACTOR) as double:
        with connect(double.url) as link:
            link.start()
            wait_until(lambda: double.totals["due"] > 150)
            link.stop()
        one = fetch(double, out)
    log = read_log(one.path.read_bytes())
    assert len(log.scans) == int(log.summary["due"]) > 100


def test_a_bad_line_costs_time_and_nothing_else(card, out):
    faults = DoubleFaults(noise=2e-4, dropped=1e-4, duplicated=1e-4)
    with SerialDouble(card=card, faults=faults, factor=FACTOR) as double:
        one = fetch(double, out)
    assert one.path.read_bytes() == (card / NAME).read_bytes()


def test_a_line_that_goes_and_comes_back_is_waited_for(card, out):
    with SerialDouble(card=card, factor=2.0) as double:
        torn = []

        def tear(done, size):
            if not torn and done < size:
                torn.append(done)
                double.tear(1.0)

        one = fetch(double, out, tear)
    assert torn and one.path.read_bytes() == (card / NAME).read_bytes()


def test_what_a_killed_download_has_left_is_gone_on_with(card, out):
    part = out / f"{NAME}.part"
    whole = (card / NAME).read_bytes()
    part.write_bytes(whole[: 130 * BLOCK_BYTES + 77])  # torn within a block
    told = []
    with SerialDouble(card=card, factor=FACTOR) as double:
        one = fetch(double, out, lambda done, size: told.append(done))
    assert told == [150 * BLOCK_BYTES] and one.path.read_bytes() == whole and not part.exists()


@pytest.mark.parametrize("harm", ["another session", "zeros", "a flipped bit"])
def test_a_part_that_is_not_sound_is_not_believed(card, out, harm):
    whole = (card / NAME).read_bytes()
    wrong = bytearray(whole[: 100 * BLOCK_BYTES])
    if harm == "another session":
        wrong[:] = log_bytes(100, SESSION + 1)
    elif harm == "zeros":  # a computer that lost its power
        wrong[60 * BLOCK_BYTES :] = bytes(40 * BLOCK_BYTES)
    else:
        wrong[50 * BLOCK_BYTES + 300] ^= 4
    (out / f"{NAME}.part").write_bytes(wrong)
    with SerialDouble(card=card, factor=FACTOR) as double:
        one = fetch(double, out)
    assert one.path.read_bytes() == whole and one.damaged == 0


def test_another_file_of_the_name_is_left_alone(card, out):
    other = b"somebody's notes"
    (out / NAME).write_bytes(other)
    (out / "HOP00001-2.HOP").write_bytes(log_bytes(150, SESSION + 9))
    with SerialDouble(card=card, factor=FACTOR) as double:
        one, again = fetch(double, out), fetch(double, out)
    assert (out / NAME).read_bytes() == other
    assert one.path.name == "HOP00001-3.HOP" == again.path.name and not again.fresh
    assert one.path.read_bytes() == (card / NAME).read_bytes()


def test_damage_on_the_card_is_told_and_kept(card, out):
    wrong = bytearray(log_bytes(150))
    wrong[70 * BLOCK_BYTES + 100] ^= 1
    (card / NAME).write_bytes(wrong)
    with SerialDouble(card=card, factor=FACTOR) as double:
        one = fetch(double, out)
    assert one.damaged == 1 and one.path.read_bytes() == wrong


def test_what_lies_behind_a_session_is_not_fetched(card, out):
    """A file that was not closed has its full size: stale blocks of an older session, and noise."""
    stale = log_bytes(200, SESSION - 5)[100 * BLOCK_BYTES : 130 * BLOCK_BYTES]
    session = log_bytes(100)[: 99 * BLOCK_BYTES]
    (card / NAME).write_bytes(session + bytes(BLOCK_BYTES) + stale + b"\xff" * 400 * BLOCK_BYTES)
    with SerialDouble(card=card, factor=FACTOR) as double:
        one, again = fetch(double, out), fetch(double, out)
    assert one.path.read_bytes() == session and one.damaged == 0 and not again.fresh


def test_a_file_of_no_size_is_a_file(card, out):
    (card / NAME).write_bytes(b"")
    with SerialDouble(card=card, factor=FACTOR) as double:
        assert fetch(double, out).path.read_bytes() == b"" and not fetch(double, out).fresh


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on the size of files")
def test_a_full_disk_is_told_and_the_next_download_goes_on(card, out):
    script = """
import resource, sys
from pathlib import Path
from wheelhop.logger import LoggerError
from wheelhop.logger.download import Downloader
from wheelhop.logger.link import connect
resource.setrlimit(resource.RLIMIT_FSIZE, (40_000, 40_000))
try:
    Downloader(connect(sys.argv[1])).download("HOP00001.HOP", 150 * 512, Path(sys.argv[2]))
except LoggerError as error:
    print(error)
"""
    with SerialDouble(card=card, factor=FACTOR) as double:
        done = subprocess.run(
            [sys.executable, "-c", script, double.url, str(out)], capture_output=True, text=True
        )
        assert "the next download goes on there" in done.stdout, done.stderr
        part = (out / f"{NAME}.part").read_bytes()
        assert len(part) > 32_000 and (card / NAME).read_bytes().startswith(part)
        assert fetch(double, out).path.read_bytes() == (card / NAME).read_bytes()


def test_a_logger_that_does_not_come_back_is_told(card, out):
    with SerialDouble(card=card, factor=2.0) as double:
        downloader = Downloader(connect(double.url), patience_s=0.3)
        double.tear(1e6)
        with pytest.raises(LoggerError, match="the next download goes on there"):
            downloader.download(NAME, 150 * BLOCK_BYTES, out)
        downloader.close()


def test_files_are_chosen_by_name_all_or_the_last():
    sizes = {"HOP00009.HOP": 1, "HOP00010.HOP": 2}
    assert choose([], False, sizes, "COM3") == ["HOP00010.HOP"]
    assert choose([], True, sizes, "COM3") == sorted(sizes)
    assert choose(["hop00009.hop"], False, sizes, "COM3") == ["HOP00009.HOP"]
    with pytest.raises(LoggerError, match=r"HOP7: not on the card, there are HOP00009.HOP, HOP"):
        choose(["HOP7"], False, sizes, "COM3")
    with pytest.raises(LoggerError, match="there are no log files"):
        choose([], True, {}, "COM3")
