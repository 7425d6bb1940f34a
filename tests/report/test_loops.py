"""The loops of a rig's report, on rigs that share no code."""

import numpy as np
import pytest

from tests.component import rig
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import fit_baseline
from wheelhop.diagnose.search.look import step_of
from wheelhop.report.cases import records_of
from wheelhop.report.loops import _moved, loop_of, loops_figure, shown_runs
from wheelhop.report.sections import loops
from wheelhop.report.stretch import seconds_of
from wheelhop.vehicle import read_nominal


@pytest.fixture(scope="module", params=["displacement", "force"])
def fitted(request, tmp_path_factory):
    drive = request.param
    component = rig.Component(0.0 if drive == "displacement" else 5.0, 20000.0, 300.0)
    folder = tmp_path_factory.mktemp(drive) / "c"
    campaign = read_campaign(rig.make_campaign(folder, drive, component, seed=1, noise=0.003))
    base = fit_baseline(campaign, read_nominal(campaign), progress=lambda text: None)
    return campaign, step_of(base.workshop, base.rung)


def test_the_loops_are_those_of_spring_and_damper(fitted):
    """The inertia of what is moved by a force is no part of its law."""
    campaign, step = fitted
    run = shown_runs(campaign)[0]
    record = records_of(step.rung)[run.id]
    mass = step.rung.model.values["component.mass_kg"]
    for answer in (record.measured, record.model):
        x, v, force = loop_of(campaign, run, record, answer, mass)
        basis = np.stack([x, v, np.ones_like(x)], axis=1)
        stiffness, damping, _ = np.linalg.lstsq(basis, force, rcond=None)[0]
        assert stiffness == pytest.approx(20000.0, rel=0.03)
        assert damping == pytest.approx(300.0, rel=0.05)


def test_they_stand_in_the_report_of_a_rig_alone(fitted):
    campaign, step = fitted
    assert "smallest travel" in loops(campaign, [step])
    assert len(loops_figure(campaign, [step]).axes) == 2 * len(shown_runs(campaign))


@pytest.mark.parametrize("frequency_hz", [2.0, 70.0])
def test_a_stretch_is_as_long_as_its_waves(frequency_hz):
    signal = 3.0 + np.sin(2 * np.pi * frequency_hz * np.arange(2000) / 400.0)
    assert seconds_of(signal, 400.0, 25) == pytest.approx(25 / frequency_hz)


def test_a_record_that_ends_elsewhere_does_not_ring():
    """A carriage that travels 250 mm and moves on: its speed and acceleration, ends included."""
    time_s = np.arange(5000) / 250.0
    turn = 2.0 * np.pi * 0.33
    x = 0.012 * time_s + 0.02 * np.sin(turn * time_s)
    _, v, a = _moved(x, 250.0, 30.0)
    finer = np.arange(len(v)) / 1000.0
    assert np.abs(v - 0.012 - 0.02 * turn * np.cos(turn * finer)).max() < 0.1 * v.max()
    inside = slice(200, -200)  # less a fifth of a second
    expected = -0.02 * turn**2 * np.sin(turn * finer)
    assert np.abs(a - expected)[inside].max() < 0.1 * expected.max()
