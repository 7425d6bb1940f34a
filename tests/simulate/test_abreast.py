"""Runs side by side: each does what it does alone, however long the others are."""

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import ATV, CHANNELS, campaign_of, model_of
from wheelhop.fit import Workshop
from wheelhop.simulate import RunSimulator, abreast
from wheelhop.simulate.abreast import integrate_jobs, shared_out

SHARP = truth.Track("washboard", {"amplitude_mm": 40.0, "pitch_mm": 600.0})
ROUND = truth.Track("herringbone", {"amplitude_mm": 20.0, "pitch_mm": 800.0})
RUNS = {
    f"run-{i}": truth.Run(track, 3.0 + 0.3 * i, 20.0 + i, np.arange(rows) / 100.0)
    for i, (track, rows) in enumerate([(ROUND, 256), (ROUND, 300), (SHARP, 256), (ROUND, 256)])
}
CAMPAIGN = campaign_of(RUNS)
FRICTION = {"front_N": 60.0, "rear_N": 40.0, "presliding_N_m": 5e5}
MODELS = {
    "linear": model_of(ATV, RUNS),
    "a law with memory": model_of(ATV, RUNS, "dry-friction", FRICTION),
    "a sensor's fault": model_of(ATV, RUNS, "sensor-gain", {"error": 0.1}, choice="B2"),
}


def simulators():
    return [RunSimulator(CAMPAIGN, run, 4.0) for run in CAMPAIGN.runs]


@pytest.mark.parametrize("name", MODELS)
def test_each_does_what_it_does_alone(name):
    model = MODELS[name]
    system = model.system(CHANNELS, "road")
    together = simulators()
    jobs = [one.due(model, system) for one in together]
    for part in shared_out(zip(together, jobs, strict=True), 1):
        integrate_jobs(part)
    for one, job, alone in zip(together, jobs, simulators(), strict=True):
        assert len(job.acceleration) == one.samples(job)
        one.keep(job)
        assert one.due(model, system) is None
        assert np.array_equal(one.record(model, system), alone.record(model, system))


def test_runs_are_integrated_once_and_those_of_one_step_together(monkeypatch):
    """Three runs on round tracks, of two lengths, in one call; the sharp one has shorter steps."""
    model = MODELS["linear"]
    workshop = Workshop(CAMPAIGN, model, jobs=1)
    asked, before = [], abreast.integrate

    def counted(tasks, **given):
        asked.append(len(tasks))
        return before(tasks, **given)

    monkeypatch.setattr(abreast, "integrate", counted)
    workshop.responses(model)
    assert sorted(asked) == [1, 3]


@pytest.mark.parametrize(("workers", "sizes"), [(1, [1, 3]), (2, [1, 1, 2]), (8, [1, 1, 1, 1])])
def test_every_worker_gets_a_part(workers, sizes):
    model = MODELS["linear"]
    system = model.system(CHANNELS, "road")
    asked = [(one, one.due(model, system)) for one in simulators()]
    assert sorted(map(len, shared_out(asked, workers))) == sizes
