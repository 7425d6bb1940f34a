"""Which runs and channels are shown: where the first model fails worst, and a typical place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.compare import Comparison, Record
from wheelhop.diagnose import Rung, Step
from wheelhop.fit import RunFit

Array = NDArray[np.float64]

WINDOW_S = 2.5
"""So much of a run is shown against time: enough to see the shape of the waves."""


@dataclass(frozen=True, eq=False)
class Case:
    """One channel of one run, in band: `measured` and the answers of the first and the last
    model, each (n,), m/s²; the part (start, stop) shown against time."""

    title: str
    run_id: str
    channel: str
    rate_hz: float
    time_s: Array
    measured: Array
    before: Array
    after: Array
    noise_rms_m_s2: float
    shown: slice


def cases(channels: Sequence[str], steps: Sequence[Step]) -> list[Case]:
    """The worst and a typical case, on runs that no fit has seen if there are any."""
    first, last = records_of(steps[0].rung), records_of(steps[-1].rung)
    comparison = steps[0].comparison
    ratio = _ratios(comparison)
    order = [(i, j) for i, j in zip(*np.unravel_index(np.argsort(ratio, axis=None), ratio.shape),
             strict=True) if np.isfinite(ratio[i, j])]  # fmt: skip
    chosen = {order[-1]: "Where it fails worst", order[len(order) // 2]: "A typical place"}
    found = []
    for (i, j), title in chosen.items():
        run_id = comparison.breakdown.runs_channels.rows[i]
        found.append(_case(title, channels[j], int(j), first[run_id], last[run_id], comparison))
    return found


def records_of(rung: Rung) -> Mapping[str, Record]:
    """Measured and modelled runs of a fitted model, by run id."""
    runs = rung.fit.runs + (() if rung.validation is None else rung.validation.runs)
    return {run.bench.run.id: _record(run) for run in runs}


def _record(run: RunFit) -> Record:
    bench = run.bench
    residual = np.zeros_like(bench.measured)
    residual[:, bench.predicted] = run.residual.reshape(bench.band.count, -1)
    measured = np.where(bench.predicted, bench.measured, 0.0)
    return Record(bench.run, bench.band, bench.predicted, measured, residual, None)


def _ratios(comparison: Comparison) -> Array:
    """Residual over noise of each run and channel; NaN for runs not to be chosen."""
    grid = comparison.breakdown.runs_channels
    held_out = np.array([comparison.roles[run] == "validate" for run in grid.rows])
    ratio = np.array(grid.ratio)
    if held_out.any():
        ratio[~held_out] = np.nan
    if not np.isfinite(ratio).any():  # no noise to compare with
        ratio = np.sqrt(grid.residual)
    return ratio


def _case(
    title: str, channel: str, column: int, first: Record, last: Record, comparison: Comparison
) -> Case:
    band, time = first.band, first.run.time_s

    def signal(coefficients: Array) -> Array:
        return band.from_coefficients(coefficients[:, column])

    measured, before, after = (signal(c) for c in (first.measured, first.model, last.model))
    return Case(
        title,
        first.run.id,
        channel,
        band.rate_hz,
        time,
        measured,
        before,
        after,
        float(comparison.floor.noise_rms_m_s2[column]),
        _loudest(measured - before, round(WINDOW_S * band.rate_hz)),
    )


def _loudest(residual: Array, length: int) -> slice:
    """The stretch of this length that holds most of the residual."""
    length = min(length, len(residual))
    held = np.convolve(residual**2, np.ones(length), mode="valid")
    start = int(np.argmax(held))
    return slice(start, start + length)
