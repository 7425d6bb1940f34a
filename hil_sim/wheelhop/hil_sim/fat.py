"""Just enough of FAT16 and FAT32 to read files quickly and to scatter one.

Source: Microsoft, FAT: General Overview of On-Disk Format, version 1.03.
"""

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.hil_sim.program import SimulationError

BLOCK_SIZE = 512
ENTRY_SIZE = 32
VOLUME_ID, DIRECTORY = 0x08, 0x10  # a part of a long name has VOLUME_ID, too
FAT32_MASK, BAD_CLUSTER = 0x0FFFFFFF, 0x0FFFFFF7


class Fat:
    """The file system that begins at block `start` of an image. Raises `SimulationError`."""

    def __init__(self, path: Path, start: int):
        self.path = path
        boot = self._bytes_at(start * BLOCK_SIZE, BLOCK_SIZE)
        bytes_per_sector, per_cluster, reserved, fats, root_entries = struct.unpack_from(
            "<HBHBH", boot, 11
        )
        fat_size = struct.unpack_from("<H", boot, 22)[0] or struct.unpack_from("<I", boot, 36)[0]
        total = struct.unpack_from("<H", boot, 19)[0] or struct.unpack_from("<I", boot, 32)[0]
        if bytes_per_sector != BLOCK_SIZE or not (per_cluster and fats and fat_size):
            raise SimulationError(f"{path}: no FAT file system at block {start}")
        root_blocks = -(-root_entries * ENTRY_SIZE // BLOCK_SIZE)
        self.cluster_size: int = per_cluster * BLOCK_SIZE
        self._fats = [(start + reserved + i * fat_size) * BLOCK_SIZE for i in range(fats)]
        self._root = (start + reserved + fats * fat_size) * BLOCK_SIZE
        self._root_size = root_blocks * BLOCK_SIZE
        self._data: int = self._root + self._root_size
        self.clusters = (total - reserved - fats * fat_size - root_blocks) // per_cluster
        self.is_fat32 = self.clusters >= 65525
        self._free_count = (start + struct.unpack_from("<H", boot, 48)[0]) * BLOCK_SIZE + 488
        self._root_cluster = struct.unpack_from("<I", boot, 44)[0]

    def files(self) -> dict[str, int]:
        """Names and sizes of the files in the root directory."""
        return {name: size for name, _, size in self._entries()}

    def read(self, name: str, limit: int | None = None) -> bytes:
        """The content of a file, or its beginning."""
        first, size = self._find(name)
        wanted = size if limit is None else min(size, limit)
        content = bytearray()
        with self.path.open("rb") as file:
            for cluster in self._chain(first):
                if len(content) >= wanted:
                    break
                file.seek(self._offset(cluster))
                content += file.read(self.cluster_size)
        return bytes(content[:wanted])

    def free_bytes(self) -> int:
        """Room in free clusters."""
        return int(np.count_nonzero(self._table()[2:] == 0)) * self.cluster_size

    def scatter(self, name: str, free_run: int) -> None:
        """Give a file one cluster in every `free_run` + 1 of those it has, and free the others.

        The root directory then has what is left of the size.
        """
        first, _ = self._find(name)
        table = self._table()
        had = list(self._chain(first))
        kept = had[:: free_run + 1]
        end = FAT32_MASK if self.is_fat32 else 0xFFFF
        table[had] = 0
        table[kept] = [*kept[1:], end]
        self._write_table(table)
        with self.path.open("r+b") as file:
            file.seek(self._entry_offset(name) + 28)
            file.write(struct.pack("<I", len(kept) * self.cluster_size))

    def reserve(self, leave: int) -> None:
        """Mark all free clusters but the last ones, `leave` bytes of them, as bad."""
        table = self._table()
        free = np.flatnonzero(table == 0)
        bad = BAD_CLUSTER & (FAT32_MASK if self.is_fat32 else 0xFFFF)
        table[free[: len(free) - leave // self.cluster_size]] = bad
        self._write_table(table)

    def _bytes_at(self, offset: int, count: int) -> bytes:
        with self.path.open("rb") as file:
            file.seek(offset)
            return file.read(count)

    def _offset(self, cluster: int) -> int:
        return self._data + (cluster - 2) * self.cluster_size

    def _table(self) -> NDArray[np.int64]:
        width = 4 if self.is_fat32 else 2
        raw = self._bytes_at(self._fats[0], (self.clusters + 2) * width)
        return np.frombuffer(raw, dtype=f"<u{width}").astype(np.int64)

    def _write_table(self, table: NDArray[np.int64]) -> None:
        """Write all copies of the table, and the number of free clusters."""
        with self.path.open("r+b") as file:
            for fat in self._fats:
                file.seek(fat)
                file.write(table.astype("<u4" if self.is_fat32 else "<u2").tobytes())
            if self.is_fat32:
                file.seek(self._free_count)
                file.write(struct.pack("<I", np.count_nonzero(table[2:] == 0)))

    def _chain(self, cluster: int) -> Iterator[int]:
        table = self._table()
        for _ in range(self.clusters):
            if not 2 <= cluster < self.clusters + 2:
                return
            yield cluster
            cluster = int(table[cluster]) & (FAT32_MASK if self.is_fat32 else 0xFFFF)

    def _directory(self) -> Iterator[tuple[int, bytes]]:
        """Offset in the image and bytes of every entry of the root directory."""
        if self.is_fat32:
            pieces = [(self._offset(c), self.cluster_size) for c in self._chain(self._root_cluster)]
        else:
            pieces = [(self._root, self._root_size)]
        for offset, size in pieces:
            block = self._bytes_at(offset, size)
            for i in range(0, size, ENTRY_SIZE):
                if block[i] == 0:
                    return
                yield offset + i, block[i : i + ENTRY_SIZE]

    def _entries(self) -> Iterator[tuple[str, int, int]]:
        """Name, first cluster and size of the files."""
        for _, entry in self._directory():
            if entry[0] == 0xE5 or entry[11] & (VOLUME_ID | DIRECTORY):
                continue
            high, low, size = struct.unpack_from("<H4xHI", entry, 20)
            yield _name(entry), (high << 16 if self.is_fat32 else 0) | low, size

    def _find(self, name: str) -> tuple[int, int]:
        for found, first, size in self._entries():
            if found == name.upper():
                return first, size
        raise SimulationError(f"{self.path}: there is no file {name} on the card")

    def _entry_offset(self, name: str) -> int:
        return next(o for o, entry in self._directory() if _name(entry) == name.upper())


def _name(entry: bytes) -> str:
    stem, suffix = (entry[a:b].decode("latin-1").rstrip() for a, b in ((0, 8), (8, 11)))
    return f"{stem}.{suffix}" if suffix else stem
