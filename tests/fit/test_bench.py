"""The bench: work for all runs in parallel threads."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from threading import Barrier, Event, current_thread
from time import sleep

import numpy as np
import pytest

from tests import truth
from tests.fit import test_component
from tests.patience import PATIENCE_S
from tests.simulate.setup import ATV, campaign_of, model_of
from wheelhop.campaign import TrackSpec
from wheelhop.fit import Workshop
from wheelhop.fit.bench import processors
from wheelhop.fit.spread import cost
from wheelhop.simulate import Model

CLEAN = Path(__file__).parents[2] / "examples/clean"
NESTED = """
import sys
from wheelhop.campaign import read_campaign
from wheelhop.fit import Workshop, initial_model
from wheelhop.vehicle import read_nominal

campaign = read_campaign(sys.argv[1], skip=set(sys.argv[2:]))
workshop = Workshop(campaign, initial_model(campaign, read_nominal(campaign)), jobs=2)
print(workshop.each(lambda i: sum(workshop.each(lambda j: i * j, [1, 2, 3])), [1, 2, 3]))
"""


def test_work_that_asks_for_work_does_not_wait_for_itself():
    """Both threads at once need a third: none is free until they are done."""
    skipped = sorted(path.stem for path in (CLEAN / "runs").glob("*.csv"))[2:]
    command = [sys.executable, "-c", NESTED, str(CLEAN), *skipped]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.stdout == "[6, 12, 18]\n", done.stderr


UNKNOWN = TrackSpec("unknown", {})
NOISE, SIZE = 0.1, 512
RECORD = np.random.default_rng(1).normal(size=(SIZE, 8))


def campaign_with(noise_rms=NOISE):
    """A run on a road and one of which nobody knows the road, held out."""
    run = truth.Run(truth.Track("flat", {}), 4.0, 0.0, np.arange(SIZE) / 100.0)
    campaign = campaign_of({"run": run}, {"run": RECORD}, noise_rms=noise_rms)
    (driven,) = campaign.runs
    held_out = replace(driven, id="held out", role="validate", track=UNKNOWN)
    return replace(campaign, runs=(driven, held_out))


MODEL = model_of(ATV, {}).with_run("run", {"speed_m_s": 4.0, "start_m": 0.0})


def workshop_of(noise_rms=NOISE, **given):
    return Workshop(campaign_with(noise_rms), MODEL, **given)


@pytest.fixture(scope="module")
def workshop():
    return workshop_of(jobs=2)


def test_noise_of_the_stated_size_has_it_in_every_coefficient(workshop):
    """White in band, with the stated rms there."""
    band = workshop.benches["run"].band
    white = np.random.default_rng(2).normal(size=band.count)
    signal = band.from_coefficients(white * workshop.noise)
    assert signal.std() == pytest.approx(NOISE, rel=0.1)
    assert workshop_of(noise_rms=None).noise == 0.0
    other = Workshop(campaign_with(), MODEL, noise_rms=2.0 * NOISE)
    assert other.noise == pytest.approx(2.0 * workshop.noise)


def test_only_measured_axles_are_doubted(workshop):
    """Of them the axles themselves are not predicted."""
    road, axles = workshop.benches["run"], workshop.benches["held out"]
    assert (road.doubt == 1.0).all() and axles.doubt[:, axles.predicted].min() > 1.0
    assert road.predicted.all() and axles.predicted.sum() == 4
    assert (workshop_of(noise_rms=None).benches["held out"].doubt == 1.0).all()
    assert [bench.run.id for bench in workshop.of_role("validate")] == ["held out"]
    assert workshop.astray.keys() == {"held out"}
    assert workshop_of(noise_rms=None).astray == {}
    responses = workshop.responses(MODEL)
    assert responses[1].doubt is axles.doubt and responses[0].doubt is not road.doubt
    assert responses[1].noise_ratio is axles.noise_ratio and responses[0].noise_ratio is None
    heard = axles.predicted
    assert (axles.noise_ratio[:, heard] <= axles.doubt[:, heard]).all()
    assert axles.noise_ratio[:, heard].min() > 1.0


@pytest.mark.parametrize("name", ["run", "held out"])
def test_a_residual_is_what_was_measured_less_what_is_modelled_per_doubt(workshop, name):
    bench = workshop.benches[name]
    systems = workshop.systems(MODEL)
    assert bench.size == bench.band.count * bench.predicted.sum()
    recorded = bench.band.coefficients(RECORD[:, bench.predicted])
    modelled = bench.band.coefficients(
        bench.simulator.record(MODEL, systems[bench.drive])[:, bench.predicted]
    )
    left = (recorded - modelled).ravel()
    residual = bench.residual(MODEL, systems)
    np.testing.assert_allclose(residual * bench.doubt[:, bench.predicted].ravel(), left, atol=1e-9)
    np.testing.assert_allclose(bench.undoubted(residual), left, atol=1e-9)
    assert bench.energy == pytest.approx(float((recorded**2).sum()))


def test_each_channel_has_a_noise_of_its_own(workshop):
    bench = workshop.benches["run"]
    size = np.arange(1.0, 9.0) * 10.0
    residual = (np.ones((bench.band.count, 1)) * size).ravel()
    spread = bench.spread(residual, 1.0).reshape(bench.band.count, -1)
    np.testing.assert_allclose(spread, np.tile(size, (bench.band.count, 1)), rtol=0.02)
    alone = sum(cost(np.full((bench.band.count, 1), s), 1.0) for s in size)
    assert bench.cost(residual, 1.0) == pytest.approx(alone)


def test_a_run_begins_before_its_record_and_is_remembered_for_four_time_constants(workshop):
    """Of the seven between both, which are whole steps."""
    bench = workshop.benches["run"]
    lead = bench.simulator.setting.record_start_s - bench.simulator.setting.start_s
    assert lead > 0.5
    assert bench.memory_s == pytest.approx(4.0 / 7.0 * lead, rel=0.03)
    for earlier, given in ((1.0, ()), (2.0, (2.0,))):
        setting = workshop.bench(bench.run, *given).simulator.setting
        assert setting.record_start_s - setting.start_s == pytest.approx(earlier * lead, rel=0.03)


def test_what_hangs_on_a_rig_has_nothing_to_forget():
    campaign = test_component.campaign_of(test_component.run_of(1, "force"))
    values = {f"component.{key}": value for key, value in test_component.TRUE.items()}
    (bench,) = Workshop(campaign, Model(values), jobs=1).benches.values()
    assert bench.memory_s == 0.0


def test_as_many_threads_work_as_are_asked_for():
    """Three at once meet; one thing alone is done where it was asked for."""
    together = Barrier(3, timeout=PATIENCE_S)
    at_once = workshop_of(jobs=3)
    assert sorted(at_once.each(lambda i: together.wait(), range(3))) == [0, 1, 2]
    pair = Barrier(2, timeout=PATIENCE_S)
    assert sorted(at_once.each(lambda i: pair.wait(), range(2))) == [0, 1]
    assert at_once.each(lambda i: current_thread(), [1]) == [current_thread()]


def test_processors_are_those_this_process_may_use(monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(
        os, "sched_getaffinity", lambda process: {3, 5} if process == 0 else {1}, raising=False
    )
    monkeypatch.setattr(os, "cpu_count", lambda: 64)
    assert processors() == 2
    monkeypatch.setattr(sys, "platform", "darwin")
    assert processors() == 64
    monkeypatch.setattr(os, "cpu_count", lambda: None)  # the system doesn't say
    assert processors() == 1


def test_while_one_batch_is_looked_at_the_threads_are_at_the_next(workshop):
    """And no further ahead: of the others nothing is made yet."""
    begun, asked = [Event() for _ in range(4)], []

    def squared(i):
        begun[i].set()
        return i * i

    def batches():
        for i in range(4):
            asked.append(i)
            yield [i, i]

    for i, found in enumerate(workshop.in_turn(squared, batches())):
        assert found == [i * i, i * i]
        assert asked == [*range(min(i + 2, 4))]
        assert all(begun[k].wait(PATIENCE_S) for k in asked)


def test_a_run_is_not_worked_on_by_two_threads_at_once(workshop):
    """Its simulator keeps what it was last asked for."""
    busy, met = set(), []

    def occupied(item):
        run, batch = item
        met.append(run in busy)
        busy.add(run)
        sleep(0.001 * (3 - batch % 3))
        busy.discard(run)
        return batch

    found = list(workshop.in_turn(occupied, ([("a", i), ("b", i)] for i in range(20))))
    assert found == [[i, i] for i in range(20)]
    assert not any(met)


def test_a_batch_that_fails_stops_those_behind_it(workshop):
    """As does a caller who has seen enough."""
    done, told = [], Event()

    def inverse(i):
        done.append(i)
        if i == 9:
            told.wait(PATIENCE_S)
        return 1.0 / i

    with pytest.raises(ZeroDivisionError):
        list(workshop.in_turn(inverse, [[0, *[9] * 39], [1] * 40, [2] * 40]))
    told.set()
    workshop.each(str, [3, 3])  # the threads have come to what was asked for last
    assert 2 not in done and len(done) < 40  # and left out the rest of the batch itself, too
    first = next(workshop.in_turn(inverse, [[4], [5], [6]]))
    assert first == [0.25] and 6 not in done
