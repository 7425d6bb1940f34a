"""One build description, and sources that the formatter and the checker find nothing in."""

import json
import shlex
import shutil
import subprocess

import pytest

from tools import firmware_build
from tools.firmware_build import ROOT

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


def test_platformio_reads_the_same_flags():
    needs("pio", "nothing, but pip install platformio")
    lint = subprocess.run(
        ["pio", "project", "config", "--lint"], cwd=ROOT, capture_output=True, text=True
    )
    assert "free from linting errors" in lint.stdout, lint.stdout + lint.stderr
    done = subprocess.run(
        ["pio", "project", "config", "--json-output"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    sections = {name: dict(options) for name, options in json.loads(done.stdout)}
    ini = firmware_build.read_ini()
    for env in ("nano", "mega", "native"):
        theirs = sections[f"env:{env}"]
        ours = shlex.split(firmware_build.option(ini, env, "build_flags"))
        assert shlex.split(" ".join(theirs["build_flags"])) == ours
        if env != "native":
            assert theirs["board"] == firmware_build.option(ini, env, "board")
            assert theirs["board"] in firmware_build.BOARDS


def test_the_firmware_builds_for_both_controllers_without_a_warning():
    needs("avr-g++", "gcc-avr avr-libc binutils-avr")
    if not firmware_build.CORE.exists():
        pytest.skip("the Arduino core is missing: sudo apt-get install arduino-core-avr")
    done = subprocess.run(
        [ROOT / "tools/build_firmware.sh", "nano", "mega"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert "warning" not in done.stderr, done.stderr
