"""A formula: a sum of named terms at one place, as an effect; and the file that keeps it."""

from __future__ import annotations

import inspect
from collections.abc import Sequence

from wheelhop.campaign import Channel
from wheelhop.effects import Effect, Parameter
from wheelhop.effects.base import Values
from wheelhop.effects.dry_friction import LONGEST_STEP_S
from wheelhop.law.free import SCALE
from wheelhop.law.places import SEAT, Where
from wheelhop.law.terms import Term, has_sliders
from wheelhop.vehicle import Assembly


class Formula(Effect):
    """Σ of terms; the amplitudes, forces at the end of the motion recorded, are free."""

    id = "formula"
    place = "suspension"
    on_rig = True
    title = "a sum of few physical terms"
    equation = r"f = \sum_i F_i\,g_i(x, \dot x)"
    source = "forward selection by evidence among the terms of wheelhop.law.terms"

    def __init__(self, where: Where, terms: Sequence[Term]) -> None:
        self.where, self.terms = where, tuple(terms)
        self.needs_road = where.kind == "tyre"  # type: ignore[misc]
        if has_sliders(terms):
            self.longest_step_s = LONGEST_STEP_S["elastic"]

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """The force of each term."""
        scale = SCALE * self.where.load_N(vehicle)
        return [
            Parameter(
                f"{t.name}_N",
                "N",
                f"force of the {t.words}",
                scale / vehicle[f"rig.{t.by}"] if t.by else scale,
            )
            for t in self.terms
        ]

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add every term at every part of the place."""
        for row in self.where.rows(vehicle):
            for term in self.terms:
                parts.add_law(row, term.kernel, (theta[f"{term.name}_N"], *term.shape), term.by)


HEADER = '''"""{title}: found by `wheelhop law` in "{campaign}"."""

from math import exp, tanh

from wheelhop.effects import Effect, Parameter, law
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
        for row in {rows}:
{laws}
'''


def source_of(formula: Formula, values: Values, campaign: str, law_id: str) -> str:
    """A Python file with the formula as an effect of its own, each term's source in it; the fitted
    amplitudes among the `values` of the model with it become the scales of its parameters."""
    where, terms = formula.where, formula.terms
    kernels = dict.fromkeys(term.kernel for term in terms)
    sources = "\n\n".join(_bare(kernel) for kernel in kernels)
    parameters = "\n".join(
        f'            Parameter("{t.name.replace("-", "_")}_N", "N", "force of the {t.words}",'
        f" scale={abs(values[f'{formula.id}.{t.name}_N']) or 1.0:.6g}),"
        for t in terms
    )
    laws = "\n".join(
        f"            parts.add_law(row, {_name(t)},"
        f' (theta["{t.name.replace("-", "_")}_N"], {", ".join(f"{s:.9g}" for s in t.shape)})'
        + (f', by="{t.by}")' if t.by else ")")
        for t in terms
    )
    title = f"law of the {where.name}"
    imports, rows = _rows(where, values)
    heading = title[0].upper() + title[1:]
    return HEADER.format(title=heading, campaign=campaign, imports=imports) + "\n" + sources + (
        CLASS.format(
            words=" + ".join(t.words for t in terms).capitalize(),
            id=law_id,
            place="tyre" if where.kind == "tyre" else "suspension",
            on_rig=formula.on_rig and where.name == "component",
            needs_road=where.kind == "tyre",
            step=formula.longest_step_s,
            title=title,
            equation=" + ".join(t.equation for t in terms),
            parameters=parameters,
            rows=rows,
            laws=laws,
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
