"""What Compare shows: one state, the events that change it, and what is drawn of it.

The page keeps the state and nothing else; its fields and charts are made from it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, Channel
from wheelhop.workbench.charts import (
    AFTER,
    BEFORE,
    FLOOR,
    MEASURED,
    MORE,
    WHOLE,
    Line,
    Options,
    Panel,
    Window,
    chart,
    power_density,
)
from wheelhop.workbench.shown import Rung

Array = NDArray[np.float64]
Added = tuple[str, ...]

ALL_RUNS = -1
STEP = 0.2  # of what is shown, for one press of a key
CLOSEST = 0.5  # per cent of a record
NOTHING = "left out, or not predicted by the model: nothing to compare"


@dataclass(frozen=True)
class Compared:
    """What is looked at: a run and a channel (indices into the campaign's; `ALL_RUNS`: every run
    taken, one after the other), which models of the ladder (indices into `ladder`, which names the
    effects each of them has), and from where to where, per cent of the record."""

    run: int = 0
    channel: int = 0
    ladder: tuple[Added, ...] = ()
    models: tuple[int, ...] = ()
    window: Window = WHOLE

    def at(self, run: int | None = None, channel: int | None = None) -> Compared:
        """Another run, channel or both; another run is looked at as a whole."""
        run = self.run if run is None else run
        channel = self.channel if channel is None else channel
        window = self.window if run == self.run else WHOLE
        return replace(self, run=run, channel=channel, window=window)

    def stepped(self, by: int, runs: Sequence[int]) -> Compared:
        """So many runs further among `runs`, round and round; from all runs on, the first one."""
        at = runs.index(self.run) if self.run in runs else 0
        return self.at(run=runs[(at + by) % len(runs)])

    def beside(self, models: Collection[int]) -> Compared:
        """Other models of the ladder."""
        return replace(self, models=tuple(sorted(models)))

    def on(self, ladder: tuple[Added, ...]) -> Compared:
        """Another ladder has been fitted: its first and its last model are looked at."""
        if ladder == self.ladder:
            return self
        models = tuple(sorted({0, len(ladder) - 1})) if ladder else ()
        return replace(self, ladder=ladder, models=models)

    def zoomed(self, run: int, window: Window) -> Compared:
        """The browser says what it shows of a run; of one looked at before that is old news."""
        return replace(self, window=window) if run == self.run else self

    def pressed(self, key: str) -> Compared:
        """A key zooms or moves."""
        return replace(self, window=moved(self.window, key))


def moved(window: Window, key: str) -> Window:
    """What of a record is looked at, per cent, after a key: + − zoom, arrows move, 0 shows all."""
    first, last = window
    width = last - first
    if key == "0":
        return WHOLE
    if key in ("+", "="):
        width = max(width * (1 - 2 * STEP), CLOSEST)
    elif key in ("-", "−"):
        width = min(width / (1 - 2 * STEP), 100.0)
    by = {"ArrowLeft": -STEP, "ArrowRight": STEP}.get(key, 0.0) * width
    middle = min(max((first + last) / 2 + by, width / 2), 100.0 - width / 2)
    return middle - width / 2, middle + width / 2


def runs_offered(state: Compared, campaign: Campaign, left_out: Collection[str]) -> list[int]:
    """The runs that are taken, and the one that is looked at."""
    runs = enumerate(campaign.runs)
    return [i for i, run in runs if i == state.run or run.id not in left_out]


def model_name(added: Added) -> str:
    """What is added to the baseline, or the baseline itself."""
    return f"with {' + '.join(added)}" if added else "baseline"


@dataclass(frozen=True, eq=False)
class Curve:
    """One signal, a record (n,) of each run."""

    name: str
    colour: str
    records: tuple[Array, ...]

    @property
    def whole(self) -> Array:
        """One run after the other."""
        return np.concatenate(self.records)


@dataclass(frozen=True, eq=False)
class Curves:
    """A channel as it was measured and as every model has it, the measured one first; `noise` is
    its noise in band, rms, 0 where it is not known."""

    channel: Channel
    rate_hz: float
    curves: tuple[Curve, ...]
    noise: float = 0.0


def curves(
    state: Compared, campaign: Campaign, rungs: Sequence[Rung], left_out: Collection[str]
) -> Curves | None:
    """What a state looks at; None where there is nothing to compare."""
    channel = campaign.channels[state.channel]
    chosen = runs_offered(state, campaign, left_out) if state.run == ALL_RUNS else [state.run]
    runs = [campaign.runs[i] for i in chosen]
    models = [rungs[i] for i in state.models]
    if not models:
        records = [run.record[:, state.channel] for run in runs if len(run.time_s)]
        measured = Curve("measured", MEASURED, tuple(record - record.mean() for record in records))
        return Curves(channel, campaign.sample_rate_hz, (measured,)) if records else None
    first = models[0]
    ids = [run.id for run in runs if run.id in first.signals]
    if channel.name not in first.channels or not ids:
        return None
    k = first.channels.index(channel.name)

    def of(name: str, colour: str, rung: Rung, kind: str) -> Curve:
        signals = [getattr(rung.signals[i], kind)[:, k] for i in ids]
        return Curve(name, colour, tuple(signal.astype(np.float64) for signal in signals))

    return Curves(
        channel,
        first.signals[ids[0]].rate_hz,
        (
            of("measured", MEASURED, first, "measured"),
            *(
                of(model_name(rungs[i].added), _colour(i, len(rungs)), rungs[i], "modelled")
                for i in state.models
            ),
        ),
        float(np.nan_to_num(first.noise_rms[k])),
    )


def _colour(model: int, count: int) -> str:
    """Of the first and the last model of a ladder, and of those between."""
    if model in (0, count - 1):
        return BEFORE if model == 0 else AFTER
    return MORE[model % len(MORE)]


def words_of(found: Curves | None) -> str:
    """The line above the charts."""
    if found is None:
        return NOTHING
    rms = " · ".join(f"{c.name} {np.sqrt(np.mean(c.whole**2)):.3g}" for c in found.curves)
    return f"rms, {found.channel.unit}: {rms}"


def time_chart(found: Curves | None, window: Window) -> Options:
    """The signals against time and below them what each model leaves, both over one window."""
    if found is None:
        return {}
    measured, *models = found.curves
    lengths = [len(record) for record in measured.records]
    time = np.arange(sum(lengths)) / found.rate_hz
    joins = tuple(np.cumsum(lengths)[:-1] / found.rate_hz)
    upper = [Line(measured.name, time, measured.whole, measured.colour, 2.2)]
    upper += [Line(c.name, time, c.whole, c.colour, dashed=c.colour in MORE) for c in models]
    lower = [
        Line(c.name, time, measured.whole - c.whole, c.colour, dashed=c.colour in MORE)
        for c in models
    ]
    unit, quantity = found.channel.unit, f"{found.channel.quantity}, {found.channel.unit}"
    panels = [Panel("" if lower else "time, s", quantity, upper, joins=joins)]
    if lower:
        band = 2 * found.noise
        panels.append(Panel("time, s", f"residual, {unit}", lower, band=band, joins=joins))
    return chart(panels, (66, 34)[: len(panels)], range(len(panels)), window)


def spectrum(found: Curves | None, band_hz: tuple[float, float]) -> Options:
    """Power densities in band; of several runs the mean of theirs, each weighed by its length."""
    if found is None:
        return {}
    low, high = band_hz
    lines = []
    for curve in found.curves:
        frequency, power = power_density(curve.records, found.rate_hz)
        kept = (frequency >= low) & (frequency <= high) & (power > 0)
        dashed = curve.colour in MORE
        lines.append(Line(curve.name, frequency[kept], power[kept], curve.colour, dashed=dashed))
    if found.noise > 0:
        level = np.full(2, found.noise**2 / (high - low))
        lines.append(Line("noise floor", np.array([low, high]), level, FLOOR, dashed=True))
    unit = f"({found.channel.unit})" if "/" in found.channel.unit else found.channel.unit
    panel = Panel("frequency, Hz", f"power density, {unit}²/Hz", lines, log=True)
    return chart([panel], (100,), (0,))
