"""A burst of errors delays a recording and does not end it; `start` answers within 5 s."""

import pytest

from tests.firmware.promises.logger import Logger, configure, faults_of
from tests.firmware.promises.test_going_on import linked
from wheelhop.hil_sim import CardImage, Faults

START_S = 5.0
LONGEST = 8192  # clusters
SLOW_WRITE_S = 10e-3
SLOW_READ_S = 2.4e-3  # with the transfer: 31 s for the table of a full card of 32 GB


def refused(one, count, skip=0):
    """The next writes fail, `skip` of them aside."""
    first = one.board.counters().card_writes + skip
    one.board.faults = Faults(rejects={first + k: "write" for k in range(count)})


@pytest.mark.parametrize("skip", range(0, 10, 2))
def test_refused_writes_while_the_next_file_is_made(small_files, tmp_path, skip):
    card = CardImage.fat32(tmp_path / "card.img", cluster_blocks=1)
    with Logger(small_files, configure(card, "size_mb = 1\nrate = 400\n")) as one:
        one.boot()
        assert one.command("start").ok
        one.until(lambda: "HOP00001.HOP" in card.files() and one.acknowledgements() != [], 5.0)
        one.until(lambda: one.acknowledgements()[-1].blocks >= 60, step=1e-3)
        refused(one, 3, skip)
        one.run(10.0)
        assert one.command("status").values["state"] == "recording"
        assert one.command("stop").ok
        assert linked(one) and faults_of(card) == []


@pytest.mark.parametrize("cause", ["brown-out", "power"])
@pytest.mark.parametrize("count", [3, 9])
def test_refused_writes_after_a_reset_and_at_power_up(logger, card, cause, count):
    if cause == "power":
        configure(card, "size_mb = 1\nstart = power\n")
        one = logger(card, faults=Faults(rejects=dict.fromkeys(range(count), "crc")))
    else:
        one = logger(card)
        assert one.command("start").ok
        one.run(1.5)
        refused(one, count)
        one.board.reset("brown-out")
    one.run(10.0)
    assert one.command("status").values["state"] == "recording"
    assert one.command("stop").ok
    assert faults_of(card) == []


def test_a_card_that_refuses_for_long_keeps_its_room_and_the_memory_of_the_number(logger, card):
    """Each attempt uses neither clusters nor the EEPROM, which lasts for 100 000 writes."""
    configure(card, "size_mb = 1\nstart = power\n")
    free = card.free_bytes()
    one = logger(card, faults=Faults(rejects=dict.fromkeys(range(1000), "write")))
    one.run(30.0)
    assert one.command("status").values["card"].startswith("card error")
    assert set(one.board.eeprom()) == {0xFF}
    assert card.free_bytes() == free
    begun = one.board.time
    one.board.faults = Faults()
    one.until(lambda: one.command("status").values["state"] == "recording", 10.0, step=0.5)
    assert one.board.time - begun < 10.0
    assert one.command("stop").ok and sorted(card.files()) == ["HOP.CFG", "HOP00001.HOP"]


def thousand_logs(path):
    card = CardImage.fat32(path, 256, cluster_blocks=1)
    card.write_all({f"HOP{k:05}.HOP": b"x" * 512 for k in range(1, 1001)})
    return card


@pytest.mark.parametrize("latency_s", [100e-6, SLOW_READ_S])
def test_start_beside_a_thousand_logs_with_an_erased_memory(logger, tmp_path, latency_s):
    card = thousand_logs(tmp_path / "card.img")
    one = logger(card, faults=Faults(read_latency=latency_s))
    begin = one.board.time
    reply = one.command("start", 90.0)
    assert reply.text == "HOP01001.HOP"
    assert one.board.time - begin < START_S
    one.run(0.5)
    assert one.command("stop", 30.0).ok and card.check() == ""


@pytest.mark.parametrize(
    ("size_gib", "cluster_blocks", "leave_mib"),
    [(32, 64, 0), (32, 64, 136), (128, 128, 0), (128, 128, 300)],
)
def test_start_on_a_large_card_whose_reads_are_slow(
    logger, tmp_path, size_gib, cluster_blocks, leave_mib
):
    """Full, or with room for one file at its end, a little more than a 448th of the card."""
    card = CardImage.fat32(
        tmp_path / "card.img", size_gib * 1024, cluster_blocks=cluster_blocks, partitioned=True
    )
    card.reserve(leave_mib << 20)
    one = logger(card, faults=Faults(read_latency=SLOW_READ_S))
    begin = one.board.time
    reply = one.command("start", 90.0)
    took_s = one.board.time - begin
    assert (reply.text == "HOP00001.HOP") if leave_mib else reply.text.startswith("no room")
    assert took_s < START_S


def test_start_beside_a_thousand_logs_on_a_nearly_full_card_of_small_clusters(logger, tmp_path):
    """Everything at once: the directory, the search for room, and the longest chain."""
    card = CardImage.fat32(tmp_path / "card.img", 32 * 1024, cluster_blocks=8, partitioned=True)
    card.write_all({f"HOP{k:05}.HOP": b"x" * 512 for k in range(1, 1001)})
    card.reserve(136 << 20)
    one = logger(card, faults=Faults(read_latency=SLOW_READ_S))
    begin = one.board.time
    assert one.command("start", 90.0).text == "HOP01001.HOP"
    assert one.board.time - begin < START_S


def test_a_file_is_no_longer_than_its_chain_can_be_written_at_once(logger, tmp_path):
    """And the time in its header is that of the first sample, behind all that writing."""
    card = CardImage.fat32(tmp_path / "card.img", cluster_blocks=1)
    one = logger(card, faults=Faults(write_busy=SLOW_WRITE_S))
    begin = one.board.time
    assert one.command("time 1800000000").ok
    assert one.command("start", 90.0).ok
    took_s = one.board.time - begin
    assert 1.3 < took_s < START_S
    assert card.files()["HOP00001.HOP"] == LONGEST * 512
    told_s = next(int(text[7:]) for text in one.texts("H") if text.startswith("unix_s="))
    assert took_s - 1.5 < told_s - 1800000000 <= took_s


def test_what_is_in_the_way_under_the_next_name_is_passed_by(logger, tmp_path):
    card = CardImage.fat32(tmp_path / "card.img")
    card.write("HOP00001.HOP", b"precious")
    card.protect("HOP00001.HOP")
    card.make_folder("HOP00002.HOP")
    card.write("HOP00003.HOP", b"")
    card.protect("HOP00003.HOP")
    one = logger(card)
    assert one.command("set size_mb=1").ok
    assert one.command("start").text == "HOP00004.HOP"
    one.run(0.5)
    assert one.command("stop").ok and card.check() == ""


@pytest.mark.parametrize("busy_s", [300e-6, 0.1])
def test_a_card_that_shows_late_that_it_is_busy(logger, card, busy_s):
    one = logger(card, faults=Faults(late_busy=1, write_busy=busy_s))
    assert one.command("start", 30.0).ok
    one.run(2.0)
    assert one.command("stop", 30.0).ok
    log = one.log()
    assert len(log.scans) == int(log.summary["due"]) and log.summary["card_errors"] == "0"
    assert one.board.counters().card_violations == 0, one.board.last_violation()
