"""What computes the points of a sweep: processes on this machine."""

from __future__ import annotations

import os
import signal
import sys
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from threading import Thread
from typing import Any

from wheelhop.files import away_from_here
from wheelhop.fit.bench import processors


class Workers(ProcessPoolExecutor):
    """Processes of this machine, started afresh, as threads do not survive a fork. Where the block
    they work for fails, and where this process is killed, they end at once."""

    def __init__(self, jobs: int) -> None:
        context = get_context("spawn")
        watched, self._held = context.Pipe(duplex=False)
        with away_from_here():  # what keeps track of its semaphores is a process, too
            super().__init__(jobs, context, _end_with, (watched,))

    def submit(self, *work: Any, **options: Any) -> Future[Any]:
        """As any executor. A Ctrl-C is the parent's alone, also while a process starts."""
        with away_from_here():
            if sys.platform == "win32":
                return super().submit(*work, **options)
            before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
            try:
                return super().submit(*work, **options)  # a process it starts inherits the mask
            finally:
                signal.pthread_sigmask(signal.SIG_SETMASK, before)

    def __exit__(self, kind: type[BaseException] | None, *what: Any) -> None:
        """Wait for the work, unless the block has failed."""
        if kind is not None:
            self._held.close()
        super().__exit__(kind, *what)


def workers(jobs: int | None = None) -> Workers:
    """One process for each processor."""
    return Workers(jobs or processors())


def _end_with(watched: Connection) -> None:
    """Nobody else ends a worker whose parent was killed: it watches for the pipe to be closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        with suppress(EOFError, OSError):
            watched.recv()
        os._exit(1)

    Thread(target=watch, daemon=True).start()
