"""Promise 8: settings without a compiler, from a file that may hold anything."""

import random

import pytest

from tests.firmware.promises.logger import configure
from wheelhop.hil_sim import Faults

GOOD = """# a comment, and a longer one: --------------------------------------------------------
rate = 200
   channels = L1 L2 - - r_1 R2 X Y9\t
name = Paris Roubaix 3

stream=on
size_mb = 2
start = button"""


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_a_good_file_sets_everything(logger, card, end, mark):
    one = logger(configure(card, mark + GOOD.replace("\n", end)))
    assert one.command("start").ok
    one.run(1.0)
    assert one.command("stop").ok
    header = one.log().header
    assert header["rate_hz"] == "200" and header["conversions"] == "4"
    assert header["channels"] == "L1 L2 - - r_1 R2 X Y9"
    assert header["name"] == "Paris Roubaix 3"
    assert header["config_errors"] == "0"
    assert len(one.streamed(6)) >= len(one.log().scans) >= 190


BAD_LINES = [
    "rate = 150",
    "rate = fast",
    "rate =",
    "rate",
    "= 100",
    "Rate = 100",
    "channels = A1 A2 A3",
    "channels = A1 A1 A3 A4 A5 A6 A7 A8",
    "channels = A1 A2 A3 A4 A5 A6 A7 TOOLONG",
    "channels = - - - - - - - -",
    "channels = A1 A2 A3 A4 A5 A6 A7 A8 A9",
    "channels = A1 A2 A3 A4 A5 A6 A7 A-8",
    "name = " + "n" * 16,
    "size_mb = 0",
    "size_mb = 4096",
    "size_mb = 1e3",
    "start = now",
    "stream = yes",
    "unknown = 1",
    "rate = 200 # no comments behind values",
    "x" * 64,
    "rate = 200" + " " * 100,
    "name = caf\u00e9",
    "\x01\x02\x03",
    "clock_ppm = 5",
]


@pytest.mark.parametrize("line", BAD_LINES, ids=lambda line: repr(line[:30]))
def test_a_line_that_is_not_understood_is_reported_and_changes_nothing(logger, card, line):
    good = "size_mb = 1\n"
    one = logger(configure(card, f"{good}{line}\nname = after\n"), trace=True)
    assert one.command("start").ok
    assert any(text.startswith("HOP.CFG line 2") for text in one.texts("M")), one.texts("M")
    one.run(0.3)
    assert one.command("stop").ok
    header = one.log().header
    assert header["config_errors"] == "1"
    assert header["rate_hz"] == "100" and header["channels"] == "B1 B2 B3 B4 A1 A2 A3 A4"
    assert header["name"] == "after"  # the lines behind count
    assert one.flashes() == 7


@pytest.mark.parametrize("seed", range(4))
def test_a_file_of_garbage_neither_stops_nor_changes_the_logger(logger, card, seed):
    rng = random.Random(seed)
    card.write("HOP.CFG", rng.randbytes(5000))
    one = logger(card)
    assert one.command("set size_mb=1").ok
    assert one.command("start").ok
    one.run(0.5)
    assert one.command("stop").ok
    log = one.log()
    assert log.header["rate_hz"] == "100" and int(log.header["config_errors"]) > 0
    assert one.board.counters().resets == 0


def test_an_empty_file_and_none_mean_the_defaults(logger, card):
    card.write("HOP.CFG", b"")
    one = logger(card)
    assert one.command("info").values["channels"] == "B1 B2 B3 B4 A1 A2 A3 A4"
    assert one.texts("M") == ["ready"]


def test_the_button_starts_and_stops(logger, card):
    one = logger(card, trace=True)
    one.board.press_button()
    one.until(lambda: any(text == "channels=B1 B2 B3 B4 A1 A2 A3 A4" for text in one.texts("H")))
    one.run(1.0)
    one.board.press_button()
    one.until(lambda: "unix_s" in one.summary())
    one.run(0.5)
    log = one.log()
    assert log.summary["end"] == "button" and len(log.scans) >= 99


def test_a_bouncing_button_is_pressed_once(logger, card):
    one = logger(card)
    for _ in range(5):
        one.board.press_button(0.002)
        one.board.run(0.001)
    one.board.press_button(0.1)
    one.run(2.0)
    assert one.command("status").values["state"] == "recording"


def test_power_can_start_a_session(logger, card):
    one = logger(configure(card, "size_mb = 1\nstart = power\n"))
    one.run(3.0)
    one.board.cut_power()
    one.board.power_on()
    one.run(4.0)
    assert one.command("stop").ok
    names = sorted(name for name in card.files() if name.endswith(".HOP"))
    assert names == ["HOP00001.HOP", "HOP00002.HOP"]
    first, second = (one.log(name) for name in names)
    assert first.summary["end"] == "recovered" and second.summary["end"] == "command"
    assert min(len(first.scans), len(second.scans)) > 150


CAUSES = {
    "watchdog": lambda one: one.command("reset"),
    "external": lambda one: one.board.reset("external"),
    "brown-out": lambda one: one.board.reset("brown-out"),
    "power": lambda one: (one.board.cut_power(), one.run(0.1), one.board.power_on()),
}


@pytest.mark.parametrize("cause", CAUSES)
def test_after_every_kind_of_reset_the_session_is_closed_and_the_cause_told(logger, card, cause):
    one = logger(card)
    assert one.command("start").ok
    one.run(2.5)
    begin = len(one.frames)
    CAUSES[cause](one)
    one.until(lambda: "ready" in one.texts("M", begin))
    acknowledged = one.acknowledgements()[-1].written
    assert one.command("info").values["reset"] == cause
    one.run(1.0)
    log = one.log("HOP00001.HOP")
    assert log.summary["end"] == "recovered" and log.summary["reset"] == cause
    assert len(log.scans) == int(log.summary["due"]) >= acknowledged > 100
    resumes = cause != "power"  # whoever switches the logger on decides whether it records
    assert (one.command("status").values["state"] == "recording") == resumes
    assert one.command("stop").ok and card.check() == ""
    if resumes:
        second = one.log("HOP00002.HOP")
        assert second.header["continues"] == f"{log.session:08X}" and len(second.scans) > 80
        assert one.command("start").ok and one.command("stop").ok
        assert one.log("HOP00003.HOP").header["continues"] == ""  # asked for, not gone on with


def test_resets_in_quick_succession_are_gone_on_with(logger, card):
    """As when the starter turns."""
    one = logger(card)
    assert one.command("start").ok
    one.run(1.5)
    for pause_s in (0.3, 0.05, 0.9, 0.4):
        one.board.reset("brown-out")
        one.run(pause_s)
    one.run(2.0)
    assert one.command("status").values["state"] == "recording"
    assert one.command("stop").ok and card.check() == ""
    assert len(one.log().scans) > 60  # of 2 s: the start and the closing of a file take one


def test_nothing_is_gone_on_with_where_the_settings_say_so(logger, card):
    configure(card, "size_mb = 1\nresume = off\n")
    one = logger(card)
    assert one.command("start").ok
    one.run(1.5)
    begin = len(one.frames)
    one.board.reset("brown-out")
    one.until(lambda: "ready" in one.texts("M", begin))
    one.run(1.0)
    assert one.command("status").values["state"] == "ready"
    assert one.log("HOP00001.HOP").summary["end"] == "recovered"
    assert sorted(card.files()) == ["HOP.CFG", "HOP00001.HOP"]


def test_what_belongs_to_the_device_is_kept_without_power(logger, card):
    one = logger(card)
    for setting in ("device=1234", "calibration=rig-2026-07", "clock_ppm=-4321"):
        assert one.command(f"set {setting}").ok
    one.run(0.2)
    one.board.cut_power()
    one.board.power_on()
    one.boot()
    assert one.command("time 1800000000").ok
    assert one.command("start").ok
    one.run(2.2)
    assert one.command("stop").ok
    log = one.log()
    assert log.header["device"] == "1234"
    assert log.header["calibration"] == "rig-2026-07"
    assert log.header["clock_ppm"] == "-4321"
    assert 1800000000 <= int(log.header["unix_s"]) <= 1800000001
    assert int(log.summary["unix_s"]) - int(log.header["unix_s"]) in (2, 3)


@pytest.mark.parametrize("seed", range(3))
def test_an_eeprom_of_garbage_is_no_obstacle(logger, card, seed):
    one = logger(card, eeprom=random.Random(seed).randbytes(1024), faults=Faults())
    assert one.command("start").ok
    one.run(0.5)
    assert one.command("stop").ok
    assert len(one.log().scans) >= 49
