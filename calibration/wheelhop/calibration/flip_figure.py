"""The picture of sensors turned over: what was taken for a rest, and how well rests repeat."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from wheelhop.calibration.flip import Flip
from wheelhop.files import write_picture
from wheelhop.files.units import STANDARD_GRAVITY_M_S2
from wheelhop.logger.recording import Recording


def draw_flip(found: Flip, log: Recording, path: Path) -> None:
    """Write the picture, its format by the suffix of `path`. Raises InputError."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 5), layout="constrained")
    axes: Any = figure.subplots(2, 1, sharex=True)
    whole, close = axes
    for number, channel in enumerate(found.channels):
        colour = f"C{number % 10}"
        zero = (channel.up_code + channel.down_code) / 2
        whole.plot(log.time_s, log.values[:, number] - zero, lw=0.8, color=colour)
        for rest, sign in zip(found.rests, found.orientations, strict=True):
            level = rest.codes[number] - zero - sign * STANDARD_GRAVITY_M_S2 / channel.gain.value
            middle = (rest.start_s + rest.end_s) / 2
            aside = 2.0 * (number - (len(found.channels) - 1) / 2)
            label = channel.name if rest is found.rests[0] else None
            close.plot(middle + aside, level, "o", ms=4, color=colour, label=label)
    for rest in found.rests:
        for axis in axes:
            axis.axvspan(rest.start_s, rest.end_s, color="0.93", lw=0)
    whole.set_ylabel("code, from that at 0 g")
    whole.set_title("Shaded: at rest, all sensors turned the same way", fontsize=10)
    close.set_ylabel("rest off its mean, code")
    close.set_title("Did they come back to where they were?", fontsize=10)
    close.set_xlabel("time, s")
    close.axhline(0, color="0.6", lw=0.8)
    limit = max(1.0, 1.1 * max(abs(y) for y in close.get_ylim()))
    close.set_ylim(-limit, limit)
    close.legend(fontsize=8, ncols=8, loc="upper right")
    for axis in axes:
        axis.spines[["top", "right"]].set_visible(False)
    write_picture(path, figure)
