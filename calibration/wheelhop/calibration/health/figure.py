"""The picture of an examination: every channel over time and frequency, findings marked."""

from pathlib import Path
from typing import Any

import numpy as np

from wheelhop.calibration.health.examine import Health
from wheelhop.files import write_picture
from wheelhop.logger.recording import Recording

INK, SOFT, RULE, GOOD, BAD = "#1b1f24", "#5b6470", "#dfe3e8", "#0b66a8", "#c8540a"
COLUMNS = 1200  # of the envelope: more rows are drawn as their least and greatest


def draw_health(recording: Recording, health: Health, file: Path) -> None:
    """Write a figure (the suffix says which kind); a channel with a finding is orange."""
    from matplotlib.figure import Figure
    from scipy import signal

    count = len(recording.channels)
    figure = Figure(figsize=(11.0, 1.05 * count + 1.2), layout="constrained")
    axes = figure.subplots(count, 2, width_ratios=[3, 1], squeeze=False, sharex="col")
    # For the eye only: a gap counts as the mean.
    there = recording.values[~recording.missing]
    centred = np.nan_to_num(recording.values - (there.mean(axis=0) if len(there) else 0.0))
    grid, power = signal.welch(
        centred, recording.rate_hz, nperseg=min(len(centred), round(5 * recording.rate_hz)), axis=0
    )
    for c, channel in enumerate(recording.channels):
        time, spectrum = axes[c]
        found = [f for f in health.findings if not f.channels or channel.name in f.channels]
        own = [f for f in found if f.channels]
        colour = BAD if own else GOOD
        _envelope(time, recording, c, colour)
        for finding in found:
            span = min(finding.start_s, finding.stop_s), max(finding.start_s, finding.stop_s)
            whole = span[1] - span[0] > 0.9 * len(recording.values) / recording.rate_hz
            if not whole:
                time.axvspan(*span, color=BAD, alpha=0.2, lw=0)
        words = ", ".join(dict.fromkeys(f.kind for f in own))
        time.set_ylabel(channel.name, rotation=0, ha="right", va="center", color=INK)
        time.annotate(words, (1.0, 1.0), xycoords="axes fraction", ha="right", va="bottom",
                      fontsize=8, color=BAD)  # fmt: skip
        spectrum.semilogy(grid[1:], np.sqrt(power[1:, c]) + 1e-9, color=colour, lw=0.9)
        for axis in (time, spectrum):
            axis.spines[["top", "right"]].set_visible(False)
            axis.tick_params(labelsize=7, color=SOFT)
    axes[0, 0].set_title("over time", loc="left", fontsize=10)
    axes[0, 1].set_title("spectrum, unit/√Hz", loc="left", fontsize=10)
    axes[-1, 0].set_xlabel("time, s")
    axes[-1, 1].set_xlabel("Hz")
    write_picture(file, figure, dpi=130)


def _envelope(axis: Any, recording: Recording, c: int, colour: str) -> None:
    rows = len(recording.values)
    step = max(1, rows // COLUMNS)
    if step == 1:
        axis.plot(recording.time_s, recording.values[:, c], color=colour, lw=0.7)
        return
    blocks = recording.values[: rows // step * step, c].reshape(-1, step)
    time = recording.time_s[: rows // step * step : step]
    axis.fill_between(time, blocks.min(axis=1), blocks.max(axis=1), color=colour, lw=0.4)
