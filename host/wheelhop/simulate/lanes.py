"""Vectors of numbers in compiled code: what the processor does to many at the price of one.

numba leaves it to the compiler to find loops that a vector unit could do; in the integrator it does
not find them. These few intrinsics say it. Arrays whose last axis has `LANES` numbers, contiguous,
are read and written by *row*, the index into all their axes but the last, flattened.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.extending import intrinsic as _intrinsic
from numba.extending import models, register_model
from numpy.typing import NDArray

Array = NDArray[np.float64]

intrinsic: Any = _intrinsic  # numba's types take these for what the compiler is told of them

LANES = 8
"""Double-precision numbers in a vector register of 512 bits; smaller registers take several."""


class _Vector(types.Type):
    def __init__(self) -> None:
        super().__init__(name=f"Vector{LANES}")


VECTOR = _Vector()
_LLVM = ir.VectorType(ir.DoubleType(), LANES)


@register_model(_Vector)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _LLVM)  # type: ignore[no-untyped-call]


@intrinsic
def load(typing, array, row):  # type: ignore[no-untyped-def]
    """The vector at a row of an array."""

    def code(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        place = _place(context, builder, signature.args[0], *arguments)
        return builder.load(place, align=8)

    return VECTOR(array, types.intp), code


@intrinsic
def store(typing, array, row, vector):  # type: ignore[no-untyped-def]
    """Write a vector into a row of an array."""

    def code(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        place = _place(context, builder, signature.args[0], *arguments[:2])
        builder.store(arguments[2], place, align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, VECTOR), code


@intrinsic
def splat(typing, number):  # type: ignore[no-untyped-def]
    """The vector of one number in all lanes."""

    def code(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        zero = ir.Constant(ir.IntType(32), 0)
        one = builder.insert_element(ir.Constant(_LLVM, ir.Undefined), arguments[0], zero)
        mask = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
        return builder.shuffle_vector(one, ir.Constant(_LLVM, ir.Undefined), mask)

    return VECTOR(types.float64), code


@intrinsic
def plus(typing, c, a, b):  # type: ignore[no-untyped-def]
    """c + a b."""

    def code(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        total, one, other = arguments
        product = builder.fmul(one, other, flags=("fast",))
        return builder.fadd(total, product, flags=("fast",))

    return VECTOR(VECTOR, VECTOR, VECTOR), code


def aligned(shape: tuple[int, ...]) -> Array:
    """Zeros, no vector of which lies across two of the processor's cache lines."""
    count, line = math.prod(shape), LANES * 8
    raw = np.zeros(count + LANES)
    begin = -raw.ctypes.data % line // 8
    return raw[begin : begin + count].reshape(shape)


def side_by_side(given: Sequence[Array]) -> Array:
    """Arrays put side by side along a last axis; the first one fills empty lanes."""
    together = aligned((*given[0].shape, LANES))
    np.stack([*given, *[given[0]] * (LANES - len(given))], axis=-1, out=together)
    return together


def _place(context: Any, builder: Any, kind: Any, array: Any, row: Any) -> Any:
    data = context.make_array(kind)(context, builder, array).data
    first = builder.mul(row, ir.Constant(row.type, LANES))
    return builder.bitcast(builder.gep(data, [first]), _LLVM.as_pointer())
