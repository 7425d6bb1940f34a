"""Draw the picture of docs/simulate.md from the table of the sweep that the page shows.

Run it from anywhere: python docs/make_simulate_figure.py TABLE.parquet
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pyarrow.parquet as pq

DAMPING = "suspension.front.damping_N_s_m"
PANELS = {
    "comfort_wk_rms_m_s2": "weighted acceleration, m/s² rms",
    "dynamic_load_front": "front tyre load, rms / static",
}
INKS = ("#0b5fa5", "#7a6a58", "#d1495b")


def main(table: Path) -> None:
    """Draw simulate.png beside this file."""
    rows = pq.read_table(table).to_pydict()
    speed, damping = np.array(rows["speed_kmph"]), np.array(rows[DAMPING])
    figure, axes = plt.subplots(1, 2, figsize=(8.0, 3.2), layout="constrained")
    for axis, (column, label) in zip(axes, PANELS.items(), strict=True):
        for value, ink in zip(np.unique(damping), INKS, strict=True):
            line = damping == value
            axis.plot(speed[line], np.array(rows[column])[line], color=ink, label=f"{value:.0f}")
        axis.set(
            xlabel="speed, km/h", ylabel=label, xlim=(speed.min(), speed.max()), ylim=(0, None)
        )
        axis.grid(alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
    axes[0].legend(title="front damping, N s/m", frameon=False)
    for axis in axes:
        axis.set_xticks(range(4, 25, 4))
    figure.savefig(Path(__file__).parent / "simulate.png", dpi=120)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
