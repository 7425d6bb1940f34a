"""Whatever has happened to a file or a card, what is whole is saved, and nothing else."""

import errno
from argparse import Namespace

import numpy as np
import pytest

from tests.firmware.promises import reader
from tests.logger.session import SESSION, blocks_of, random_sums, session
from wheelhop.cli import recover as command
from wheelhop.logger import LoggerError, card, describe, read_log, recover, recovery
from wheelhop.logger.block import pack_block, pack_scans

SUMS = random_sums(500)
OTHER = random_sums(200, 3, seed=2)
OTHER_SESSION = 0x000D_0001


def saved(tmp_path, data, **options):
    """What is recovered from these bytes."""
    source = tmp_path / "source.bin"
    source.write_bytes(data)
    found = list(recover(source, tmp_path / "out", **options))
    assert source.read_bytes() == data
    assert not list((tmp_path / "out").glob(".*"))
    return found


def scans(path):
    """Sums by scan number, as a reader of the specification alone sees them."""
    log = reader.read_log(path.read_bytes())
    assert log.bad == [] and log.summary is not None
    assert int(log.summary["due"]) == len(log.scans) + int(log.summary["lost"])
    return log.scans


def original(sums, gone=()):
    return {i: tuple(row) for i, row in enumerate(sums.tolist()) if i not in set(gone)}


def test_a_healthy_log_comes_back_to_the_byte(tmp_path):
    data = session(SUMS, lost=[100, 300])
    (one,) = saved(tmp_path, data)
    assert one.path.read_bytes() == data
    assert one.path.name == "HOP00012.HOP"
    assert one.complete and (one.due, one.written, one.lost, one.damaged) == (500, 498, 2, 0)


def test_damaged_blocks_are_left_out_and_counted(tmp_path):
    blocks = blocks_of(session(SUMS, lost=[100]))
    blocks[2][200] ^= 1
    blocks[5] = bytearray(512)
    (one,) = saved(tmp_path, b"".join(blocks))
    assert not one.complete
    # Block 3 ends with scan 99, since 100 is lost.
    gone = [*range(37, 74), 100, *range(138, 175)]
    assert (one.due, one.lost, one.damaged) == (500, 1, 74)
    assert scans(one.path) == original(SUMS, gone)
    assert read_log(one.path).summary["damaged"] == "74"


def test_what_was_recovered_can_be_damaged_and_recovered_again(tmp_path):
    blocks = blocks_of(session(SUMS, lost=[100]))
    blocks[2][200] ^= 1
    (first,) = saved(tmp_path, b"".join(blocks))
    blocks = blocks_of(first.path.read_bytes())
    blocks[7] = bytearray(512)
    (tmp_path / "again").mkdir()
    (second,) = saved(tmp_path / "again", b"".join(blocks))
    assert read_log(second.path).summary["damaged"] == str(37 + 37)
    assert "75 missing: 1 lost by the logger, 74 damaged since" in describe(read_log(second.path))


def test_a_file_that_was_cut_off_ends_with_its_last_whole_block(tmp_path):
    data = session(SUMS)
    (one,) = saved(tmp_path, data[: 7 * 512 + 300])
    assert scans(one.path) == original(SUMS[: 6 * 37])
    assert one.troubles == ("not closed",)


def test_a_file_that_has_lost_its_beginning_is_still_found(tmp_path):
    data = session(SUMS)
    like = read_log(session(random_sums(3)))
    (one,) = saved(tmp_path, data[700:], header_from=like)
    assert "header lost" in one.troubles
    assert scans(one.path) == original(SUMS, range(37))
    assert np.isnan(read_log(one.path).recording().values[:37]).all()


def test_without_a_header_the_data_are_kept_for_later(tmp_path):
    (one,) = saved(tmp_path, session(SUMS)[512:])
    log = read_log(one.path, header_from=read_log(session(random_sums(3))))
    assert np.array_equal(log.recording().values * 8, SUMS)


def test_every_session_of_a_card_is_found_wherever_it_lies(tmp_path, monkeypatch):
    """Sectors of two sessions in a wild order, amid old rubbish; pieces end inside blocks."""
    monkeypatch.setattr(card, "PIECE_BYTES", 5000)
    rng = np.random.default_rng(3)
    sectors = blocks_of(session(SUMS) + session(OTHER, session=OTHER_SESSION))
    sectors += blocks_of(session(SUMS))[:4]  # a copy
    sectors += [rng.bytes(512) for _ in range(40)]
    sectors += [b"HOP1D" + rng.bytes(507)] * 3
    sectors += [pack_block(b"D", 77, 5, count=3)]  # one block is no session
    sectors = [bytes(sectors[i]) for i in rng.permutation(len(sectors))]
    first, second = saved(tmp_path, b"".join(sectors))
    assert first.complete and second.complete
    assert scans(first.path) == original(SUMS)
    assert scans(second.path) == original(OTHER)


@pytest.mark.parametrize("cut", range(-3, 4))
def test_a_block_across_two_pieces_is_found_once(tmp_path, monkeypatch, cut):
    monkeypatch.setattr(card, "PIECE_BYTES", 512 + cut)
    (one,) = saved(tmp_path, session(SUMS))
    assert one.complete and one.written == 500


def test_sessions_with_the_same_number_get_names_of_their_own(tmp_path):
    twin = SESSION ^ 1
    found = saved(tmp_path, session(SUMS) + session(OTHER, session=twin))
    assert [one.path.name for one in found] == ["HOP00012-beee.HOP", "HOP00012-beef.HOP"]


def test_a_block_that_contradicts_the_others_is_left_out(tmp_path):
    false = pack_block(b"D", SESSION, 4, first_scan=9999, count=20)
    (one,) = saved(tmp_path, false + session(SUMS))
    assert one.contradictions == 1
    assert scans(one.path) == original(SUMS)


@pytest.mark.parametrize("first", [2**32 - 100, 2**32 - 37])
@pytest.mark.parametrize("gone", [2, 6])
def test_scan_numbers_may_pass_two_to_the_thirty_two(tmp_path, first, gone):
    blocks = blocks_of(session(SUMS[:37], close=False))
    for k in range(8):
        place = {"first_scan": (first + 37 * k) % 2**32, "lost": first - 37}
        rows = pack_scans(SUMS[37 * k : 37 * k + 37])
        blocks.append(pack_block(b"D", SESSION, 2 + k, count=37, payload=rows, **place))
    blocks[gone] = bytearray(512)
    (one,) = saved(tmp_path, b"".join(blocks))
    assert (one.due, one.lost, one.damaged) == (first + 37 * 8, first - 37, 37)
    log = read_log(one.path)
    kept = [i for i in range(37 * 8) if i // 37 != gone - 2]
    pieces = list(log.scans(37))
    assert np.concatenate([numbers for numbers, _ in pieces]).tolist() == [first + i for i in kept]
    assert np.array_equal(np.concatenate([rows for _, rows in pieces]), SUMS[kept])


def test_nothing_is_ever_overwritten(tmp_path):
    (one,) = saved(tmp_path, session(SUMS))
    before = one.path.read_bytes()
    with pytest.raises(LoggerError, match=r"HOP00012\.HOP: is there already"):
        saved(tmp_path, session(OTHER))
    assert one.path.read_bytes() == before


def test_a_disk_that_forgets_is_noticed(tmp_path, monkeypatch):
    whole = recovery.os.fsync

    def forget(handle):
        whole(handle)
        (part,) = (tmp_path / "out").iterdir()
        data = bytearray(part.read_bytes())
        data[1000] ^= 1
        part.write_bytes(data)

    monkeypatch.setattr(recovery.os, "fsync", forget)
    with pytest.raises(LoggerError, match="reads back differently"):
        saved(tmp_path, session(SUMS))
    assert not (tmp_path / "out").exists()


def test_a_full_disk_is_said_in_a_line(tmp_path, monkeypatch):
    def refuse(handle):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(recovery.os, "fsync", refuse)
    with pytest.raises(LoggerError, match=r"HOP00012\.HOP: cannot be written: No space left"):
        saved(tmp_path, session(SUMS))
    assert not (tmp_path / "out").exists()


def test_the_exit_status_tells(tmp_path, capsys):
    file, folder = tmp_path / "a.bin", tmp_path / "a"
    data = session(SUMS)

    def status(content, into):
        file.write_bytes(content)
        return command.run(Namespace(file=file, into=folder / into, header_from=None))

    assert status(data, "whole") == 0
    assert status(data[:3000], "cut") == 1
    assert "not closed" in capsys.readouterr().out
    with pytest.raises(LoggerError, match="not a session in it"):  # exit status 2
        status(bytes(5000), "none")
