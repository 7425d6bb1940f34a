"""Force laws in C, from the very Python that the integrator compiles.

Laws are plain arithmetic on floating-point numbers: assignments, branches, loops of a fixed count,
and functions of the mathematical library. What is more than that is refused.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Callable, Sequence
from types import FunctionType
from typing import Any

from wheelhop.campaign import CampaignError
from wheelhop.vehicle import Law

OPERATORS: dict[type, str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Lt: "<", ast.LtE: "<=",
    ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=", ast.And: "&&", ast.Or: "||",
    ast.USub: "-", ast.UAdd: "+", ast.Not: "!",
}  # fmt: skip
FUNCTIONS = {"min": "fmin", "max": "fmax", "abs": "fabs", "float": "", "int": "trunc"} | {
    name: name
    for name in (
        *("exp", "expm1", "log", "log1p", "sqrt", "hypot", "copysign", "floor", "ceil"),
        *("sin", "cos", "tan", "atan", "atan2", "sinh", "cosh", "tanh", "atanh"),
    )
}


class _Refused(Exception):
    """Something that is no arithmetic."""


def in_c(laws: Sequence[Law]) -> str:
    """Functions `law_0`, `law_1`, … in C, with what they call.

    ``double law_i(double x, double v, double dx, double dt, double z, const double *p, double
    *after)`` returns the force and writes the memory. Raises CampaignError for a law that is more
    than arithmetic.
    """
    written: dict[str, str] = {}
    for number, one in enumerate(laws):
        function: FunctionType = one.py_func  # type: ignore[attr-defined]
        try:
            _Writer(function, f"law_{number}", written, is_law=True).write()
        except (_Refused, OSError, SyntaxError) as error:
            raise CampaignError(
                f"export: the law {function.__name__} cannot be written in C: {error}"
            ) from None
    return "\n".join(written.values())


class _Writer:
    """One function; what it calls is written before it."""

    def __init__(
        self, function: FunctionType, name: str, written: dict[str, str], *, is_law: bool
    ) -> None:
        self._names = {**function.__globals__, **inspect.getclosurevars(function).nonlocals}
        self._name, self._written, self._is_law = name, written, is_law
        tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
        (self._tree,) = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
        self._arguments = [argument.arg for argument in self._tree.args.args]
        if is_law:
            self._array = self._arguments[-1]
        else:
            self._array = ""
        self._local = sorted(
            {
                node.id
                for node in ast.walk(self._tree)
                if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
            }
            - set(self._arguments)
        )
        self._temporary = 0

    def write(self) -> None:
        """Write the function."""
        given = [
            f"const double *{self._c(a)}" if a == self._array else f"double {self._c(a)}"
            for a in self._arguments
        ]
        if self._is_law:
            given.append("double *memory")
        body = [line for node in self._tree.body for line in self._statement(node)]
        kept = [f"  double {', '.join(f'{self._c(name)} = 0' for name in self._local)};"]
        lines = [*(kept if self._local else []), *(f"  {line}" for line in body)]
        head = f"static double {self._name}({', '.join(given)})"
        self._written[self._name] = "\n".join([head, "{", *lines, "}"])

    def _c(self, name: str) -> str:
        """A name that C has for nothing else."""
        return f"{name}_"

    def _statement(self, node: ast.stmt) -> list[str]:
        match node:
            case ast.Expr(value=ast.Constant()):
                return []  # the docstring
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                return [f"{self._c(name)} = {self._value(value)};"]
            case ast.Assign(targets=[ast.Tuple(elts=names)], value=ast.Tuple(elts=values)):
                return self._together(names, values)
            case ast.AugAssign(target=ast.Name(id=name), op=op, value=value):
                return [f"{self._c(name)} {self._operator(op)}= {self._value(value)};"]
            case ast.If(test=test, body=body, orelse=other):
                lines = [f"if ({self._value(test)}) {{", *self._block(body), "}"]
                return [*lines, *(["else {", *self._block(other), "}"] if other else [])]
            case ast.While(test=test, body=body, orelse=[]):
                return [f"while ({self._value(test)}) {{", *self._block(body), "}"]
            case ast.For(
                target=ast.Name(id=name),
                iter=ast.Call(func=ast.Name(id="range"), args=[count]),
                body=body,
                orelse=[],
            ):
                i = self._c(name)
                head = f"for ({i} = 0; {i} < {self._value(count)}; {i} += 1) {{"
                return [head, *self._block(body), "}"]
            case ast.Break():
                return ["break;"]
            case ast.Return(value=ast.Tuple(elts=[force, after])) if self._is_law:
                return [
                    f"{{ double force = {self._value(force)}; *memory = {self._value(after)};"
                    " return force; }"
                ]
            case ast.Return(value=value) if value is not None and not self._is_law:
                return [f"return {self._value(value)};"]
        raise _Refused(ast.unparse(node)[:60])

    def _together(self, names: Sequence[ast.expr], values: Sequence[ast.expr]) -> list[str]:
        """All values are found before any is kept."""
        found, kept = [], []
        for name, value in zip(names, values, strict=True):
            if not isinstance(name, ast.Name):
                raise _Refused(ast.unparse(name))
            self._temporary += 1
            at = f"t{self._temporary}_"
            found.append(f"double {at} = {self._value(value)};")
            kept.append(f"{self._c(name.id)} = {at};")
        return ["{", *found, *kept, "}"]

    def _block(self, body: Sequence[ast.stmt]) -> list[str]:
        return [f"  {line}" for node in body for line in self._statement(node)]

    def _value(self, node: ast.expr) -> str:
        match node:
            case ast.Constant(value=bool() | int() | float() as value):
                return repr(float(value))
            case ast.Name(id=name):
                return self._named(name)
            case ast.Subscript(value=ast.Name(id=name), slice=index) if name == self._array:
                return f"{self._c(name)}[(int)({self._value(index)})]"
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                return f"pow({self._value(left)}, {self._value(right)})"
            case ast.BinOp(left=left, op=op, right=right):
                return f"({self._value(left)} {self._operator(op)} {self._value(right)})"
            case ast.UnaryOp(op=op, operand=operand):
                return f"({self._operator(op)}{self._value(operand)})"
            case ast.BoolOp(op=op, values=values):
                return f"({f' {self._operator(op)} '.join(map(self._value, values))})"
            case ast.Compare(left=left, ops=ops, comparators=others):
                sides = [left, *others]
                pairs = [
                    f"{self._value(a)} {self._operator(op)} {self._value(b)}"
                    for a, op, b in zip(sides, ops, others, strict=False)
                ]
                return f"({' && '.join(pairs)})"
            case ast.IfExp(test=test, body=body, orelse=other):
                return f"({self._value(test)} ? {self._value(body)} : {self._value(other)})"
            case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
                return self._called(name, arguments)
        raise _Refused(ast.unparse(node)[:60])

    def _named(self, name: str) -> str:
        if name in self._arguments or name in self._local:
            return self._c(name)
        value = self._names.get(name)
        if isinstance(value, int | float):
            return repr(float(value))
        raise _Refused(name)

    def _called(self, name: str, arguments: Sequence[ast.expr]) -> str:
        values = [self._value(argument) for argument in arguments]
        if name in FUNCTIONS:
            if name in ("min", "max") and len(values) != 2:
                raise _Refused(f"{name} of {len(values)}")
            return f"{FUNCTIONS[name]}({', '.join(values)})"
        helper: Callable[..., Any] | None = getattr(self._names.get(name), "py_func", None)
        if not isinstance(helper, FunctionType):
            raise _Refused(name)
        if name not in self._written:
            _Writer(helper, name, self._written, is_law=False).write()
        return f"{name}({', '.join(values)})"

    def _operator(self, op: ast.AST) -> str:
        if type(op) not in OPERATORS:
            raise _Refused(type(op).__name__)
        return OPERATORS[type(op)]
