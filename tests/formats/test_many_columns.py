"""A file of many columns: the work grows with their number, not with its square."""

import sys
from pathlib import Path

import numpy as np
import pytest

from tests.formats.foreign import LVM
from wheelhop.formats import Map, lvm, mdf, read
from wheelhop.formats.mapping import Pick
from wheelhop.formats.table import Table, to_recording
from wheelhop.logger.recording import Channel

STEPS = 0


class Name(str):
    """A name that counts how often it is compared or looked up."""

    def __eq__(self, other):
        count(1)
        return str.__eq__(self, other)

    def __hash__(self):
        count(1)
        return str.__hash__(self)


class Number(int):
    """A number of a column that counts as a name does."""

    def __eq__(self, other):
        count(1)
        return int.__eq__(self, other)

    def __hash__(self):
        count(1)
        return int.__hash__(self)


def count(more):
    global STEPS
    STEPS += more


def steps(work, *arguments):
    """How much `work` counts."""
    global STEPS
    STEPS = 0
    work(*arguments)
    return STEPS


def convert(columns, by_name):
    """Make a recording of all columns of a table, each picked."""
    names = [Name(f"c{k}") for k in range(columns)]
    numbers = tuple(Number(k + 1) for k in range(columns))
    channels = tuple(Channel(name, "m/s²") for name in names)
    values = np.zeros((2, columns))
    table = Table(Path("x"), "text", channels, values, rate_hz=100.0, numbers=numbers)
    picks = tuple(Pick(key) for key in (names if by_name else numbers))
    assert to_recording(table, Map(picks=picks)).values.shape == (2, columns)


@pytest.mark.parametrize("by_name", [True, False])
def test_twice_the_columns_are_picked_with_twice_the_work(by_name):
    assert steps(convert, 400, by_name) <= 2.1 * steps(convert, 200, by_name)


def test_twice_the_groups_of_an_mdf_are_joined_with_twice_the_work(tmp_path, monkeypatch):
    """As most tools write it: a group for each channel. What is copied is counted."""
    asammdf = pytest.importorskip("asammdf")
    column_stack = np.column_stack

    def counted(parts):
        made = column_stack(parts)
        count(made.size)
        return made

    def file(groups):
        path = tmp_path / f"{groups}.mf4"
        time_s = np.arange(20) / 100.0
        with asammdf.MDF() as made:
            for k in range(groups):
                made.append([asammdf.Signal(np.ones(20), time_s, name=f"c{k}", unit="m/s^2")])
            made.save(path)
        return path

    paths = file(30), file(60)
    monkeypatch.setattr(mdf.np, "column_stack", counted)
    few, many = (steps(read, path) for path in paths)
    assert read(paths[1]).values.shape == (20, 60)
    assert many <= 2.1 * few


def test_twice_the_columns_of_labview_take_twice_the_instructions(tmp_path):
    """Instructions of Python in the module that reads them."""

    def file(columns):
        head = "".join(f"c{k}\t" for k in range(columns))
        rows = "".join(f"0,0{k}" + "\t0,5" * columns + "\n" for k in range(3))
        path = tmp_path / f"{columns}.lvm"
        segment = f"***End_of_Header***\nX_Value\t{head}Comment\n"
        path.write_text(LVM.format(x_columns="One") + segment + rows)
        return path

    def trace(frame, event, argument):
        if frame.f_code.co_filename != lvm.__file__:
            return None
        frame.f_trace_opcodes = True
        count(event == "opcode")
        return trace

    def traced(path):
        before = sys.gettrace()
        sys.settrace(trace)
        try:
            assert read(path).values.shape == (3, int(path.stem))
        finally:
            sys.settrace(before)

    paths = file(200), file(400)
    few, many = (steps(traced, path) for path in paths)
    assert few > 1000 and many <= 2.1 * few
