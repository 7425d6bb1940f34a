"""`Recording`: samples at equal steps, where they come from, and what was done to them."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

CODE = "code"
"""Unit of a raw sample: mean code of the converter, 0 … 1023, whose reference is code 1024."""
ACCELERATION = "m/s²"


@dataclass(frozen=True)
class Channel:
    """One column: `name` as recorded, its `unit`, and where it was measured.

    `point` is a place of the campaign format (A1 … A4, B1 … B4, body) or empty: not known.
    `sensor` is the serial number of the accelerometer, `calibration` the id of the constants that
    were applied; both empty if unknown.
    """

    name: str
    unit: str
    point: str = ""
    sensor: str = ""
    calibration: str = ""


@dataclass(frozen=True, eq=False)
class Recording:
    """What one recorder recorded in one go.

    `values` is (n, n_channels), float64, in the channels' units; a sample that is missing is NaN in
    its whole row and never invented. Row i is the mean over `averaging_s` seconds, centred on
    `start_s` + i / `rate_hz` of the recorder's own clock. `start_unix_s` is the true time of that
    clock's zero, None if unknown. `history` says what was done to the samples, oldest first;
    `notes` holds what else the recorder said (header keys and their values).
    """

    values: NDArray[np.float64]
    rate_hz: float
    channels: tuple[Channel, ...]
    start_s: float = 0.0
    averaging_s: float = 0.0
    start_unix_s: float | None = None
    history: tuple[str, ...] = ()
    notes: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.values.ndim != 2 or self.values.shape[1] != len(self.channels):
            raise ValueError(f"values {self.values.shape}, expected (n, {len(self.channels)})")

    @property
    def time_s(self) -> NDArray[np.float64]:
        """(n,) the instant of each row, seconds."""
        return self.start_s + np.arange(len(self.values)) / self.rate_hz

    @property
    def missing(self) -> NDArray[np.bool_]:
        """(n,) True where a sample is missing."""
        return np.asarray(np.isnan(self.values).any(axis=1))

    def after(self, step: str, **changes: object) -> "Recording":
        """Return the recording with `changes` of its fields, and the `step` that made them."""
        return replace(self, history=(*self.history, step), **changes)  # type: ignore[arg-type]
