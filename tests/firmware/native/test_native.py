"""The firmware's hardware-independent parts on a PC, with the sanitizers watching.

The C++ tests are in `test_parts`; PlatformIO runs the same ones: `pio test -e native`.
"""

import shutil
import subprocess
from pathlib import Path

import pytest

from tests.patience import PATIENCE_S
from tools.firmware_build import ROOT, native_command

PARTS = Path(__file__).with_name("test_parts")


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    """All parts and their tests in one program."""
    if shutil.which("g++") is None:
        pytest.skip("g++ is missing: sudo apt-get install g++")
    target = tmp_path_factory.mktemp("native") / "parts"
    subprocess.run(native_command(PARTS, target), check=True, cwd=ROOT)
    return target


@pytest.fixture(scope="module")
def image(tmp_path_factory):
    """An empty FAT file system of 8 MiB, or nothing where mkfs.vfat is missing."""
    tool = shutil.which("mkfs.vfat", path="/usr/sbin:/sbin:/usr/bin")
    if tool is None:
        return []
    path = tmp_path_factory.mktemp("image") / "card.img"
    command = [tool, "--invariant", "-F", "16", "-s", "1", "-C", str(path), "8192"]
    subprocess.run(command, check=True, capture_output=True)
    return [path]


def test_parts(program, image):
    done = subprocess.run([program, *image], capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count(":PASSED") >= 40, done.stdout
