"""What a call costs, counted: the same on every machine, whatever else it does."""

import gc
import sys
from collections.abc import Callable

import numpy as np


def calls(function: Callable[..., object], *arguments: object) -> int:
    """How many functions, of Python's and of C's, are called while `function` works."""
    count = 0

    def note(frame: object, event: str, argument: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    usual = sys.getprofile()
    sys.setprofile(note)
    try:
        function(*arguments)
    finally:
        sys.setprofile(usual)
    return count


def array_bytes(thing: object) -> int:
    """Bytes of all the arrays that `thing` holds, each memory once."""
    met: dict[int, object] = {}
    owners: dict[int, np.ndarray] = {}
    waiting = [thing]
    while waiting:
        one = waiting.pop()
        if id(one) in met or isinstance(one, type | type(sys) | type(calls)):
            continue
        met[id(one)] = one
        if isinstance(one, np.ndarray):
            while isinstance(one.base, np.ndarray):
                one = one.base
            owners[id(one)] = one
        else:
            waiting += gc.get_referents(one)
    return sum(array.nbytes for array in owners.values())
