"""A session in several files: full ones, one that a reset ended, and their way to the host."""

from argparse import Namespace
from threading import Lock

import pytest

from tests.firmware.promises.logger import Logger, configure
from wheelhop.cli import download
from wheelhop.hil_sim import CardImage, constant
from wheelhop.logger import read_log
from wheelhop.logger.link import Link

CODES = [100.0, 200, 300, 400, 600, 700, 800, 1000]
BLOCKS = 64  # of a file, in this build
NAMES = [f"HOP0000{k}.HOP" for k in range(1, 5)]


class Port:
    """The board as a serial port; its time goes on while the host listens."""

    name = "simulated board"

    def __init__(self, board):
        self._board = board
        self._lock = Lock()  # the host listens in a thread of its own

    def read(self):
        with self._lock:
            self._board.run(20e-3)
            return self._board.serial.read()

    def write(self, data):
        with self._lock:
            self._board.serial.write(data)

    def close(self):
        """There is nothing to give back."""


@pytest.fixture
def recorded(small_files, tmp_path):
    """A logger with a session in four files: two full, one ended by a reset, one by the user."""
    card = configure(
        CardImage.fat32(tmp_path / "card.img", cluster_blocks=1), "size_mb = 1\nrate = 400\n"
    )
    with Logger(small_files, card, signals=constant(CODES)) as one:
        one.boot()
        assert one.command("start").ok
        for name in NAMES[1:3]:
            one.until(lambda name=name: name in card.files(), timeout=20.0, step=0.1)
        one.run(2.0)
        one.board.reset("external")
        one.until(lambda: NAMES[3] in card.files(), timeout=20.0, step=0.1)
        one.run(1.0)
        assert one.command("status").values["state"] == "recording"
        assert one.command("stop").ok
        yield one


def test_files_of_one_session_are_whole_linked_and_downloaded_together(
    recorded, tmp_path, monkeypatch, capsys
):
    card = recorded.card
    assert sorted(name for name in card.files() if name != "HOP.CFG") == NAMES
    assert card.check() == ""
    logs = [recorded.log(name) for name in NAMES]
    assert [log.summary["end"] for log in logs] == ["full", "full", "recovered", "command"]
    assert [log.header["continues"] for log in logs] == [
        "",
        *(f"{log.session:08X}" for log in logs[:-1]),
    ]
    for log in logs:
        assert int(log.summary["lost"]) == 0 and log.bad == []
        assert sorted(log.scans) == list(range(int(log.summary["due"])))
        assert set(log.scans.values()) == {tuple(int(2 * code) for code in CODES)}
    for log in logs[:2]:
        assert BLOCKS - 4 <= len(log.blocks) <= BLOCKS

    monkeypatch.setattr(download, "connect", lambda port, baud: Link(Port(recorded.board)))
    out = tmp_path / "out"
    out.mkdir()
    asked = Namespace(port="", baud=500_000, names=[], all=False, out=out)
    assert download.run(asked) == 0
    assert f"{out / NAMES[3]} goes on with {NAMES[2]}" in capsys.readouterr().out
    for name in NAMES:
        assert (out / name).read_bytes() == card.read(name)
        assert read_log(out / name).missing == 0
