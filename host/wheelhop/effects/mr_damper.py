"""A force that yields and stores: elastic first, then creeping, then sliding."""

from __future__ import annotations

from collections.abc import Sequence

from wheelhop.campaign import Channel
from wheelhop.effects.base import Effect, Values
from wheelhop.effects.hysteresis import yielding
from wheelhop.effects.parameters import Amplitude, Parameter, Shape
from wheelhop.vehicle import Assembly, ends, inputs_of, struts


class MrDamper(Effect):
    """A force with a limit: below it gives way as a spring does and stores, near it creeps, beyond
    it slides at a force that hardly grows. The fluid of a magnetorheological damper does so, and
    any joint that both creeps and is elastic. Where inputs are recorded, a coil's voltage or
    current, the limit may be a constant plus so much times each."""

    id = "mr-damper"
    place = "suspension"
    on_rig = True
    on_vehicle = False
    title = "a force that yields and stores: elastic before, creeping at, sliding beyond its limit"
    equation = (
        r"f = (F_y + \sum_u F_u u)\,\zeta,\quad d\,\dot\zeta = \dot x - w\,\mathrm{artanh}\,\zeta"
    )
    longest_step_s = 0.00125
    source = (
        "three-parameter element in series with the yielding one: D. R. Gamota, F. E. Filisko,"
        " Dynamic mechanical studies of electrorheological materials, J. Rheology 35 (1991) 399;"
        " amplitudes linear in the voltage: B. F. Spencer et al., Phenomenological model for"
        " magnetorheological dampers, J. Eng. Mech. 123 (1997) 230"
    )

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """Yield force per axle, and of each input; the way it gives before, the speed it creeps."""
        found = ends(vehicle)
        usual = next(iter(found.values())).usual
        return (
            *(
                Amplitude(
                    f"{end}_N",
                    "N",
                    f"yield force of {strut.name}",
                    0.2 * strut.usual.load_N,
                    lower=0.0,
                )
                for end, strut in found.items()
            ),
            *(_by(name, size, usual.load_N) for name, size in inputs_of(vehicle).items()),
            Shape(
                "yield_m",
                "m",
                "way it gives before it yields",
                0.05 * usual.travel_m,
                lower=1e-3 * usual.travel_m,
                upper=usual.travel_m,
                starts=(0.01 * usual.travel_m, 0.1 * usual.travel_m),
            ),
            Shape(
                "creep_m_s",
                "m/s",
                "speed at which it creeps with three quarters of the yield force",
                0.1 * usual.speed_m_s,
                lower=2e-3 * usual.speed_m_s,
                upper=usual.speed_m_s,
                starts=(0.02 * usual.speed_m_s, 0.15 * usual.speed_m_s),
            ),
        )

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add the force to each strut, and what each input adds."""
        shape = (theta["yield_m"], theta["creep_m_s"])
        for strut in struts(vehicle):
            parts.add_law(strut.row, yielding, (theta[f"{strut.end}_N"], *shape))
            for name in inputs_of(vehicle):
                parts.add_law(strut.row, yielding, (theta[f"{name}_N"], *shape), by=name)


def _by(name: str, size: float, load_N: float) -> Amplitude:
    return Amplitude(f"{name}_N", "N", f"yield force per unit of {name}", 0.2 * load_N / size)
