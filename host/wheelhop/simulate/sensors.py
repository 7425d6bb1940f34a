"""What the instrument makes of true accelerations: its faults act on the integration's own steps,
run-up included, before samples are taken."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Channel
from wheelhop.effects import Effect
from wheelhop.simulate.model import Values

Array = NDArray[np.float64]


def sensed(
    acceleration: Array,
    rate_hz: float,
    before: int,
    faults: Iterable[tuple[Effect, Values]],
    channels: Sequence[Channel],
) -> Array:
    """Readings (n, c), m/s², of accelerations (n, c), so many of them before the record, through
    effects with their numbers, in their order."""
    since_s = (np.arange(len(acceleration)) - before) / rate_hz
    for effect, theta in faults:
        acceleration = effect.sense(theta, acceleration, channels, rate_hz)
        lingering = effect.lingering(theta, since_s, channels)
        if lingering is not None:
            acceleration = acceleration + lingering
    return acceleration
