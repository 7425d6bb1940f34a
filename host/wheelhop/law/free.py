"""A force of free form at one place: splines of extension and rate, and memory beside them.

It is an effect like any other and linear in its coefficients, which are forces at knots, so that
screening tells to first order what it explains, and a full fit judges it beside named laws.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from scipy.interpolate import CubicSpline

from wheelhop.campaign import Channel
from wheelhop.effects import Amplitude, Effect, Parameter, law
from wheelhop.effects.base import Array, Values
from wheelhop.effects.dry_friction import LONGEST_STEP_S
from wheelhop.law.places import Where
from wheelhop.law.terms import Term, has_sliders
from wheelhop.vehicle import Assembly
from wheelhop.vehicle.assembly import Row

SCALE = 0.1
"""A clearly visible force at a knot, as a share of the load that is usual at the place."""


@law
def free_force(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """Cubic splines of x and of v, straight beyond their ends. p: the numbers of knots of
    both, then for each its knots, values there and second derivatives."""
    total, begin = 0.0, 2
    for axis in range(2):
        n = int(p[axis])
        at = x if axis == 0 else v
        if n > 1:
            i = 0
            while i < n - 2 and at > p[begin + i + 1]:
                i += 1
            left, right = p[begin + i], p[begin + i + 1]
            width = right - left
            low, high = p[begin + n + i], p[begin + n + i + 1]
            bend_low, bend_high = p[begin + 2 * n + i], p[begin + 2 * n + i + 1]
            inside = min(max(at, left), right)
            b = (inside - left) / width
            a = 1.0 - b
            total += (
                a * low + b * high
                + ((a * a * a - a) * bend_low + (b * b * b - b) * bend_high) * width * width / 6.0
            )  # fmt: skip
            slope = (high - low) / width + width / 6.0 * (
                (1.0 - 3.0 * a * a) * bend_low + (3.0 * b * b - 1.0) * bend_high
            )
            total += slope * (at - inside)
        begin += 3 * n
    return total, z


@dataclass(frozen=True)
class Form:
    """What a free law is made of: knots (a,) of extension, m, and (b,) of rate, m/s, 0 among both,
    terms beside the splines, and by name the recorded inputs that one more spline of rate, with a
    slope at rest, is times; where it is `apart`, each axle has forces of its own."""

    name: str
    extension_m: tuple[float, ...] = ()
    rate_m_s: tuple[float, ...] = ()
    terms: tuple[Term, ...] = ()
    inputs: tuple[tuple[str, tuple[float, ...]], ...] = ()
    apart: bool = False


class FreeForce(Effect):
    """f(x, v) = f₁(x) + f₂(v) + Σ terms at one place, from what the data say alone."""

    id = "free-force"
    place = "suspension"
    on_rig = True
    title = "a force of free form"
    equation = r"f = f_1(x) + f_2(\dot x) + \sum_j F_j\,g_j"
    source = (
        "restoring force as a function of state: S. F. Masri, T. K. Caughey, J. Appl. Mech. 46"
        " (1979) 433; parallel sliders: W. D. Iwan, J. Appl. Mech. 33 (1966) 893; not-a-knot"
        " spline, exact for a cubic law: C. de Boor, A Practical Guide to Splines (Springer"
        " 1978), ch. IV"
    )

    def __init__(self, where: Where, forms: Mapping[str, Form], form: str = "") -> None:
        self.where, self.forms = where, forms
        self.form = forms[form] if form else next(iter(forms.values()))
        self.needs_road = where.kind == "tyre"  # type: ignore[misc]
        if has_sliders(self.form.terms):
            self.longest_step_s = LONGEST_STEP_S["elastic"]

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """More and more terms: the evidence says how many the data ask for."""
        return tuple(self.forms)

    def with_choice(self, choice: str) -> FreeForce:
        """The law with these terms."""
        return FreeForce(self.where, self.forms, choice)

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """A force at each knot but the one at 0, where there is none, and one of each term; where
        axles stand apart, for each of them."""
        return [
            replace(one, name=f"{prefix}{one.name}")
            for prefix, end in self._ends()
            for one in self._of_end(end, vehicle)
        ]

    def _ends(self) -> list[tuple[str, Where]]:
        return self.where.ends() if self.form.apart else [("", self.where)]

    def _of_end(self, where: Where, vehicle: Values) -> list[Parameter]:
        scale = SCALE * where.load_N(vehicle)
        named = (
            *((f"at_{1e3 * x:.4g}_mm_N", f"force at {1e3 * x:.4g} mm", x)
              for x in self.form.extension_m),
            *((f"at_{1e3 * v:.4g}_mm_s_N", f"force at {1e3 * v:.4g} mm/s", v)
              for v in self.form.rate_m_s),
            *((f"{t.name}_N", f"force of the {t.words}", 1.0) for t in self.form.terms),
        )  # fmt: skip
        found: list[Parameter] = [
            Amplitude(name, "N", words, scale) for name, words, at in named if at != 0.0
        ]
        for by, knots in self.form.inputs:
            size = vehicle[f"rig.{by}"]
            found += [
                Amplitude(
                    f"{by}_at_{1e3 * v:.4g}_mm_s_N",
                    "N",
                    f"force at {1e3 * v:.4g} mm/s per {by}",
                    scale / size,
                )
                for v in knots
                if v != 0.0
            ]
        return found

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the force at every part of the place."""
        for prefix, end in self._ends():
            own = {n.removeprefix(prefix): f for n, f in theta.items() if n.startswith(prefix)}
            self._add(own, end.rows(vehicle), parts)

    def _add(self, theta: Values, rows: Sequence[Row], parts: Assembly) -> None:
        form = self.form
        packed = [float(len(form.extension_m)), float(len(form.rate_m_s))]
        for knots, unit in ((form.extension_m, "mm"), (form.rate_m_s, "mm_s")):
            if knots:
                packed += _spline(knots, theta, "at_", unit)
        for row in rows:
            if len(packed) > 2:
                parts.add_law(row, free_force, tuple(packed))
            for term in form.terms:
                parts.add_law(row, term.kernel, (theta[f"{term.name}_N"], *term.shape))
            for by, knots in form.inputs:
                numbers = [0.0, float(len(knots)), *_spline(knots, theta, f"{by}_at_", "mm_s")]
                parts.add_law(row, free_force, tuple(numbers), by)


def _spline(knots: Sequence[float], theta: Values, prefix: str, unit: str) -> list[float]:
    """Knots, values there and second derivatives."""
    values = [theta.get(f"{prefix}{1e3 * k:.4g}_{unit}_N", 0.0) for k in knots]
    return [*knots, *values, *CubicSpline(knots, values)(knots, 2).tolist()]
