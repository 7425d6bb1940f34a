"""Processes that compute the points of a sweep."""

from __future__ import annotations

import os
import signal
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context, parent_process
from threading import Thread

from wheelhop.fit.workshop import processors


def workers(jobs: int | None = None) -> ProcessPoolExecutor:
    """One process for each processor, started afresh, as threads do not survive a fork."""
    return ProcessPoolExecutor(jobs or processors(), get_context("spawn"), _end_with_parent)


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
