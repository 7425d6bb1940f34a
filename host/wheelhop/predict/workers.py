"""What computes the points of a sweep: processes on this machine, or a Dask cluster."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from importlib import import_module
from multiprocessing import get_context, parent_process
from threading import Thread
from typing import Any

from wheelhop.campaign import CampaignError
from wheelhop.fit.bench import processors

ANSWERS_S = 10.0
"""So long a cluster has to answer."""


def workers(jobs: int | None = None) -> ProcessPoolExecutor:
    """One process for each processor, started afresh, as threads do not survive a fork."""
    return ProcessPoolExecutor(jobs or processors(), get_context("spawn"), _end_with_parent)


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """The workers of the Dask scheduler at an address, such as "tcp://10.0.0.5:8786".

    A point whose worker is lost is computed by another. The workers need the same wheelhop, and
    surveys and effects of one's own under the same paths. Raises CampaignError, one line, where
    nothing answers, and where the workers cannot compute.
    """
    try:
        dask: Any = import_module("distributed")
    except ImportError:
        raise CampaignError(
            f"--cluster {address}: Dask is not installed: pip install 'wheelhop[cluster]'"
        ) from None
    try:
        client = dask.Client(address, timeout=ANSWERS_S, set_as_default=False)
    except (OSError, ValueError) as error:
        reason = str(error).partition("\n")[0]
        raise CampaignError(f"--cluster {address}: no Dask scheduler answers: {reason}") from None
    with client:
        if not client.scheduler_info()["workers"]:
            raise CampaignError(f"--cluster {address}: has no workers: start dask worker {address}")
        try:
            yield client.get_executor(pure=False)
        except ImportError as error:
            raise CampaignError(
                f"--cluster {address}: a worker cannot compute: {error}: install wheelhop on all"
            ) from None
        except dask.KilledWorker as error:
            reason = str(error).partition("\n")[0]
            raise CampaignError(
                f"--cluster {address}: {reason}: the same command goes on from here"
            ) from None


def _end_with_parent() -> None:
    """A parent that is killed cannot end its workers: they watch for it themselves. Ctrl-C is the
    parent's alone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()
    if parent is not None:

        def watch() -> None:
            parent.join()
            os._exit(1)

        Thread(target=watch, daemon=True).start()
