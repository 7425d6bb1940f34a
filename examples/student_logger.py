"""Make CSV files as a student team's logger writes them: mm, deg/s, g and km/h.

    python examples/student_logger.py [FOLDER]

The recordings are those of pots-gyro-gps beside this file; docs/tutorial.md begins with them.
"""

from __future__ import annotations

import sys
from math import pi
from pathlib import Path

import pandas as pd

NAMES = {"time_s": ("Time", "s", 1.0, 2)} | {
    f"pot_{end}": (f"Damper {end.upper()}", "mm", 1e3, 3) for end in ("fl", "fr", "rl", "rr")
}
NAMES |= {
    "pitch_rate": ("Gyro Pitch", "deg/s", 180 / pi, 4),
    "roll_rate": ("Gyro Roll", "deg/s", 180 / pi, 4),
    "imu": ("Acc Z", "g", 1 / 9.80665, 5),
    "gps": ("GPS Speed", "km/h", 3.6, 2),
}
"""Of each channel what the logger calls it, its unit, how many of that one of SI is, and digits."""


def main(folder: Path) -> None:
    """Write one file for each run."""
    folder.mkdir(exist_ok=True)
    for file in sorted((Path(__file__).parent / "pots-gyro-gps" / "runs").glob("*.csv")):
        known = pd.read_csv(file)
        made = {name: (scale * known[key]).round(n) for key, (name, _, scale, n) in NAMES.items()}
        heads = [",".join(names[i] for names in NAMES.values()) for i in (0, 1)]
        text = pd.DataFrame(made).to_csv(header=False, index=False, lineterminator="\n")
        target = folder / f"lap-{file.stem.removesuffix('-kmph')}.csv"
        target.write_text("\n".join([*heads, text]), encoding="utf-8")
    print(f"{folder}: recordings of a student car")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "logger"))
