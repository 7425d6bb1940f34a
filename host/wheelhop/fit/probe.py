"""How an effect looks at the data while it seeks where its fit may begin."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from wheelhop.campaign import CampaignError, Channel, RigRun
from wheelhop.effects import Effect, RunSetting
from wheelhop.fit.bench import Bench, Workshop
from wheelhop.fit.placement import find_start
from wheelhop.simulate import Model
from wheelhop.simulate.prescribed import slow_part
from wheelhop.vehicle import COMPONENT, CORNERS, axle_name

Array = NDArray[np.float64]


Values = Mapping[str, float]


class NotFinite(CampaignError):
    """A model answers with what is not finite in a run, so that nothing can be seen by it."""


class FitProbe:
    """Some runs as an effect may see them (`wheelhop.effects.Probe`)."""

    def __init__(self, workshop: Workshop, model: Model, benches: Sequence[Bench]) -> None:
        self._workshop, self._model = workshop, model
        self._benches = {bench.run.id: bench for bench in benches}
        self._systems = workshop.systems(model)
        self._campaign = workshop.campaign
        self._channels = workshop.campaign.channels
        self._lowest_hz = workshop.campaign.band_hz[0]

    def shape_starts(self, effect: Effect) -> Sequence[Values]:
        """Where an effect's shapes may begin, as it finds them in these runs; none where the model
        without it runs away in one of them, which is said in the workshop's `run_away`."""
        try:
            return effect.shape_starts(self)
        except NotFinite:
            return ()

    def run_starts(self, effect: Effect, run: RunSetting, shapes: Values) -> Sequence[Values]:
        """Where what it leaves free in a run may begin; absent where the model runs away there."""
        try:
            return effect.run_starts(self, run, shapes)
        except NotFinite:
            return ({},)

    @property
    def settings(self) -> Sequence[RunSetting]:
        """The runs."""
        return [bench.simulator.setting for bench in self._benches.values()]

    @property
    def channels(self) -> Sequence[Channel]:
        """The channels, in the order of the columns."""
        return self._channels

    @property
    def values(self) -> Mapping[str, float]:
        """The model's numbers, by their dotted names."""
        return self._model.values

    def time_s(self, run_id: str) -> Array:
        """Sample times (n,)."""
        return self._benches[run_id].run.time_s

    def recorded(self, run_id: str) -> Array:
        """The record (n, c) as it is, in the channels' units."""
        return self._benches[run_id].run.record

    def measured(self, run_id: str) -> Array:
        """The record in band (n, c), every channel per its noise scale; zero where the model
        predicts nothing."""
        return self._in_band(self._benches[run_id], self._benches[run_id].run.record)

    def modelled(self, run_id: str, changes: Mapping[str, float]) -> Array:
        """The model's answer in band (n, c), alike, some of the run's numbers moved by an
        amount."""
        return self.all_modelled(run_id, [changes])[0]

    def all_modelled(self, run_id: str, trials: Sequence[Mapping[str, float]]) -> list[Array]:
        """`modelled` for several changes."""
        bench: Bench = self._benches[run_id]
        values = self._model.runs.get(run_id, {})
        moved = [
            self._model.with_run(run_id, {k: values[k] + d for k, d in changes.items()})
            for changes in trials
        ]
        records = bench.records([(model, self._systems) for model in moved])
        return [self._in_band(bench, record) for record in records]

    def _in_band(self, bench: Bench, record: Array) -> Array:
        shown = self._finite(bench, np.where(bench.predicted, record, 0.0))
        return bench.band.signal(shown / bench.noise_scale)

    def _finite(self, bench: Bench, shown: Array) -> Array:
        """What a model says of a run, if all of it is a number, and its square.

        Raises
        ------
        NotFinite
            It is not.
        """
        with np.errstate(over="ignore"):
            square = float(np.sum(shown**2))
        if not np.isfinite(square):
            effects = tuple(effect.id for effect in self._model.effects)
            self._workshop.run_away.add((bench.run.id, effects))
            what = " and ".join(("these numbers", *effects))
            raise NotFinite(
                f"{self._campaign.vehicle_file}: a model with {what} runs away in run"
                f' "{bench.run.id}": leave one of them out, or correct a number'
            )
        return shown

    def placed(self, run_id: str, channels: Collection[int]) -> Mapping[str, float]:
        """Speed and start at which the linear model agrees best with some of the channels."""
        bench = self._benches[run_id]
        if bench.drive != "road" or not channels:
            return {}
        system = self._systems[bench.drive]
        return find_start(self._campaign, bench.run, self._model, system, channels)

    def period_m(self, run_id: str) -> float | None:
        """Length after which the run's track repeats; None if it does not, or is not known."""
        return self._benches[run_id].simulator.period_m

    def way_m(self, run_id: str) -> Array:
        """The way (n, 4), m, each wheel has come along the track."""
        return self._benches[run_id].simulator.way(self._model)

    def travel(self, run_id: str) -> Mapping[str, Array]:
        """Extensions in band of the struts of each end (n, struts), m, where a strut's travel is
        measured, or both its ends have a sensor: what the model says, or on measured axles the
        record, integrated twice; on a rig what was recorded."""
        bench = self._benches[run_id]
        if isinstance(bench.run, RigRun):
            return {COMPONENT: bench.run.displacement[:, None]}
        response = bench.response(self._model, self._systems).record
        told = self._finite(bench, np.where(bench.predicted, response, bench.run.record))
        place = {c.point: i for i, c in enumerate(self._channels)}
        pots = {c.corner: i for i, c in enumerate(self._channels) if c.quantity == "travel"}
        found: dict[str, list[Array]] = {}
        for corner in CORNERS:
            upper, lower = place.get(f"B{corner + 1}"), place.get(f"A{corner + 1}")
            if corner in pots:
                shown = told[:, pots[corner]] / self._channels[pots[corner]].per_wheel
                found.setdefault(axle_name(corner), []).append(bench.band.signal(shown))
            elif upper is not None and lower is not None:
                relative = told[:, upper] - told[:, lower]
                way = _integrated_twice(bench.run.time_s, relative, self._lowest_hz)
                found.setdefault(axle_name(corner), []).append(way)
        return {end: np.stack(extensions, axis=1) for end, extensions in found.items()}


def _integrated_twice(time_s: Array, acceleration: Array, lowest_hz: float) -> Array:
    """Displacement (n,), m, of an acceleration, without what is slower than the band."""
    height = CubicSpline(time_s, acceleration).antiderivative(2)(time_s)
    return np.asarray(height - slow_part(time_s, height, 1.0 / lowest_hz)(time_s))
