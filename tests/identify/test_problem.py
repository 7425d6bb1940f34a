"""The least squares of a transfer matrix: their slopes, and runs taken together or alone."""

from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import read_campaign
from wheelhop.identify import Sections, Structure, measure, suspensions
from wheelhop.identify.gram import Stack
from wheelhop.identify.problem import Problem, Step, reduced
from wheelhop.vehicle import read_vehicle

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def clean():
    campaign = read_campaign(EXAMPLES / "clean")
    vehicle = read_vehicle(campaign.vehicle_file)
    return measure(campaign), suspensions(vehicle.values, vehicle.uncertainty)


def test_the_step_is_the_slope_of_the_cost(clean):
    """Of the cost with the numerators solved for, constraints and suspensions included."""
    measured, belief = clean
    weights = [1.0 / (1.0 + part.omega) for part in measured.fit]
    problem = Problem(
        Stack(measured.fit, weights, 5), Structure(), *(2 * [(0, 1, 2, 3)]), belief,
        np.array([1.0, 2.0, 0.5, 1.0]), 5,
    )  # fmt: skip
    here = problem.start(Sections(np.array([9.0, 30.0]), np.array([0.4, 1.3]), 60.0))
    here[-3:] *= 1.1
    _, gradient = reduced(problem.linearised(problem.at(here)))
    for k in range(len(here)):
        step = 1e-5 * max(abs(here[k]), 0.1) * np.eye(len(here))[k]
        slope = (problem.at(here + step).cost - problem.at(here - step).cost) / (2 * step[k])
        assert -2 * gradient[k] == pytest.approx(slope, rel=1e-3, abs=1e-6 * abs(gradient).max())


def test_runs_side_by_side_are_as_runs_one_after_the_other(clean, monkeypatch):
    """Memory decides how many are taken at once, and it decides nothing else."""
    measured, belief = clean
    alone = [part.only(np.array([i])) for part in measured.fit for i in range(len(part.runs))]
    runs = [*measured.fit, *alone]
    weights = [(1.0 + k) / (1.0 + part.omega) for k, part in enumerate(runs)]
    noise = [1e-4 * weight for weight in weights]

    def step():
        problem = Problem(
            Stack(runs, weights, 5, noise=noise), Structure(), *(2 * [(0, 1, 2, 3)]), belief,
            np.array([1.0, 2.0, 0.5, 1.0]), 5,
        )  # fmt: skip
        poles = Sections(np.array([9.0, 30.0]), np.array([0.4, 1.3]), 60.0)
        point = problem.at(problem.start(poles))
        return len(problem.stack.parts), point, problem.linearised(point)

    few, point, together = step()
    monkeypatch.setattr("wheelhop.identify.gram.CHUNK", 1)
    many, same, apart = step()
    assert few < many == 2 * len(alone)
    np.testing.assert_allclose(point.free, same.free, rtol=1e-6)
    assert point.cost == pytest.approx(same.cost, rel=1e-9)
    np.testing.assert_allclose(together.normal, apart.normal, atol=1e-9 * apart.normal.max())
    largest = np.abs(apart.gradient).max()
    np.testing.assert_allclose(together.gradient, apart.gradient, atol=1e-6 * largest)


def test_an_inexact_elimination_leaves_no_negative_curvature():
    """Numerators that are hardly told apart take more out of a number's column than is in it; no
    descent may see that as curvature below 0."""
    columns = np.random.default_rng(2).normal(size=(60, 8))
    columns = np.column_stack([columns, columns @ np.ones(8)])
    normal = columns.T @ columns
    normal[-1, -1] *= 0.9
    left, _ = reduced(Step(normal, columns.T @ columns[:, 0], np.eye(9), 1))
    assert left[0, 0] == 0.0
