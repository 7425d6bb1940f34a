"""How an effect looks at the data while it seeks where its fit may begin."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from wheelhop.effects import RunSetting
from wheelhop.fit import Bench, Workshop
from wheelhop.simulate import Model

Array = NDArray[np.float64]


class FitProbe:
    """Some runs as an effect may see them (`wheelhop.effects.Probe`)."""

    def __init__(self, workshop: Workshop, model: Model, benches: Sequence[Bench]) -> None:
        self._model = model
        self._benches = {bench.run.id: bench for bench in benches}
        self._systems = workshop.systems(model)

    @property
    def settings(self) -> Sequence[RunSetting]:
        """The runs."""
        return [bench.simulator.setting for bench in self._benches.values()]

    def time_s(self, run_id: str) -> Array:
        """Sample times (n,)."""
        return self._benches[run_id].run.time_s

    def measured(self, run_id: str) -> Array:
        """The record in band (n, c), m/s²; zero where the model predicts nothing."""
        bench = self._benches[run_id]
        return bench.band.signal(np.where(bench.predicted, bench.run.acceleration, 0.0))

    def modelled(self, run_id: str, changes: Mapping[str, float]) -> Array:
        """The model's answer in band (n, c), some of the run's numbers moved by an amount."""
        bench: Bench = self._benches[run_id]
        values = self._model.runs.get(run_id, {})
        moved = self._model.with_run(run_id, {k: values[k] + d for k, d in changes.items()})
        response = bench.response(moved, self._systems)
        return bench.band.signal(np.where(bench.predicted, response.acceleration, 0.0))
