"""Locks are this user's alone, follow no link, outlive no process, and leave nothing behind."""

import errno
import hashlib
import os
import stat
import sys
import tempfile
from pathlib import Path

import pytest

from wheelhop.files import InputError, claimed, locked

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="owners and modes are POSIX's")


def name_of(guarded: Path) -> str:
    return hashlib.sha256(os.fsencode(guarded.resolve())).hexdigest()[:16]


@pytest.fixture
def shared(tmp_path, monkeypatch):
    """The folder for temporary files, that everybody may write into."""
    folder = tmp_path / "shared"
    folder.mkdir()
    folder.chmod(0o1777)
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


@pytest.fixture
def runtime(tmp_path, monkeypatch, shared):
    """The user's runtime directory, as the system makes it when he logs in."""
    folder = tmp_path / "runtime"
    folder.mkdir(mode=0o700)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(folder))
    return folder


@pytest.fixture
def without_runtime(monkeypatch, shared):
    """None, as on macOS, or where nobody has logged in."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", "/nonexistent")
    return shared / f"wheelhop-{os.geteuid()}"


def refused(folder: Path, why: str) -> None:
    with pytest.raises(InputError, match=why), claimed(folder, "workbench"):
        pass


def files(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if not path.is_dir()]


def test_a_claim_is_in_the_users_own_folder_and_goes_with_its_end(tmp_path, runtime, shared):
    with claimed(tmp_path, "workbench"):
        (lock,) = files(runtime)
        assert stat.S_IMODE(lock.parent.stat().st_mode) == 0o700
        assert files(shared) == []
        refused(tmp_path, "a workbench is open on it already")
        assert files(runtime) == [lock]
    assert files(runtime) == []


def test_without_a_runtime_directory_it_is_a_closed_folder(tmp_path, without_runtime):
    with claimed(tmp_path, "workbench"):
        assert stat.S_IMODE(without_runtime.stat().st_mode) == 0o700
        assert len(files(without_runtime)) == 1
    assert files(without_runtime) == []


def test_a_link_among_the_temporary_files_is_not_followed(tmp_path, runtime, shared):
    """Its name can be foreseen by whoever knows the campaign's folder."""
    victim = tmp_path / "victim"
    name = name_of(tmp_path / "workbench")
    (shared / f"wheelhop-{name}.lock").symlink_to(victim)
    with claimed(tmp_path, "workbench"):
        assert not victim.exists()


def test_a_link_in_the_place_of_a_lock_is_refused_in_a_line(tmp_path, runtime):
    victim = tmp_path / "victim"
    (runtime / "wheelhop").mkdir(mode=0o700)
    link = runtime / "wheelhop" / f"{name_of(tmp_path / 'workbench')}.lock"
    link.symlink_to(victim)
    refused(tmp_path, rf"^{link}: cannot be locked: .*: delete it$")
    assert not victim.exists()


@pytest.mark.parametrize("how", ["open", "another's", "a link", "a file"])
def test_a_folder_that_is_not_the_users_alone_is_refused(how, tmp_path, without_runtime):
    if how == "a file":
        without_runtime.write_text("")
    elif how == "a link":
        (tmp_path / "elsewhere").mkdir(mode=0o700)
        without_runtime.symlink_to(tmp_path / "elsewhere")
    else:
        without_runtime.mkdir(mode=0o700)
        if how == "open":
            without_runtime.chmod(0o770)
        elif os.geteuid() == 0:
            os.chown(without_runtime, 12345, -1)
        else:
            pytest.skip("only root can give a folder away")
    refused(tmp_path, "is not a folder that only you may enter")
    assert files(tmp_path / "shared") in ([], [without_runtime])


def test_another_users_runtime_directory_is_not_entered(tmp_path, runtime, shared):
    """As after sudo, which may hand on the variable."""
    runtime.chmod(0o755)
    with claimed(tmp_path, "workbench"):
        assert files(runtime) == []
        assert len(files(shared / f"wheelhop-{os.geteuid()}")) == 1


def test_two_users_are_not_in_each_others_way(tmp_path, runtime, monkeypatch):
    other = tmp_path / "other"
    other.mkdir(mode=0o700)
    with claimed(tmp_path, "workbench"):
        monkeypatch.setenv("XDG_RUNTIME_DIR", str(other))
        with claimed(tmp_path, "workbench"):
            pass


def test_what_a_killed_process_leaves_locks_nothing_and_goes(tmp_path, runtime):
    child = os.fork()
    if child == 0:
        with claimed(tmp_path, "workbench"):
            os._exit(0)
    assert os.waitpid(child, 0)[1] == 0
    assert len(files(runtime)) == 1
    with claimed(tmp_path, "workbench"):
        pass
    assert files(runtime) == []


def test_a_lock_that_was_deleted_while_it_was_opened_is_taken_anew(tmp_path, runtime, monkeypatch):
    """Whoever had it gives it back, and deletes it, between our opening and our taking it."""
    from wheelhop.files import lock

    take, calls = lock._take, []

    def late(file):
        calls.append(file)
        if len(calls) == 1:
            (path,) = files(runtime)
            path.unlink()
        return take(file)

    monkeypatch.setattr(lock, "_take", late)
    with claimed(tmp_path, "workbench"):
        assert len(calls) == 2 and len(files(runtime)) == 1
        refused(tmp_path, "already")


def test_a_folder_that_cannot_be_locked_has_a_file_that_stands_for_it(
    tmp_path, runtime, monkeypatch
):
    """As on NFS, where flock takes a file that is open for writing."""
    import fcntl

    flock = fcntl.flock

    def of_files(file, how):
        if stat.S_ISDIR(os.fstat(file).st_mode):
            raise OSError(errno.EBADF, "Bad file descriptor")
        flock(file, how)

    monkeypatch.setattr(fcntl, "flock", of_files)
    monkeypatch.setattr("wheelhop.files.lock.PATIENCE_S", 0.0)
    with locked(tmp_path):
        assert len(files(runtime)) == 1
        with pytest.raises(InputError, match="another wheelhop"), locked(tmp_path):
            pass
    assert files(runtime) == []
