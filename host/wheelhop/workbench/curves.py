"""The signals that Compare looks at: one row for every channel of every run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, Channel, RigRun, Run
from wheelhop.report.stretch import farthest, worst_stretch
from wheelhop.workbench.charts import AFTER, BEFORE, MEASURED, MORE, Window
from wheelhop.workbench.compared import Added, Compared, offered_channels
from wheelhop.workbench.shown import Rung

Array = NDArray[np.float64]

SHOWN_AS = {"m": (1e3, "mm")}
"""Units that a page shows another one for, and by what a value is multiplied."""


@dataclass(frozen=True, eq=False)
class Curve:
    """One signal (n,)."""

    name: str
    colour: str
    signal: Array


@dataclass(frozen=True, eq=False)
class Row:
    """A channel of a run as it was measured and as every model has it, the measured one first;
    `noise` is its noise in band, rms, 0 where it is not known; `place_m` (n,) is where the front
    axle was, as modelled or else at the speed stated, None on a rig."""

    run: str
    channel: str
    quantity: str
    unit: str
    rate_hz: float
    curves: tuple[Curve, ...]
    noise: float = 0.0
    place_m: Array | None = None

    @property
    def length_s(self) -> float:
        """How long it is."""
        return len(self.curves[0].signal) / self.rate_hz


def rows_of(state: Compared, campaign: Campaign, rungs: Sequence[Rung]) -> tuple[Row, ...]:
    """What a state looks at, run by run; without what is left out or not predicted."""
    runs, offered = {run.id: run for run in campaign.runs}, offered_channels(campaign)
    models = [(i, rungs[i]) for i in state.models]
    found = [
        _modelled(offered[name], run, models, len(rungs))
        if models
        else _recorded(campaign, offered[name], runs[run])
        for run in state.runs
        for name in state.channels
    ]
    return tuple(row for row in found if row is not None)


def _recorded(campaign: Campaign, channel: Channel, run: Run) -> Row | None:
    """As it was recorded, about its mean."""
    names = [each.name for each in campaign.channels]
    if not len(run.time_s):
        return None
    if channel.name in names:
        signal = run.record[:, names.index(channel.name)]
    else:
        assert isinstance(run, RigRun)
        signal = _imposed(run, campaign.sample_rate_hz)[channel.name]
    factor, unit = SHOWN_AS.get(channel.unit, (1.0, channel.unit))
    curve = Curve("measured", MEASURED, factor * (signal - signal.mean()))
    place = run.speed_m_s * run.time_s if run.speed_m_s > 0.0 else None
    return Row(
        *(run.id, channel.name, channel.quantity, unit, campaign.sample_rate_hz, (curve,)),
        place_m=place,
    )


def _imposed(run: RigRun, rate_hz: float) -> Mapping[str, Array]:
    speed = run.velocity
    if speed is None:
        speed = np.gradient(run.displacement) * rate_hz
    return {"force": run.force, "displacement": run.displacement, "velocity": speed}


def _modelled(
    channel: Channel, run: str, models: Sequence[tuple[int, Rung]], count: int
) -> Row | None:
    """As it is in band."""
    first = models[0][1]
    signals = first.signals.get(run)
    if signals is None:
        return None
    factor, unit = SHOWN_AS.get(channel.unit, (1.0, channel.unit))

    def column(rung: Rung, which: str) -> Array | None:
        own = rung.signals[run]
        if channel.name in own.loop:
            found = getattr(own.loop[channel.name], which)
        elif channel.name in rung.channels:
            found = getattr(own, which)[:, rung.channels.index(channel.name)]
        else:
            return None
        return np.asarray(factor * found, np.float64)

    measured = column(first, "measured")
    if measured is None or not measured.any():
        return None
    curves = [Curve("measured", MEASURED, measured)]
    for i, rung in models:
        modelled = column(rung, "modelled")
        assert modelled is not None
        curves.append(Curve(model_name(rung.added), colour_of(i, count), modelled))
    noise = 0.0
    if channel.name in first.channels:
        noise = factor * float(np.nan_to_num(first.noise_rms[first.channels.index(channel.name)]))
    return Row(
        *(run, channel.name, channel.quantity, unit),
        *(signals.rate_hz, tuple(curves), noise),
        None if signals.position_m is None else np.asarray(signals.position_m, np.float64),
    )


def model_name(added: Added) -> str:
    """What is added to the baseline, or the baseline itself."""
    return f"with {' + '.join(added)}" if added else "baseline"


def colour_of(model: int, count: int) -> str:
    """Of the first and the last model of a ladder, and of those between."""
    if model in (0, count - 1):
        return BEFORE if model == 0 else AFTER
    return MORE[model % len(MORE)]


def at_first(rows: Sequence[Row], loops: bool) -> Window:
    """What is looked at of rows before anybody has chosen: where most is left of the first one by
    its first model, or most moves without one; of `loops` some about the farthest point of what
    they are drawn over."""
    row = rows[1] if loops and len(rows) > 1 else rows[0]
    measured, *models = (curve.signal for curve in row.curves)
    if loops:
        part = farthest(measured, row.rate_hz)
    else:
        known = models and not np.array_equal(measured, models[0])
        left = measured - models[0] if known else measured
        part = worst_stretch(measured, left, row.rate_hz)
    return part.start / row.rate_hz, part.stop / row.rate_hz


def within(row: Row, window: Window) -> slice:
    """The samples of a row that lie in a window, s."""
    first, last = (np.clip(end * row.rate_hz, 0, len(row.curves[0].signal)) for end in window)
    return slice(round(float(first)), round(float(last)))
