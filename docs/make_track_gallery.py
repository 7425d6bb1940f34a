"""Draw the pictures of docs/tracks.md: each kind of track under its wheels.

Run it from anywhere: python docs/make_track_gallery.py
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from wheelhop.campaign import TrackSpec
from wheelhop.track import Track, make_track, wheel_envelope

DOCS = Path(__file__).parent
BELGIAN_BLOCK = DOCS.parent / "tests/data/belgian-block/belgian_block.crg"
RADIUS, SMALL_RADIUS = 0.279, 0.10  # m
LEFT, RIGHT = 0.59, -0.59  # m
GROUND, RADIUS_INK, SMALL_INK = "#7a6a58", "#0b5fa5", "#d1495b"

# kind, its values, the stretch of x to show, whether left and right differ
GALLERY: list[tuple[str, dict[str, float | str], tuple[float, float], bool]] = [
    ("washboard", {"amplitude_m": 0.015, "pitch_m": 0.4}, (0.0, 1.6), False),
    ("one-sided-washboard", {"amplitude_m": 0.025, "pitch_m": 0.6}, (0.0, 2.4), True),
    (
        "herringbone",
        {"amplitude_m": 0.02, "pitch_m": 0.8, "angle_rad": np.radians(20)},
        (0.0, 2.4),
        True,
    ),
    (
        "chassis-twist",
        {"amplitude_m": 0.175, "pitch_m": 3.0, "width_m": 4.0, "lateral_offset_m": 0.1},
        (0.0, 6.0),
        True,
    ),
    (
        "sine-sweep",
        {"amplitude_m": 0.015, "pitch_start_m": 1.0, "pitch_end_m": 0.25, "length_m": 4.0},
        (-0.4, 4.4),
        False,
    ),
    ("half-sine-bump", {"amplitude_m": 0.05, "length_m": 0.4, "side": "both"}, (-0.5, 0.9), False),
    ("step-bump", {"height_m": 0.05, "width_m": 0.3, "side": "both"}, (-0.5, 0.8), False),
    ("iso8608", {"unevenness_m3": 256e-6, "waviness": 2.0, "seed": 1.0}, (0.0, 6.0), True),
    (
        "cobblestone",
        {
            "height_m": 0.01,
            "seed": 1.0,
            "stone_length_m": 0.15,
            "stone_width_m": 0.16,
            "joint_m": 0.01,
            "joint_depth_m": 0.015,
        },
        (0.0, 2.0),
        True,
    ),
    ("profile", {"file": str(BELGIAN_BLOCK)}, (4.0, 7.0), True),
]


def main() -> None:
    """One picture per kind."""
    for kind, values, stretch, two_sided in GALLERY:
        sides = (("left", LEFT), ("right", RIGHT)) if two_sided else (("both sides", LEFT),)
        figure, rows = plt.subplots(
            len(sides),
            figsize=(8.0, 2.2 * len(sides) + 0.5),
            sharex=True,
            sharey=True,
            squeeze=False,
            layout="constrained",
        )
        ground = make_track(TrackSpec(kind, values))
        for axes, (side, y) in zip(rows[:, 0], sides, strict=True):
            draw(axes, ground, y, stretch)
            axes.set_ylabel(f"{side}\nheight / mm")
        lines = [line.get_ydata() for axes in rows[:, 0] for line in axes.lines]
        low, high = np.min(lines), np.max(lines)
        margin = 0.1 * (high - low)
        rows[0, 0].set_ylim(low - margin, high + margin)
        figure.legend(
            *rows[0, 0].get_legend_handles_labels(),
            loc="outside upper center",
            ncols=3,
            fontsize=8,
            frameon=False,
        )
        rows[-1, 0].set_xlabel("x / m")
        figure.savefig(DOCS / "tracks" / f"{kind}.png", dpi=110)
        plt.close(figure)


def draw(axes: Axes, ground: Track, y: float, stretch: tuple[float, float]) -> None:
    """The profile and what the centres of two wheels, one of them small, make of it."""
    x = np.linspace(*stretch, 4001)
    z = 1e3 * ground.elevation(x, y)
    heights = {
        radius: 1e3 * wheel_envelope(ground, y, radius, *stretch).height(x)
        for radius in (RADIUS, SMALL_RADIUS)
    }
    axes.fill_between(x, z, -1e3, color=GROUND, alpha=0.35, lw=0)
    axes.plot(x, z, color=GROUND, lw=1, label="ground")
    axes.plot(x, heights[SMALL_RADIUS], color=SMALL_INK, lw=1, ls="--", label="wheel, R = 100 mm")
    axes.plot(x, heights[RADIUS], color=RADIUS_INK, lw=1.4, label="wheel, R = 279 mm")
    axes.set_xlim(stretch)
    axes.spines[["top", "right"]].set_visible(False)


if __name__ == "__main__":
    main()
