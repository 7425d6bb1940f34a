"""The stack: how deep it can go by the machine code, and how deep it goes."""

from tests.firmware.promises.logger import configure
from tools import firmware_stack
from wheelhop.hil_sim import CardImage

ENTRIES = 16  # of a directory, in a cluster of one block
SPARE = 256  # bytes of RAM that shall never be touched


def test_the_deepest_life_found_comes_close_to_the_deepest_chain_of_calls(elf, logger, tmp_path):
    """A session is to be closed, and the next one's file makes the directory grow."""
    card = CardImage.fat32(tmp_path / "card.img", cluster_blocks=1)
    configure(card, "size_mb = 1\nstream = on\nnonsense\n")
    one = logger(card)
    assert one.command("start").ok
    one.run(1.0)
    one.board.cut_power()
    for number in range(ENTRIES - 3):  # with the label, HOP.CFG and the log: no room for another
        card.write(f"FILE{number}.BIN", b"")
    one.board.power_on()
    one.boot()
    assert one.command("start").ok
    one.run(1.0)
    assert one.command("stop").ok and one.command("get HOP00001.HOP 0 9").ok
    assert len(card.files()) == ENTRIES
    left, _ = firmware_stack.bound(elf)
    assert SPARE <= left <= one.board.stack_left() < left + 60
    assert card.check() == ""
