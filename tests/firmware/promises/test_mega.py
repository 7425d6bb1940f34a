"""The second target keeps the promises, too."""

import numpy as np

from tests.firmware.promises.logger import Logger
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
