"""The picture of a synchronicity check: the beam's shapes, and each channel's skew."""

from pathlib import Path

import numpy as np

from wheelhop.calibration.sync.beam_file import BeamSession
from wheelhop.calibration.sync.check import LIMIT_S, SyncCheck
from wheelhop.files import write_picture

INK, SOFT, RULE, THEORY, BAD = "#1b1f24", "#5b6470", "#dfe3e8", "#0b66a8", "#c8540a"


def draw_sync(check: SyncCheck, session: BeamSession, file: Path, limit_s: float = LIMIT_S) -> None:
    """Write a figure (the suffix says which kind): theory as lines, measurement as points."""
    from matplotlib.figure import Figure

    count = len(check.frequencies_hz)
    figure = Figure(figsize=(8.0, 1.7 * count + 2.6), layout="constrained")
    axes = figure.subplots(count + 1, 1, height_ratios=[1.0] * count + [1.5])
    along = np.linspace(0.0, session.beam.length_m, 200)[1:]
    at = np.array([c.position_m for c in check.channels])
    at_mm = 1e3 * at
    for f, (frequency, axis) in enumerate(zip(check.frequencies_hz, axes, strict=False)):
        shape = session.beam.receptance(frequency, session.drive_m, along)[0].real
        there = session.beam.receptance(frequency, session.drive_m, at)[0].real
        expected = np.array([c.expected[f] for c in check.channels])
        scale = float(expected @ there / (there @ there))
        axis.axhline(0.0, color=RULE, lw=1.0)
        axis.plot(1e3 * along, scale * shape, color=THEORY, lw=1.4, label="theory")
        measured = [c.measured[f] for c in check.channels]
        axis.plot(at_mm, measured, "o", color=INK, ms=5, label="measured")
        axis.set_ylabel(f"{frequency:.2f} Hz")
        axis.set_xlim(0.0, 1e3 * session.beam.length_m * 1.02)
    axes[0].legend(frameon=False, loc="best", fontsize=8)
    axes[0].set_title("Amplitude with its sign, in the recording's unit", loc="left", fontsize=10)
    axes[count - 1].set_xlabel("position from the clamp, mm")
    _skews(axes[-1], check, limit_s)
    for axis in axes:
        axis.spines[["top", "right"]].set_visible(False)
        axis.tick_params(labelsize=8, color=SOFT)
    write_picture(file, figure)


def _skews(axis, check: SyncCheck, limit_s: float) -> None:  # type: ignore[no-untyped-def]
    names = [c.name for c in check.channels]
    skew_us = np.array([c.skew_s for c in check.channels]) * 1e6
    skew_us -= np.nanmedian(skew_us) if np.isfinite(skew_us).any() else 0.0
    colours = [BAD if c.verdict in ("fail", "not told") else THEORY for c in check.channels]
    axis.axhspan(-limit_s * 1e6, limit_s * 1e6, color=RULE, alpha=0.5, lw=0)
    axis.axhline(0.0, color=SOFT, lw=0.8)
    for i, channel in enumerate(check.channels):
        if np.isnan(skew_us[i]):
            axis.annotate("not told", (i, 0), color=BAD, fontsize=8, ha="center", va="bottom")
            continue
        axis.errorbar(
            i, skew_us[i], 1e6 * channel.expanded_s, fmt="o", color=colours[i], capsize=4, ms=6
        )
    axis.set_xticks(range(len(names)), names)
    axis.set_xlim(-0.5, len(names) - 0.5)
    axis.set_ylabel("later than their median, µs")
    axis.set_title(
        f"Sampling instants (± k = 2); grey: the limit of {1e3 * limit_s:g} ms",
        loc="left",
        fontsize=10,
    )
