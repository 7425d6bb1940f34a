"""Runs whose records are linear in the numbers of a model: all of a fit is known in closed form."""

from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from wheelhop.campaign import Run, TrackSpec
from wheelhop.effects import RunSetting
from wheelhop.fit import Free
from wheelhop.fit.bench import RUNS_AWAY
from wheelhop.fit.work import Work
from wheelhop.simulate import Model

SIZE, SIGMA, SPEED = 60, 0.3, 4.0
SHARED = (Free("stiffness", 100.0, 20.0, 10.0), Free("mass", 5.0, 0.5, 0.25))
OWN = ("speed_m_s", "start_m")
OWN_SCALES, OWN_SIGMAS = np.array([1e-3 * SPEED, 1e-2]), np.array([0.06 * SPEED, np.inf])
SCALES = np.array([free.scale for free in SHARED])


@dataclass
class LinearBench:
    """A run whose record is linear in the numbers, unless `law` bends it."""

    run: Run
    matrix: np.ndarray  # (size, shared + own) per scale, around what is believed
    measured: np.ndarray
    names: tuple[str, ...]
    law: object = staticmethod(lambda numbers: numbers)
    steepness: float = 1.0  # by how much derivatives are exaggerated
    band = SimpleNamespace(count=SIZE)
    memory_s, drive, size, simulated, asked = 1.0, "road", SIZE, 0, 0
    measures_force = False
    work = Work()

    @property
    def simulator(self):
        setting = RunSetting(self.run.id, self.run.speed_m_s, -1.0, 0.0, 1.0, True)
        return SimpleNamespace(setting=setting, series=None)

    @property
    def energy(self):
        return float(self.measured @ self.measured)

    def record(self, model):
        own = model.runs.get(self.run.id, {})
        means = dict(zip(OWN, (self.run.speed_m_s, 0.0), strict=True))
        shared = [(model.values[n] - CENTRE[n]) / UNIT[n] for n in self.names]
        mine = [(own.get(n, means[n]) - means[n]) / s for n, s in zip(OWN, OWN_SCALES, strict=True)]
        numbers = np.array([*shared, *(mine if self.run.speed_m_s > 0.0 else ())])
        return self.matrix @ self.law(numbers)

    def changes(self, base, trials):
        self.simulated, self.asked = self.simulated + len(trials), self.asked + 1
        here = self.record(base[0])
        return [self.steepness * (self.record(model) - here) for model, _ in trials]

    def coefficients(self, change):
        return change

    undoubted = coefficients

    @RUNS_AWAY
    def residual(self, model, systems):
        return self.measured - self.record(model)

    def spread(self, residual, sigma):
        return np.ones(SIZE)

    def cost(self, residual, sigma):
        return float(residual @ residual) / sigma**2

    def counted(self, powers):
        return float(powers.sum()), np.ones_like(powers)


CENTRE = {free.name: free.mean for free in SHARED} | {"extra": 0.0}
UNIT = {free.name: free.scale for free in SHARED} | {"extra": 2.0}


class Shop(SimpleNamespace):
    """A workshop without an engine."""

    def __init__(self, noise=SIGMA):
        super().__init__(noise=noise, measured=(), watch=lambda iteration, error: None)

    def systems(self, model):
        return {"road": None}

    def each(self, function, items):
        return [function(item) for item in items]

    def ahead(self, model, systems, benches):
        """Nothing is integrated."""


def benches_of(seed, speed=SPEED, count=3, names=("stiffness", "mass"), noise=SIGMA, faint=1.0):
    """Runs of numbers that are off by about as much as is believed; of their speed they show little
    where it is faint."""
    rng, benches = np.random.default_rng(seed), []
    width = len(names) + (2 if speed > 0.0 else 0)
    off = rng.normal(size=len(names)) * 1.5
    for i in range(count):
        matrix = rng.normal(size=(SIZE, width))
        matrix[:, len(names) : len(names) + 1] *= faint
        numbers = np.concatenate([off, 5.0 * rng.normal(size=width - len(names))])
        measured = matrix @ numbers + noise * rng.normal(size=SIZE)
        run = Run(
            *(f"run{i}", Path("run.csv"), "fit", speed, TrackSpec("flat", {})),
            *(np.arange(SIZE) / 100.0, np.zeros((SIZE, 1))),
        )
        benches.append(LinearBench(run, matrix, measured, names))
    return benches


START = Model(dict(CENTRE), (), {})


def in_full(benches, sigma=SIGMA):
    """Design, data and prior precision of all numbers, shared ones first, per scale."""
    g, own = len(SHARED), benches[0].matrix.shape[1] - len(SHARED)
    design = np.zeros((SIZE * len(benches), g + own * len(benches)))
    for k, bench in enumerate(benches):
        rows = slice(k * SIZE, (k + 1) * SIZE)
        design[rows, :g] = bench.matrix[:, :g]
        design[rows, g + k * own : g + (k + 1) * own] = bench.matrix[:, g:]
    data = np.concatenate([bench.measured for bench in benches])
    each = np.tile((OWN_SCALES / OWN_SIGMAS)[:own] ** 2, len(benches))
    prior = np.concatenate([(SCALES / [f.sigma for f in SHARED]) ** 2, each])
    return design, data, prior
