"""A rubber bushing between strut and body."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, hypot, pi

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, Values, law
from wheelhop.effects.parameters import Amplitude, Parameter, Shape
from wheelhop.material import Elements
from wheelhop.material.series import in_series as on_elements
from wheelhop.vehicle import Assembly, Usual, ends, mounted, struts

TYPICAL_HZ = 8.0
"""Between the body's resonances and the wheels': there a mount half as soft as its strut shows."""


@law
def in_series(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """What a mount of compliance p[0] and relaxation time p[1] takes away from a strut of
    stiffness p[2] and damping p[3].

    The mount's extension u obeys a u + b u̇ = s (k x + c ẋ), a = 1 + s k, b = τ + s c. The state
    z = b u − s c x is free of ẋ: ż = −λ z + s (k − λ c) x, λ = a/b, solved exactly along the
    parabola through x at both ends of the step and its rate at the end, for any λ.
    """
    compliance, tau, stiffness, damping = p[0], p[1], p[2], p[3]
    a, b = 1.0 + compliance * stiffness, tau + compliance * damping
    rate, push = a / b, compliance * (stiffness - a / b * damping)
    if dt > 0.0:
        decay = exp(-rate * dt)
        # ∫ rⁱ e^(−λ r) dr over the step, r the time before its end.
        zeroth = (1.0 - decay) / rate
        first = (zeroth - dt * decay) / rate
        second = (2.0 * first - dt * dt * decay) / rate
        bend = (v * dt - dx) / (dt * dt)
        z = decay * z + push * (x * zeroth - v * first + bend * second)
    u = (z + compliance * damping * x) / b
    u_rate = (compliance * (stiffness * x + damping * v) - a * u) / b
    return -stiffness * u - damping * u_rate, z


@law
def relaxing(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    """A force p[2] x + p[3] ẋ + p[0] z with ż = p[1] (x − z), solved exactly along the parabola
    through x at both ends of the step and its rate at the end."""
    gain, rate = p[0], p[1]
    if dt > 0.0:
        # What lags behind x: x − z obeys ẏ = ẋ − λ y.
        decay = exp(-rate * dt)
        zeroth = (1.0 - decay) / rate
        first = (zeroth - dt * decay) / rate
        bend = (v * dt - dx) / (dt * dt)
        behind = decay * (x - dx - z) + v * zeroth - 2.0 * bend * first
        z = x - behind
    return p[2] * x + p[3] * v + gain * z, z


class MountBushing(Effect):
    """A mount in series with every strut: a spring and damper (Kelvin–Voigt), or, where the nominal
    numbers have a specimen measured on a rig, that one."""

    id = "mount-bushing"
    place = "suspension"
    on_rig = True
    title = "a viscoelastic mount in series with the strut"
    equation = r"u + \tau \dot u = s\,[k (x - u) + c (\dot x - \dot u)],\quad f = -k u - c \dot u"
    source = (
        "Kelvin–Voigt element, e.g. J. C. Dixon, The Shock Absorber Handbook, 2nd ed. (Wiley 2007),"
        " ch. 6, bushes of the damper's ends"
    )

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Compliance per axle; the rubber's relaxation time, unless the specimen has it."""
        if mounted(vehicle) is not None:
            return [
                Amplitude(
                    f"{end}_mounts",
                    "1",
                    f"compliance of the mount of {strut.name}, as a multiple of the specimen's",
                    1.0,
                    lower=0.0,
                )
                for end, strut in ends(vehicle).items()
            ]
        return (
            *(
                Amplitude(
                    f"{end}_m_N",
                    "m/N",
                    f"compliance of the mount of {strut.name}: one over its stiffness",
                    0.5 / _rigidity(strut.usual),
                    lower=0.0,
                )
                for end, strut in ends(vehicle).items()
            ),
            Shape(
                "relaxation_s",
                "s",
                "damping over stiffness of the mount",
                0.005,
                lower=1e-4,
                upper=0.2,
                starts=(0.001, 0.005, 0.02),
            ),
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Take away from each strut what its mount gives way."""
        elements = mounted(vehicle)
        if elements is not None:
            _stand_on(elements, theta, vehicle, parts)
            return
        for strut in struts(vehicle):
            compliance, tau = theta[f"{strut.end}_m_N"], theta["relaxation_s"]
            parts.add_law(
                strut.row, in_series, (compliance, tau, strut.stiffness_N_m, strut.damping_N_s_m)
            )


def _stand_on(elements: Elements, theta: Values, vehicle: Values, parts: Assembly) -> None:
    """Put every strut on the specimen, so many times over."""
    for strut in struts(vehicle):
        share = theta[f"{strut.end}_mounts"]
        series = on_elements(strut.stiffness_N_m, strut.damping_N_s_m, elements, share)
        beside = (
            series.stiffness_N_m - strut.stiffness_N_m,
            series.damping_N_s_m - strut.damping_N_s_m,
        )
        for gain, rate in zip(series.gains_N_m, series.rates_1_s, strict=True):
            parts.add_law(strut.row, relaxing, (float(gain), float(rate), *beside))
            beside = (0.0, 0.0)


def _rigidity(usual: Usual) -> float:
    """Dynamic stiffness, N/m, of a strut where its mount matters."""
    return hypot(usual.stiffness_N_m, 2 * pi * TYPICAL_HZ * usual.damping_N_s_m)
