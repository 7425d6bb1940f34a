"""What it is worth to record what need not be sought: python -m benchmarks.known_channels

Makes cars of the independent simulator whose engine runs faster and slower by a third in every run,
or whose driver brakes and accelerates, with a channel of the engine's speed or of the acceleration
along x; diagnoses each with that channel and without it, and prints verdict, held-out error and
processor time. The channel of the acceleration has noise of 0.2 m/s², an offset of 0.4 m/s² and
shows 5 % too much, as a sensor does that tilts with the body.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from tests.truth.body_effects import EngineVibration, LongitudinalPitch
from tests.truth.campaign import write_campaign
from tests.truth.effect import Effect
from tests.truth.model import CHANNELS, Drive
from tests.truth.presets import PRESETS
from wheelhop.api import diagnose

SHARE, PERIOD_S, ORDER = 0.33, 9.0, 2.0
ENGINE_X_M = -0.45
NOISE_M_S2, OFFSET_M_S2, GAIN = 0.2, 0.4, 1.05


class Revving(EngineVibration):
    """An engine whose speed goes up and down."""

    def start(self, drive: Drive) -> None:
        """Its force, and its speed in every run, rad/s."""
        phase, first = drive.rng.uniform(0.0, 2 * np.pi, 2)
        omega = 2 * np.pi / PERIOD_S
        turns = drive.time - SHARE / omega * np.cos(omega * drive.time + phase)
        drive.push("engine", self.force_N * np.sin(2 * np.pi * self.freq_hz * turns + first))
        rate = 1.0 + SHARE * np.sin(omega * drive.time + phase)
        _show(self, drive, 2 * np.pi * self.freq_hz / ORDER * rate)


class Pedals(LongitudinalPitch):
    """A driver whose pedals a sensor sees."""

    def start(self, drive: Drive) -> None:
        """What he does, and what the sensor shows."""
        super().start(drive)
        _show(self, drive, GAIN * self._forward + OFFSET_M_S2)


def _show(effect: Effect, drive: Drive, values: ArrayLike) -> None:
    vars(effect).setdefault("shown", []).append((drive.time, np.asarray(values, float)))


HIDDEN: dict[str, tuple[Callable[[], Effect], str, float]] = {
    "engine-vibration": (
        lambda: Revving(60.0, 14.0, ENGINE_X_M),
        '{ quantity = "speed", of = "engine" }',
        0.0,
    ),
    "longitudinal-pitch": (
        lambda: Pedals(2.5),
        '{ quantity = "acceleration", axis = "x" }',
        NOISE_M_S2,
    ),
}
"""What is hidden, the channel that shows its cause, and the noise of that."""


def made(folder: Path, name: str, seed: int) -> Path:
    """A campaign of an ATV with the channel `known` beside the eight points."""
    make, _, noise = HIDDEN[name]
    effect, rng = make(), np.random.default_rng(seed)
    write_campaign(folder, PRESETS["atv"], [effect], seed=seed, short=True, draft=True)
    toml = (folder / "campaign.toml").read_text()
    files = [line.split('"')[1] for line in toml.split("\n") if line.startswith("file = ")]
    for file, (instants, values) in zip(files, vars(effect)["shown"], strict=True):
        head, *rows = (folder / file).read_text().split()
        shown = np.interp([float(row.split(",")[0]) for row in rows], instants, values)
        shown = shown + rng.normal(0.0, noise, len(rows))
        rows = [f"{row},{value:.6g}" for row, value in zip(rows, shown, strict=True)]
        (folder / file).write_text("\n".join([f"{head},known", *rows]) + "\n")
    return folder


def listed(folder: Path, channel: str) -> None:
    """List the points, and the channel, if any."""
    lines = [f'{name} = "{name}"' for name in CHANNELS] + (
        [f"known = {channel}"] if channel else []
    )
    text = (folder / "campaign.toml").read_text()
    head, _, runs = text.partition("[[run]]")
    head = head.partition("[channels]")[0].rstrip()
    (folder / "campaign.toml").write_text(
        "\n".join([head, "", "[channels]", *lines, "", f"[[run]]{runs}"])
    )


def main() -> None:
    """Print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=0, help="of the first campaign")
    parser.add_argument("--cars", type=int, default=1, help="so many of each")
    given = parser.parse_args()
    for name, (_, channel, _) in HIDDEN.items():
        for seed in range(given.seed, given.seed + given.cars):
            with tempfile.TemporaryDirectory() as folder:
                made(Path(folder), name, seed)
                for words, said in (("without", ""), ("with", channel)):
                    listed(Path(folder), said)
                    begun = time.process_time()
                    found = diagnose(folder, jobs=1).diagnosis
                    spent = time.process_time() - begun
                    print(f"{name} {seed} {words:8s} {found!r}, {spent:.0f} CPU s", flush=True)


if __name__ == "__main__":
    main()
