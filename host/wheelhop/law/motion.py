"""How every place moved in the runs fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import RigRun
from wheelhop.effects import Effect, law
from wheelhop.effects.base import Values
from wheelhop.fit import Bench, FitProbe, Workshop
from wheelhop.law.along import laws_of
from wheelhop.law.forced import ForcedRun
from wheelhop.law.moved import Moved
from wheelhop.law.places import Where, places
from wheelhop.simulate import Model
from wheelhop.vehicle import Assembly, Motion, axle_name
from wheelhop.vehicle.assembly import Row

Array = NDArray[np.float64]


class Moves:
    """The motion of every place of a model in the runs fitted, as model and records tell it; `law`
    is a model with one effect more, whose forces say what no record tells below the band."""

    def __init__(self, workshop: Workshop, model: Model, law: Model | None = None) -> None:
        self._workshop, self._model, self._law = workshop, model, law
        self._benches = workshop.of_role("fit")
        self.rows = _rows(model)

    @property
    def on_road(self) -> bool:
        """Whether every run is one of a vehicle on a track that is known."""
        return all(bench.drive == "road" for bench in self._benches)

    @cached_property
    def forced(self) -> Mapping[str, ForcedRun]:
        """The runs, each with a port at every one of `rows`; only on the road."""
        model = self._model.with_effect(_Ends(self.rows), ())
        system, law, laws = self._workshop.systems(model)["road"], self._law, []
        if law is not None:
            found = laws_of(law.effects[-1], law.theta(law.effects[-1]), self._model.values)
            laws = [(self.rows.index(row), kernel, numbers) for row, kernel, numbers, _ in found]
        runs = self._workshop.each(
            lambda bench: ForcedRun(bench, model, system, self._workshop.noise, laws), self._benches
        )
        return {bench.run.id: run for bench, run in zip(self._benches, runs, strict=True)}

    def of(self, where: Where) -> Moved | None:
        """How a place moved; None where nothing tells."""
        ways = [way for bench in self._benches for way in self._ways(bench, where)]
        if not ways:
            return None
        x, v = (np.concatenate(part) for part in zip(*ways, strict=True))
        runs = [bench.run for bench in self._benches if isinstance(bench.run, RigRun)]
        names = runs[0].inputs if runs else ()
        inputs = {name: np.concatenate([run.inputs[name] for run in runs]) for name in names}
        setting = self._benches[0].simulator.setting
        before_s = setting.record_start_s - setting.start_s
        return Moved(x, v, tuple(len(one) for one, _ in ways), inputs, before_s)

    def _ways(self, bench: Bench, where: Where) -> list[tuple[Array, Array]]:
        run, corners = bench.run, where.corners
        if isinstance(run, RigRun):
            x, v, _ = Motion(self._workshop.campaign, run).at(run.time_s)  # type: ignore[arg-type]
            return [(x, v)]
        if self.on_road:
            forced = self.forced[run.id]
            ports = [self.rows.index(row) for row in where.rows(self._model.values)]
            at = forced.samples
            return [(forced.extension[at, i], forced.rate[at, i]) for i in ports]
        travel = FitProbe(self._workshop, self._model, [bench]).travel(run.id)
        if where.kind != "strut":
            return []
        ends = [(travel[axle_name(i)], i % 2) for i in corners if axle_name(i) in travel]
        ways = [end[:, min(side, end.shape[1] - 1)] for end, side in ends]
        return [(x, np.gradient(x, run.time_s)) for x in ways]


def _rows(model: Model) -> list[Row]:
    """The extensions of all places, each once."""
    every = [row for where in places(model.values) for row in where.rows(model.values)]
    return list(dict.fromkeys(every))


@law
def _none(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    return 0.0, z


class _Ends(Effect):
    """Nothing but ports, one for each of these extensions."""

    id = "ends"
    place = "suspension"

    def __init__(self, rows: Sequence[Row]) -> None:
        self._rows = rows

    def modify(self, theta: Values, vehicle: Values, parts: Assembly) -> None:
        """Add them."""
        for row in self._rows:
            parts.add_law(row, _none, ())
