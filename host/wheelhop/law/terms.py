"""Terms of which a formula is made: one number each, their widths and gaps on a grid of the data.

Every compiled function is written so that its source can stand in a user's own file.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import exp, tanh
from types import MappingProxyType

import numpy as np

from wheelhop.effects import law
from wheelhop.effects.base import Array

Kernel = Callable[[float, float, float, float, float, Array], tuple[float, float]]


@law
def power(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """p[0] (x / p[1])^p[2]."""
    return p[0] * (x / p[1]) ** p[2], z


@law
def orifice(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """p[0] v |v| / p[1]²."""
    return p[0] * v * abs(v) / p[1] ** 2, z


@law
def viscous(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """p[0] v / p[1]."""
    return p[0] * v / p[1], z


@law
def one_way(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """p[0] |v| / p[1]: damping that differs in rebound and compression."""
    return p[0] * abs(v) / p[1], z


@law
def rounded(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """p[0] tanh(v / p[1])."""
    return p[0] * tanh(v / p[1]), z


@law
def stop(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """p[0] times the way beyond x = p[1], over p[2]: p[1] > 0 in rebound, < 0 in compression."""
    beyond = max(x - p[1], 0.0) if p[1] > 0.0 else min(x - p[1], 0.0)
    return p[0] * beyond / p[2], z


@law
def growing(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """p[0] (exp(x / p[1]) - 1)."""
    return p[0] * (exp(min(x / p[1], 50.0)) - 1.0), z


@law
def slip(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """Jenkins element: p[0] z / p[1], its stretch z held within ± p[1]."""
    stretch = min(max(z + dx, -p[1]), p[1])
    return p[0] * stretch / p[1], stretch


@law
def placed(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """p[0] (x / p[1])^p[2] v / p[3]: damping that differs with the extension."""
    return p[0] * (x / p[1]) ** p[2] * v / p[3], z


@law
def loaded_slip(
    x: float, v: float, dx: float, dt: float, z: float, p: Array
) -> tuple[float, float]:
    """p[0] x / p[2] times the stretch of a Jenkins element, held within ± p[1], over p[1]."""
    stretch = min(max(z + dx, -p[1]), p[1])
    return p[0] * x / p[2] * stretch / p[1], stretch


@law
def drifting(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """p[0] v / p[1] per p[2] seconds since the motion began."""
    return p[0] * v / p[1] * (z + dt) / p[2], z + dt


@law
def valve(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """p[0] (v - p[1] p[2]) / p[3] either way while a valve is open, z = 1: it opens at the speed
    p[1], and shuts below p[1] p[2]."""
    beyond = max(abs(v) - p[1] * p[2], 0.0)
    is_open = abs(v) > p[1] or (z > 0.5 and beyond > 0.0)
    force = p[0] * (beyond if v > 0.0 else -beyond) / p[3]
    return (force, 1.0) if is_open else (0.0, 0.0)


@dataclass(frozen=True)
class Term:
    """One term: its compiled law, the numbers after the amplitude, and how it reads."""

    name: str
    kernel: Kernel
    shape: tuple[float, ...]
    words: str
    equation: str
    by: str = ""  #: the input it is times


PER_S = 10.0
"""Time over which the force of a term that follows it is stated."""


def candidates(
    extension: Array, rate: Array, inputs: Mapping[str, Array] = MappingProxyType({})
) -> list[Term]:
    """Terms with widths and gaps that suit how the place moved (T,), m and m/s: all powers up to
    the third that are none of spring and damper, and what no power is. Spring, damper and friction
    also times each input."""
    x, v = float(np.abs(extension).max()), float(np.abs(rate).max())
    found = [
        Term("square", power, (x, 2.0), "quadratic spring (uneven both ways)",
             rf"F (x/{milli(x)}\,mm)^2"),
        Term("cube", power, (x, 3.0), "cubic spring", rf"F (x/{milli(x)}\,mm)^3"),
        Term("orifice", orifice, (v,), "damping that grows with speed squared",
             rf"F v|v|/({v:.3g}\,m/s)^2"),
        Term("one-way", one_way, (v,), "damping that differs in rebound and compression",
             rf"F |v|/({v:.3g}\,m/s)"),
        *positioned(x, v),
        drift(v),
    ]  # fmt: skip
    found += [creeping(width) for width in _widths(rate)]
    sides = {float(share * side) for side in (extension.min(), extension.max())
             for share in (0.0, 0.25, 0.5, 0.75)}  # fmt: skip
    found += [beyond(gap, x) for gap in sorted(sides)]
    found += [exponential(width) for width in (0.5 * x, -0.5 * x)]
    found += [slipping(way) for way in slips(extension)]
    found += [slipping_loaded(way, x) for way in slips(extension)[::3]]
    found += [valved(share * v, shut, v) for share in VALVES for shut in SHUT]
    return found + [
        times(term, name)
        for name in inputs
        for term in [*_linear(x, v), *(t for t in found if t.kernel in (rounded, slip))]
    ]


def neighbours(term: Term, step: float) -> list[Term]:
    """This term with a gap or width a little smaller and larger: gaps by `step` of the largest
    extension, others by a factor of e^(4 step); none of a term that has neither."""
    first, *rest = term.shape
    if term.kernel not in SHAPED:
        return []
    if term.kernel is stop:
        ways = [first - step * rest[0], first + step * rest[0]]
    else:
        ways = [first * exp(-4.0 * step), first * exp(4.0 * step)]
    found = [shaped(term, way) for way in ways]
    if term.kernel is valve:
        shuts = (rest[0] * exp(-4.0 * step), min(rest[0] * exp(4.0 * step), 1.0))
        found += [_times_as(term, valved(first, shut, rest[1])) for shut in shuts]
    return found


def shaped(term: Term, first: float) -> Term:
    """This term with another gap or width."""
    return _times_as(term, SHAPED[term.kernel](first, *term.shape[1:]))


def _times_as(term: Term, other: Term) -> Term:
    """Another term times the recorded input that a term is times, if any."""
    return times(other, term.by) if term.by else other


def has_sliders(terms: Sequence[Term]) -> bool:
    """Whether one of them is dry friction, which asks for shorter steps."""
    return any(term.kernel in (slip, loaded_slip) for term in terms)


def times(term: Term, name: str) -> Term:
    """A term times a recorded input."""
    return replace(
        term,
        name=f"{term.name}-by-{name.removeprefix('input_')}",
        words=f"{term.words}, times {name}",
        equation=rf"{term.equation}\,u",
        by=name,
    )


def _linear(x: float, v: float) -> list[Term]:
    """Spring and damper, which a component has of its own but for an input they depend on."""
    return [
        Term("spring", power, (x, 1.0), "spring", rf"F x/{milli(x)}\,mm"),
        Term("damper", viscous, (v,), "damper", rf"F v/({v:.3g}\,m/s)"),
    ]


def milli(value: float) -> str:
    """A thousand times the value, three digits of it and no exponent: mm, mm/s."""
    return f"{float(f'{1e3 * value:.3g}'):g}"


def positioned(x: float, v: float) -> list[Term]:
    """Damping that differs with the extension, unlike and alike both ways."""
    of = rf"v/({v:.3g}\,m/s)"
    return [
        Term("damper-by-place", placed, (x, 1.0, v), "damping that changes along the travel",
             rf"F x/{milli(x)}\,mm\,{of}"),
        Term("damper-by-travel", placed, (x, 2.0, v), "damping that grows away from rest",
             rf"F (x/{milli(x)}\,mm)^2\,{of}"),
    ]  # fmt: skip


def drift(v: float) -> Term:
    """Damping that follows the time in the run."""
    return Term("damper-by-time", drifting, (v, PER_S), f"damping that changes, per {PER_S:g} s of"
                " driving", rf"F v/({v:.3g}\,m/s)\,t/{PER_S:g}\,s")  # fmt: skip


def creeping(width: float) -> Term:
    """Friction that is damping below a speed."""
    return Term(f"friction-{milli(width)}-mm-s", rounded, (width,),
                f"friction that creeps below {milli(width)} mm/s",
                rf"F \tanh(v/{milli(width)}\,mm/s)")  # fmt: skip


def beyond(gap: float, x: float) -> Term:
    """A spring that acts beyond a gap."""
    words = f"stop beyond {1e3 * gap:+.3g} mm" if gap else "spring that differs in compression"
    past = rf"x {'+' if gap < 0.0 else '-'} {milli(abs(gap))}\,mm" if gap else "x"
    return Term(f"stop-{milli(gap)}-mm", stop, (gap, x), words,
                rf"F \langle {past}\rangle/{milli(x)}\,mm")  # fmt: skip


def exponential(width: float) -> Term:
    """A spring that grows e-fold by a width, to one side."""
    side = "rebound" if width > 0 else "compression"
    return Term(f"exponential-{milli(width)}-mm", growing, (width,),
                f"spring that grows exponentially in {side}",
                rf"F (e^{{x/{milli(width)}\,mm}} - 1)")  # fmt: skip


def slipping(way: float) -> Term:
    """A spring that slips after a way."""
    return Term(f"slip-{milli(way)}-mm", slip, (way,),
                f"friction that gives way elastically by {milli(way)} mm",
                rf"F z/{milli(way)}\,mm,\ |z| \leq {milli(way)}\,mm")  # fmt: skip


def slipping_loaded(way: float, x: float) -> Term:
    """A spring that slips after a way, at a force in proportion to the extension."""
    return Term(f"loaded-slip-{milli(way)}-mm", loaded_slip, (way, x),
                f"friction that follows the load, elastic by {milli(way)} mm",
                rf"F x/{milli(x)}\,mm\,z/{milli(way)}\,mm,"
                rf"\ |z| \leq {milli(way)}\,mm")  # fmt: skip


def valved(opens: float, shut: float, v: float) -> Term:
    """Damping beyond a valve that opens at a speed, and shuts at this share of it."""
    way = f"opens at {milli(opens)} and shuts at {milli(shut * opens)} mm/s"
    if shut == 1.0:
        way = f"opens at {milli(opens)} mm/s"
    return Term(f"valve-{milli(opens)}-mm-s-{shut:.3g}", valve, (opens, shut, v),
                f"damping of a valve that {way}",
                rf"F \langle|v| - {milli(shut * opens)}\,mm/s\rangle\,"
                rf"\operatorname{{sgn}} v/({v:.3g}\,m/s)")  # fmt: skip


VALVES = (0.1, 0.2, 0.35, 0.5, 0.7)
"""Shares of the largest speed at which a valve may open."""

SHUT = (0.5, 0.75, 1.0)
"""Shares of that at which it may shut."""

SHAPED: Mapping[Kernel, Callable[..., Term]] = {
    rounded: creeping,
    stop: beyond,
    growing: exponential,
    slip: slipping,
    loaded_slip: slipping_loaded,
    valve: valved,
}
"""Terms whose first number is a gap or a width that data may ask for, and what makes them."""

SPEEDS = (rounded, valve)
"""Of those the terms for which it is a speed."""


def slips(extension: Array) -> tuple[float, ...]:
    """Ways after which sliders slip: from two thousandths of the travel to most of it."""
    return tuple(float(w) for w in np.geomspace(0.002, 0.7, 10) * np.abs(extension).max())


def knots(values: Array, count: int) -> tuple[float, ...]:
    """`count` knots over the range of a motion, rest among them: midway between even spacing, which
    follows a law everywhere, and quantiles, which follow it where the motion mostly is."""
    share = np.linspace(0.0, 1.0, count)
    inner = 0.5 * np.quantile(values, share) + 0.5 * (values.min() + share * np.ptp(values))
    inner[np.argmin(np.abs(inner[1:-1])) + 1] = 0.0
    return tuple(sorted(set(float(f"{1e3 * k:.4g}") / 1e3 for k in inner)))


def _widths(rate: Array) -> Sequence[float]:
    return [float(w) for w in np.geomspace(0.01, 1.0, 5) * np.abs(rate).max()]
