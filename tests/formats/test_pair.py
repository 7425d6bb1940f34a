"""Samples and the header beside them: whatever ends a program while it writes the two, they are
read as those of before, as those of after, or not at all; never the numbers of one under the units
of the other."""

import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.formats.recordings import believed
from wheelhop.formats import ExchangeError, read, registry, write
from wheelhop.formats.header import sidecar
from wheelhop.logger.recording import Channel, Recording

BEFORE = Recording(np.array([[1.25], [-3.5], [2.0], [0.5]]), 100.0, (Channel("A1", "m/s²"),))
AFTER = replace(BEFORE, values=100.0 * BEFORE.values + 512.0, channels=(Channel("A1", "code"),))
WRITING = {registry.__file__, sys.modules["wheelhop.files.write"].__file__}
SUFFIXES = (".csv", ".uff")


def same(one: Recording, other: Recording) -> bool:
    units = [[c.unit for c in r.channels] for r in (one, other)]
    return units[0] == units[1] and np.array_equal(one.values, other.values)


def check(path: Path, existed: bool, where: object) -> str:
    """Which of the two recordings is read, "" for neither; anything else fails."""
    if not path.exists():
        assert not existed, where
        return ""
    try:
        found = read(path)
    except ExchangeError as error:
        line = str(error)
        assert "is the header of other samples" in line and "write both again" in line, where
        assert line.isprintable(), where
        return ""
    assert same(found, AFTER) or (existed and same(found, BEFORE)), (where, found.channels)
    return "after" if same(found, AFTER) else "before"


def begun(folder: Path, suffix: str, existed: bool) -> Path:
    folder.mkdir()
    path = folder / f"run{suffix}"
    if existed:
        write(BEFORE, path)
    return path


def rename_that_ends(at: int, after: bool, end):
    """os.replace, whose call number `at` is the last thing that happens."""
    rename, calls = os.replace, [0]

    def ending(source, target):
        calls[0] += 1
        if calls[0] < at:
            return rename(source, target)
        if after:
            rename(source, target)
        return end()

    return ending


@pytest.mark.skipif(not hasattr(os, "fork"), reason="a process that is killed is a fork of this")
@pytest.mark.parametrize("existed", [False, True], ids=["new", "replaced"])
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_killed_before_or_after_any_rename(suffix, existed, tmp_path):
    seen = set()
    for at in (1, 2):
        for after in (False, True):
            path = begun(tmp_path / f"{at}{after}", suffix, existed)
            child = os.fork()
            if child == 0:
                os.replace = rename_that_ends(at, after, lambda: os._exit(7))
                write(AFTER, path)
                os._exit(0)
            assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
            seen.add(check(path, existed, (at, after)))
            write(AFTER, path)
            assert same(read(path), AFTER)
    assert seen == ({"before", "", "after"} if existed else {"", "after"})


@pytest.mark.parametrize("error", [KeyboardInterrupt, PermissionError])
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_what_fails_before_or_after_any_rename_leaves_a_pair(suffix, error, tmp_path, monkeypatch):
    """Nothing has to be asked of the user, where the program lives on to tidy up."""

    def fail():
        raise error(13, "Permission denied")

    for at in (1, 2):
        for after in (False, True):
            path = begun(tmp_path / f"{at}{after}", suffix, True)
            with monkeypatch.context() as patched:
                patched.setattr(os, "replace", once(rename_that_ends(at, after, fail)))
                with pytest.raises((KeyboardInterrupt, ExchangeError)):
                    write(AFTER, path)
            replaced = (at, after) == (2, True)
            assert check(path, True, (at, after)) == ("after" if replaced else "before")
            assert {file.name for file in path.parent.iterdir()} == {path.name, f"{path.name}.toml"}


def once(rename):
    """The rename that fails, and from then on the one that works."""
    works = os.replace

    def first(source, target):
        try:
            return rename(source, target)
        except BaseException:
            os.replace = works
            raise

    return first


@pytest.mark.parametrize("existed", [False, True], ids=["new", "replaced"])
def test_interrupted_in_any_line(existed, tmp_path):
    """Ctrl-C strikes at each line in turn of what writes the two files."""
    line, seen = 0, []
    while True:
        line += 1
        path = begun(tmp_path / str(line), ".csv", existed)
        left = [line]

        def strike(frame, event, argument, left=left):
            if frame.f_code.co_filename not in WRITING:
                return None
            if event == "line":
                left[0] -= 1
                if left[0] == 0:
                    raise KeyboardInterrupt
            return strike

        before = sys.gettrace()
        sys.settrace(strike)
        try:
            write(AFTER, path)
        except KeyboardInterrupt:
            pass
        finally:
            sys.settrace(before)
        seen.append(check(path, existed, line))
        if left[0] > 0:
            break
    assert len(seen) > 60 and seen[-1] == "after"
    assert seen[0] == ("before" if existed else "")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_samples_of_another_program_are_not_read_under_a_header_that_was_left(suffix, tmp_path):
    for name, recording in (("run", BEFORE), ("other", AFTER)):
        write(recording, tmp_path / f"{name}{suffix}")
    path = tmp_path / f"run{suffix}"
    (tmp_path / f"other{suffix}").replace(path)
    assert check(path, True, "copied over") == ""
    sidecar(tmp_path / f"other{suffix}").replace(sidecar(path))
    assert check(path, True, "with its header") == "after"


def test_a_header_that_does_not_name_its_samples_is_believed(tmp_path):
    """As wheelhop wrote them before, and as the user says who has edited the samples himself."""
    path = tmp_path / "run.csv"
    write(BEFORE, path)
    path.write_text(path.read_text().replace("-3.5", "-3.75"))
    assert check(path, True, "edited") == ""
    believed(path)
    assert read(path).values[1, 0] == -3.75


def test_line_ends_of_another_system_are_the_same_samples(tmp_path):
    path = tmp_path / "run.csv"
    write(BEFORE, path)
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert check(path, True, "CRLF") == "before"
