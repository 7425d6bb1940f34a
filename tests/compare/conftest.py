"""Small campaigns made of formulas: what `wheelhop.compare` sees, with nothing simulated."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import Campaign, Channel, Run, TrackSpec
from wheelhop.simulate import Response

RATE = 100.0
N = 1024
POINTS = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")
PITCH = 0.5

Signal = Callable[[np.ndarray, float], np.ndarray]
"""(time (n,), speed) → (n, n_channels)."""


class Bench:
    """Builds a campaign whose model is known and whose residual is what a test asks for."""

    def __init__(self) -> None:
        self.rng = np.random.default_rng(7)

    def noise(self, rms: float, shape: tuple[int, ...] = (N, 8)) -> np.ndarray:
        return rms * self.rng.standard_normal(shape)

    def motion(self, time: np.ndarray, speed: float, channels: int = 8) -> np.ndarray:
        """A vehicle on a washboard: three harmonics, another phase in every channel."""
        phase = np.arange(channels)
        angle = 2 * np.pi * speed * time / PITCH
        return sum(5.0 / m * np.sin(m * angle[:, None] + m * phase + m * speed) for m in (1, 2, 3))

    def campaign(
        self,
        speeds: Sequence[float],
        residual: Signal,
        *,
        points: Sequence[str] = POINTS,
        noise: float | None = 0.1,
        kind: str = "washboard",
        roles: Sequence[str] | None = None,
        n: int = N,
        motion: Signal | None = None,
    ) -> tuple[Campaign, list[Response]]:
        time = np.arange(n) / RATE
        values = {"pitch_m": PITCH, "amplitude_m": 0.01} if kind == "washboard" else {}
        roles = roles or ["fit", *["validate"] * (len(speeds) - 1)]
        move = motion or (lambda t, v: self.motion(t, v, len(points)))
        runs, responses = [], []
        for k, (speed, role) in enumerate(zip(speeds, roles, strict=True)):
            model = move(time, speed)
            measured = model + residual(time, speed)
            file = Path(f"{k}.csv")
            runs.append(Run(f"run-{k}", file, role, speed, TrackSpec(kind, values), time, measured))
            position = 3.0 + speed * time if kind != "unknown" else None
            responses.append(Response(f"run-{k}", model, position))
        channels = tuple(Channel(p.lower(), p) for p in points)
        whole = Campaign(
            Path(),
            "bench",
            Path("vehicle.toml"),
            RATE,
            (0.5, 30.0),
            0.0,
            noise,
            channels,
            tuple(runs),
        )
        return whole, responses


@pytest.fixture
def bench() -> Bench:
    return Bench()
