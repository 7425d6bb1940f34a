"""What the ELF of a firmware says: MCU, memory map, variables."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

MACHINES = {5: "atmega328p", 6: "atmega2560"}  # AVR architecture in the flags of the ELF
MACHINE_AVR = 83
RAM = range(0x800000, 0x810000)  # where the linker puts it
SYMBOL_TABLE, ALLOCATED = 2, 2  # section type, section flag


class SimulationError(Exception):
    """The simulated board cannot be made or run as asked; the text is one line for the user."""


@dataclass(frozen=True)
class Section:
    """A section header of an ELF32 file."""

    kind: int
    flags: int
    address: int
    offset: int
    size: int
    link: int


@dataclass(frozen=True)
class Program:
    """MCU, end of the static data in RAM, and address and size of every variable."""

    path: Path
    mcu: str
    static_end: int
    variables: dict[str, tuple[int, int]] = field(repr=False)

    def variable(self, name: str) -> tuple[int, int]:
        """Address in RAM and size in bytes. Raises `SimulationError` if there is none."""
        if name not in self.variables:
            raise SimulationError(f"{self.path}: the firmware has no variable {name}")
        return self.variables[name]


def read_elf(path: Path) -> Program:
    """Read the headers of an ELF32 file. Raises `SimulationError`."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise SimulationError(f"{path}: {error.strerror}; build the firmware first") from None
    try:
        if data[:5] != b"\x7fELF\x01" or struct.unpack_from("<H", data, 0x12)[0] != MACHINE_AVR:
            raise SimulationError(f"{path}: not the ELF of an AVR program")
        (flags,) = struct.unpack_from("<I", data, 0x24)
        sections = list(_sections(data))
        variables = dict(_variables(data, sections))
    except struct.error:
        raise SimulationError(f"{path}: the ELF is cut short; build it again") from None
    if (flags & 0x7F) not in MACHINES:
        raise SimulationError(f"{path}: neither for the ATmega328P nor for the ATmega2560")
    in_ram = [s for s in sections if s.flags & ALLOCATED and s.address in RAM]
    end = max((s.address + s.size - RAM.start for s in in_ram), default=0)
    return Program(path, MACHINES[flags & 0x7F], end, variables)


def _sections(data: bytes) -> Iterator[Section]:
    (table,) = struct.unpack_from("<I", data, 0x20)
    size, count = struct.unpack_from("<HH", data, 0x2E)
    for index in range(count):
        yield Section(*struct.unpack_from("<4x6I", data, table + index * size))


def _variables(data: bytes, sections: list[Section]) -> Iterator[tuple[str, tuple[int, int]]]:
    for symbols in (s for s in sections if s.kind == SYMBOL_TABLE):
        names = sections[symbols.link].offset
        for offset in range(symbols.offset, symbols.offset + symbols.size, 16):
            name, address, size = struct.unpack_from("<3I", data, offset)
            if address in RAM and size:
                text = data[names + name : data.index(b"\0", names + name)]
                yield text.decode("latin-1"), (address - RAM.start, size)
