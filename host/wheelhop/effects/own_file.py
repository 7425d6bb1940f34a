"""Effects of a user's own file: the text that was read, and may have been reviewed, is what runs.

Python's import would prefer bytecode beside the file, `__pycache__/NAME.cpython-311.pyc`, without
comparing it with the text if that bytecode says so (PEP 552, "unchecked"), and numba would unpickle
compiled laws from there. Both may have come with the file from somebody else. Here the text itself
is compiled, in a module named by its hash, and its compiled laws are kept in the user's own cache
under that hash.
"""

from __future__ import annotations

import linecache
import re
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

from numba import NumbaError
from numba.core.caching import CacheImpl, _CacheLocator

from wheelhop.campaign import CampaignError
from wheelhop.effects.base import Effect
from wheelhop.files import Source, cache_folder, own_folder

MODULE = "wheelhop_user_"
"""How the modules' names begin, before the SHA-256 of the text."""


def read_source(path: Path) -> Source:
    """The text of a file with effects. Raises CampaignError where there is none to read."""
    if not path.is_file():
        raise CampaignError(f"{path}: there is no such file; --effects takes a Python file")
    return Source.read(path, CampaignError)


def effects_in(source: Source) -> list[type[Effect]]:
    """Run a text and return the effects it defines.

    Tracebacks, and what inspects the code, show the lines of this text under the file's name.
    Raises CampaignError for a file that is not called a Python file, a text that does not run, and
    one that holds no effect.
    """
    if source.path.suffix != ".py":
        raise CampaignError(f"{source}: not a Python file; its name must end in .py")
    path, lines = str(source.path), [f"{line}\n" for line in source.text.split("\n")]
    linecache.cache[path] = (len(source.text), None, lines, path)  # None: not compared with a file
    module = ModuleType(f"{MODULE}{source.digest}")
    module.__file__ = path
    sys.modules[module.__name__] = module  # where compiled laws kept from the last time look for it
    try:
        exec(compile(source.text, path, "exec", dont_inherit=True), vars(module))
    except NumbaError as error:
        raise CampaignError(f"{source}: {_does_not_compile(error)}") from error
    except CampaignError:
        raise
    except (Exception, SystemExit) as error:
        kind = type(error).__name__
        raise CampaignError(f"{source}: does not run: {kind}: {error}; mend the file") from error
    found = effects_of_module(module)
    if not found:
        raise CampaignError(
            f"{source}: holds no effect; define a subclass of wheelhop.effects.Effect in it"
        )
    return found


def effects_of_module(module: ModuleType) -> list[type[Effect]]:
    """The effects that a module defines, those it has only imported left out."""
    return [
        value
        for value in vars(module).values()
        if isinstance(value, type)
        and issubclass(value, Effect)
        and value.__module__ == module.__name__
    ]


def _does_not_compile(error: NumbaError) -> str:
    """What the compiler says of a law, without its colours, stages and candidates."""
    lines = [re.sub(r"\x1b\[\d*m", "", line).strip() for line in str(error).splitlines()]
    said = re.split(", defined at| During:", " ".join([line for line in lines if line][1:3]))[0]
    place = re.search(r"line (\d+)", str(error))
    where = f" in line {place[1]}" if place else ""
    return f"a law{where} does not compile: {said}; it computes with numbers and returns two"


class _InOwnCache(_CacheLocator):
    """Where numba keeps the compiled functions of a module of ours: by the hash of its text."""

    def __init__(self, digest: str, line: int) -> None:
        self._digest, self._line = digest, line
        self._folder = own_folder(cache_folder() / "laws", CampaignError) / digest

    def get_cache_path(self) -> str:
        return str(self._folder)

    def get_source_stamp(self) -> str:
        return self._digest

    def get_disambiguator(self) -> str:
        return str(self._line)

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> _InOwnCache | None:
        """None for every function that does not come from a user's file."""
        name = py_func.__module__
        if not name.startswith(MODULE):
            return None
        made = cls(name.removeprefix(MODULE), py_func.__code__.co_firstlineno)
        made.ensure_cache_path()  # type: ignore[no-untyped-call]
        return made


CacheImpl._locator_classes.insert(0, _InOwnCache)
