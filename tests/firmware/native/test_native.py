"""The firmware's hardware-independent parts on a PC, with the sanitizers watching.

The C++ tests are in `test_parts`; PlatformIO runs the same ones: `pio test -e native`.
"""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.patience import PATIENCE_S
from tools.firmware_build import ROOT, native_command
from wheelhop.hil_sim import CardImage
from wheelhop.logger.correct import correct_window
from wheelhop.logger.read import read_log

PARTS = Path(__file__).with_name("test_parts")
TOGETHER = Path(__file__).with_name("together")


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


@pytest.fixture(scope="module")
def together(tmp_path_factory):
    """The firmware as it is for a board whose converter takes all inputs at once, with 16 bits."""
    if shutil.which("g++") is None:
        pytest.skip("g++ is missing: sudo apt-get install g++")
    target = tmp_path_factory.mktemp("together") / "together"
    command = [part for part in native_command(TOGETHER, target) if "sanitize" not in part]
    command[1:1] = ["-DBOARD_SIMULTANEOUS", str(PARTS / "fake_board.cpp")]
    subprocess.run(command, check=True, cwd=ROOT)
    return target


@pytest.mark.parametrize("rate_hz", [100, 400])
def test_another_boards_log_is_decoded(together, image, tmp_path, rate_hz):
    """Format 2: 22-bit sums of 16-bit codes, every input at the same instants; and what a wheel, a
    button and a thermometer beside them say."""
    if not image:
        pytest.skip("mkfs.vfat is missing: sudo apt-get install dosfstools")
    card = CardImage(tmp_path / "card.img")
    subprocess.run([together, *image, card.path, str(rate_hz), "5"], check=True)
    path = tmp_path / "HOP00001.HOP"
    path.write_bytes(card.read("HOP00001.HOP"))
    assert path.read_bytes()[:4] == b"HOP2"
    log = read_log(path)
    recording = log.recording()
    per_scan = 6400 // rate_hz
    number, taken = np.arange(8), (per_scan - 1) / 2  # the mean of n is exact in the sums
    codes = (5000 + 7000 * number + (13 + number) * taken) / 64
    assert log.due == log.written == 5 * rate_hz and log.lost == 0
    assert np.array_equal(recording.values, np.tile(codes, (5 * rate_hz, 1)))
    assert recording.start_s == pytest.approx((per_scan - 1) / 2 / 6400)
    assert recording.averaging_s == pytest.approx(1 / rate_hz)
    beside = log.beside
    assert beside is not None and np.all(np.diff(beside.scan) == rate_hz // 10)
    assert beside.speed_m_s(beside.time_s) == pytest.approx(10 * 1000 / 568)
    assert beside.temperature_c(beside.time_s) == pytest.approx(25.0, abs=0.01)
    assert beside.marks_s == pytest.approx([1.1], abs=0.01)
    whole = correct_window(recording)
    assert np.allclose(whole.values, recording.values)


def test_parts(program, image):
    done = subprocess.run([program, *image], capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count(":PASSED") >= 40, done.stdout
