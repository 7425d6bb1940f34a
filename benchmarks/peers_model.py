"""One mechanism for wheelhop, MuJoCo and Exudyn: a car over a half-sine bump.

Coordinates are heave, pitch, roll, four axles, then the frame's modes and the driver on the seat.
All masses are diagonal, so that MuJoCo takes each coordinate as a body on a slide joint. What is
stated here is stated once more by wheelhop's own assembly: that they agree is the first result.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.truth import PRESETS
from wheelhop.campaign import Channel
from wheelhop.effects import load_effects
from wheelhop.frame import CORNERS, read_corner_modes
from wheelhop.simulate import Model
from wheelhop.vehicle import System, baseline, between, body_inertia
from wheelhop.vehicle.assembly import Body
from wheelhop.vehicle.frame_modes import mode_values

Array = NDArray[np.float64]
CHANNELS = [Channel(f"{place}{i}", f"{place}{i}") for place in "BA" for i in (1, 2, 3, 4)]
ENDS = ("front", "front", "rear", "rear")
CAR = dict(PRESETS["atv"].vehicle)
FRAME = Path("examples/frame/baja.toml")
MODES = 6  # and four more for what all others give way to
SEAT = {"mass_kg": 70.0, "stiffness_N_m": 70.0 * (2 * np.pi * 3.0) ** 2, "damping_N_s_m": 500.0}
SEAT_AT = Body(-0.10, 0.0)
HEIGHT_M, LENGTH_M, BEGINS_M = 0.06, 0.60, 0.5
LAWS: Mapping[str, Mapping[str, float]] = {
    "progressive-spring": {"front_N_m3": 4e6, "rear_N_m3": 2e6},
    "bump-stop": {"stiffness_N_m": 3e4, "clearance_m": 0.02},
    "asymmetric-damper": {"front_N_s_m": 200.0, "rear_N_s_m": 150.0},
    "digressive-damper": {"front_loss": 0.4, "rear_loss": 0.4, "knee_m_s": 0.2},
    "dry-friction": {"front_N": 75.0, "rear_N": 55.0, "creep_m_s": 0.02},
    "anti-roll-bar": {"front_N_m": 3000.0, "rear_N_m": 2000.0},
}
FORMS = {"progressive-spring": "cubic", "dry-friction": "creeping"}


@dataclass(frozen=True, eq=False)
class Mechanism:
    """Diagonal masses (n,), stiffness and damping (n, n) without the tyres', rows of the struts
    (4, n), the outputs (8, n), and wheelhop's own equations of the same."""

    mass: Array
    springs: list[tuple[Array, float, float]]  #: row, stiffness and damping
    struts: Array
    output: Array
    system: System
    laws: bool = False
    tyre: Array = field(default_factory=lambda: _tyres(CAR))

    def matrices(self) -> tuple[Array, Array]:
        """Stiffness and damping (n, n), tyres included."""
        n = len(self.mass)
        k, c = np.zeros((n, n)), np.zeros((n, n))
        tyres = [(np.eye(n)[3 + i], *self.tyre[i]) for i in range(4)]
        for row, stiffness, damping in [*self.springs, *tyres]:
            k += stiffness * np.outer(row, row)
            c += damping * np.outer(row, row)
        return k, c

    @property
    def strut_numbers(self) -> list[dict[str, float]]:
        """The laws' numbers of every strut, for programs that write them anew."""
        return [
            {
                "cubic": LAWS["progressive-spring"][f"{end}_N_m3"],
                "stop": LAWS["bump-stop"]["stiffness_N_m"],
                "clearance": LAWS["bump-stop"]["clearance_m"],
                "one_sided": LAWS["asymmetric-damper"][f"{end}_N_s_m"],
                "lost": LAWS["digressive-damper"][f"{end}_loss"]
                * CAR[f"suspension.{end}.damping_N_s_m"],
                "knee": LAWS["digressive-damper"]["knee_m_s"],
                "slip": LAWS["dry-friction"][f"{end}_N"],
                "creep": LAWS["dry-friction"]["creep_m_s"],
            }
            for end in ENDS
        ]


def _tyres(values: Mapping[str, float]) -> Array:
    keys = ("tyre_stiffness_N_m", "tyre_damping_N_s_m")
    return np.array([[values[f"wheel.{end}.{key}"] for key in keys] for end in ENDS])


def _places() -> list[tuple[float, float]]:
    ahead, half = CAR["geometry.cg_to_front_axle_m"], CAR["geometry.track_width_m"] / 2
    behind = CAR["geometry.wheelbase_m"] - ahead
    return [(ahead, half), (ahead, -half), (-behind, half), (-behind, -half)]


def flexible() -> Mechanism:
    """Full car, driver on a seat, frame with ten modes; linear."""
    frame = mode_values(read_corner_modes(FRAME), MODES, 0.02)
    values = {**CAR, **frame}
    count = sum(key.endswith("frequency_hz") for key in frame)
    parts = baseline(values, CHANNELS, "road")
    driver = parts.add_coordinate("driver")
    parts.add_mass(((1.0, driver),), SEAT["mass_kg"])
    parts.add_spring(between(driver, SEAT_AT), SEAT["stiffness_N_m"], SEAT["damping_N_s_m"])
    corners = np.array([[frame[f"frame.{c}.x_m"], frame[f"frame.{c}.y_m"]] for c in CORNERS])
    x, y = corners.T + np.array([[CAR["geometry.cg_to_front_axle_m"]], [0.0]])
    shapes = np.array(
        [
            np.linalg.solve(
                np.stack([np.ones(4), x, y, x * y], axis=1),
                [frame[f"frame.{i}.{c}"] for c in CORNERS],
            )
            for i in range(1, count + 1)
        ]
    )

    def body(px: float, py: float) -> Array:
        rigid = [1.0, -px, py, 0.0, 0.0, 0.0, 0.0]
        return np.concatenate([rigid, shapes @ [1.0, px, py, px * py], [0.0]])

    n = 7 + count + 1
    axles, seat = np.eye(n)[3:7], body(SEAT_AT.x_m, SEAT_AT.y_m)
    tops = np.array([body(*place) for place in _places()])
    springs = _struts(tops - axles)
    springs.append((np.eye(n)[-1] - seat, SEAT["stiffness_N_m"], SEAT["damping_N_s_m"]))
    for i in range(count):
        omega = 2 * np.pi * frame[f"frame.{i + 1}.frequency_hz"]
        springs.append((np.eye(n)[7 + i], omega**2, 2 * 0.02 * omega))
    mass = np.concatenate([_rigid_masses(), np.ones(count), [SEAT["mass_kg"]]])
    system = parts.system(body_inertia(values))
    return Mechanism(mass, springs, tops - axles, np.vstack([tops, axles]), system)


def with_laws() -> Mechanism:
    """Full car, rigid, with a law of every kind in its struts."""
    tops = np.array([[1.0, -x, y, 0.0, 0.0, 0.0, 0.0] for x, y in _places()])
    axles = np.eye(7)[3:7]
    rows = tops - axles
    springs = _struts(rows)
    for i, end in ((0, "front"), (2, "rear")):
        springs.append((rows[i] - rows[i + 1], LAWS["anti-roll-bar"][f"{end}_N_m"], 0.0))
    model, library = Model(CAR), load_effects()
    for name, theta in LAWS.items():
        effect = library[name].with_choice(FORMS[name]) if name in FORMS else library[name]
        model = model.with_effect(effect, effect.parameters_for(CAR, CHANNELS))
        model = model.with_values({f"{name}.{key}": value for key, value in theta.items()})
    system = model.system(CHANNELS, "road")
    return Mechanism(_rigid_masses(), springs, rows, np.vstack([tops, axles]), system, laws=True)


def _struts(rows: Array) -> list[tuple[Array, float, float]]:
    return [
        (row, CAR[f"suspension.{e}.stiffness_N_m"], CAR[f"suspension.{e}.damping_N_s_m"])
        for row, e in zip(rows, ENDS, strict=True)
    ]


def _rigid_masses() -> Array:
    body = [CAR[f"body.{key}"] for key in ("mass_kg", "pitch_inertia_kg_m2", "roll_inertia_kg_m2")]
    return np.array([*body, *(CAR[f"wheel.{end}.unsprung_mass_kg"] for end in ENDS)])


def arrivals_s(speed_m_s: float) -> list[float]:
    """When each wheel reaches the bump."""
    behind = (0.0, 0.0, CAR["geometry.wheelbase_m"], CAR["geometry.wheelbase_m"])
    return [(BEGINS_M + back) / speed_m_s for back in behind]


def bump(speed_m_s: float, time_s: NDArray[np.floating]) -> tuple[Array, Array]:
    """Heights, m, and rates, m/s, of the ground under the wheels (T, 4): left wheels alone."""
    height, rate = np.zeros((len(time_s), 4)), np.zeros((len(time_s), 4))
    turn = np.pi * speed_m_s / LENGTH_M
    for i in (0, 2):
        since = time_s - arrivals_s(speed_m_s)[i]
        on = (since > 0.0) & (since < LENGTH_M / speed_m_s)
        height[:, i] = np.where(on, HEIGHT_M * np.sin(turn * since), 0.0)
        rate[:, i] = np.where(on, HEIGHT_M * turn * np.cos(turn * since), 0.0)
    return height, rate
