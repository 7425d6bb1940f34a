"""The campaign on the bench: simulators, in-band data and residuals of all its runs."""

from __future__ import annotations

import os
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from functools import cached_property
from threading import current_thread
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, Run
from wheelhop.compare import weighed
from wheelhop.compare.band import InBand
from wheelhop.effects import Effect, Parameter
from wheelhop.fit.measured_axles import doubt, led_astray, shared_error
from wheelhop.fit.shared_error import SharedError
from wheelhop.fit.spread import cost, cost_of, spread, weights_of
from wheelhop.fit.work import PER_RECORD_S, PER_STEP, Work
from wheelhop.simulate import Model, Response, RunSimulator, Simulator, drive_of, make_simulator
from wheelhop.simulate.abreast import integrate_jobs, shared_out
from wheelhop.vehicle import Drive, Measured, System
from wheelhop.vehicle.assembly import FREE_1_S

Array = NDArray[np.float64]
RUN_UP = 7.0
"""So many of the nominal vehicle's slowest time constants lie between start and record."""

REMEMBERED = 4.0 / RUN_UP
"""After this share of the run-up 2 % of a disturbance are left: close enough for a derivative."""

T = TypeVar("T")
S = TypeVar("S")

RUNS_AWAY = np.errstate(over="ignore", invalid="ignore")
"""A fit may try a model that is not stable: its record is infinite, which is no news."""

MEASURED_DRIVES = ("axles", "travel")
"""What moves the model there was measured, and is uncertain itself."""

Trial = tuple[Model, dict[Drive, System]]
"""A model with its equations of motion."""


@dataclass(frozen=True, eq=False)
class Bench:
    """One run, ready to be simulated again and again."""

    run: Run
    simulator: Simulator
    band: InBand
    measured: Array  #: (2 n_bins, c) in-band data of the record, as `coefficients` says
    predicted: NDArray[np.bool_]  #: (c,) channels the model predicts in this run
    memory_s: float  #: after this time what has moved the vehicle is as good as forgotten
    doubt: Array  #: (2 n_bins, c) noise of every datum per the sensors', `measured_axles.doubt`
    noise_ratio: Array  #: the same without motion folded into measured axles
    noise_scale: Array  #: (c,) of every channel, `wheelhop.compare.weights`
    work: Work  #: where what is simulated is counted
    shared_error: SharedError | None = None  #: where channels err together, beyond their noise

    def _counted(self, trials: Sequence[Trial], done: Callable[[], T]) -> T:
        """What is done with the records of these models, counted as work."""
        before, time_s = self.simulator.steps, self.run.time_s
        found = done()
        seconds = len(trials) * float(time_s[-1] - time_s[0])
        steps = self.simulator.steps - before
        self.work.add(PER_RECORD_S * seconds + PER_STEP * steps)
        return found

    @property
    def drive(self) -> Drive:
        """What moves the model in this run."""
        return self.simulator.drive

    @property
    def measures_force(self) -> bool:
        """Whether a force is measured, in a strut or on a rig."""
        channels = self.simulator.campaign.channels
        return self.drive == "rig" or any(c.quantity == "force" for c in channels)

    def spread(self, residual: Array, sigma: float) -> Array:
        """Standard deviation of every datum (size,) of a residual per that of the sensors' noise,
        σ."""
        return np.tile(spread(residual.reshape(self.band.count, -1), sigma), self.band.count)

    def cost(self, residual: Array, sigma: float) -> float:
        """−2 ln p of a residual (size,)."""
        return cost(residual.reshape(self.band.count, -1), sigma)

    def counted(self, powers: Array) -> tuple[float, Array]:
        """−2 ln p of a residual whose channels leave Σ r²/σ² (c,), and the weight 1/ρ² (c,) of
        each."""
        return cost_of(powers, self.band.count), weights_of(powers, self.band.count)

    @property
    def energy(self) -> float:
        """Σ y² of the predicted channels, in band."""
        return float((self.recorded(self.measured[:, self.predicted]) ** 2).sum())

    @property
    def size(self) -> int:
        """Number of in-band data of the predicted channels."""
        return self.band.count * int(self.predicted.sum())

    def response(self, model: Model, systems: dict[Drive, System]) -> Response:
        """What the model says this run should have measured."""
        found = self._counted(
            [(model, systems)], lambda: self.simulator.simulate(model, systems[self.drive])
        )
        if self.drive not in MEASURED_DRIVES:
            return found
        return replace(found, doubt=self.doubt, noise_ratio=self.noise_ratio)

    @RUNS_AWAY
    def modelled(self, model: Model, systems: dict[Drive, System]) -> Array:
        """In-band model coefficients (size,) of the predicted channels."""
        (record,) = self.records([(model, systems)])
        return self.coefficients(record)

    @RUNS_AWAY
    def records(self, trials: Sequence[Trial]) -> list[Array]:
        """What several models say the instrument should have recorded (n, channels), at much less
        cost than one after the other."""
        asked = [(model, s[self.drive]) for model, s in trials]
        return self._counted(trials, lambda: self.simulator.records(asked))

    @RUNS_AWAY
    def changes(self, base: Trial, trials: Sequence[Trial]) -> list[Array]:
        """By how much the records (n, channels) of several models differ from that of `base`."""
        first, *others = [(model, s[self.drive]) for model, s in (base, *trials)]
        return self._counted(trials, lambda: self.simulator.changes(first, others))

    @RUNS_AWAY
    def coefficients(self, record: Array) -> Array:
        """In-band data (size,) of a record's predicted channels: coefficients per `noise_scale` of
        the channel, and per `doubt`, or free of `shared_error`. Of a record that is not finite, as
        of a model that is not stable, they are infinite: whatever is measured, it is far off."""
        found = self.band.coefficients(record[:, self.predicted]) / self.noise_scale[self.predicted]
        if self.shared_error is not None:
            found = self.shared_error.white(found)
        else:
            found = found / self.doubt[:, self.predicted]
        return np.where(np.isfinite(found), found, np.inf).ravel()

    def seen_by(self, columns: Array, channels: Sequence[int]) -> Array:
        """Columns of data (size, k) as they would be, had only some `channels` been recorded beside
        those that drive the run."""
        of_predicted = np.cumsum(self.predicted) - 1
        kept = [int(of_predicted[i]) for i in channels if self.predicted[i]]
        data = columns.reshape(self.band.count, -1, columns.shape[1])
        if self.shared_error is None:
            seen = data[:, kept]
        else:
            seen = self.shared_error.among(kept).white(self.shared_error.recorded(data)[:, kept])
        return np.asarray(seen.reshape(-1, columns.shape[1]))

    def undoubted(self, data: Array) -> Array:
        """Data (size,) as they were recorded, with the errors of what drives the run."""
        return self.recorded(data.reshape(self.band.count, -1)).ravel()

    def recorded(self, data: Array) -> Array:
        """Data (2 n_bins, p) as they were recorded, with the errors of what drives the run."""
        if self.shared_error is not None:
            return self.shared_error.recorded(data)
        return np.asarray(data * self.doubt[:, self.predicted])

    @property
    def foreseen(self) -> float:
        """How many of the data's variances are the error of what drives the run."""
        if self.shared_error is not None:
            return self.shared_error.foreseen
        return float((1.0 - 1.0 / self.doubt[:, self.predicted] ** 2).sum())

    def residual(self, model: Model, systems: dict[Drive, System]) -> Array:
        """Measured minus modelled, (size,)."""
        return self.measured[:, self.predicted].ravel() - self.modelled(model, systems)


def processors() -> int:
    """How many processors this process may use; the computer may have more."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


Watch = Callable[[int, float], None]
"""Told of every iteration of a fit of shared numbers: which one, from 1, and the error E so far."""


class Workshop:
    """All runs of a campaign on their benches, worked on by a few threads; `model` is the nominal
    vehicle, `measured` what is known of sums and relations of its numbers; `watch` sees every fit
    converge; `run_away` holds runs, and the effects of models whose answers in them were not finite
    where an effect looked at them."""

    def __init__(
        self,
        campaign: Campaign,
        model: Model,
        *,
        measured: Sequence[Measured] = (),
        noise_rms: float | None = None,
        jobs: int | None = None,
    ) -> None:
        self.campaign = campaign = weighed(campaign)
        self.measured = tuple(measured)
        self.nominal = model.values
        self.work = Work()
        self.run_away = set[tuple[str, tuple[str, ...]]]()
        self._employ(jobs or min(processors(), 8))
        self.drives = tuple(sorted({drive_of(campaign, run) for run in campaign.runs}))
        nominal = self.systems(model)
        self._run_up_s = 0.0 if "rig" in self.drives else run_up(nominal)
        self._nominal_systems = nominal
        self.benches = {run.id: self.bench(run) for run in campaign.runs}
        self.set_noise(campaign.noise_rms if noise_rms is None else noise_rms)

    def _employ(self, workers: int) -> None:
        """Have so many threads; nobody watches yet."""
        self.watch: Watch = lambda iteration, error: None
        self._threads = f"workshop-{id(self)}"
        self._workers = workers
        self._pool = ThreadPoolExecutor(workers, self._threads)

    def __getstate__(self) -> dict[str, object]:
        """All but the threads, who watches them, and compiled laws."""
        gone = ("watch", "_threads", "_pool", "_nominal_systems")
        return {name: value for name, value in vars(self).items() if name not in gone}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._employ(min(self._workers, processors()))
        self._nominal_systems = self.systems(Model(self.nominal))

    def set_noise(self, rms: float | None) -> None:
        """State the in-band noise of one channel of the leading quantity; None: not known, any
        residual may be noise.

        `noise` is the standard deviation of one in-band coefficient: n samples with this noise in
        band have n · rms² as their sum of squares, spread over the band's coefficients.
        """
        band = next(iter(self.benches.values())).band
        self.noise = 0.0 if rms is None else float(rms * np.sqrt(band.n / band.count))

    def parameters_of(self, effect: Effect) -> Sequence[Parameter]:
        """An effect's parameters on the nominal vehicle. A fit follows the model's own scale of
        masses and forces from there (`Free.follows_scale`)."""
        return effect.parameters_for(self.nominal, self.campaign.channels)

    def systems(self, model: Model) -> dict[Drive, System]:
        """Equations of motion of a model for every drive that occurs in the campaign."""
        return {drive: model.system(self.campaign.channels, drive) for drive in self.drives}

    def of_role(self, role: str) -> tuple[Bench, ...]:
        """The benches of the runs with this role."""
        return tuple(b for b in self.benches.values() if b.run.role == role)

    def each(self, function: Callable[[S], T], items: Iterable[S]) -> list[T]:
        """`function` of every item, in parallel threads; the compiled integrator runs free of the
        interpreter's lock.

        Raises
        ------
        OutOfBudget
            The work that is allowed is done.
        """
        given = list(items)
        inside = current_thread().name.startswith(self._threads)
        if not inside:
            self.work.check()
        # A thread that waits for another of the same pool could wait for ever.
        if len(given) < 2 or inside:
            return [function(item) for item in given]
        begun = [self._pool.submit(function, item) for item in given]
        try:
            return [future.result() for future in begun]
        finally:  # interrupted: no thread is left at work on a run
            for future in begun:
                future.cancel()
            wait(begun)

    def in_turn(
        self, function: Callable[[S], T], batches: Iterable[Sequence[S]]
    ) -> Iterator[list[T]]:
        """`function` of every item, batch by batch: while the caller works on one batch, the
        threads are at the next. Batches are equally long; of two the items in one place, which may
        be of the same run, are never worked on at once. Raises OutOfBudget as `each` does."""
        self.work.check()

        def after(previous: Future[T] | None, item: S) -> T:
            wait([previous] if previous is not None else [])
            return function(item)

        begun: deque[list[Future[T]]] = deque()

        def results() -> list[T]:
            found = [future.result() for future in begun[0]]
            begun.popleft()
            return found

        try:
            for batch in batches:
                before = begun[-1] if begun else [None] * len(batch)
                pairs = zip(before, batch, strict=True)
                begun.append([self._pool.submit(after, *pair) for pair in pairs])
                if len(begun) > 1:
                    yield results()
            while begun:
                yield results()
        finally:
            for future in (future for batch in begun for future in batch):
                future.cancel()

    def ahead(self, model: Model, systems: dict[Drive, System], benches: Sequence[Bench]) -> None:
        """Integrate what the records of a model in these runs ask for, runs side by side; what is
        asked for next of each is its record."""
        rolling = [b.simulator for b in benches if isinstance(b.simulator, RunSimulator)]
        if len(rolling) < 2:
            return
        due = self.each(RUNS_AWAY(lambda s: s.due(model, systems[s.drive])), rolling)
        asked = [(s, job) for s, job in zip(rolling, due, strict=True) if job is not None]
        before = sum(simulator.steps for simulator in rolling)
        self.each(RUNS_AWAY(integrate_jobs), shared_out(asked, self._workers))
        self.work.add(PER_STEP * (sum(simulator.steps for simulator in rolling) - before))
        for simulator, job in asked:
            simulator.keep(job)

    def responses(self, model: Model) -> list[Response]:
        """Responses of all runs, in the campaign's order."""
        systems, benches = self.systems(model), list(self.benches.values())
        self.ahead(model, systems, benches)
        return self.each(lambda b: b.response(model, systems), benches)

    @cached_property
    def astray(self) -> dict[str, Bench]:
        """Runs driven by measured motion on another bench, where it is as wrong as it may be."""
        return {
            b.run.id: replace(b, simulator=self.bench(led_astray(self.campaign, b.run)).simulator)
            for b in self.benches.values()
            if b.drive in MEASURED_DRIVES and self.campaign.noise_rms is not None
        }

    def bench(self, run: Run, earlier: float = 1.0) -> Bench:
        """A run of this campaign, or one that could be driven, on its bench; begun `earlier` times
        as long before its record."""
        simulator = make_simulator(self.campaign, run, earlier * self._run_up_s)
        band = InBand(len(run.time_s), self.campaign.sample_rate_hz, self.campaign.band_hz)
        systems = self._nominal_systems
        shown = systems.get(simulator.drive)  # None on a road that could be driven
        predicted: NDArray[np.bool_] = np.ones(len(self.campaign.channels), bool)
        if shown is not None:
            predicted = np.asarray(~np.isnan(shown.output).any(axis=1))
        doubted = ratio = np.ones((band.count, len(predicted)))
        together: SharedError | None = None
        measured_drive = simulator.drive in MEASURED_DRIVES
        if shown is not None and measured_drive and self.campaign.noise_rms is not None:
            doubted, ratio = doubt(self.campaign, run, shown, band.frequency_hz)
            if simulator.drive == "travel":
                together = shared_error(self.campaign, run, shown, band.frequency_hz, predicted)
        scale = self.campaign.noise_scale
        measured = band.coefficients(run.record) / scale / doubted
        if together is not None:
            coefficients = band.coefficients(run.record[:, predicted]) / scale[predicted]
            measured = np.zeros_like(measured)
            measured[:, predicted] = together.white(coefficients)
        memory_s = REMEMBERED * self._run_up_s
        return Bench(
            run,
            simulator,
            band,
            measured,
            predicted,
            memory_s,
            doubted,
            ratio,
            scale,
            self.work,
            together,
        )


def run_up(systems: dict[Drive, System]) -> float:
    """When the nominal vehicle has forgotten its start."""
    poles = [system.poles() for system in systems.values()]
    held = [part[np.abs(part) > FREE_1_S] for part in poles]  # travel leaves the body free
    slowest = min((float(-part.real.max()) for part in held if len(part)), default=np.inf)
    return float(np.clip(RUN_UP / max(slowest, 1e-3), 1.5, 6.0))
