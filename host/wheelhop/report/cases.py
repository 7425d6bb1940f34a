"""Which runs and channels are shown: where the first model fails worst, and a typical place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Channel
from wheelhop.compare import Comparison, Record
from wheelhop.diagnose import Rung, Step
from wheelhop.files import InputError, did_you_mean
from wheelhop.fit import RunFit
from wheelhop.report.stretch import worst_stretch

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Case:
    """One channel of one run, in band: `measured` and the answers of the first and the last
    model, each (n,), in `unit`; the part (start, stop) shown against time."""

    title: str
    run_id: str
    channel: str
    quantity: str
    unit: str
    rate_hz: float
    time_s: Array
    measured: Array
    before: Array
    after: Array
    noise_rms: float
    shown: slice


def cases(channels: Sequence[Channel], steps: Sequence[Step]) -> list[Case]:
    """The worst and a typical case, on runs that no fit has seen if there are any."""
    first, last = records_of(steps[0].rung), records_of(steps[-1].rung)
    comparison = steps[0].comparison
    order = _by_ratio(comparison)
    found = []
    for title, (run_id, column) in (
        ("The worst place", order[-1]),
        ("A typical place", order[len(order) // 2]),
    ):
        runs = first[run_id], last[run_id]
        found.append(_case(title, channels[column], column, *runs, comparison))
    return found


def case_of(
    channels: Sequence[Channel], steps: Sequence[Step], run_id: str | None, channel: str | None
) -> Case:
    """One channel of one run; of what is not named that where the first model fails worst.

    Raises
    ------
    InputError
        No such run or channel was compared.
    """
    first, last = records_of(steps[0].rung), records_of(steps[-1].rung)
    names = [each.name for each in channels]
    for what, asked, known in (("run", run_id, list(first)), ("channel", channel, names)):
        if asked is not None and asked not in known:
            near = did_you_mean(asked, known) or f"; there are {', '.join(known)}"
            raise InputError(f'there is no {what} "{asked}"{near}')
    comparison = steps[0].comparison
    runs = [run_id] if run_id else list(first)
    named = range(len(names)) if channel is None else [names.index(channel)]
    order = _by_ratio(comparison, list(first))
    found = [(run, column) for run, column in order if run in runs and column in named]
    if not found:
        raise InputError(f'the model predicts no "{channel}" in run "{run_id or "any"}"')
    run, column = found[-1]
    pair = first[run], last[run]
    return _case(f"{names[column]} in {run}", channels[column], column, *pair, comparison)


def records_of(rung: Rung) -> Mapping[str, Record]:
    """Measured and modelled runs of a fitted model, by run id."""
    return {run.bench.run.id: _record(run) for run in runs_of(rung)}


def runs_of(rung: Rung) -> tuple[RunFit, ...]:
    """The runs a model was fitted to, and those held out."""
    return rung.fit.runs + (() if rung.validation is None else rung.validation.runs)


def _record(run: RunFit) -> Record:
    bench = run.bench
    residual = np.zeros_like(bench.measured)
    residual[:, bench.predicted] = bench.undoubted(run.residual).reshape(bench.band.count, -1)
    measured = np.zeros_like(bench.measured)
    measured[:, bench.predicted] = bench.recorded(bench.measured[:, bench.predicted])
    scale = bench.noise_scale
    return Record(
        bench.run, bench.band, bench.predicted, measured, residual, None, noise_scale=scale
    )


def _by_ratio(comparison: Comparison, among: Sequence[str] = ()) -> list[tuple[str, int]]:
    """Runs and columns in the order of residual over noise, of the runs `among` which is asked; by
    default of the runs held out, if there are any."""
    grid = comparison.breakdown.runs_channels
    eligible = (
        among or [run for run in grid.rows if comparison.roles[run] == "validate"] or grid.rows
    )
    # Without any noise to compare with, the residual itself counts.
    size = grid.ratio if np.isfinite(grid.ratio).any() else grid.residual
    cells = [
        (float(ratio), run, column)
        for run, row in zip(grid.rows, size, strict=True)
        for column, ratio in enumerate(row)
        if run in eligible and np.isfinite(ratio)
    ]
    return [(run, column) for _, run, column in sorted(cells)]


def _case(
    title: str, channel: Channel, column: int, first: Record, last: Record, comparison: Comparison
) -> Case:
    band, time = first.band, first.run.time_s

    def signal(coefficients: Array) -> Array:
        return first.signal(coefficients)[:, column]

    measured, before, after = (signal(c) for c in (first.measured, first.model, last.model))
    return Case(
        title,
        first.run.id,
        channel.name,
        channel.quantity,
        channel.unit,
        band.rate_hz,
        time,
        measured,
        before,
        after,
        float(comparison.floor.of_channels[column]),
        worst_stretch(measured, measured - before, band.rate_hz),
    )
