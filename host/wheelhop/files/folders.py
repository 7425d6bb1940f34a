"""Folders of one user's alone, for what other users must neither put there nor change."""

import contextlib
import os
import stat
import sys
import tempfile
from pathlib import Path

from wheelhop.files.error import InputError

CACHES = {"darwin": "Library/Caches", "win32": "AppData/Local"}


def runtime_folder(kind: type[InputError] = InputError) -> Path:
    """A folder of this user's alone, on this computer, for what ends with the processes that use
    it; made if need be.

    It is `wheelhop` in XDG_RUNTIME_DIR (XDG Base Directory Specification), else `wheelhop-UID`
    among the temporary files, which Windows and macOS keep for each user apart. Raises an error of
    this `kind` where that belongs to another user, or others may enter it.
    """
    parent = Path(tempfile.gettempdir())
    name = "wheelhop"
    if sys.platform != "win32":
        given = Path(os.environ.get("XDG_RUNTIME_DIR") or f"/run/user/{os.geteuid()}")
        if given.is_absolute() and _is_own(given):
            parent = given
        else:
            name = f"wheelhop-{os.geteuid()}"
    return own_folder(parent / name, kind)


def own_folder(folder: Path, kind: type[InputError] = InputError) -> Path:
    """Make a folder that only this user may enter, those above it too. Raises an error of this
    `kind` if what is there already is another user's, a link, or open to others."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(FileExistsError):
            folder.mkdir(mode=0o700)
    except OSError as error:
        raise kind(f"{folder}: cannot be made: {error.strerror or error}") from None
    if not _is_own(folder):
        raise kind(f"{folder}: is not a folder that only you may enter: delete it (or chmod 700)")
    return folder


def _is_own(folder: Path) -> bool:
    try:
        found = folder.lstat()
    except OSError:
        return False
    if sys.platform == "win32":  # a profile is its user's by its access control list
        return stat.S_ISDIR(found.st_mode)
    closed = not found.st_mode & 0o077
    return stat.S_ISDIR(found.st_mode) and found.st_uid == os.geteuid() and closed


def cache_folder() -> Path:
    """Where wheelhop keeps for this user what can be made again: in XDG_CACHE_HOME, or where the
    system has such files. It may not be there."""
    given = os.environ.get("XDG_CACHE_HOME")
    return Path(given or Path.home() / CACHES.get(sys.platform, ".cache")) / "wheelhop"
