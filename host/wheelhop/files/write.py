"""Writing files that people keep: each is replaced whole, or stays as it was.

A file is written beside its place, brought to the disk, and then given its name; the folder is
brought to the disk after that. File systems promise no less than these four steps need, and few
promise more (Pillai et al., "All File Systems Are Not Created Equal", OSDI 2014, table 1).
"""

import contextlib
import errno
import json
import os
import secrets
import shutil
import stat
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

from wheelhop.files.error import InputError

DRAFT = ".wheelhop-"
"""How the names of drafts begin. After a power cut one may be left; it can be deleted."""
CANNOT_SYNC = (errno.EINVAL, errno.ENOSYS, errno.EOPNOTSUPP)
OPEN_FILES = ("/dev", "/dev/fd", "/proc/self/fd")
PICTURES = (".png", ".svg", ".pdf")


class Picture(Protocol):
    """What matplotlib calls a Figure."""

    def savefig(self, fname: Any, **options: Any) -> Any:
        """Draw into a file."""


def write_text(
    path: Path, text: str, kind: type[InputError] = InputError, within: Path | None = None
) -> None:
    """Replace a text file (UTF-8, line ends "\\n") as `replacing` does."""
    with replacing(path, kind, within) as draft:
        draft.write_text(text, encoding="utf-8", newline="\n")


def write_picture(
    path: Path, picture: Picture, dpi: int = 150, kind: type[InputError] = InputError
) -> None:
    """Replace a picture as `replacing` does; `check_picture` says which names it may have."""
    check_picture(path, kind)
    with replacing(path, kind) as draft:
        picture.savefig(draft, dpi=dpi, format=path.suffix.lower().removeprefix(".") or "png")


@contextmanager
def replacing(
    path: Path, kind: type[InputError] = InputError, within: Path | None = None
) -> Iterator[Path]:
    """A draft for the block to write, which takes the place of `path` when the block is done.

    It has the suffix of `path`. If anything fails, `path` is as it was and the draft is gone. A
    link is followed inside the folder `within` (default: that of `path`) and refused if it leads
    out of it. A device or a pipe is written as it is. Raises an error of this `kind` for whatever
    the disk refuses.
    """
    target, kept = path, ""
    try:
        plain = check_target(path, kind, within)
        if plain is None:
            yield path
            return
        target, kept = plain, "; it is as it was before"
        draft = _new_draft(target)
        try:
            yield draft
            _finish(draft, target)
        finally:
            with contextlib.suppress(OSError):
                draft.unlink(missing_ok=True)
    except BrokenPipeError:
        raise
    except (OSError, RuntimeError) as error:  # RuntimeError: a loop of links
        reason = getattr(error, "strerror", None) or error
        raise kind(f"{path}: cannot be written: {reason}{kept}") from None
    sync_folder(target.parent)


def remove(made: Sequence[Path]) -> None:
    """Delete files and folders that were just made, the last first; folders in use stay."""
    for path in reversed(made):
        with contextlib.suppress(OSError):
            path.rmdir() if path.is_dir() else path.unlink(missing_ok=True)


def make_folder(folder: Path, kind: type[InputError] = InputError) -> list[Path]:
    """Make a folder and those above it; return those that were not there, parents first.

    Raises an error of this `kind` for whatever the disk refuses; then none is left.
    """
    made: list[Path] = []
    try:
        for missing in [f for f in (folder, *folder.parents) if not f.exists()][::-1]:
            missing.mkdir(exist_ok=True)
            made.append(missing)
    except OSError as error:
        remove(made)
        raise kind(f"{folder}: cannot be made: {error.strerror or error}") from None
    return made


@contextmanager
def made_folder(folder: Path) -> Iterator[None]:
    """A folder for the block to write into; if that fails, it goes again where it was not there."""
    made = make_folder(folder)
    try:
        yield
    except BaseException:
        remove(made)
        raise


@contextmanager
def new_folder(folder: Path, kind: type[InputError] = InputError) -> Iterator[Path]:
    """A draft of a folder for the block to fill, which becomes `folder` when the block is done.

    `folder` must not be there, or be empty. If anything fails there is no trace of the draft;
    only a power cut or SIGKILL may leave one. Raises an error of this `kind` for whatever the disk
    refuses.
    """
    try:
        if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
            raise kind(f"{folder}: is there already, and is no folder: choose another name")
        if folder.is_dir() and any(folder.iterdir()):
            raise kind(f"{folder}: is there already, and not empty: choose another name")
        made = make_folder(folder.parent, kind)
        draft = folder.with_name(f"{DRAFT}{secrets.token_hex(6)}")
        try:
            draft.mkdir()
            yield draft
            for inner in (draft, *(path for path in draft.rglob("*") if path.is_dir())):
                sync_folder(inner)
            if folder.is_dir():
                folder.rmdir()
            draft.replace(folder)
        except BaseException:
            shutil.rmtree(draft, ignore_errors=True)
            remove(made)
            raise
    except OSError as error:
        raise kind(f"{folder}: cannot be written: {error.strerror or error}") from None
    sync_folder(folder.parent)


def is_draft(path: Path) -> bool:
    """Whether a file is a draft that a power cut has left behind."""
    return path.name.startswith(DRAFT)


def quoted(text: str) -> str:
    """A text as a basic string of TOML: a JSON string is one, once DEL is escaped too."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def check_target(
    path: Path, kind: type[InputError] = InputError, within: Path | None = None
) -> Path | None:
    """The plain file that `replacing` would replace; None for what is written as it is.

    Raises an error of this `kind` for a folder, a file in a folder that is not there, a link out of
    the folder `within`, and a file that is read-only.
    """
    place = Path(os.path.abspath(path))
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        mode = stat.S_IFREG
    if stat.S_ISDIR(mode):
        raise kind(f"{path}: is a folder; give the name of a file to write")
    if not stat.S_ISREG(mode) or str(place.parent) in OPEN_FILES:  # /dev/stdout may be a file
        return None
    target, folder = place.resolve(), (within or place.parent).resolve()
    if not target.is_relative_to(folder):
        raise kind(
            f"{path}: is a link out of its folder, to {target}: delete the link, or name that file"
        )
    if not target.parent.is_dir():
        raise kind(f"{path}: cannot be written, there is no folder {path.parent}")
    if target.exists() and not os.access(target, os.W_OK):
        raise kind(f"{path}: cannot be written: it is read-only")
    return target


def check_new(path: Path, kind: type[InputError] = InputError) -> None:
    """As `check_target`, and an error for a file that is there: nobody shall lose it."""
    if check_target(path, kind) is not None and path.exists():
        raise kind(f"{path}: is there already: choose another name, or delete it first")


def check_picture(path: Path, kind: type[InputError] = InputError) -> None:
    """As `check_target`, and an error for a name that does not say how to draw."""
    if check_target(path, kind) is not None and path.suffix.lower() not in PICTURES:
        raise kind(f"{path}: a picture is {', '.join(PICTURES)}: give it such a name")


def _new_draft(target: Path) -> Path:
    draft = target.with_name(f"{DRAFT}{secrets.token_hex(6)}{target.suffix}")
    os.close(os.open(draft, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    return draft


def _finish(draft: Path, target: Path) -> None:
    if target.exists():
        draft.chmod(stat.S_IMODE(target.stat().st_mode))
    file = os.open(draft, os.O_RDWR)
    try:
        os.fsync(file)
    except OSError as error:
        if error.errno not in CANNOT_SYNC:  # some file systems have nothing to bring to a disk
            raise
    finally:
        os.close(file)
    os.replace(draft, target)


def sync_folder(folder: Path) -> None:
    """Bring to the disk which names the files in `folder` have, if the system can.

    What is in the files is safe by then, and the names are whole before and after: like SQLite, we
    do not call a file unwritten because of them.
    """
    if sys.platform != "win32":  # there names are in NTFS's journal; a folder cannot be opened
        with contextlib.suppress(OSError):
            file = os.open(folder, os.O_RDONLY)
            try:
                os.fsync(file)
            finally:
                os.close(file)
