"""The second target keeps the promises, too."""

import numpy as np

from tests.firmware.promises.logger import Logger, configure
from tests.firmware.promises.test_stalls import check_totals
from wheelhop.hil_sim import Faults, constant


def test_a_session_with_a_stall_on_the_mega(mega_elf, card):
    levels = np.arange(8) * 100 + 50.5
    with Logger(mega_elf, card, signals=constant(levels), trace=True) as one:
        one.boot()
        assert one.command("start").ok
        first = one.board.counters().card_writes
        one.board.faults = Faults(stalls={first + 3: 0.6})
        one.board.trace()
        one.run(3.0)
        trace = one.board.trace()
        one.board.press_button()
        one.until(lambda: "unix_s" in one.summary())
        one.run(0.5)
        log = one.log()
        assert log.summary["end"] == "button" and log.summary["lost"] == "0"
        assert set(log.scans.values()) == {tuple(int(level) * 8 for level in levels)}
        assert abs(int(log.summary["stall_ms"]) - 600) <= 3
        assert trace.conversion_jitter() == 0
        assert one.flashes() == 1  # ready
        counters = one.board.counters()
        assert (counters.card_violations, counters.reference_conflicts) == (0, 0)
        assert one.command("start").ok
        one.run(0.5)
        reply = one.command("stop")
        assert check_totals(one, one.log(), reply)[2] == 0
        assert len(one.command("list").lines) == 2
        assert one.command("get HOP00002.HOP 0 9").text == str(card.files()["HOP00002.HOP"])


def test_at_400_scans_a_second_the_mega_holds_600_ms(mega_elf, card):
    """With all eight channels, while streaming, and a reading of the supply on the way."""
    configure(card, "size_mb = 1\nstream = on\nrate = 400\n")
    with Logger(mega_elf, card, signals=constant(500.5)) as one:
        one.boot()
        assert one.command("start").ok
        first = one.board.counters().card_writes
        one.board.faults = Faults(stalls={first + 2: 0.6, first + 25: 0.6})
        one.run(0.5)
        one.board.reference_volts = 3.0
        one.run(4.0)
        reply = one.command("stop")
        log = one.log()
        assert check_totals(one, log, reply)[2] == 0
        assert int(log.summary["room"]) == 8 * 37 >= int(log.summary["deepest"]) >= 240
        assert set(log.scans.values()) == {(1000,) * 8}
        assert sum(block.kind == b"V" for block in log.blocks) == 1
        counters = one.board.counters()
        assert (counters.card_violations, counters.missed) == (0, 0)
