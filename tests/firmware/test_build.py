"""One build description, and sources that the formatter and the checker find nothing in."""

import hashlib
import shutil
import subprocess

import pytest

from tools import firmware_build
from tools.firmware_build import ROOT
from wheelhop.logger.flash import check_hex

SOURCES = sorted(
    path
    for folder in ("firmware/src", "firmware/lib", "firmware/include", "tests/firmware/native")
    for path in (ROOT / folder).rglob("*")
    if path.suffix in (".h", ".cpp")
)


def needs(tool, package):
    if shutil.which(tool) is None:
        pytest.skip(f"{tool} is missing: sudo apt-get install {package}")


def test_sources_are_formatted():
    needs("clang-format", "clang-format")
    style = f"--style=file:{ROOT / 'firmware/.clang-format'}"
    done = subprocess.run(
        ["clang-format", style, "--dry-run", "--Werror", *map(str, SOURCES)],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr


def test_cppcheck_finds_nothing():
    needs("cppcheck", "cppcheck")
    folders = [f"-I{path}" for path in sorted((ROOT / "firmware/lib").iterdir())]
    options = ["--std=c++11", "--language=c++", "--platform=avr8", "--error-exitcode=1", "--quiet"]
    options += ["--enable=warning,style,performance,portability", "-D__AVR_ATmega328P__"]
    done = subprocess.run(
        ["cppcheck", *options, *folders, "-Ifirmware/include", "firmware/src", "firmware/lib"],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr


def run_avr(script, *words):
    """Run a script of tools/ that builds firmware; skips where it cannot."""
    needs("avr-g++", "gcc-avr avr-libc binutils-avr")
    if not firmware_build.CORE.exists():
        pytest.skip("the Arduino core is missing: sudo apt-get install arduino-core-avr")
    done = subprocess.run([ROOT / "tools" / script, *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done


def test_the_firmware_builds_for_both_controllers_without_a_warning():
    done = run_avr("build_firmware.sh", "nano", "mega")
    assert "warning" not in done.stderr, done.stderr


def test_a_release_is_whole_and_carries_its_sums():
    run_avr("firmware_release.sh")
    folder = ROOT / "build/release"
    lines = (folder / "SHA256SUMS").read_text().splitlines()
    names = ["wheelhop-logger-mega.hex", "wheelhop-logger-nano.hex"]
    assert [line.split()[1] for line in lines] == names
    for line in lines:
        file = folder / line.split()[1]
        check_hex(file)
        assert hashlib.sha256(file.read_bytes()).hexdigest() == line.split()[0]
