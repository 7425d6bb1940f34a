"""What every real car is: a little wrong in ten ways at once, each hardly to be seen by itself.

A campaign of the kind "everything" hides one clear effect, or nothing, in a machine that has small
amounts of five other effects, whose files are off in four ways, and whose noise is coloured and
stated too low. Each amount is drawn so that alone, with white noise that is stated rightly, it
leaves 1.02 to 1.6 times the noise.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from scipy.signal import firwin2

from benchmarks.blind.folder import Rng, Table, edit, list_channels, records, scale_tracks
from tests.truth import CHANNELS, in_band

SHOWS = (1.02, 1.6)
"""What each imperfection alone leaves, over the noise."""

IN_THE_MACHINE = (
    "dry-friction",
    "small-scale-roughness",
    "speed-fluctuation",
    "progressive-spring",
    "asymmetric-damper",
)
"""Effects that are there a little."""

ALSO_RIGHT = (*IN_THE_MACHINE, "sensor-gain", "belief: ")
"""How the names begin that are there, whatever is hidden."""

COLOURED, STATED = 0.55, 0.8
"""Share of the noise's amplitude that is coloured, and of its level that is stated."""

Imperfection = Callable[[Path, Rng, float], None]


def is_there(name: str) -> bool:
    """Whether a verdict's entry names one of the imperfections."""
    return name.startswith(ALSO_RIGHT)


def _gains(folder: Path, rng: Rng, amount: float) -> None:
    """Every channel's scale is off, nobody knows by how much."""
    gains = 1.0 + 0.015 * amount * rng.normal(size=len(CHANNELS))

    def scaled(names: list[str], rows: np.ndarray) -> Table:
        rows[:, 1:] *= gains
        return names, rows

    records(folder, scaled)


def _positions(folder: Path, rng: Rng, amount: float) -> None:
    """Every sensor on the body sits elsewhere than stated."""
    vehicle = (folder / "vehicle.toml").read_text()
    found = [
        re.search(rf"(?m)^{key} = (\S+)", vehicle)
        for key in ("wheelbase_m", "track_width_m", "cg_to_front_axle_m")
    ]
    length, width, ahead = (float(number[1]) for number in found if number)
    places = {name: f'"{name}"' for name in CHANNELS}
    for name in (name for name in CHANNELS if name.startswith("B")):
        corner = int(name[1]) - 1
        away = 0.015 * amount * rng.normal(size=2)
        x, y = ahead - length * (corner // 2) + away[0], width * (0.5 - corner % 2) + away[1]
        places[name] = f"[{x:.5f}, {y:.5f}]"
    list_channels(folder, places)


def _survey(key: str, deviation: float) -> Imperfection:
    """A number of every kind of track is stated by its own small factor off."""

    def spoil(folder: Path, rng: Rng, amount: float) -> None:
        factors: dict[str, float] = {}

        def factor(kind: str) -> float:
            if kind not in factors:
                factors[kind] = 1.0 + deviation * amount * rng.normal()
            return factors[kind]

        scale_tracks(folder, key, factor)

    return spoil


IN_THE_FILES: Mapping[str, Imperfection] = {
    "scales": _gains,
    "positions": _positions,
    "amplitudes": _survey("amplitude_mm", 0.02),
    "pitches": _survey("pitch_mm", 0.0015),
}
"""What is wrong about what is stated, each at an amount: 1 is what a careful owner leaves."""


def colour_the_noise(folder: Path, rng: Rng) -> None:
    """Add noise whose amplitude falls as 1/√f to the white noise, and state less than the sum."""
    text = (folder / "campaign.toml").read_text()
    numbers = {
        key: float(found[1])
        for key in ("noise_rms_m_s2", "sample_rate_hz")
        if (found := re.search(rf"(?m)^{key} = (\S+)$", text))
    }
    white, rate_hz = numbers["noise_rms_m_s2"], numbers["sample_rate_hz"]
    coloured = white * COLOURED / np.sqrt(1.0 - COLOURED**2)
    frequency = np.linspace(0.0, rate_hz / 2.0, 257)
    falling = 1.0 / np.sqrt(np.maximum(frequency, 0.5))
    shape = firwin2(513, frequency, falling, fs=rate_hz)

    def add(names: list[str], rows: np.ndarray) -> Table:
        raw = rng.normal(size=(len(rows) + len(shape) - 1, rows.shape[1] - 1))
        noise = np.column_stack([np.convolve(column, shape, "valid") for column in raw.T])
        rows[:, 1:] += coloured / np.sqrt(np.mean(in_band(noise, rate_hz) ** 2)) * noise
        return names, rows

    records(folder, add)
    stated = STATED * float(np.hypot(white, coloured))
    edit(
        folder / "campaign.toml",
        lambda text: re.sub(
            r"(?m)^(noise_rms_m_s2 = )\S+$", lambda found: f"{found[1]}{stated:.4g}", text
        ),
    )


def imperfections(hidden: Sequence[str]) -> tuple[str, ...]:
    """The effects that such a machine has a little of, beside what is hidden."""
    return tuple(name for name in IN_THE_MACHINE if name not in hidden)
