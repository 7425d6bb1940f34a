"""Draw the pictures of the pages on health, the gate, calibration and Python, each from what its
page describes.

Run it from anywhere: python docs/make_page_pictures.py
"""

from __future__ import annotations

import datetime as dt
import shutil
import tempfile
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.signal import welch

import wheelhop as wh
from wheelhop.calibration.conditions import Conditions
from wheelhop.calibration.shaker.comparison import compare_with_reference
from wheelhop.calibration.shaker.figure import draw
from wheelhop.cli.main import main as wheelhop
from wheelhop.hil_sim.rig import STEPPED, Rig, Sensor, Shaking
from wheelhop.report.svg import COLOURS, STYLE

DOCS = Path(__file__).parent
CLEAN, FRICTION = (DOCS.parent / "examples" / name for name in ("clean", "open-dry-friction"))
RUN = "washboard-high-fast"
KMPH, PITCH_M = 13.0, 0.6


def main() -> None:
    """All four."""
    health(DOCS / "health.png")
    gate(DOCS / "gate.png")
    calibration(DOCS / "calibration.png")
    wh.plot(wh.compare(FRICTION, "dry-friction"), "where").savefig(DOCS / "where.png", dpi=110)


def health(file: Path) -> None:
    """A recording of which one sensor falls silent and another meets the end of its range."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "run.csv"
        shutil.copy(CLEAN / f"runs/{RUN}.csv", copy)
        table = pd.read_csv(copy)[["time_s", "B1", "B2", "A3", "A4"]]
        later = table["time_s"] > 0.4 * table["time_s"].iloc[-1]
        table.loc[later, "A3"] = table.loc[later, "A3"].iloc[0]
        table["B1"] = table["B1"].clip(upper=0.7 * table["B1"].max())
        table.to_csv(copy, index=False)
        wheelhop(["health", str(copy), "--figure", str(file)])


def gate(file: Path) -> None:
    """Where the waves of a track stand in a record, and where a speed in m/s would put them."""
    samples = wh.read(CLEAN).recording(RUN).to_dataframe()
    rate_hz = (len(samples) - 1) / (samples.index[-1] - samples.index[0])
    hertz, power = welch(samples["B1_m_s2"].to_numpy(), rate_hz, nperseg=512)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.2, 2.6), layout="constrained")
        axes = figure.subplots()
        axes.semilogy(hertz, power, color=COLOURS["ink"], label="recorded at B1")
        for speed, colour, unit in (
            (KMPH / 3.6, COLOURS["after"], "km/h"),
            (KMPH, COLOURS["before"], "m/s"),
        ):
            axes.axvline(speed / PITCH_M, 0, 0.84, color=colour, linestyle="--",
                         label=f"waves at {KMPH:g} {unit}")  # fmt: skip
        axes.set_xlim(0.0, 30.0)
        axes.set_ylim(power[hertz > 0.5].min() / 3, power.max() * 60)
        axes.set_xlabel("frequency, Hz")
        axes.set_title("Power spectral density, (m/s²)²/Hz")
        axes.legend(ncols=3, loc="upper right")
        figure.savefig(file, dpi=130)


def calibration(file: Path) -> None:
    """Two sensors beside a reference on the simulated shaker."""
    rng = np.random.default_rng(1)
    rig = Rig((Sensor("B1"), Sensor("B2", corner_hz=40.0)), Shaking(STEPPED), -0.4, 1500.0)
    year = dt.date(2026, 11, 1), dt.date(2027, 11, 1)
    conditions = Conditions("cal-2026-11", *year, reference_expanded=0.003)
    draw(compare_with_reference(rig.reference(rng), rig.log(rng), conditions), file)


if __name__ == "__main__":
    main()
