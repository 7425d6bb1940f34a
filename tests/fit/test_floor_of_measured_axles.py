"""The floor where measured axles drive the model: what the truest model leaves, and no fit less."""

from dataclasses import replace

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import ATV, CHANNELS, campaign_of
from wheelhop.campaign import TrackSpec
from wheelhop.compare import compare
from wheelhop.fit import Workshop, fit, vehicle_parameters
from wheelhop.simulate import Model
from wheelhop.vehicle import Vehicle

SAMPLES, RATE_HZ, NOISE = 1024, 100.0, 0.1
BASICS = {1.3: 3.0, 2.1: 1.0, 3.4: 2.0}
"""Of each run's track, Hz, and the amplitude of every harmonic, m/s²: all stay below half the
sample rate, so that nothing is folded, while the upper octave is full of lines."""


def of_axles(basic_hz, amplitude, rng):
    time = np.arange(SAMPLES) / RATE_HZ
    order = np.arange(1, int(49.0 / basic_hz))
    phase = 2.0 * np.pi * rng.random((len(order), 4))
    angle = 2.0 * np.pi * basic_hz * np.outer(time, order)
    return amplitude * np.sin(angle[:, :, None] + phase).sum(axis=1)


@pytest.fixture(scope="module")
def drawn():
    """A linear vehicle driven by axles whose motion is known; white noise on every sensor."""
    rng = np.random.default_rng(5)
    time = np.arange(SAMPLES) / RATE_HZ
    run = truth.Run(truth.Track("flat", {}), 4.0, 0.0, time)
    axles = [i for i, channel in enumerate(CHANNELS) if channel.is_axle]
    records = {}
    for basic_hz, amplitude in BASICS.items():
        records[f"{basic_hz}"] = np.zeros((SAMPLES, 8))
        records[f"{basic_hz}"][:, axles] = of_axles(basic_hz, amplitude, rng)
    campaign = campaign_of(dict.fromkeys(records, run), records, noise_rms=NOISE)
    unknown = TrackSpec("unknown", {})
    campaign = replace(campaign, runs=tuple(replace(r, track=unknown) for r in campaign.runs))
    model = Model(dict(ATV), (), {name: {} for name in records})
    quiet = Workshop(campaign, model, jobs=1)
    white = NOISE / np.sqrt((30.0 - 0.5) / 50.0)
    runs = []
    for bench in quiet.benches.values():
        body = bench.simulator.record(model, quiet.systems(model)["axles"])
        record = np.where(bench.predicted, body, bench.run.record)
        runs.append(replace(bench.run, record=record + white * rng.normal(size=record.shape)))
    campaign = replace(campaign, runs=tuple(runs))
    return campaign, model, Workshop(campaign, model, jobs=1)


def floor_of(campaign, workshop, model):
    return compare(campaign, workshop.responses(model)).floor


def test_the_true_model_leaves_the_floor(drawn):
    campaign, model, workshop = drawn
    found = fit(workshop, model, (), workshop.of_role("fit"))
    floor = floor_of(campaign, workshop, found.model)
    spent = sum(run.freedom for run in found.runs) / found.size
    sampling = np.sqrt(0.5 / found.size)  # relative, on amplitudes
    assert found.error / np.sqrt(1.0 - spent) == pytest.approx(floor.error, rel=3.0 * sampling)
    assert floor.expected > floor.error  # what may be folded is not known, and so no bound


def test_no_fit_undercuts_the_floor_by_more_than_its_degrees_of_freedom(drawn):
    campaign, model, workshop = drawn
    free = tuple(vehicle_parameters(campaign, Vehicle("", dict(ATV), dict.fromkeys(ATV, 0.1))))
    found = fit(workshop, model, free, workshop.of_role("fit"))
    floor = floor_of(campaign, workshop, found.model)
    spent = (len(free) + sum(run.freedom for run in found.runs)) / found.size
    sampling = np.sqrt(0.5 / found.size)
    assert found.error > floor.error * np.sqrt(1.0 - spent) * (1.0 - 3.0 * sampling)
    assert found.error < floor.error * (1.0 + 3.0 * sampling)
