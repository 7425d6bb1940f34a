"""The real firmware, and cards for it."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.firmware.promises.logger import Logger, configure
from wheelhop.hil_sim import CardImage, SimulationError
from wheelhop.hil_sim.process import build

ROOT = Path(__file__).parents[3]
TOOLS = {"avr-g++": "gcc-avr avr-libc", "mkfs.vfat": "dosfstools", "mcopy": "mtools"}
SMALL = "size_mb = 1\nstream = on\n"


def built(env, folder):
    """The ELF of an environment, copied to where no other build touches it.

    Skips where tools are missing, fails where the firmware does not build.
    """
    for tool, packages in TOOLS.items():
        if shutil.which(tool, path=f"{os.environ['PATH']}:/usr/sbin:/sbin") is None:
            pytest.skip(f"{tool} is missing: sudo apt-get install {packages}")
    try:
        build()
    except SimulationError as error:
        pytest.skip(str(error))
    script = ROOT / "tools" / "build_firmware.sh"
    done = subprocess.run([script, env], capture_output=True, text=True, cwd=ROOT)
    if "is missing" in done.stderr:
        pytest.skip(done.stderr.strip().splitlines()[-1])
    assert done.returncode == 0, done.stderr
    return shutil.copy(ROOT / "build" / "firmware" / env / "firmware.elf", folder / f"{env}.elf")


@pytest.fixture(scope="session")
def elf(tmp_path_factory):
    """The Nano's firmware."""
    return built("nano", tmp_path_factory.mktemp("nano"))


@pytest.fixture(scope="session")
def small_files(tmp_path_factory):
    """The Nano's firmware, whose files are small."""
    return built("nano-small-files", tmp_path_factory.mktemp("small"))


@pytest.fixture(scope="session")
def mega_elf(tmp_path_factory):
    """The Mega's firmware."""
    return built("mega", tmp_path_factory.mktemp("mega"))


@pytest.fixture
def card(tmp_path):
    """A FAT32 card whose sessions are small and streamed."""
    return configure(CardImage.fat32(tmp_path / "card.img"), SMALL)


@pytest.fixture
def logger(elf):
    """A function that makes a `Logger`, booted unless told otherwise; all end with the test."""
    loggers = []

    def make(card=None, *, boot=True, **options):
        loggers.append(Logger(elf, card, **options))
        if boot:
            loggers[-1].boot()
        return loggers[-1]

    yield make
    for one in loggers:
        one.board.close()
