"""What the struts of a model do in its runs: how far each is extended, and the force in it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from wheelhop.simulate.abreast import integrate_jobs
from wheelhop.simulate.model import Model
from wheelhop.simulate.run import RunSimulator
from wheelhop.vehicle import Drive, Reading, System, body_inertia, struts

Array = NDArray[np.float64]


def strut_motion(model: Model, simulators: Sequence[RunSimulator]) -> list[tuple[Array, Array]]:
    """Travel, m, and force, N, of every strut at the samples of each run, (n, struts) both.

    Both count at the wheel, from the static position, and are positive in extension. The force is
    that of the spring, the damper and all laws that act along the strut. Each sample is a mean over
    the campaign's averaging window; neither the recorder's filter nor a fault of a sensor acts.
    """
    systems = {drive: _showing_struts(model, drive) for drive in {s.drive for s in simulators}}
    asked = [(s, systems[s.drive]) for s in simulators]
    jobs = [(s, s.job(model, system, s.stride(model, system))) for s, system in asked]
    integrate_jobs(jobs)
    found = []
    for simulator, job in jobs:
        assert job.acceleration is not None
        shown = simulator.at_samples(job.acceleration, job.per_sample)
        found.append((shown[:, 0::2], shown[:, 1::2]))
    return found


def _showing_struts(model: Model, drive: Drive) -> System:
    """The mechanism with two outputs for every strut: its travel and its force."""
    parts = model.parts((), drive)
    for strut in struts(model.values):
        parts.add_output(Reading("displacement", strut.row))
        parts.add_output(Reading("force", strut.row))
    return parts.system(body_inertia(model.values))
