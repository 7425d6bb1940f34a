"""The probe firmware, compiled once, and a card host that drives the card through it."""

import shutil
import subprocess
from pathlib import Path

import pytest

from tests.hil_sim.probe import Probe
from wheelhop.hil_sim import SimulationError
from wheelhop.hil_sim.process import build


@pytest.fixture(scope="session")
def probe_elf(tmp_path_factory):
    """`probe.c` for the ATmega328P; skips where the tools are missing."""
    if shutil.which("avr-gcc") is None:
        pytest.skip("avr-gcc is missing: sudo apt-get install gcc-avr avr-libc")
    try:
        build()
    except SimulationError as error:
        pytest.skip(str(error))
    elf = tmp_path_factory.mktemp("probe") / "probe.elf"
    source = Path(__file__).with_name("probe.c")
    options = ["-std=gnu11", "-Os", "-mmcu=atmega328p", "-DF_CPU=16000000UL", "-Wall", "-Werror"]
    subprocess.run(["avr-gcc", *options, "-o", elf, source], check=True)
    return elf


@pytest.fixture
def probe(probe_elf):
    """A function that makes a running `Probe` with the board's options; all end with the test."""
    probes = []

    def make(**options):
        probes.append(Probe(probe_elf, **options))
        return probes[-1]

    yield make
    for one in probes:
        one.board.close()
