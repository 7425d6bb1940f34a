"""The sensors' self-test: a command moves a pin, and no session is ever recorded with it on."""

import numpy as np

from tests.firmware.promises.logger import Logger
from wheelhop.hil_sim import constant


def shown(one, seconds=0.3):
    """The codes that come over the line at the end of so long."""
    one.run(seconds)
    scans = one.streamed()
    return np.array(scans[max(scans)]) / 8


def test_the_self_test_moves_every_sensor_and_ends_with_a_session(logger, card):
    shift = 30.0 + 5 * np.arange(8)
    one = logger(card, signals=constant(500.5))
    one.board.self_test = constant(shift)
    assert one.command("stream on").ok
    assert (shown(one) == 500).all()
    assert one.command("test on").ok
    assert (shown(one) == 500 + shift).all()
    assert one.command("test off").ok
    assert (shown(one) == 500).all()
    assert one.command("test on").ok and one.command("start").ok
    assert (shown(one, 1.0) == 500).all()
    refused = one.command("test on")
    assert not refused.ok and refused.text == "not during a session"
    assert (shown(one) == 500).all() and one.command("stop").ok
    assert set(one.log().scans.values()) == {(4000,) * 8}


def test_the_self_test_on_the_mega_ends_with_a_reset(mega_elf, card):
    with Logger(mega_elf, card, signals=constant(500.5)) as one:
        one.boot()
        assert one.command("stream on").ok and one.command("test on").ok
        assert (shown(one) == 543).all()
        one.board.reset()
        one.boot()
        assert one.command("stream on").ok
        assert (shown(one) == 500).all()
