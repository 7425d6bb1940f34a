"""`wheelhop flash`: what reaches the board, and what is said when something is in the way.

Where avrdude is installed it talks to a boot loader on a pseudo-terminal; a stand-in on PATH
shows what it is asked, and fails in all the ways.
"""

import shlex
import shutil

import pytest

from tests.logger.bootloader import ATMEGA2560, Bootloader
from wheelhop.cli.main import main
from wheelhop.logger import flash

AVRDUDE = shutil.which("avrdude")
real = pytest.mark.skipif(AVRDUDE is None, reason="avrdude is missing: apt-get install avrdude")
PROGRAM = bytes(range(256)) * 3 + b"the end"


def intel_hex(data):
    """Intel HEX with 16 bytes a record."""
    lines = []
    for start in range(0, len(data), 16):
        piece = data[start : start + 16]
        record = bytes([len(piece), start >> 8, start & 0xFF, 0]) + piece
        lines.append(f":{(record + bytes([-sum(record) & 0xFF])).hex().upper()}")
    return "\n".join([*lines, ":00000001FF", ""])


@pytest.fixture
def hex_file(tmp_path):
    path = tmp_path / "firmware.hex"
    path.write_text(intel_hex(PROGRAM))
    return path


@pytest.fixture
def tools(tmp_path, monkeypatch):
    """A function that puts a stand-in for a tool on a PATH with nothing else; returns its log."""
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(folder))

    def add(name, says="", status=0):
        log = tmp_path / f"{name}.log"
        script = folder / name
        lines = [
            "#!/bin/sh",
            f'for word in "$@"; do echo "$word"; done >{log}',
            f"echo >>{log} $PWD",
        ]
        script.write_text("\n".join([*lines, f"echo {shlex.quote(says)} >&2", f"exit {status}\n"]))
        script.chmod(0o755)
        return log

    return add


@pytest.fixture
def plugged(monkeypatch):
    """The serial ports over USB, for the test to fill."""
    ports = []
    monkeypatch.setattr(flash, "find_ports", lambda: ports)
    return ports


def complaint(capsys, *words):
    """The one line on stderr of a command that must fail."""
    assert main(["flash", *map(str, words)]) == 2
    err = capsys.readouterr().err
    assert err.startswith("wheelhop: ") and err.count("\n") == 1
    return err


@real
@pytest.mark.parametrize(("options", "baud"), [([], 115200), (["--old-bootloader"], 57600)])
def test_the_firmware_reaches_the_board(hex_file, capsys, options, baud):
    with Bootloader(baud=baud) as board:
        assert main(["flash", "--port", board.port, "--hex", str(hex_file), *options]) == 0
        assert board.flash[: len(PROGRAM)] == PROGRAM
        out = capsys.readouterr().out
        assert f"Arduino Nano on {board.port}" in out and str(hex_file) in out and "avrdude" in out
        assert out.endswith("read back the same\n")


@real
def test_what_reads_back_differently_is_an_error(hex_file, capsys):
    with Bootloader(corrupt=True) as board:
        assert "reads back" in complaint(capsys, "--port", board.port, "--hex", hex_file)


@real
def test_another_controller_is_told_and_not_written_to(hex_file, capsys):
    with Bootloader(signature=ATMEGA2560) as board:
        assert "--board" in complaint(capsys, "--port", board.port, "--hex", hex_file)
        assert set(board.flash) == {0xFF}


@real
def test_a_port_that_is_not_there_is_told(hex_file, capsys):
    assert "no such port" in complaint(capsys, "--port", "/dev/ttyNONE", "--hex", hex_file)


@pytest.mark.parametrize(
    ("options", "part", "programmer", "baud"),
    [
        ([], "m328p", "arduino", "115200"),
        (["--old-bootloader"], "m328p", "arduino", "57600"),
        (["--board", "mega"], "m2560", "wiring", "115200"),
    ],
)
def test_avrdude_is_asked_for_the_right_board(tools, hex_file, options, part, programmer, baud):
    log = tools("avrdude")
    assert main(["flash", "--port", "/dev/x", "--hex", str(hex_file), *options]) == 0
    asked = log.read_text().splitlines()
    for flag, value in {"-p": part, "-c": programmer, "-b": baud, "-P": "/dev/x"}.items():
        assert asked[asked.index(flag) + 1] == value
    assert f"flash:w:{hex_file}:i" in asked
    assert "-V" not in asked  # it verifies


@pytest.mark.parametrize(
    ("says", "words"),
    [
        ("avrdude error: programmer is not responding", "--old-bootloader"),
        ("avrdude: stk500_recv(): programmer is not responding", "right port"),
        ("avrdude: ser_open(): can't open device: Permission denied", "dialout"),
        ("avrdude: ser_open(): can't open device: Device or resource busy", "another program"),
        ("avrdude error: the moon is full", "the moon is full"),
        ("avrdude: libftdi.so.1: error: No such file or directory", "libftdi"),
        ("", "does not say why"),
        ("\x1b[31mred\nerror: \x07", "?"),
    ],
)
def test_avrdudes_trouble_is_one_line(tools, hex_file, capsys, says, words):
    tools("avrdude", says, status=1)
    assert words in complaint(capsys, "--port", "/dev/x", "--hex", hex_file)


def test_the_old_boot_loader_is_not_suggested_twice(tools, hex_file, capsys):
    tools("avrdude", "not in sync", status=1)
    words = "--port", "/dev/x", "--hex", hex_file
    assert "--old-bootloader" not in complaint(capsys, *words, "--old-bootloader")
    assert "--old-bootloader" not in complaint(capsys, *words, "--board", "mega")


def test_with_platformio_alone_it_builds_and_uploads(tools):
    log = tools("pio")
    assert main(["flash", "--port", "/dev/x", "--board", "mega"]) == 0
    *asked, folder = log.read_text().splitlines()
    assert asked[0] == "run" and folder == str(flash.SOURCE_TREE)
    assert " ".join(asked[-6:]) == "-e mega -t upload --upload-port /dev/x"


def test_with_platformio_alone_what_it_cannot_do_is_told(tools, hex_file, capsys):
    log = tools("pio")
    assert "needs avrdude" in complaint(capsys, "--port", "/dev/x", "--hex", hex_file)
    assert "needs avrdude" in complaint(capsys, "--port", "/dev/x", "--old-bootloader")
    assert not log.exists()


def test_no_tool_names_the_packages(tools, hex_file, capsys):
    line = complaint(capsys, "--port", "/dev/x", "--hex", hex_file)
    assert "apt-get install avrdude" in line and "pip install platformio" in line


def test_no_firmware_says_where_to_get_it(tools, tmp_path, monkeypatch, capsys):
    tools("avrdude")
    monkeypatch.setattr(flash, "SOURCE_TREE", tmp_path)
    line = complaint(capsys, "--port", "/dev/x")
    assert "make firmware" in line and "release" in line
    built = tmp_path / "build/firmware/nano/firmware.hex"
    built.parent.mkdir(parents=True)
    built.write_text(intel_hex(PROGRAM))
    assert main(["flash", "--port", "/dev/x"]) == 0


def test_a_wrong_pair_of_options_is_told(tools, hex_file, capsys):
    tools("avrdude")
    assert "Mega" in complaint(capsys, "--board", "mega", "--old-bootloader", "--hex", hex_file)


def torn(text):
    return text[: len(text) // 2]


def flipped(text):
    return text.replace(":10001000", ":10001001")


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (torn, "line"),
        (flipped, "line 2"),
        (lambda text: text.replace(":00000001FF\n", ""), "the end is missing"),
        (lambda text: "", "the end is missing"),
        (lambda text: "<html>\nNot found\n</html>", "line 1"),
    ],
    ids=["torn", "a wrong digit", "no end", "empty", "a web page"],
)
def test_a_damaged_hex_file_is_never_written(tools, hex_file, capsys, damage, words):
    log = tools("avrdude")
    hex_file.write_text(damage(hex_file.read_text()))
    line = complaint(capsys, "--port", "/dev/x", "--hex", hex_file)
    assert str(hex_file) in line and words in line
    assert not log.exists()


def test_a_file_that_is_no_hex_file_is_told(tools, tmp_path, capsys):
    tools("avrdude")
    elf = tmp_path / "firmware.elf"
    elf.write_bytes(b"\x7fELF\xff\xfe")
    assert "binary" in complaint(capsys, "--port", "/dev/x", "--hex", elf)
    assert "No such file" in complaint(capsys, "--port", "/dev/x", "--hex", tmp_path / "none.hex")


def test_the_only_port_is_found_and_a_choice_is_left_to_the_user(tools, hex_file, capsys, plugged):
    log = tools("avrdude")
    assert "no serial port" in complaint(capsys, "--hex", hex_file)
    plugged += ["/dev/ttyACM0", "/dev/ttyUSB3"]
    assert "ttyACM0, /dev/ttyUSB3; say which" in complaint(capsys, "--hex", hex_file)
    assert not log.exists()
    del plugged[0]
    assert main(["flash", "--hex", str(hex_file)]) == 0
    assert "/dev/ttyUSB3" in log.read_text().splitlines()


def test_the_command_explains_itself(capsys):
    with pytest.raises(SystemExit) as end:
        main(["flash", "--help"])
    assert end.value.code == 0
    out = capsys.readouterr().out
    assert all(word in out for word in ("--port", "--hex", "--board", "--old-bootloader"))
