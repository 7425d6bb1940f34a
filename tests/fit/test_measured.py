"""What scales say of a whole car holds its numbers together in a fit."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.fit.test_common_scale import NOISE, RUNS, STATED, heavier
from tests.simulate.setup import ATV, campaign_of, model_of, simulated
from wheelhop.diagnose.verdict.critic import _moved
from wheelhop.diagnose.verdict.numbers import measured_of
from wheelhop.fit import Workshop, fit, vehicle_parameters
from wheelhop.fit.belief import Belief
from wheelhop.vehicle import Measured
from wheelhop.vehicle.measured import measurable


def weighed(values, relative=0.01):
    """All that can be measured of a vehicle with these numbers, to so much."""
    found = {key: Measured(key, 1.0, 1.0).of(values) for key in measurable(values)}
    return tuple(Measured(key, value, relative * value) for key, value in found.items())


AXLES = tuple(m for m in weighed(ATV) if m.key.endswith("axle_kg"))


@given(seed=st.integers(0, 99))
def test_pull_and_precision_of_what_was_measured_are_slopes(seed):
    rng = np.random.default_rng(seed)
    numbers = vehicle_parameters(campaign_of(RUNS), STATED)
    belief, alone = Belief.of(numbers, weighed(ATV)), Belief.of(numbers)
    values = ATV | {f.name: f.mean * np.exp(0.1 * rng.normal()) for f in numbers}
    step = 1e-4 * rng.normal(size=len(numbers))
    there, back = (
        values
        | {f.name: values[f.name] + s * f.scale * d for f, d in zip(numbers, step, strict=True)}
        for s in (1.0, -1.0)
    )
    related = belief.distance(values) - alone.distance(values)
    away = [np.log(m.of(values) / m.value) / m.relative for m in belief.measured]
    assert related == pytest.approx(np.square(away).sum())
    slope = (belief.distance(there) - belief.distance(back)) / 2.0
    assert -2.0 * belief.pull(values) @ step == pytest.approx(slope, rel=1e-3, abs=1e-6)
    matrix = belief.precision_at(values)
    assert belief.log_precision_at(values) == pytest.approx(np.linalg.slogdet(matrix)[1])
    # Whatever is measured besides, nothing is known worse than by itself.
    assert np.all(belief.deviations_at(values) <= alone.deviations_at(values) * (1.0 + 1e-9))


@pytest.fixture(scope="module")
def records():
    rng = np.random.default_rng(1)
    clean = simulated(campaign_of(RUNS), model_of(ATV, RUNS))
    return {k: v + NOISE * rng.normal(size=v.shape) for k, v in clean.items()}


def fitted(records, vehicle, measured):
    campaign, start = campaign_of(RUNS, records, noise_rms=NOISE), model_of(vehicle.values, RUNS)
    workshop = Workshop(campaign, start, measured=measured, jobs=1)
    shared = vehicle_parameters(campaign, vehicle)
    return fit(workshop, start, shared, workshop.of_role("fit"))


def test_scales_tell_the_masses_and_forces_of_a_car_whose_numbers_are_all_stated_too_high(records):
    """Numbers to 10 %, weights to 1 %: what is left is as uncertain as the weights."""
    vehicle = replace(STATED, values=heavier(ATV, 1.15))
    for measured, high, known in (((), 1.15, 0.02), (AXLES, 1.005, 0.01)):
        found = fitted(records, vehicle, measured)
        for name in ("body.mass_kg", "suspension.rear.stiffness_N_m"):
            assert found.model.values[name] == pytest.approx(high * ATV[name], rel=0.02)
            relative = found.uncertainty(name) / found.model.values[name]
            assert relative == pytest.approx(known, rel=0.7)
        for value, sd in found.relations.values():
            assert sd < 0.0101 * value
    assert set(found.relations) == {"measured.front_axle_kg", "measured.rear_axle_kg"}


def test_weights_that_the_records_contradict_are_said_to_be_wrong(records):
    """Where the centre of mass lies shows; both weights by the same factor would not."""
    front, rear = AXLES
    wrong = (replace(front, value=1.5 * front.value, sigma=front.sigma), rear)
    found = fitted(records, STATED, wrong)
    step = SimpleNamespace(rung=SimpleNamespace(fit=found))
    (finding,) = _moved(measured_of(step), [])
    assert finding.kind == "moved" and "measured.front_axle_kg" in finding.about
    right = SimpleNamespace(rung=SimpleNamespace(fit=fitted(records, STATED, AXLES)))
    assert list(_moved(measured_of(right), [])) == []
