"""Force laws as compiled code calls them.

A loop that is compiled once calls any set of laws by their addresses. Functions among its arguments
would do the same, but of these numba finds out the types anew at every call, in Python.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
import warnings
from collections.abc import Sequence
from functools import cache
from itertools import groupby
from threading import Lock
from types import FunctionType
from typing import Any

import numba
import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import NumbaExperimentalFeatureWarning, carray, types  # type: ignore[attr-defined]
from numpy.typing import NDArray

from wheelhop.effects import law
from wheelhop.simulate.lanes import LANES, intrinsic
from wheelhop.vehicle import Law

Array = NDArray[np.float64]

PARSING = Lock()
"""CPython 3.11 counts how deep the trees of all threads are as one, and a tree that is made beside
another may end in a SystemError (python/cpython issue 106905)."""

# Elsewhere laws are called through pointers. numba calls that experimental; tests hold what we use.
warnings.simplefilter("ignore", NumbaExperimentalFeatureWarning)


SLOTS = 4
"""Tuples of laws among the arguments are padded to a multiple of this: for each length a loop is
compiled once more."""


@law
def _no_force(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    return 0.0, z


def padded(laws: tuple[Law, ...]) -> tuple[Law, ...]:
    """A tuple of laws of one of the few lengths that are compiled."""
    return laws + (_no_force,) * (-len(laws) % SLOTS if laws else SLOTS)


FORCE, AFTER, X, V, START, MEMORY = range(6)
"""Of every port: its force and the memory that it leaves; its extension and the rate of it; what
extension and memory were when the step began."""


def _all_ports(ports_at, count, elapsed, parameters_at, lanes, width, first, last):  # type: ignore[no-untyped-def]
    """Forces of some of `count` ports that have one law, `LAW`: of ports (6, count, LANES), which
    begin at an address, and parameters (lanes, count, width)."""
    ports = carray(ports_at, (6, count, LANES))
    parameters = carray(parameters_at, (lanes, count, width))
    for i in range(first, last):
        for s in range(lanes):
            ports[FORCE, i, s], ports[AFTER, i, s] = LAW(  # type: ignore[name-defined] # noqa: F821
                ports[X, i, s], ports[V, i, s], ports[X, i, s] - ports[START, i, s], elapsed,
                ports[MEMORY, i, s], parameters[s, i],
            )  # fmt: skip


_NUMBERS = types.CPointer(types.float64)  # type: ignore[no-untyped-call]
_COUNT = types.int64
_ARGUMENTS = (_NUMBERS, _COUNT, types.float64, _NUMBERS, *4 * (_COUNT,))


@cache
def _for_all_ports(single: Any) -> Any:
    """A law for all ports and lanes at once: a call costs more than most laws.

    It is `_all_ports` as if that were written beside the law, where its compiled code is kept.
    """
    function: FunctionType = single.py_func
    code = _all_ports.__code__.replace(
        co_filename=function.__code__.co_filename,
        co_firstlineno=function.__code__.co_firstlineno,
        co_name=f"{function.__name__}_for_all_ports",
        co_qualname=f"{function.__qualname__}_for_all_ports",
    )
    names = {"LAW": single, "range": range, "carray": carray, "LANES": LANES}
    names |= {"FORCE": FORCE, "AFTER": AFTER, "X": X, "V": V, "START": START, "MEMORY": MEMORY}
    made = FunctionType(code, names | {"__name__": function.__module__})
    return numba.cfunc(types.void(*_ARGUMENTS), cache=True, error_model="numpy")(made)


@cache
def addresses(laws: tuple[Law, ...]) -> NDArray[np.int64]:
    """Where the compiled code of each law begins, for `call`."""
    return np.array([_for_all_ports(law).address for law in laws], dtype=np.int64)


@intrinsic
def call(typing, address, ports, elapsed, parameters, first, last):  # type: ignore[no-untyped-def]
    """Call the law at an address for the ports from the `first` to before the `last`, of `ports`
    (6, n, LANES) and `parameters` (lanes used, n, …)."""

    def code(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        at, port, since, number, begin, end = arguments
        port = context.make_array(signature.args[1])(context, builder, port)
        number = context.make_array(signature.args[3])(context, builder, number)
        lanes, count, width = (builder.extract_value(number.shape, i) for i in range(3))
        kind = ir.FunctionType(
            ir.VoidType(), [context.get_value_type(argument) for argument in _ARGUMENTS]
        )
        function = builder.inttoptr(at, kind.as_pointer())
        given = [port.data, count, since, number.data, lanes, width, begin, end]
        builder.call(function, given)
        return context.get_dummy_value()

    signature = types.void(types.int64, ports, types.float64, parameters, types.int64, types.int64)
    return signature, code


@cache
def groups_of(port_law: tuple[int, ...], laws: tuple[Law, ...]) -> NDArray[np.int64]:
    """Neighbouring ports with the same law: rows of law, first port, the one after the last, and
    whether the law has a memory."""
    runs = [(law, len(list(ports))) for law, ports in groupby(port_law)]
    ends = np.cumsum([0, *(count for _, count in runs)])
    rows = [(law, ends[i], ends[i + 1], remembers(laws[law])) for i, (law, _) in enumerate(runs)]
    return np.array(rows, dtype=np.int64).reshape(-1, 4)


@cache
def remembers(single: Any) -> bool:
    """Whether a law returns anything for its memory but what it was given."""
    function: FunctionType = single.py_func
    try:
        with PARSING:
            tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    except (OSError, SyntaxError):
        return True
    given = function.__code__.co_varnames[4]
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id == given and not isinstance(node.ctx, ast.Load):
            return True
        if isinstance(node, ast.Return):
            after = node.value.elts[-1] if isinstance(node.value, ast.Tuple) else None
            if not (isinstance(after, ast.Name) and after.id == given):
                return True
    return False


def laws_side_by_side(parameters: Sequence[Array]) -> Array:
    """The laws' numbers (lanes, p, width): a spline of more knots takes more of them."""
    width = max(one.shape[1] for one in parameters)
    together = np.zeros((len(parameters), len(parameters[0]), width))
    for own, one in zip(together, parameters, strict=True):
        own[:, : one.shape[1]] = one
    return together
