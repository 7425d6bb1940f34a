"""Jobs of several runs, integrated side by side.

A vector unit does eight mechanisms at the price of one. A fit that tries one model in every run
would leave most lanes empty if each run were integrated by itself.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from wheelhop.campaign import Averaging
from wheelhop.simulate.integrator import Task, integrate
from wheelhop.simulate.job import Job
from wheelhop.simulate.lanes import LANES

if TYPE_CHECKING:
    from wheelhop.simulate.run import RunSimulator

Asked = tuple["RunSimulator", Job]
"""A job and the simulator of its run."""


class Sampling(NamedTuple):
    """How the accelerations of a job are sampled: see `integrate`."""

    step_s: float
    first: int
    stride: int
    averaging: Averaging


def integrate_jobs(asked: Iterable[Asked]) -> None:
    """Integrate jobs, those of one make together: their accelerations are there afterwards."""
    for group in _alike(asked):
        tasks = [simulator.task(job) for simulator, job in group]
        for (simulator, _), task in zip(group, tasks, strict=True):
            simulator.steps += len(task.height)
        samples = [simulator.samples(job) for simulator, job in group]
        steps = max(len(task.height) for task in tasks)
        found = integrate(
            [_longer(task, steps) for task in tasks],
            **group[0][0].sampling(group[0][1])._asdict(),
            n_samples=max(samples),
        )
        for (_, job), acceleration, count in zip(group, found, samples, strict=True):
            job.acceleration = acceleration[:count]


def shared_out(asked: Iterable[Asked], workers: int) -> list[list[Asked]]:
    """Jobs in parts for so many workers: every part of one make, of runs about equally long."""
    parts = []
    for group in _alike(asked):
        group.sort(key=lambda item: item[0].samples(item[1]))
        count = max(-(-len(group) // LANES), min(workers, len(group)))
        ends = [len(group) * i // count for i in range(count + 1)]
        parts += [group[a:b] for a, b in pairwise(ends)]
    return parts


def _alike(asked: Iterable[Asked]) -> list[list[Asked]]:
    groups: dict[object, list[Asked]] = {}
    for simulator, job in asked:
        groups.setdefault((job.make, simulator.sampling(job)), []).append((simulator, job))
    return list(groups.values())


def _longer(task: Task, steps: int) -> Task:
    """The task with its motion going on at rest to so many steps: nothing of what was before
    changes."""
    more = steps - len(task.height)
    if not more:
        return task
    height = np.pad(task.height, ((0, more), (0, 0)), mode="edge")
    rate = np.pad(task.rate, ((0, more), (0, 0)))
    force = np.pad(task.force, ((0, 2 * more), (0, 0)))
    return Task(task.system, height, rate, force, task.initial)
