"""`python -m wheelhop.hil_sim`: the board on a pseudo-terminal, and one line for every mistake."""

import os
import subprocess
import sys

import numpy as np
import pytest

from wheelhop.hil_sim.__main__ import main

FAST = ["--fast", "--seconds", "0.05"]


def test_it_runs_a_firmware_and_says_where_the_port_is(probe_elf, tmp_path, capsys):
    card = tmp_path / "card.img"
    assert main([str(probe_elf), "--card", str(card), "--button", "0.01", *FAST]) == 0
    port, end = capsys.readouterr().out.splitlines()
    assert port.startswith("serial port /dev/")
    assert end.startswith("running at 0.1") and "bytes of stack untouched" in end
    assert card.stat().st_size == 64 << 20


def test_it_talks_through_the_port(probe_elf):
    command = [sys.executable, "-m", "wheelhop.hil_sim", str(probe_elf), "--seconds", "20"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        port = os.open(process.stdout.readline().split()[-1], os.O_RDWR | os.O_NOCTTY)
        assert os.read(port, 16) == b"!"  # it has started, and listens
        os.write(port, b"eZ")
        assert os.read(port, 16) == b"Z"
        os.close(port)
        process.kill()


def test_voltages_come_from_a_file(probe_elf, tmp_path):
    table = tmp_path / "volts.csv"
    rows = np.column_stack([np.arange(100) / 100, np.full((100, 8), 1.65)])
    np.savetxt(table, rows, delimiter=",", header="time_s, eight voltages")
    assert main([str(probe_elf), "--signals", str(table), *FAST]) == 0


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["--signals", "none.csv"], "none.csv: No such file or directory"),
        (["--signals", "words.csv"], "words.csv: could not convert"),
        (["--signals", "narrow.csv"], "narrow.csv: 3 columns and 2 rows"),
        (["--signals", "uneven.csv"], "not in equal steps"),
        (["--stall", "12"], "--stall 12: write it as 120:250"),
    ],
)
def test_mistakes_are_told_in_one_line(probe_elf, tmp_path, capsys, monkeypatch, arguments, text):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "words.csv").write_text("a,b\n")
    (tmp_path / "narrow.csv").write_text("0,1,2\n1,1,2\n")
    (tmp_path / "uneven.csv").write_text("".join(f"{t}{',1' * 8}\n" for t in (0, 1, 3)))
    assert main([str(probe_elf), *arguments, *FAST]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("wheelhop.hil_sim: ") and text in line


def test_a_missing_firmware_is_told_in_one_line(tmp_path, capsys):
    assert main([str(tmp_path / "none.elf"), *FAST]) == 2
    assert "build the firmware first" in capsys.readouterr().err
