"""docs/field.md, word by word, with the emulated logger in place of one."""

import re
import shlex
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.patience import PATIENCE_S, wait_until
from wheelhop.cli.main import main
from wheelhop.hil_sim.day import read_day
from wheelhop.hil_sim.rehearsal import rehearsal
from wheelhop.logger import LoggerError, read_log
from wheelhop.logger.emulated import announced, emulated_ports
from wheelhop.logger.link import connect

FIELD = (Path(__file__).parents[2] / "docs/field.md").read_text(encoding="utf-8")
LINES = re.findall(r"^ {4}wheelhop (.*)$", FIELD, re.M)
LAST = LINES.index("check my-campaign") + 1
FACTOR, DRIVEN_S = 10.0, 60.0
SECONDS = [len(signals.codes) / signals.rate_hz for _, signals in rehearsal(read_day())]


@contextmanager
def running(*words):
    command = [sys.executable, "-u", "-m", "wheelhop.cli.main", *words]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, **pipes) as process:
        try:
            yield process
        finally:
            process.kill()


def scans_in(file):
    try:
        return read_log(file).written
    except LoggerError:
        return 0


class Day:
    """A day with an emulated logger, its button, and the laptop."""

    def __init__(self, emulator):
        self.emulator, self.sessions = emulator, 0

    def press(self):
        self.emulator.stdin.write("\n")
        self.emulator.stdin.flush()

    def session(self):
        """A session on the card alone."""
        self.press()
        due = 100 * SECONDS[self.sessions]
        with connect() as link:
            wait_until(lambda: int(link.status().get("due", 0)) > due)
            self.press()
            wait_until(lambda: link.status()["state"] != "recording")
        self.sessions += 1

    def drive(self, words, file):
        """A session that the laptop records, too, until the first drives are over."""
        with running(*words) as recorder:
            assert any("button" in line for line in recorder.stdout)
            self.press()
            wait_until(lambda: file.exists() and scans_in(file) > 100 * DRIVEN_S)
            self.press()
            wait_until(lambda: read_log(file).summary)
            recorder.send_signal(signal.SIGINT)
            assert recorder.wait(PATIENCE_S) == 0


@pytest.mark.parametrize("lines", [LINES[:LAST], pytest.param(LINES, marks=pytest.mark.slow)])
def test_the_day_in_the_field_goes_as_it_is_written(lines, tmp_path, monkeypatch, capfd):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    recorded = tmp_path / "HOP00003.HOP"
    with running("emulate", "--factor", str(FACTOR)) as emulator:
        wait_until(emulated_ports)
        day = Day(emulator)
        for line in lines:
            words = shlex.split(line, comments=True)
            if words == ["download"]:
                day.session()
            if words[0] == "record":
                day.drive(words, recorded)
                continue
            status = main(words)
            said = capfd.readouterr().out
            if words[0] != "health":
                assert status == 0, line
            elif "--checklist" in words:
                for step in ("quiet", "places", "upright"):
                    assert re.search(rf"^\W*{step}\W+pass", said, re.M), said
    assert emulated_ports() == []
    names = {file.name for file in tmp_path.glob("*.HOP")} - {"HOP00000.HOP"}  # before the button
    assert sorted(names) == ["HOP00001.HOP", "HOP00002.HOP", recorded.name]
    assert not read_log(recorded).missing


def test_an_emulated_logger_is_found_while_it_runs_and_no_second_one_begins(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with announced("socket://127.0.0.1:1"):
        assert emulated_ports() == ["socket://127.0.0.1:1"]
        with pytest.raises(LoggerError, match="emulated logger is open"), announced("other"):
            pass
    (tmp_path / "wheelhop/emulated logger").write_text("what a killed one left")
    assert emulated_ports() == []
