"""What people carry: sets of sensors, each as one kind of user has them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tests.truth import Sensor

POT_NOISE_M, RATIO = 5e-5, 0.65
HUBS = tuple(Sensor(f"A{i}", "acceleration", f"A{i}", 0.1) for i in (1, 2, 3, 4))


def pots(noise_m: float = POT_NOISE_M, ratio: float = RATIO) -> tuple[Sensor, ...]:
    """Four potentiometers on the dampers."""
    return tuple(Sensor(f"pot{i}", "travel", str(i), noise_m, ratio, 0.031) for i in (1, 2, 3, 4))


IMU = (
    Sensor("imu_z", "acceleration", "cg", 0.1, 1.0, 0.05),
    Sensor("pitch_rate", "rate", "pitch", 0.004, 1.0, 0.01),
    Sensor("roll_rate", "rate", "roll", 0.004, 1.0, -0.02),
)
SETS: Mapping[str, Sequence[Sensor]] = {
    "baja": (*pots(), *IMU),
    "formula-student": (*pots(), *IMU, *HUBS[:2]),
    "ride-engineer": (*HUBS, *(Sensor(f"B{i}", "acceleration", f"B{i}", 0.1) for i in (1, 4))),
    "all": (
        *pots(),
        *HUBS,
        *(Sensor(f"B{i}", "acceleration", f"B{i}", 0.1, 1.0, 0.05) for i in (1, 2, 3, 4)),
        *IMU[1:],
    ),
}
"""A Baja team: damper pots and one IMU. A Formula Student team: accelerometers on the front hubs,
too. A ride engineer: hubs and two places on the body. All of it together."""
