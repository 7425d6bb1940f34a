"""Measured and modelled signals of a run side by side, in band, each as a `Recording`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Run
from wheelhop.compare.records import Record
from wheelhop.logger.recording import Channel, Recording


@dataclass(frozen=True, eq=False)
class RunSignals:
    """One run against a model: `measured`, what the model says (`model`) and their difference
    (`residual`, measured minus model).

    Each is a `Recording` of the run's samples (n, n_channels) inside the campaign's band, means
    therefore removed, in the channels' units. A channel that the model does not predict is NaN in
    `model` and `residual`.
    """

    run: Run
    measured: Recording
    model: Recording
    residual: Recording

    def __repr__(self) -> str:
        rows, count = self.measured.values.shape
        return f"<RunSignals {self.run.id}: {rows} samples, {count} channels, in band>"


def signals_of(record: Record, names: Sequence[str], units: Sequence[str]) -> RunSignals:
    """The signals that a record holds as coefficients, its channels called by their names."""
    run, band = record.run, record.band
    points = units or [""] * len(names)
    channels = tuple(Channel(name, unit) for name, unit in zip(names, points, strict=True))
    # What is not predicted is zero in the coefficients, and the measurement is known all the same.
    model = np.where(record.predicted, record.signal(record.model), np.nan)
    residual = np.where(record.predicted, record.signal(record.residual), np.nan)

    def recording(values: NDArray[np.float64], what: str) -> Recording:
        low, high = band.frequency_hz[[0, -1]]
        step = f"{what}, {low:.3g} to {high:.3g} Hz"
        return Recording(values, band.rate_hz, channels, float(run.time_s[0]), history=(step,))

    return RunSignals(
        run,
        recording(band.signal(run.record), "measured"),
        recording(model, "modelled"),
        recording(residual, "measured minus modelled"),
    )
