"""A damper whose oil and gas give way in series with its valves."""

from __future__ import annotations

from collections.abc import Sequence
from math import copysign, inf

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, Values, law
from wheelhop.effects.hysteresis import STAGE
from wheelhop.effects.parameters import Amplitude, Parameter, Shape
from wheelhop.vehicle import Assembly, Strut, ends, mounted, struts

LEAST_BLEED, MOST_BLEED = 0.05, 0.5
"""A valve that bleeds less is hardly told from dry friction, one that bleeds more from a linear
damper behind a spring, which have names of their own; the slope of a damper's force at low speed is
some three to ten times that of its open valves."""

LEAST_OPENING = 0.05
"""Of the usual force: a valve that less holds shut is a linear damper behind a spring, too."""

LEAST_LAG = 0.004
"""Of the time in which the usual speed covers the longest way, a third of a radian of a sine: less,
0.7°, are valves without compliance, friction among them, which have names of their own."""

VALVE, BLOW_OFF = "valve", "blow-off"


@law
def valves_in_series(
    x: float, v: float, dx: float, dt: float, z: float, p: Array
) -> tuple[float, float]:
    """The force of valves behind a spring, less the damping p[1] v they replace.

    p[0] is the time in which the spring follows the open valves, their damping over its stiffness,
    p[1] the mean slope of the open valves, p[2] half of rebound less compression over it, p[3]
    the force that opens them, p[4] the share of the flow that bleeds past them, p[5] the share of
    the slope that is lost once p[6] more than the opening force has blown them off. z is the force:
    τ ż = c (ẋ − q(z)), q straight between its knees, so that either implicit stage is solved
    exactly.
    """
    damping, bleed = p[1], p[4]
    if damping <= 0.0:
        return 0.0, 0.0
    if dt <= 0.0 and z != 0.0:
        return z - damping * v, z
    # At the first sample the speed is taken to have lasted: the spring is still.
    spring, flow = (p[0], STAGE * dt) if dt > 0.0 else (0.0, 1.0)
    begin = 2.0 * dx / dt - v if dt > 0.0 else v
    drive = spring * z + flow * damping * (begin + STAGE * (v - begin))
    for stage in range(2):
        side = 1.0 + copysign(p[2], p[2] * drive)
        rest, force, slope = abs(drive), 0.0, spring + flow * bleed / side
        if rest > slope * p[3]:
            rest -= slope * p[3]
            force, slope = p[3], spring + flow / side
            if rest > slope * p[6]:
                rest -= slope * p[6]
                force, slope = force + p[6], spring + flow / (side * (1.0 - p[5]))
        reached = copysign(force + rest / slope, drive)
        if stage == 0:
            moved = spring * (reached - z)
            drive = spring * z + (1.0 - STAGE) / STAGE * moved + flow * damping * v
    return reached - damping * v, reached


class CompliantDamper(Effect):
    """The valves of a damper, which bleed, open and blow off, more in one direction than in the
    other, in series with a spring: the oil, the gas in it and the hoses give way before the valves
    let it flow. After a reversal the force lags behind the velocity. A passive damper on a
    dynamometer behaves so, most at small strokes."""

    id = "compliant-damper"
    place = "suspension"
    on_rig = True
    on_vehicle = False
    title = "the damper gives way in series with its valves: the force lags behind the velocity"
    equation = (
        r"f = z - c\,\dot x,\quad \tau\,\dot z = c\,(\dot x - q(z)),"
        r"\quad c\,(1 \pm a)\,|q| = b\,|z| + (1 - b)\,(|z| - F_o)_+"
        r" + \frac{\lambda}{1 - \lambda}\,(|z| - F_o - F_b)_+"
    )
    longest_step_s = 0.00125
    source = (
        "valves with bleed, preload and blow-off: J. C. Dixon, The Shock Absorber Handbook, 2nd ed."
        " (Wiley 2007), ch. 6 and 7; the spring of oil and gas in series with them: R. Karadayi,"
        " G. Y. Masada, A nonlinear shock absorber model, ASME AMD 80 (1986) 149"
    )

    def __init__(self, form: str = VALVE) -> None:
        self.form = form

    def applies_to(self, vehicle: Values) -> bool:
        """To what stands on no specimen: one that is known is what gives way in series."""
        return super().applies_to(vehicle) and mounted(vehicle) is None

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """Valves that open, and ones that blow off beyond."""
        return (VALVE, BLOW_OFF)

    def with_choice(self, choice: str) -> CompliantDamper:
        """The damper with these valves."""
        return CompliantDamper(choice)

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Compliance, asymmetry and opening force per axle; bleed, and what blows off."""
        found = ends(vehicle)
        load = next(iter(found.values())).usual.load_N
        return (
            *(one for end, strut in found.items() for one in _amplitudes(end, strut)),
            Shape(
                "bleed",
                "1",
                "slope of the open valves over that of the bleed before",
                0.3,
                lower=LEAST_BLEED,
                upper=MOST_BLEED,
                starts=(0.1, 0.4),
            ),
            *(self._blow_off(load) if self.form == BLOW_OFF else ()),
        )

    def _blow_off(self, load_N: float) -> tuple[Parameter, ...]:
        return (
            Amplitude(
                "loss", "1", "share of the slope lost once blown off", 0.5, lower=0.0, upper=0.98
            ),
            Shape(
                "blow_off_N",
                "N",
                "force beyond that of opening at which the valves blow off",
                0.5 * load_N,
                lower=0.05 * load_N,
                starts=(0.5 * load_N, 1.2 * load_N),
            ),
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Take the linear damping of each strut away, and put the damper there."""
        for strut in struts(vehicle):
            numbers = (
                theta[f"{strut.end}_s"],
                strut.damping_N_s_m,
                theta[f"{strut.end}_asymmetry"],
                theta[f"{strut.end}_opening_N"],
                theta["bleed"],
                theta.get("loss", 0.0),
                theta.get("blow_off_N", inf),
            )
            parts.add_law(strut.row, valves_in_series, numbers)


def _amplitudes(end: str, strut: Strut) -> tuple[Parameter, ...]:
    """What vanishes with the effect."""
    usual = strut.usual
    turn = usual.travel_m / usual.speed_m_s
    return (
        Amplitude(
            f"{end}_s",
            "s",
            f"damping of the open valves of {strut.name} over the stiffness in series with them",
            0.1 * turn,
            lower=LEAST_LAG * turn,
        ),
        Amplitude(
            f"{end}_asymmetry",
            "1",
            f"half of rebound less compression damping over their mean, {strut.name}",
            0.3,
            lower=-0.95,
            upper=0.95,
        ),
        Amplitude(
            f"{end}_opening_N",
            "N",
            f"force that opens the valves of {strut.name}",
            0.15 * usual.load_N,
            lower=LEAST_OPENING * usual.load_N,
        ),
    )
