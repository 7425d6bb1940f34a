"""Locks: two wheelhops do not change the same files at the same time.

A folder is locked itself, so that nothing is left in it. A claim, and the lock of a folder on a
file system that cannot lock folders (NFS, Windows), is a file in a folder of this user's alone:
nobody else can put a link in its place, or be in the way with his. It is deleted when it is given
back; what a killed process leaves locks nothing, and is used again.
"""

import contextlib
import errno
import hashlib
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from wheelhop.files.error import InputError
from wheelhop.files.folders import runtime_folder

PATIENCE_S = 60.0
POLL_S = 0.02
CANNOT_LOCK = (errno.EBADF, errno.EINVAL, errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP)

Release = Callable[[], None]


@contextmanager
def locked(folder: Path, kind: type[InputError] = InputError) -> Iterator[None]:
    """Keep every other wheelhop from changing what is in `folder` while the block reads and writes.

    The lock ends with the process, however that ends. Raises an error of this `kind` if another
    process holds it for longer than a minute.
    """
    until_s = time.monotonic() + PATIENCE_S
    while (release := _take_folder(folder, kind)) is None:
        if time.monotonic() > until_s:
            raise kind(f"{folder}: another wheelhop is changing it: try again when it is done")
        time.sleep(POLL_S)
    try:
        yield
    finally:
        release()


@contextmanager
def claimed(folder: Path, purpose: str, kind: type[InputError] = InputError) -> Iterator[None]:
    """Keep a second program of the same purpose out of `folder` while the block runs; programs that
    change files in it meanwhile are not hindered.

    The claim ends with the process, however that ends. Raises an error of this `kind` at once if
    another process of this user on this computer has it.
    """
    release = _take_file(folder / purpose, kind)
    if release is None:
        raise kind(f"{folder}: a {purpose} is open on it already: use that one, or end it")
    try:
        yield
    finally:
        release()


def _take_folder(folder: Path, kind: type[InputError]) -> Release | None:
    """What gives the lock of a folder back; None if another process has it."""
    if sys.platform != "win32":
        lock = os.open(folder, os.O_RDONLY)
        try:
            if _take(lock):
                return partial(os.close, lock)
            os.close(lock)
            return None
        except OSError as error:
            os.close(lock)
            if error.errno not in CANNOT_LOCK:
                raise
    return _take_file(folder, kind)


def _take_file(guarded: Path, kind: type[InputError]) -> Release | None:
    """Lock a file in the runtime directory that stands for a path."""
    name = hashlib.sha256(os.fsencode(guarded.resolve())).hexdigest()[:16]
    path = runtime_folder(kind) / f"{name}.lock"
    try:
        while True:
            file = os.open(path, os.O_CREAT | os.O_RDWR | getattr(os, "O_NOFOLLOW", 0), 0o600)
            try:
                if not _take(file):
                    os.close(file)
                    return None
                if _is_at(path, file):
                    return partial(_give_back, path, file)
            except BaseException:
                os.close(file)
                raise
            os.close(file)  # who had it has deleted it since it was opened
    except OSError as error:
        raise kind(f"{path}: cannot be locked: {error.strerror or error}: delete it") from None


def _is_at(path: Path, file: int) -> bool:
    """Whether a file that was opened at a path is there still."""
    try:
        return os.path.samestat(os.fstat(file), path.lstat())
    except FileNotFoundError:
        return False


def _give_back(path: Path, file: int) -> None:
    if sys.platform == "win32":  # what is open cannot be deleted: if another has it now, it stays
        os.close(file)
        with contextlib.suppress(OSError):
            path.unlink()
    else:
        with contextlib.suppress(OSError):
            path.unlink()
        os.close(file)


if sys.platform == "win32":
    import msvcrt

    def _take(lock: int) -> bool:
        try:
            msvcrt.locking(lock, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

else:
    import fcntl

    def _take(lock: int) -> bool:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True
