"""After a reset the recording goes on, whatever the boot loader says and wherever the card is."""

import numpy as np
import pytest

from tests.firmware.promises.boot_loaders import LOADERS
from tests.firmware.promises.logger import Logger, configure, faults_of
from tests.firmware.promises.reader import read_log
from tests.firmware.promises.test_settings import CAUSES
from wheelhop.hil_sim import CardImage, Faults

AWAY_S = (1.5, 3.0)  # a card that starts is given up after 1.2 s


@pytest.mark.parametrize("cause", CAUSES)
@pytest.mark.parametrize("loader", ["Optiboot 4.4", "Optiboot 5.0", "Optiboot 7.0"])
def test_a_boot_loader_that_hides_the_cause_does_not_end_the_recording(logger, card, loader, cause):
    one = logger(card, boot_loader=LOADERS[loader])
    assert one.command("info").values["reset"] == "power"
    assert one.command("start").ok
    one.run(1.5)
    begin = len(one.frames)
    CAUSES[cause](one)
    one.until(lambda: "ready" in one.texts("M", begin))
    one.run(2.0)
    resumes = cause != "power"
    known = {
        "Optiboot 4.4": {"power"},
        "Optiboot 5.0": {"power", "brown-out"},
        "Optiboot 7.0": CAUSES,
    }
    told = cause if cause in known[loader] else "unknown"
    assert one.command("info").values["reset"] == told
    assert (one.command("status").values["state"] == "recording") == resumes
    if resumes:
        assert one.command("stop").ok
        first, second = one.log("HOP00001.HOP"), one.log("HOP00002.HOP")
        assert second.header["continues"] == f"{first.session:08X}" and len(second.scans) > 40


def test_the_mega_goes_on_too(mega_elf, card):
    with Logger(mega_elf, card, boot_loader=LOADERS["without a version"]) as one:
        one.boot()
        assert one.command("start").ok
        one.run(1.0)
        one.board.reset("brown-out")
        one.run(2.0)
        assert one.command("status").values["state"] == "recording"


@pytest.mark.parametrize("away_s", AWAY_S)
def test_a_card_that_is_away_during_the_reset_is_waited_for(logger, card, away_s):
    """A bump that shakes the plug shakes the card."""
    one = logger(card)
    assert one.command("start").ok
    one.run(1.5)
    now = one.board.time
    one.board.faults = Faults(bounces=[(now, now + away_s)])
    one.board.reset("brown-out")
    one.run(away_s + 3.0)
    assert one.command("stop").ok and card.check() == ""
    first, second = one.log("HOP00001.HOP"), one.log("HOP00002.HOP")
    assert first.summary["end"] == "recovered"
    assert second.header["continues"] == f"{first.session:08X}" and len(second.scans) > 100


def test_a_card_that_is_busy_during_the_reset_is_waited_for(logger, card):
    one = logger(card)
    assert one.command("start").ok
    one.run(1.0)
    writes = one.board.counters().card_writes
    one.board.faults = Faults(stalls={writes: 1.8})
    one.until(lambda: one.board.counters().card_writes > writes)
    one.board.reset("external")
    one.run(4.0)
    assert one.command("status").values["state"] == "recording"


@pytest.mark.parametrize(("settings", "begins"), [("start = power\n", True), ("rate = 7\n", False)])
def test_a_card_that_comes_late_is_met_as_at_power_up(logger, card, settings, begins):
    configure(card, f"size_mb = 1\n{settings}")
    one = logger(None)
    one.run(2.0)
    begin = len(one.frames)
    one.board.insert(card)
    one.run(2.5)
    assert one.command("status").values["state"] == ("recording" if begins else "ready")
    problems = [text for text in one.texts("M", begin) if text.startswith("HOP.CFG line")]
    assert len(problems) == (not begins)


def test_a_session_that_was_stopped_does_not_go_on_by_itself(logger, card):
    """Not even if a reset was there once, and the card was away when it was stopped."""
    one = logger(card)
    one.board.reset("external")
    one.run(1.0)
    assert one.command("start").ok
    one.run(1.5)
    one.board.insert(None)
    one.run(1.0)
    assert not one.command("stop", 30.0).ok
    one.board.insert(card)
    one.run(3.0)
    assert one.command("status").values["state"] == "ready"
    assert sorted(card.files()) == ["HOP.CFG", "HOP00001.HOP"]


@pytest.mark.parametrize("delay_s", [0.13, 0.16])
def test_a_file_that_is_full_while_the_card_is_away_is_followed_by_the_next(
    small_files, tmp_path, delay_s
):
    """The contacts open while the last blocks are written, the file is closed, the next made."""
    card = CardImage.fat32(tmp_path / "card.img", cluster_blocks=1)
    with Logger(small_files, configure(card, "size_mb = 1\nrate = 400\n")) as one:
        one.boot()
        assert one.command("start").ok
        one.run(1.0)
        one.until(lambda: one.acknowledgements()[-1].blocks >= 59, step=1e-3)
        now = one.board.time + delay_s
        one.board.faults = Faults(bounces=[(now, now + 8.0)])  # a stop gives up after 5 s
        one.run(14.0)
        assert one.command("status").values["state"] == "recording"
        assert one.command("stop").ok
        names = sorted(name for name in card.files() if name.startswith("HOP0"))
        logs = [one.log(name) for name in names]
    assert len(logs) >= 2 and len(logs[1].scans) > 400
    linked = [log.header["continues"] for log in logs]
    assert linked == ["", *(f"{log.session:08X}" for log in logs[:-1])]


def linked(one):
    """Whether the card's sessions are one chain, from the first that has a header to the last."""
    names = sorted(name for name in one.card.files() if name.startswith("HOP0"))
    logs = [log for name in names if (log := read_log(one.card.read(name))) is not None]
    ids = ["", *(f"{log.session:08X}" for log in logs)]
    return [log.header["continues"] for log in logs] == ids[:-1]


@pytest.mark.parametrize("delay_s", np.arange(0.0, 0.3, 0.03).round(2))
def test_a_reset_between_a_full_file_and_the_next_does_not_end_the_recording(
    small_files, tmp_path, delay_s
):
    card = CardImage.fat32(tmp_path / "card.img", cluster_blocks=1)
    with Logger(small_files, configure(card, "size_mb = 1\nrate = 400\n")) as one:
        one.boot()
        assert one.command("start").ok
        one.run(1.0)
        one.until(lambda: one.acknowledgements()[-1].blocks >= 59, step=1e-3)
        one.run(delay_s)
        one.board.reset("brown-out")
        one.run(3.0)
        assert one.command("status").values["state"] == "recording"
        assert one.command("stop").ok
        assert faults_of(card) == []
        assert linked(one)


@pytest.mark.parametrize("pause_s", np.arange(0.0, 0.3, 0.05).round(2))
def test_a_second_reset_before_the_next_file_is_made_does_not_end_the_recording(
    logger, card, pause_s
):
    """A plug that bounces twice."""
    one = logger(card)
    assert one.command("start").ok
    one.run(1.5)
    one.board.reset("brown-out")
    one.until(lambda: len(card.read("HOP00001.HOP")) < 1 << 20, step=0.02)  # it is closed
    one.run(pause_s)
    one.board.reset("external")
    one.run(3.0)
    assert one.command("status").values["state"] == "recording"
    assert one.command("stop").ok
    assert faults_of(card) == []
    assert linked(one)


@pytest.mark.parametrize("busy_s", [0.02, 0.6])
def test_a_reset_while_a_session_is_stopped_does_not_begin_another(logger, card, busy_s):
    """Who has said stop wants no more, whatever the file says of its end."""
    one = logger(card)
    assert one.command("start").ok
    one.run(1.5)
    one.board.faults = Faults(write_busy=busy_s)
    one.board.serial.write(b"stop\n")
    one.run(0.05)
    one.board.reset("external")
    one.board.faults = Faults()
    one.run(3.0)
    assert one.command("status").values["state"] == "ready"
    assert one.log("HOP00001.HOP").summary is not None and card.check() == ""


def test_a_session_of_before_the_power_was_off_is_not_gone_on_with(logger, card):
    """Opening the port resets the board, too."""
    one = logger(card)
    assert one.command("start").ok
    one.run(1.5)
    one.board.cut_power()
    one.board.power_on()
    one.boot()
    one.run(1.0)
    one.board.reset("external")
    one.run(2.0)
    assert one.command("status").values["state"] == "ready"
