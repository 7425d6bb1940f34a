"""Make `examples/rig`: what rig, damper charts and linkage of the thesis's ATV would look like.

The measurements are not published, the numbers of table 4.1 are. A strut has
that stiffness at ride height and stiffens a little, with friction, and is cycled at three
amplitudes; a damper has a little more rebound than compression; a linkage has the motion ratio of
table 4.1, which grows in bump: python docs/make_rig_examples.py
"""

from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parents[1] / "examples/rig"
# Strut N/m and N s/m, force at ride N, stiffer by 1/m, friction N, motion ratio, its growth 1/m.
AXLES = {
    "front": (25e3, 1.50e3, 753.0, 3.0, 25.0, np.sqrt(10.5 / 25.0), 0.3),
    "rear": (15e3, 1.36e3, 957.0, 3.0, 20.0, np.sqrt(6.5 / 15.0), 0.3),
}
RIDE_MM = 50.0
STROKES_MM = (10.0, 20.0, 30.0)


def main() -> None:
    """Write every file."""
    FOLDER.mkdir(exist_ok=True)
    draw = np.random.default_rng(41)
    for name, (k, c, load, stiffening, friction, ratio, growth) in AXLES.items():
        turn = np.linspace(0.0, 2 * np.pi, 81)
        x = np.concatenate([stroke * np.sin(turn) for stroke in STROKES_MM])
        way = np.concatenate([np.sign(np.cos(turn)) for _ in STROKES_MM])
        force = load + k * 1e-3 * x * (1.0 + 0.5e-3 * stiffening * x) + friction * way
        force += 5.0 * draw.normal(size=len(x))
        write(f"{name}-strut", "displacement_mm,force_N", RIDE_MM + x, force)
        v = np.linspace(-600.0, 600.0, 25)
        force = 1e-3 * c * v * np.where(v > 0.0, 0.95, 1.05) + 60.0 + 5.0 * draw.normal(size=len(v))
        write(f"{name}-damper", "velocity_mm_s,force_N", v, force)
        z = np.linspace(-75.0, 75.0, 16)
        strut = ratio * z + 0.5e-3 * growth * z**2 + 0.1 * draw.normal(size=len(z))
        write(f"{name}-linkage", "wheel_travel_mm,strut_travel_mm", z, strut)


def write(name: str, heading: str, x: np.ndarray, y: np.ndarray) -> None:
    """Write two columns."""
    rows = [f"{a:.1f},{b:.2f}" for a, b in zip(x, y, strict=True)]
    text = "\n".join([heading, *rows]) + "\n"
    (FOLDER / f"{name}.csv").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
