"""A wheel out of balance pulls its axle up and down once a turn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, OwnValues, Probe, RunSetting, Values
from wheelhop.effects.parameters import Amplitude, Parameter, Shape
from wheelhop.effects.special import TiedRuns
from wheelhop.vehicle import CORNERS, Assembly, axle, axle_name, wheels

WHEELS: Mapping[str, tuple[int, ...]] = {
    "front_left": (0,),
    "front_right": (1,),
    "rear_left": (2,),
    "rear_right": (3,),
    "all": CORNERS,
}
"""The wheels that turn out of balance, by the name of the form."""

SCALE_M = 0.04
"""Of a wheel of 12 kg at 20 km/h a fifth of the weight that a small vehicle puts on it: it shows at
any speed. It is not the imbalance itself that is free: records show a force and a mass only by
their ratio, and a belief in small forces makes the vehicle light."""

SHOWN = 3.0
"""A force this many times its uncertainty is one: of less, noise makes an amplitude, too."""

ALIKE = 0.02
"""What else is wrong with the forces, as a fraction of the largest: alike in all runs."""

EXPONENT_KNOWN = 0.3
"""Standard deviation up to which an exponent of speed is stated;
nominal speeds that are 5 % off give it 0.1 to 0.2."""

LEAST_EXPONENT = 1.0
"""What grows with less than this power of the speed, where that is known, is no imbalance."""

ROLLING = np.linspace(0.95, 1.05, 61)
"""Effective rolling radii to look at, as a fraction of the wheel's radius: tyres roll on a radius
between the loaded and the free one."""


class WheelImbalance(TiedRuns):
    """The force follows from the wheel's own way, or from how a channel shows the wheel to turn;
    how the wheel stands when the record begins differs from run to run, and cosine and sine part of
    the imbalance are free in each."""

    id = "wheel-imbalance"
    place = "axle"
    title = "a force that turns with the wheel, growing with speed squared"
    equation = (
        r"F = \dot\alpha^2 (u_c \cos\alpha + u_s \sin\alpha),\quad \alpha = x / r,"
        r"\ u = m\,e \text{ the imbalance, } m \text{ the unsprung mass}"
    )
    source = (
        "rotating imbalance, e.g. H. Dresig, F. Holzweissig, Dynamics of Machinery (Springer 2010),"
        " ch. 2; r the effective rolling radius, H. B. Pacejka, Tire and Vehicle Dynamics, 3rd ed."
        " (2012), section 1.2"
    )
    needs_road = True

    def __init__(self, form: str = "all") -> None:
        self.form = form

    @property
    def wheels(self) -> tuple[int, ...]:
        """The corners out of balance."""
        return WHEELS[self.form]

    @property
    def _ends(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(axle_name(i) for i in self.wheels))

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """Which wheel, or all of them."""
        return tuple(WHEELS)

    def with_choice(self, choice: str) -> WheelImbalance:
        """This effect with the wheel `choice`."""
        return WheelImbalance(choice)

    def applies_to(self, vehicle: Values) -> bool:
        """Whether it has all these wheels."""
        return set(self.wheels) <= set(wheels(vehicle))

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """The radius the wheels roll on; it starts where `shape_starts` sees their line."""
        parameters = []
        for end in self._ends:
            radius = vehicle[f"wheel.{end}.radius_m"]
            parameters.append(
                Shape(
                    f"{end}_m",
                    "m",
                    f"radius on which a {end} wheel rolls: way per radian",
                    0.02 * radius,
                    lower=0.8 * radius,
                    upper=1.2 * radius,
                    starts=(radius,),
                )
            )
        return parameters

    def per_run(self, run: RunSetting) -> Sequence[Parameter]:
        """Cosine and sine part of each eccentricity, the angle counted from mid-record."""
        if run.speed_m_s <= 0:
            return ()
        return tuple(
            Amplitude(
                f"{_name(i)}_{part}_m", "m", f"{word} part of imbalance per unsprung mass", SCALE_M
            )
            for i in self.wheels
            for part, word in (("cos", "cosine"), ("sin", "sine"))
        )

    def shape_starts(self, probe: Probe) -> Sequence[Values]:
        """The rolling radius of each axle at which the residual turns with its wheels most."""
        power = {end: np.zeros(len(ROLLING)) for end in self._ends}
        for run in probe.settings:
            if not run.on_road or run.speed_m_s <= 0:
                continue
            residual = probe.measured(run.run_id) - probe.modelled(run.run_id, {})
            time, way = probe.time_s(run.run_id), probe.way_m(run.run_id)
            for end in power:
                wheels = [i for i in CORNERS if axle_name(i) == end]
                rolled = [_rolled(run, i, time, way[:, i], way[:, i])[0] for i in wheels]
                turned = np.mean(rolled, axis=0) / probe.values[f"wheel.{end}.radius_m"]
                lines = np.exp(-1j * turned / ROLLING[:, None]) @ residual
                power[end] += (np.abs(lines) ** 2).sum(axis=1) / (residual**2).sum()
        start = {}
        for end, found in power.items():
            radius = float(ROLLING[np.argmax(found)]) * probe.values[f"wheel.{end}.radius_m"]
            start[f"{end}_m"] = radius
        return [start]

    def summary(self, runs: Sequence[OwnValues]) -> dict[str, float]:
        """Each imbalance, root mean square of the force over that of the speed squared; and where
        the runs tell it, with which power of the speed the strongest force grows: 2 for an
        imbalance, 0 for a wheel that is out of round."""
        speed = np.array([run.speed_m_s for run, _, _ in runs])
        found, strongest, known_to = {}, np.zeros(len(runs)), np.zeros(len(runs))
        for i in self.wheels:
            force = speed**2 * _imbalance(i, [(theta, theta) for _, theta, _ in runs])
            found[f"{_name(i)}_kg_m"] = float(np.sqrt((force**2).sum() / (speed**4).sum()))
            if np.linalg.norm(force) > np.linalg.norm(strongest):
                strongest = force
                known_to = speed**2 * _imbalance(i, [(theta, sd) for _, theta, sd in runs])
        exponent = _exponent(speed, strongest, known_to)
        return found if exponent is None else {**found, "speed_exponent": exponent}

    def contradicted(self, runs: Sequence[OwnValues]) -> bool:
        """Whether the force does not grow with speed as an imbalance's does."""
        return self.summary(runs).get("speed_exponent", 2.0) < LEAST_EXPONENT

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """A force on each axle."""
        for i in self.wheels:
            parts.add_force(((vehicle[_mass(i)], axle(i)),))

    def forces(
        self, theta: Values, run: RunSetting, time_s: Array, way_m: Array, speed_m_s: Array
    ) -> Sequence[Array]:
        """Histories of the forces per unsprung mass."""
        middle_s = (run.record_start_s + run.end_s) / 2
        histories = []
        for i in self.wheels:
            radius = theta[f"{axle_name(i)}_m"]
            way, speed = _rolled(run, i, time_s, way_m[:, i], speed_m_s[:, i])
            angle = (way - np.interp(middle_s, time_s, way)) / radius
            cosine, sine = _parts(theta, i)
            turning = cosine * np.cos(angle) + sine * np.sin(angle)
            histories.append((speed / radius) ** 2 * turning)
        return histories


def _rolled(
    run: RunSetting, corner: int, time_s: Array, way_m: Array, speed_m_s: Array
) -> tuple[Array, Array]:
    """Way (T,), m, that a wheel rolled, and its rate: in the record as far as the vehicle came,
    within it as a channel shows the wheel to turn, if one does."""
    turned = run.known.wheels.get(corner)
    if turned is None:
        return way_m, speed_m_s
    ends = np.array([run.record_start_s, run.end_s])
    first, last = np.interp(ends, time_s, way_m)
    since, until = turned.gone(ends)
    mean = (last - first) / (until - since)
    return first + mean * (turned.gone(time_s) - since), mean * turned.faster(time_s)


def _exponent(speed: Array, force: Array, uncertainty: Array) -> float | None:
    """Slope of ln(force) over ln(speed), of the runs that show a force; None if it is not known to
    `EXPONENT_KNOWN`, by the forces' uncertainty or by their scatter."""
    shown = force > SHOWN * uncertainty
    if len(set(speed[shown])) < 4:
        return None
    error = np.hypot(uncertainty, ALIKE * force.max())[shown] / force[shown]
    x, y = np.log(speed[shown]), np.log(force[shown])
    line, scattered = np.polyfit(x, y, 1, w=1.0 / error, cov=True)
    _, expected = np.polyfit(x, y, 1, w=1.0 / error, cov="unscaled")
    variance = max(scattered[0, 0], expected[0, 0])
    return float(line[0]) if variance < EXPONENT_KNOWN**2 else None


def _name(corner: int) -> str:
    return tuple(WHEELS)[corner]


def _mass(corner: int) -> str:
    return f"wheel.{axle_name(corner)}.unsprung_mass_kg"


def _parts(theta: Values, corner: int) -> tuple[float, float]:
    """Cosine and sine part of a wheel's eccentricity, m; 0 in a run where they are not stated."""
    name = _name(corner)
    return theta.get(f"{name}_cos_m", 0.0), theta.get(f"{name}_sin_m", 0.0)


def _imbalance(corner: int, runs: Sequence[tuple[Values, Values]]) -> Array:
    """Of vehicles and eccentricities, run by run: kg·m."""
    return np.array([of[_mass(corner)] * np.hypot(*_parts(parts, corner)) for of, parts in runs])
