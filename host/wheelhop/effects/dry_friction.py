"""Dry friction in the strut and its joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import exp, sqrt, tanh

import numpy as np

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Becomes, Effect, Values, law
from wheelhop.effects.hysteresis import bouc_wen, bristles
from wheelhop.effects.parameters import Amplitude, Parameter, Shape
from wheelhop.vehicle import COMPONENT, Assembly, Law, Usual, ends, is_component, struts

LONGEST_STEP_S = {
    "elastic": 0.00125,
    "creeping": 0.000625,
    "sticking": 0.00125,
    "smooth": 0.00125,
    "falling": 0.000625,
}
"""What a joint does before it slips, and the step that takes: its stiffness against the unsprung
mass makes 50 Hz and more, its slope of tens of kN s/m decays in less than a millisecond."""

GENTLE = 1.0
"""A joint is gentle where what it does before it slips lasts longer than twice its step: with that
step, derivatives are then wrong by less than 10 %. Beyond, they soon are those of the scheme."""

RIG_FORMS = ("sticking", "smooth", "falling")
"""Forms that only one component on a rig tells from the others."""


@law
def elastic_slip(
    x: float, v: float, dx: float, dt: float, z: float, p: Array
) -> tuple[float, float]:
    """Jenkins element: a spring of stiffness p[1] that slips at the force p[0]; z is its force.
    Exact for any step as long as the motion does not turn within it."""
    force = min(max(z + p[1] * dx, -p[0]), p[0])
    return force, force


@law
def creeping_slip(
    x: float, v: float, dx: float, dt: float, z: float, p: Array
) -> tuple[float, float]:
    """Coulomb's law with its jump rounded: p[0] tanh(v / p[1])."""
    return p[0] * tanh(v / p[1]), z


@law
def falling_slip(
    x: float, v: float, dx: float, dt: float, z: float, p: Array
) -> tuple[float, float]:
    """The same falling from Stribeck's peak: p[0] tanh(v / p[1]) (1 + (p[2] − 1) e^−(v/p[3])²)."""
    return p[0] * tanh(v / p[1]) * (1.0 + (p[2] - 1.0) * exp(-((v / p[3]) ** 2))), z


LEAST = 1e-4
"""Of the usual speed, a third of the fastest, or of the longest way: joints that creep more slowly
or yield on less slip at once, as far as the record of a rig shows."""

KERNELS: dict[str, tuple[Law, *tuple[str, ...]]] = {
    "elastic": (elastic_slip, "presliding_N_m"),
    "creeping": (creeping_slip, "creep_m_s"),
    "sticking": (bristles, "presliding_N_m", "sticking", "stribeck_m_s"),
    "smooth": (bouc_wen, "yield_m", "roundness"),
    "falling": (falling_slip, "creep_m_s", "sticking", "stribeck_m_s"),
}
"""The law of each form, and its parameters after the slip force."""

CREEP = Shape(
    "creep_m_s",
    "m/s",
    "speed below which the joint creeps instead of sliding",
    0.01,
    lower=0.002,
    upper=0.04,
    starts=(0.004, 0.012),
)
"""What is believed of a vehicle's joints."""

SLOW = replace(CREEP, scale=0.08, lower=LEAST, upper=0.3, starts=(0.03, 0.1))

PEAK = (
    Shape(
        "sticking",
        "1",
        "force that holds at rest over the force that slides",
        0.3,
        lower=1.0,
        upper=3.0,
        starts=(1.4,),
    ),
    Shape(
        "stribeck_m_s",
        "m/s",
        "speed over which the force falls from the one to the other",
        0.15,
        lower=LEAST,
        upper=3.0,
        starts=(0.04, 0.3),
    ),
)

ON_RIG = {
    "creeping": (SLOW,),
    "sticking": PEAK,
    "falling": (SLOW, *PEAK),
    "smooth": (
        Shape(
            "yield_m",
            "m",
            "way on which first loading would reach the slip force at its first slope",
            0.06,
            lower=LEAST,
            upper=3.0,
            starts=(0.015, 0.12),
        ),
        Shape(
            "roundness",
            "1",
            "0.5: unloading is straight, 1: it is as round as loading",
            0.2,
            lower=0.5,
            upper=1.0,
            starts=(0.7,),
        ),
    ),
}
"""What each form has beside the slip force and a joint's stiffness; speeds and ways are shares of
what is usual on the rig, as records of a press creep at other speeds than those of a shaker."""


def _on(usual: Usual, share: Shape) -> Shape:
    """A parameter in units of its own instead of in shares of what is usual."""
    by = {"m/s": usual.speed_m_s, "m": usual.travel_m}.get(share.unit, 1.0)
    return replace(
        share,
        scale=by * share.scale,
        lower=by * share.lower,
        upper=by * share.upper,
        starts=tuple(by * start for start in share.starts),
    )


class DryFriction(Effect):
    """Beside the spring and damper of every strut: a Coulomb slider behind a spring, so that the
    joint gives way elastically before it slips, or one that creeps before it slides, as where a
    seal drags its film of oil along. On a rig also one that holds more at rest than it slides with
    (LuGre, with Stribeck's peak; or falling from that peak while it creeps), and one that yields
    smoothly, little by little (Bouc and Wen)."""

    id = "dry-friction"
    place = "suspension"
    on_rig = True
    title = "Coulomb friction in the strut and its joints, elastic or creeping before it slips"
    becomes = (
        Becomes(
            "presliding_N_m",
            "lower",
            "suspension stiffness",
            "a joint no stiffer than the spring hardly slips, it only adds to the spring",
        ),
    )
    equation = (
        r"\text{elastic: } \dot f = k_p \dot x \text{ while } |f| < F_c,\ 0 \text{ where the motion"
        r" would exceed it};\quad \text{creeping: } f = F_c \tanh(\dot x / w);"
        r"\quad \text{sticking: } \dot f = k_p \dot x\,(1 - f\,\mathrm{sgn}\dot x / g),"
        r"\ g = F_c\,(1 + (s - 1)\,e^{-(\dot x / v_s)^2});"
        r"\quad \text{smooth: } f = F_c z,"
        r"\ d\,\dot z = \dot x\,(1 - |z|\,(\beta\,\mathrm{sgn}(\dot x z) + 1 - \beta));"
        r"\quad \text{falling: } f = g \tanh(\dot x / w)"
    )
    source = (
        "Jenkins element: W. D. Iwan, A distributed-element model for hysteresis and its"
        " steady-state dynamic response, J. Appl. Mech. 33 (1966) 893, eq. 1; hyperbolic tangent:"
        " S. Andersson, A. Söderberg, S. Björklund, Friction models for sliding dry, boundary and"
        " mixed lubricated contacts, Tribology International 40 (2007) 580, eq. 4; sticking: C."
        " Canudas de Wit et al., A new model for control of systems with friction, IEEE Trans."
        " Automatic Control 40 (1995) 419, without the bristles' own damping; smooth:"
        " Y.-K. Wen, Method for random vibration of hysteretic systems, J. Eng. Mech. Div. ASCE 102"
        " (1976) 249, exponent 1"
    )

    def __init__(self, form: str = "elastic") -> None:
        self.form = form
        self.longest_step_s = LONGEST_STEP_S[form]

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """What the joint does before it slips."""
        return tuple(LONGEST_STEP_S)

    def with_choice(self, choice: str) -> DryFriction:
        """This effect with the law `choice`."""
        return DryFriction(choice)

    def applies_to(self, vehicle: Values) -> bool:
        """Two of the forms are for a component on a rig."""
        return super().applies_to(vehicle) and (self.form not in RIG_FORMS or is_component(vehicle))

    def change_step_s(self, theta: Values, vehicle: Values) -> float:
        """Twice as long where the joint is gentle to the unsprung masses."""
        step = 2.0 * self.longest_step_s
        if is_component(vehicle) or self.form in RIG_FORMS:
            return self.longest_step_s
        rates = [
            theta[f"{end}_N"] / theta["creep_m_s"] / vehicle[f"wheel.{end}.unsprung_mass_kg"]
            if self.form == "creeping"
            else sqrt(theta["presliding_N_m"] / vehicle[f"wheel.{end}.unsprung_mass_kg"])
            for end in ends(vehicle)
        ]
        return step if max(rates) * step < GENTLE else self.longest_step_s

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Slip force per axle; stiffness before slip, or the speed at which sliding sets in."""
        found = ends(vehicle)
        usual = next(iter(found.values())).usual
        return (
            *(
                Amplitude(
                    f"{end}_N",
                    "N",
                    f"slip force of {strut.name}",
                    0.06 * strut.usual.load_N,
                    lower=0.0,
                )
                for end, strut in found.items()
            ),
            *self._before_slip(usual, COMPONENT not in found),
        )

    def _before_slip(self, usual: Usual, on_car: bool) -> tuple[Parameter, ...]:
        if on_car and self.form == "creeping":
            return (CREEP,)
        more = tuple(_on(usual, share) for share in ON_RIG.get(self.form, ()))
        return (
            (self._spring(usual, on_car), *more) if self.form in ("elastic", "sticking") else more
        )

    def _spring(self, usual: Usual, on_car: bool) -> Shape:
        spring = usual.stiffness_N_m
        starts = {"sticking": (5, 40), "elastic": (20, 150) if on_car else (2, 20, 150)}[self.form]
        return Shape(
            "presliding_N_m",
            "N/m",
            "stiffness of the joint before it slips",
            100 * spring,
            lower=spring,
            upper=300 * spring if on_car else np.inf,  # a rig may hold it rigidly
            starts=tuple(start * spring for start in starts),
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the element to each strut."""
        for strut in struts(vehicle):
            kernel, *names = KERNELS[self.form]
            numbers = tuple(theta[name] for name in (f"{strut.end}_N", *names))
            if self.form == "smooth":
                numbers = (*numbers[:2], 1.0, 2.0 * numbers[2] - 1.0)
            parts.add_law(strut.row, kernel, numbers)
