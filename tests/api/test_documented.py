"""Every public function and method says what it takes, what it gives, and what it raises."""

import inspect
import re

import pytest

import wheelhop as wh

BY_HOOKS = (wh.Effect, wh.Model, wh.Log)
"""Of these docs/python.md names no method but those of docs/writing-an-effect.md."""
SECTION = re.compile(r"^(Parameters|Returns|Raises)\n-+\n", re.M)


def public():
    """Functions, and the methods of public classes, as (name, function)."""
    for name in wh.__all__:
        value = getattr(wh, name)
        if inspect.isfunction(value):
            yield name, value
        elif isinstance(value, type):
            for member, what in inspect.getmembers(value):
                function = inspect.unwrap(what) if callable(what) else what
                ours = getattr(function, "__module__", "") or ""
                if (
                    inspect.isfunction(function)
                    and not member.startswith("_")
                    and ours.startswith("wheelhop")
                    and value not in BY_HOOKS
                ):
                    yield f"{name}.{member}", function


PUBLIC = dict(public())


def sections(function):
    """The parts of a docstring by their headings."""
    parts = SECTION.split(inspect.getdoc(function))
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def arguments(function):
    names = list(inspect.signature(function).parameters)
    return [name for name in names if name not in ("self", "cls")]


@pytest.mark.parametrize("name", PUBLIC)
def test_every_argument_is_told(name):
    told = sections(PUBLIC[name]).get("Parameters", "")
    named = {
        word.strip()
        for line in told.splitlines()
        if line and not line.startswith(" ")
        for word in line.split(",")
    }
    assert set(arguments(PUBLIC[name])) == named


@pytest.mark.parametrize("name", PUBLIC)
def test_what_comes_back_is_told(name):
    returned = inspect.signature(PUBLIC[name]).return_annotation
    assert ("Returns" in sections(PUBLIC[name])) == (returned not in (None, "None")), returned


@pytest.mark.parametrize("name", [name for name in PUBLIC if "." not in name])
def test_what_is_raised_is_told(name):
    assert "Raises" in sections(PUBLIC[name])


@pytest.mark.parametrize("name", PUBLIC)
def test_what_is_said_to_be_raised_exists(name):
    for line in sections(PUBLIC[name]).get("Raises", "").splitlines():
        if line and not line.startswith(" "):
            assert line in ("ValueError", "KeyError") or line.endswith("Error"), line
