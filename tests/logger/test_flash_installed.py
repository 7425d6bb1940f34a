"""What `pip install` gives: the firmware is in the wheel, and reaches a board from there."""

import os
import shutil
import subprocess
import sys
import venv
from pathlib import Path

import pytest

from tests.logger.bootloader import ATMEGA328P, Bootloader
from tools import firmware_build
from tools.firmware_build import ROOT


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel, made of the sdist, with the firmware of a release."""
    pytest.importorskip("hatchling")
    if shutil.which("avr-g++") is None or not firmware_build.CORE.exists():
        pytest.skip("sudo apt-get install gcc-avr avr-libc arduino-core-avr")
    subprocess.run([ROOT / "tools/firmware_release.sh"], check=True, capture_output=True)
    out = tmp_path_factory.mktemp("dist")
    build = [sys.executable, "-m", "hatchling", "build", "-d", str(out)]
    subprocess.run([*build, "--target", "sdist"], cwd=ROOT, check=True, capture_output=True)
    shutil.unpack_archive(next(out.glob("*.tar.gz")), out / "source", filter="data")
    source = next((out / "source").iterdir())
    subprocess.run([*build, "--target", "wheel"], cwd=source, check=True, capture_output=True)
    return next(out.glob("*.whl"))


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """The `wheelhop` of a new environment in a folder of its own.

    What wheelhop needs besides is this environment's: an installation from PyPI takes minutes.
    """
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False)
    pip = [sys.executable, "-m", "pip", "--python", str(folder / "bin/python")]
    options = ["install", "-q", "--no-deps", "--no-index", str(wheel)]
    subprocess.run([*pip, *options], check=True, capture_output=True)
    (site,) = (folder / "lib").glob("python*/site-packages")
    needed = Path(pytest.__file__).parents[1]
    (site / "needed.pth").write_text(f"import sys; sys.path.append({str(needed)!r})\n")
    return folder / "bin/wheelhop"


def run(command, *words):
    return subprocess.run(
        [command, *words],
        capture_output=True,
        text=True,
        cwd=command.parent,
        env={**os.environ, "PYTHONPATH": ""},
    )


def image(file):
    """The program in a .hex file, from address 0 on."""
    data = bytearray()
    for line in file.read_text().splitlines():
        record = bytes.fromhex(line[1:])
        if record[3] == 0:
            assert len(data) == int.from_bytes(record[1:3], "big")
            data += record[4:-1]
    return bytes(data)


@pytest.mark.skipif(shutil.which("avrdude") is None, reason="sudo apt-get install avrdude")
def test_a_plain_installation_flashes_the_board(installed):
    with Bootloader(signature=ATMEGA328P) as board:
        done = run(installed, "flash", "--port", board.port)
        assert done.returncode == 0, done.stderr
        assert "read back the same" in done.stdout
        assert "site-packages/wheelhop/logger/firmware/wheelhop-logger-nano.hex" in done.stdout
        program = image(ROOT / "build/release/wheelhop-logger-nano.hex")
        assert board.flash[: len(program)] == program


def test_the_simulated_board_says_in_a_line_what_it_lacks(installed):
    done = run(installed.with_name("python"), "-m", "wheelhop.hil_sim", __file__)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1 and done.stderr.startswith("wheelhop.hil_sim: ")
    elf = ROOT / "build/firmware/nano/firmware.elf"
    done = run(installed.with_name("python"), "-m", "wheelhop.hil_sim", elf)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1 and "source tree" in done.stderr


@pytest.mark.parametrize("damage", ["sum", "version"])
def test_a_firmware_that_is_not_the_sources_is_not_packed(tmp_path, damage):
    pytest.importorskip("hatchling")
    for name in (
        "hatch_build.py",
        "pyproject.toml",
        "README.md",
        "LICENSE",
        "firmware/include/version.h",
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    release = tmp_path / "build/release"
    release.mkdir(parents=True)
    shutil.copytree(ROOT / "build/release", release, dirs_exist_ok=True)
    if damage == "sum":
        file = release / "wheelhop-logger-nano.hex"
        file.write_text(file.read_text().replace("0", "1", 1))
    else:
        header = tmp_path / "firmware/include/version.h"
        header.write_text(header.read_text().replace('"1', '"91'))
    command = [sys.executable, "-m", "hatchling", "build", "--target", "sdist"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode != 0 and "tools/firmware_release.sh" in done.stderr
