"""A small valid campaign on disk, to be read as it is or broken in one place."""

from pathlib import Path

import numpy as np

POINTS = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")
ROWS = 256

CAMPAIGN = """\
format = 1
title = "two runs"
vehicle = "vehicle.toml"
sample_rate_hz = 100.0
band_hz = [0.5, 30.0]
averaging_ms = 6.6
noise_rms_m_s2 = 0.12

[[run]]
id = "slow"
file = "runs/slow.csv"
role = "fit"
speed_kmph = 7.5
track.kind = "washboard"
track.amplitude_mm = 15
track.pitch_mm = 400

[[run]]
id = "fast"
file = "runs/fast.csv"
role = "validate"
speed_kmph = 36
track.kind = "chassis-twist"
track.amplitude_mm = 150
track.pitch_mm = 2000
"""

VEHICLE = """\
format = 1
name = "student-built ATV"
relative_uncertainty = 0.10

[geometry]
wheelbase_m = 1.42
track_width_m = 1.18
cg_to_front_axle_m = 0.80
cg_height_m = 0.52

[body]
mass_kg = 228.0
pitch_inertia_kg_m2 = 62.0
roll_inertia_kg_m2 = 25.0

[suspension.front]
stiffness_N_m = 10500.0
stiffness_N_m_uncertainty = 800.0
damping_N_s_m = 630.0
[suspension.rear]
stiffness_N_m = 6500.0
damping_N_s_m = 590.0

[wheel.front]
unsprung_mass_kg = 15.0
tyre_stiffness_N_m = 40000.0
tyre_damping_N_s_m = 200.0
radius_m = 0.279
[wheel.rear]
unsprung_mass_kg = 12.5
tyre_stiffness_N_m = 40000.0
tyre_damping_N_s_m = 200.0
radius_m = 0.279

[driver]
mass_kg = 70.0
x_m = -0.10
y_m = 0.0
"""


def acceleration(seed: int) -> np.ndarray:
    """(ROWS, 8) numbers as a logger writes them."""
    return np.random.default_rng(seed).normal(0.0, 5.0, (ROWS, len(POINTS))).round(4)


def csv_text(values: np.ndarray, names: tuple[str, ...] = POINTS, rate_hz: float = 100.0) -> str:
    """A recording of (n, channels) values."""
    rows = [f"{i / rate_hz:.2f}," + ",".join(map(str, row)) for i, row in enumerate(values)]
    return "\n".join([",".join(("time_s", *names)), *rows]) + "\n"


def write_campaign(folder: Path) -> Path:
    """The campaign of this module in `folder`, which is returned."""
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    (folder / "campaign.toml").write_text(CAMPAIGN)
    (folder / "vehicle.toml").write_text(VEHICLE)
    (folder / "runs/slow.csv").write_text(csv_text(acceleration(1)))
    (folder / "runs/fast.csv").write_text(csv_text(acceleration(2)))
    return folder


def edit(file: Path, old: str, new: str) -> None:
    """Replace the first `old` in a text file by `new`; it must be there."""
    text = file.read_text()
    assert old in text, f"{file} has no {old!r}"
    file.write_text(text.replace(old, new, 1))
