"""Reading files of people: plain files only, and never more than the memory can hold.

What a file will take is known before it is read: from its size, and where it is packed, from the
rows and columns that it says it holds.
"""

import codecs
import hashlib
import os
import stat
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from wheelhop.files.error import InputError

TABLE = 20.0
"""Bytes of memory for each byte of a text that becomes lines and cells: a cell of six characters
takes some 70 as a text of its own, and 8 as a number."""
NUMBERS = 3 * 8.0
"""Bytes for each number of a packed file: as it is unpacked, as a column, and in the table."""
SILENT_BYTES = 4e9  # that a system which does not say is taken to have
PIECE_BYTES = 1 << 20
RESERVED_BYTES = 1 << 26  # zeros behind a text, at most
LIMIT = Path("/sys/fs/cgroup/memory.max")  # of a container
USED = Path("/sys/fs/cgroup/memory.current")


def check_plain(path: Path, kind: type[InputError] = InputError, medium: bool = False) -> None:
    """Raise an error of this `kind` for a folder, a pipe, a socket or a device: what has no end, or
    waits for somebody, is not read. A `medium`, such as a card, may be read. What cannot be looked
    at is left to who reads it."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return
    if stat.S_ISDIR(mode):
        raise kind(f"{path}: is a folder, not a file")
    if not (stat.S_ISREG(mode) or (medium and stat.S_ISBLK(mode))):
        raise kind(f"{path}: is a pipe or a device, not a file: save what comes from it in a file")


def check_room(path: Path, needed_bytes: float, kind: type[InputError] = InputError) -> None:
    """Raise an error of this `kind` if what is in a file takes more memory than is free."""
    free = free_bytes()
    if needed_bytes > free:
        raise kind(
            f"{path}: takes about {needed_bytes / 1e9:.3g} GB of memory, and {free / 1e9:.3g} GB"
            " are free: cut it into shorter files, or read it where there is more"
        ) from MemoryError()


def read_bytes(path: Path, kind: type[InputError] = InputError, times: float = 1.0) -> bytes:
    """What is in a plain file; it takes `times` its size. Raises an error of this `kind` as
    `check_plain` and `check_room` do, and OSError."""
    check_plain(path, kind)
    with path.open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        check_room(path, times * size, kind)
        return file.read(size)


def read_text_bytes(path: Path, kind: type[InputError] = InputError) -> bytes:
    """As `read_bytes`, of a text that becomes a table. A zero byte, which no text has, ends the
    reading: what follows may be a hole of any size. UTF-16 begins with its mark."""
    return _until_zero(path, kind, 0)[0]


def read_text_and_zeros(path: Path, kind: type[InputError] = InputError) -> tuple[bytes, int]:
    """As `read_text_bytes`, and how many zero bytes stand behind the text, up to `RESERVED_BYTES`:
    loggers reserve room before they write. Zeros that are not the end raise an error of this
    `kind`."""
    return _until_zero(path, kind, RESERVED_BYTES)


def _until_zero(path: Path, kind: type[InputError], spare: int) -> tuple[bytes, int]:
    check_plain(path, kind)
    data = bytearray()
    with path.open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        check_room(path, TABLE * size, kind)
        while more := file.read(min(PIECE_BYTES, size - len(data))):
            begun = len(data)
            data += more
            if b"\0" in more and not data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
                first = begun + more.index(0)
                if size - first > spare or (data[first:] + file.read(spare)).strip(b"\0"):
                    raise kind(
                        f"{path}: byte {first} is zero: it is no text, or was cut off"
                        " while it was written: save it anew"
                    )
                return bytes(data[:first]), size - first
    return bytes(data), 0


def digest(path: Path) -> str:
    """SHA-256 of a file, hexadecimal; it is read again only after it was changed. Raises OSError,
    and InputError for what is no plain file."""
    check_plain(path)
    found = path.stat()
    return _digest(path, found.st_mtime_ns, found.st_size, found.st_ino)


@lru_cache(maxsize=4096)
def _digest(path: Path, *as_it_is: int) -> str:
    with path.open("rb") as data:
        return hashlib.file_digest(data, "sha256").hexdigest()


def free_bytes() -> float:
    """Memory that can be had, as the system says."""
    found = [SILENT_BYTES]
    with suppress(AttributeError, OSError, ValueError):  # Windows has no sysconf
        found = [float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))]
    with suppress(OSError, ValueError, IndexError):
        told = Path("/proc/meminfo").read_text(encoding="ascii").split("MemAvailable:")[1]
        found.append(1024.0 * float(told.split()[0]))
    with suppress(OSError, ValueError):  # "max": no limit
        found.append(float(LIMIT.read_text()) - float(USED.read_text()))
    return min(found)
