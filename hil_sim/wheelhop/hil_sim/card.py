"""Images of SD cards: made, filled, looked into and judged with dosfstools and mtools."""

import os
import shutil
import struct
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from wheelhop.hil_sim.fat import Fat
from wheelhop.hil_sim.program import SimulationError

BLOCK_SIZE = 512
MIB = 1 << 20
PARTITION_START = 2048  # block, where card makers put it
FAT16_TYPE, FAT32_TYPE, EXFAT_TYPE, PROTECTIVE_TYPE = 0x06, 0x0C, 0x07, 0xEE
BASIC_DATA = bytes.fromhex("a2a0d0ebe5b9334487c068b6b72699c7")  # kind of a partition, in a GPT

CardKind = Literal["sdhc", "sdsc", "sd-v1"]


@dataclass(frozen=True)
class CardImage:
    """An image file and the kind of card it is the content of.

    `kind` is "sdhc" (addressed by blocks), "sdsc" (by bytes) or "sd-v1" (by bytes, and without
    CMD8). The file system begins at block `start`: 0 without a partition table. `serial` is the
    number by which a host tells one card from another.
    """

    path: Path
    kind: CardKind = "sdhc"
    start: int = 0
    serial: int = 1

    @classmethod
    def fat32(
        cls,
        path: Path | str,
        size_mib: int = 64,
        *,
        cluster_blocks: int | None = None,
        partitioned: bool = False,
        kind: CardKind = "sdhc",
    ) -> "CardImage":
        """Make a card with FAT32, of 40 MiB or more.

        `cluster_blocks` is the size of a cluster, by default the largest power of two up to 64 for
        which the file system has the 65525 clusters that make it FAT32.
        """
        if cluster_blocks is None:
            cluster_blocks = 64
            while cluster_blocks > 1 and size_mib * 2048 < 66_600 * cluster_blocks:
                cluster_blocks //= 2
        return cls._fat(path, size_mib, 32, cluster_blocks, partitioned, kind)

    @classmethod
    def fat16(
        cls,
        path: Path | str,
        size_mib: int = 64,
        *,
        cluster_blocks: int = 4,
        partitioned: bool = False,
        kind: CardKind = "sdsc",
    ) -> "CardImage":
        """Make a card with FAT16."""
        return cls._fat(path, size_mib, 16, cluster_blocks, partitioned, kind)

    @classmethod
    def exfat(cls, path: Path | str, size_mib: int = 64) -> "CardImage":
        """Make a card that begins as one with exFAT does, with a partition; there are no files."""
        card = cls._blank(path, size_mib, "sdhc", PARTITION_START)
        blocks = size_mib * MIB // BLOCK_SIZE - PARTITION_START
        card.write_block(0, _partition_table(EXFAT_TYPE, blocks))
        card.write_block(PARTITION_START, _exfat_boot_sector(blocks))
        return card

    @classmethod
    def gpt(cls, path: Path | str, size_mib: int = 64) -> "CardImage":
        """Make a card with FAT32 in a GUID partition table, as a PC may."""
        card = cls.fat32(path, size_mib, partitioned=True)
        blocks = size_mib * MIB // BLOCK_SIZE
        card.write_block(0, _partition_table(PROTECTIVE_TYPE, blocks - 1, start=1))
        card.write_block(1, b"EFI PART\0\0\1\0")
        last = blocks - 34  # the table's copy is behind it
        card.write_block(2, BASIC_DATA + bytes(16) + struct.pack("<QQ", PARTITION_START, last))
        return card

    @classmethod
    def unformatted(cls, path: Path | str, size_mib: int = 64) -> "CardImage":
        """Make a card full of zeros."""
        return cls._blank(path, size_mib, "sdhc", 0)

    @classmethod
    def _blank(cls, path: Path | str, size_mib: int, kind: CardKind, start: int) -> "CardImage":
        card = cls(Path(path), kind, start)
        with card.path.open("wb") as file:
            file.truncate(size_mib * MIB)
        return card

    @classmethod
    def _fat(
        cls,
        path: Path | str,
        size_mib: int,
        bits: int,
        cluster_blocks: int,
        partitioned: bool,
        kind: CardKind,
    ) -> "CardImage":
        start = PARTITION_START if partitioned else 0
        card = cls._blank(path, size_mib, kind, start)
        blocks = size_mib * MIB // BLOCK_SIZE - start
        if partitioned:
            kind_byte = FAT32_TYPE if bits == 32 else FAT16_TYPE
            card.write_block(0, _partition_table(kind_byte, blocks))
        options = ["--invariant", "-F", str(bits), "-s", str(cluster_blocks), "-n", "LOGGER"]
        if partitioned:
            options += ["--offset", str(start)]
        _tool("mkfs.vfat", *options, str(card.path), str(blocks // 2))
        return card

    def copy(self, path: Path | str) -> "CardImage":
        """A copy of the card in another file; holes stay holes."""
        _tool("cp", "--sparse=always", str(self.path), str(path))
        return replace(self, path=Path(path))

    def read_block(self, block: int) -> bytes:
        """The 512 bytes of one block."""
        with self.path.open("rb") as file:
            file.seek(block * BLOCK_SIZE)
            return file.read(BLOCK_SIZE)

    def write_block(self, block: int, data: bytes) -> None:
        """Replace (the beginning of) one block."""
        with self.path.open("r+b") as file:
            file.seek(block * BLOCK_SIZE)
            file.write(data)

    def files(self) -> dict[str, int]:
        """Names and sizes of the files in the root directory."""
        return self._file_system().files()

    def read(self, name: str, limit: int | None = None) -> bytes:
        """The content of a file, or the first `limit` bytes of it."""
        return self._file_system().read(name, limit)

    def write(self, name: str, data: bytes) -> None:
        """Put a file into the root directory, in place of one of that name."""
        with tempfile.NamedTemporaryFile() as file:
            file.write(data)
            file.flush()
            self._mtool("mcopy", "-o", file.name, f"::{name}")

    def write_all(self, files: Mapping[str, bytes]) -> None:
        """Put many files into the root directory."""
        with tempfile.TemporaryDirectory() as folder:
            for name, data in files.items():
                (Path(folder) / name).write_bytes(data)
            names = [str(Path(folder) / name) for name in files]
            self._mtool("mcopy", "-o", *names, "::")

    def delete(self, name: str) -> None:
        """Delete a file of the root directory."""
        self._mtool("mdel", f"::{name}")

    def make_folder(self, name: str) -> None:
        """Make a folder in the root directory."""
        self._mtool("mmd", f"::{name}")

    def protect(self, name: str) -> None:
        """Mark a file as read-only."""
        self._mtool("mattrib", "+r", f"::{name}")

    def fill(self, leave: int = 0) -> None:
        """Fill the card with one file, up to `leave` bytes (rounded down to clusters)."""
        self._allocate("FULL.BIN", leave)

    def reserve(self, leave: int) -> None:
        """Mark all but `leave` bytes as bad clusters: a full card without the data."""
        self._file_system().reserve(leave)

    def fragment(self, free_run: int) -> None:
        """Occupy one cluster in every `free_run` + 1, so that no more are free in one piece."""
        self._allocate("PIECES.BIN", 0)
        self._file_system().scatter("PIECES.BIN", free_run)

    def free_bytes(self) -> int:
        """Room in free clusters."""
        return self._file_system().free_bytes()

    def check(self) -> str:
        """What fsck.vfat finds wrong, "" if nothing."""
        with tempfile.TemporaryDirectory() as folder:
            volume = self.path
            if self.start:
                volume = Path(folder) / "volume"
                _copy_data(self.path, self.start * BLOCK_SIZE, volume)
            done = subprocess.run(
                [_found("fsck.vfat"), "-n", str(volume)], capture_output=True, text=True
            )
        return "" if done.returncode == 0 else (done.stdout + done.stderr).strip()

    def listing(self) -> str:
        """What mtools, an implementation of its own, makes of the root directory."""
        return self._mtool("mdir", "-a", "-b", "::")

    def _file_system(self) -> Fat:
        return Fat(self.path, self.start)

    def _allocate(self, name: str, leave: int) -> None:
        size = max(self._file_system().free_bytes() - leave, 0)
        with tempfile.NamedTemporaryFile() as file:
            file.truncate(size)
            self._mtool("mcopy", "-o", file.name, f"::{name}")

    def _mtool(self, tool: str, *arguments: str) -> str:
        return _tool(tool, "-i", f"{self.path}@@{self.start * BLOCK_SIZE}", *arguments)


def _copy_data(source: Path, start: int, target: Path) -> None:
    """Copy a file from byte `start` on; its holes are skipped, and stay holes."""
    size = source.stat().st_size
    with source.open("rb") as reader, target.open("wb") as writer:
        writer.truncate(size - start)
        end = start
        while end < size:
            try:
                begin = os.lseek(reader.fileno(), end, os.SEEK_DATA)
            except OSError:  # nothing but a hole is left
                return
            end = os.lseek(reader.fileno(), begin, os.SEEK_HOLE)
            reader.seek(begin)
            writer.seek(begin - start)
            for offset in range(begin, end, MIB):
                writer.write(reader.read(min(MIB, end - offset)))


def _found(tool: str) -> str:
    path = os.pathsep.join([os.environ.get("PATH", ""), "/usr/sbin", "/sbin"])
    if (found := shutil.which(tool, path=path)) is None:
        raise SimulationError(
            f"{tool} is missing; on Debian and Ubuntu: sudo apt-get install dosfstools mtools"
        )
    return found


def _tool(tool: str, *arguments: str) -> str:
    environment = {**os.environ, "MTOOLS_SKIP_CHECK": "1"}
    done = subprocess.run(
        [_found(tool), *arguments], capture_output=True, text=True, env=environment
    )
    if done.returncode != 0:
        raise SimulationError(f"{tool}: {(done.stderr or done.stdout).strip()}")
    return done.stdout


def _partition_table(kind: int, blocks: int, start: int = PARTITION_START) -> bytes:
    """A master boot record with one partition."""
    entry = struct.pack("<B3sB3sII", 0, b"\xfe\xff\xff", kind, b"\xfe\xff\xff", start, blocks)
    return (bytes(446) + entry).ljust(510, b"\0") + b"\x55\xaa"


def _exfat_boot_sector(blocks: int) -> bytes:
    """The main boot sector of the exFAT specification 1.00, section 3.1."""
    fat_offset, heap_offset, cluster_shift = 128, 256, 6
    clusters = (blocks - heap_offset) >> cluster_shift
    fields = struct.pack(
        "<QQIIIIIIHHBBBBB",
        *(PARTITION_START, blocks, fat_offset, 128, heap_offset, clusters, 4, 0x12345678),
        *(0x0100, 0, 9, cluster_shift, 1, 0x80, 0),
    )
    head = b"\xeb\x76\x90" + b"EXFAT   " + bytes(53)
    return (head + fields).ljust(510, b"\0") + b"\x55\xaa"
