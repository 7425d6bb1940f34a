"""Memory: flash that is left, and the stack: how deep it can go by the machine code, and goes."""

import subprocess

from tests.firmware.promises.logger import configure
from tools import firmware_stack
from wheelhop.hil_sim import CardImage

ENTRIES = 16  # of a directory, in a cluster of one block
SPARE = 300  # bytes of RAM that shall never be touched
FLASH = 30720 - 1024  # bytes: what the old boot loader leaves, and a kilobyte for what comes next


def test_a_kilobyte_of_the_nanos_flash_is_left(elf):
    listed = subprocess.run(["avr-size", str(elf)], capture_output=True, text=True, check=True)
    text, data = map(int, listed.stdout.splitlines()[1].split()[:2])
    assert text + data <= FLASH


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
