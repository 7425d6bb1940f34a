"""A formula: a sum of named terms at one place, as an effect; and the file that keeps it."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from wheelhop.campaign import Channel
from wheelhop.effects import Amplitude, Effect, Parameter, Shape
from wheelhop.effects.base import Values
from wheelhop.effects.dry_friction import LONGEST_STEP_S
from wheelhop.law.free import SCALE
from wheelhop.law.places import SEAT, Where
from wheelhop.law.terms import SHAPED, SPEEDS, Term, has_sliders, shaped
from wheelhop.vehicle import Assembly


@dataclass(frozen=True)
class Part:
    """A term at one of the ends a formula has forces for: the beginning of their names, its place,
    the term as it was fitted, and the full names of its force and of its gap or width, empty where
    that is not free."""

    prefix: str
    where: Where
    term: Term
    force: str
    shape: str

    @property
    def words(self) -> str:
        """How it reads: "front: " before what each axle has of its own."""
        return f"{self.prefix.replace('_', ': ')}{self.term.words}"


class Formula(Effect):
    """Σ of terms; the amplitudes, forces at the end of the motion recorded, are free."""

    id = "formula"
    place = "suspension"
    on_rig = True
    title = "a sum of few physical terms"
    equation = r"f = \sum_i F_i\,g_i(x, \dot x)"
    source = "forward selection by evidence among the terms of wheelhop.law.terms"

    def __init__(
        self,
        where: Where,
        terms: Sequence[Term],
        apart: bool = False,
        free_shapes: bool = False,
    ) -> None:
        self.where, self.terms, self.apart = where, tuple(terms), apart
        self._free_shapes = free_shapes
        self.needs_road = where.kind == "tyre"  # type: ignore[misc]
        if has_sliders(terms):
            self.longest_step_s = LONGEST_STEP_S["elastic"]

    def of(self, terms: Sequence[Term]) -> Formula:
        """The formula with other terms."""
        return Formula(self.where, terms, self.apart, self._free_shapes)

    def with_free_shapes(self) -> Formula:
        """The formula whose gaps and widths are numbers to be fitted, too."""
        return Formula(self.where, self.terms, self.apart, True)

    def with_each_axle(self) -> Formula:
        """The formula with forces, and gaps that are free, of each axle's own."""
        return Formula(self.where, self.terms, True, self._free_shapes)

    def common(self, name: str) -> str:
        """What a number of one axle is called where axles have no numbers of their own."""
        for prefix, _ in self.where.ends():
            name = name.replace(f"{self.id}.{prefix}", f"{self.id}.", 1)
        return name

    def ends(self) -> list[tuple[str, Where]]:
        """What has forces of its own, each with the beginning of their names."""
        return self.where.ends() if self.apart else [("", self.where)]

    def forces_of(self, term: Term) -> list[str]:
        """The full names of a term's forces, one at each of `ends`."""
        return [f"{self.id}.{prefix}{term.name}_N" for prefix, _ in self.ends()]

    def parts(self, values: Values) -> list[Part]:
        """Every term at each of `ends`, as it was fitted in a model with these `values`."""
        found = []
        for prefix, end in self.ends():
            for term in self.terms:
                own = f"{self.id}.{prefix}"
                shape = f"{own}{_shape_name(term)}" if self._is_free(term) else ""
                fitted = shaped(term, values[shape]) if shape else term
                found.append(Part(prefix, end, fitted, f"{own}{term.name}_N", shape))
        return found

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """The force of each term at each of `ends`; its gap or width, if that is free."""
        forces = [
            Amplitude(
                f"{prefix}{t.name}_N",
                "N",
                f"force of the {t.words}",
                SCALE * end.load_N(vehicle) / (vehicle[f"rig.{t.by}"] if t.by else 1.0),
            )
            for prefix, end in self.ends()
            for t in self.terms
        ]
        free = [_shape_of(term) for term in self.terms if self._is_free(term)]
        return forces + [
            replace(one, name=f"{prefix}{one.name}") for prefix, _ in self.ends() for one in free
        ]

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add every term at every part of the place."""
        for prefix, end in self.ends():
            for t in self.terms:
                shape = t.shape
                if self._is_free(t):
                    shape = (theta[f"{prefix}{_shape_name(t)}"], *shape[1:])
                for row in end.rows(vehicle):
                    parts.add_law(row, t.kernel, (theta[f"{prefix}{t.name}_N"], *shape), t.by)

    def _is_free(self, term: Term) -> bool:
        return self._free_shapes and term.kernel in SHAPED and term.shape[0] != 0.0


def _shape_name(term: Term) -> str:
    return f"{term.name}_{'m_s' if term.kernel in SPEEDS else 'm'}"


def _shape_of(term: Term) -> Parameter:
    """The gap or width of a term as a number of its own: it keeps its sign."""
    first = term.shape[0]
    low, high = sorted((0.1 * first, np.inf * np.sign(first)))
    unit = "m/s" if term.kernel in SPEEDS else "m"
    words = f"gap or width of the {term.words}"
    return Shape(
        _shape_name(term), unit, words, 0.5 * abs(first), lower=low, upper=high, starts=(first,)
    )


HEADER = '''"""{title}: found by `wheelhop law` in "{campaign}"."""

from math import exp, tanh

from wheelhop.effects import Amplitude, Effect, law
from wheelhop.vehicle import {imports}

'''

CLASS = '''

class FoundLaw(Effect):
    """{words}."""

    id = "{id}"
    place = "{place}"
    on_rig = {on_rig}
    needs_road = {needs_road}
    longest_step_s = {step}
    title = "{title}"
    equation = r"{equation}"
    source = "wheelhop law"

    def parameters_for(self, vehicle, channels):
        return (
{parameters}
        )

    def modify(self, theta, vehicle, parts):
{laws}
'''


def source_of(formula: Formula, values: Values, campaign: str, law_id: str) -> str:
    """A Python file with the formula as an effect of its own, each term's source in it; the fitted
    amplitudes among the `values` of the model with it become the scales of its parameters, and
    fitted gaps and widths are what they are."""
    where, parts = formula.where, formula.parts(values)
    kernels = dict.fromkeys(part.term.kernel for part in parts)
    sources = "\n\n".join(_bare(kernel) for kernel in kernels)
    numbers = [part.force.removeprefix(f"{formula.id}.").replace("-", "_") for part in parts]
    parameters = "\n".join(
        f'            Amplitude("{number}", "N", "force of the {part.term.words}",'
        f" scale={abs(values[part.force]) or 1.0:.6g}),"
        for part, number in zip(parts, numbers, strict=True)
    )
    imports, rows = "", []
    for prefix, end in formula.ends():
        imports, of_end = _rows(end, values)
        laws = "\n".join(
            f"            parts.add_law(row, {_name(part.term)},"
            f' (theta["{number}"], {", ".join(f"{s:.9g}" for s in part.term.shape)})'
            + (f', by="{part.term.by}")' if part.term.by else ")")
            for part, number in zip(parts, numbers, strict=True)
            if part.prefix == prefix
        )
        rows.append(f"        for row in {of_end}:\n{laws}")
    title = f"law of {where.in_words}"
    heading = title[0].upper() + title[1:]
    return HEADER.format(title=heading, campaign=campaign, imports=imports) + "\n" + sources + (
        CLASS.format(
            words=" + ".join(dict.fromkeys(part.words for part in parts)).capitalize(),
            id=law_id,
            place="tyre" if where.kind == "tyre" else "suspension",
            on_rig=formula.on_rig and where.name == "component",
            needs_road=where.kind == "tyre",
            step=formula.longest_step_s,
            title=title,
            equation=" + ".join(dict.fromkeys(part.term.equation for part in parts)),
            parameters=parameters,
            laws="\n".join(rows),
        )
    )  # fmt: skip


def _rows(where: Where, values: Values) -> tuple[str, str]:
    """What a file imports for the extensions of a place, and these."""
    if where.kind == "mount":
        foot = where.foot(values)
        row = f"between(Coordinate({where.aboard!r}), Body({foot.x_m:.9g}, {foot.y_m:.9g}))"
        there = f' if "{SEAT}.mass_kg" in vehicle else ()' if where.on_seat(values) else ""
        return "Body, Coordinate, between", f"({row},){there}"
    one, each = "strut_at", "strut_at(vehicle, i).row"
    if where.kind == "tyre":
        one, each = "tyre", "tyre(i)"
    return one, f"({each} for i in {where.corners})"


def _name(term: Term) -> str:
    return str(term.kernel.__name__)


def _bare(kernel: object) -> str:
    return inspect.getsource(kernel.py_func).replace(": float", "").replace(  # type: ignore[attr-defined]
        ": Array", "").replace(" -> tuple[float, float]", "").strip() + "\n"  # fmt: skip
