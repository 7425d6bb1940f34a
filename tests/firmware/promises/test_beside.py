"""The Mega's inputs beside the eight: in the file between its scans, and none is lost for them."""

import numpy as np

from tests.firmware.promises.logger import Logger, configure
from tests.firmware.promises.test_stalls import check_totals
from wheelhop.hil_sim import Faults, constant
from wheelhop.logger.read import read_log

WHEEL_HZ, SPEED_M_S = 25.0, 25.0 * 1000 / 568


def test_marks_pulses_and_temperature_beside_a_stall(mega_elf, card, tmp_path):
    """At the highest rate, while streaming; the temperature's turns are every other reading."""
    configure(card, "size_mb = 1\nstream = on\nrate = 400\npulses_per_km = 568\n")
    levels = 100.5 + 100 * np.arange(8)
    with Logger(mega_elf, card, signals=constant(levels), trace=True) as one:
        one.board.wheel_hz, one.board.temperature_code = WHEEL_HZ, 233.5
        one.boot()
        assert one.command("start").ok
        one.board.trace()
        one.run(2.0)
        one.board.press_mark()
        first = one.board.counters().card_writes
        one.board.faults = Faults(stalls={first + 2: 0.6})
        one.run(2.0)
        one.board.press_mark()
        one.run(2.0)
        assert one.board.trace().conversion_jitter() == 0
        reply = one.command("stop")
        assert [text for text in one.texts("M") if "mark" in text] == ["mark 1", "mark 2"]
        log = one.log()
        assert check_totals(one, log, reply)[2] == 0
        assert set(log.scans.values()) == {tuple(int(level) * 2 for level in levels)}
        counters = one.board.counters()
        assert (counters.missed, counters.card_violations, counters.serial_overruns) == (0, 0, 0)
        path = tmp_path / "HOP00001.HOP"
        path.write_bytes(card.read("HOP00001.HOP"))
    beside = read_log(path).beside
    assert beside is not None and np.all(np.diff(beside.scan) == 40)
    assert len(beside.scan) == int(log.summary["due"]) // 40
    assert np.allclose(beside.marks_s, [2.1, 4.2], atol=0.15)
    assert np.allclose(beside.speed_m_s(beside.time_s)[3:], SPEED_M_S, rtol=2e-3)
    assert set(beside.temperature_code[4:]) == {233}


def test_a_mark_without_a_session_is_none(mega_elf, card):
    with Logger(mega_elf, card) as one:
        one.boot()
        one.board.press_mark()
        one.run(0.5)
        assert one.command("start").ok
        one.run(0.5)
        assert one.command("stop").ok
        assert [text for text in one.texts("M") if "mark" in text] == []
