"""A Dask cluster: its workers compute with the very same wheelhop, or get no work."""

from __future__ import annotations

import logging
import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, Future
from contextlib import contextmanager
from importlib import import_module
from threading import Event, Lock, Thread
from typing import Any

from wheelhop.campaign import CampaignError
from wheelhop.files import require
from wheelhop.predict.identity import identity

ANSWERS_S = 10.0
"""So long a cluster has to answer."""
LOOKS_S = 1.0
"""Between two looks at who works."""
WAITS_LOOKS = 60
"""So many looks in a row may find nobody: a worker that has died is started anew by its nanny."""
GOES_ON = "what is finished is kept, and the same command goes on from here"


@contextmanager
def cluster(
    address: str, progress: Callable[[str], None] = lambda text: None
) -> Iterator[Executor]:
    """The workers of the Dask scheduler at an address, such as "tcp://10.0.0.5:8786".

    A point whose worker is lost is computed by another. The workers need the same wheelhop: each is
    asked for its `identity` before it gets work. `progress` is told when there are none left.
    Raises CampaignError, one line, where nothing answers, where a worker computes with another
    wheelhop or with none, and where the scheduler or all workers are lost.
    """
    place = f"--cluster {address}"
    with _connected(address, place) as client:
        working = _Cluster(client, address, place, progress)
        try:
            yield working
        except CancelledError:
            raise working.over or CampaignError(
                f"{place}: the scheduler has ended: {GOES_ON}"
            ) from None
        except ImportError as error:
            raise CampaignError(
                f"{place}: a worker cannot compute: {error}: install wheelhop on all"
            ) from None
        except import_module("distributed").KilledWorker as error:
            reason = str(error).partition("\n")[0]
            raise CampaignError(f"{place}: {reason}: {GOES_ON}") from None
        finally:
            working.shutdown(wait=False)


def _connected(address: str, place: str) -> Any:
    require("distributed", place, "cluster", CampaignError)
    dask: Any = import_module("distributed")
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL)  # what is wrong is told by us
    try:
        dask.comm.resolve_address(address)  # a client for what is no address cannot be closed
        return dask.Client(address, timeout=ANSWERS_S, set_as_default=False)
    except ValueError as error:
        reason = f"{error}: write it as tcp://HOST:PORT"
    except OSError as error:
        reason = str(error).partition("\n")[0]
    raise CampaignError(f"{place}: no Dask scheduler answers: {reason}")


class _Cluster(Executor):
    """The workers, looked at once a second: `over` is why they get no more work."""

    def __init__(
        self, client: Any, address: str, place: str, progress: Callable[[str], None]
    ) -> None:
        self.over: CampaignError | None = None
        self._client, self._address, self._place = client, address, place
        self._progress = progress
        self._known: set[str] = set()
        self._nobody = 0
        self._inner: Executor = client.get_executor(pure=False)
        self._look()
        if not self._known:
            raise CampaignError(f"{place}: has no workers: start dask worker {address}")
        self._ended, self._changing = Event(), Lock()
        Thread(target=self._watch, daemon=True).start()

    def submit(self, work: Callable[..., Any], /, *args: Any, **options: Any) -> Future[Any]:
        """As any executor; what is to be done is unpacked after the worker has said who it is."""
        packed = pickle.dumps((work, args, options))
        with self._changing:
            if self.over is not None:
                raise self.over
            return self._inner.submit(compute, identity(), packed)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the watch; without `wait`, what has not been computed is not computed."""
        self._ended.set()
        self._inner.shutdown(wait)

    def _watch(self) -> None:
        while not self._ended.wait(LOOKS_S):
            try:
                self._look()
            except CampaignError as error:
                with self._changing:
                    self.over = error
                    self._inner.shutdown(wait=False)  # who waits for a result is told
                return
            except OSError:
                return  # a client that has lost its scheduler cancels everything itself

    def _look(self) -> None:
        """Ask those who have come who they are. Raises CampaignError if one computes with another
        wheelhop, and if there has been nobody for too long."""
        there = set(self._client.nthreads())
        self._nobody = 0 if there else self._nobody + 1
        if self._nobody > WAITS_LOOKS:
            raise CampaignError(
                f"{self._place}: no worker is left: start dask worker {self._address}; {GOES_ON}"
            )
        if self._nobody and self._known:
            self._progress(f"no worker is left: {WAITS_LOOKS * LOOKS_S:.0f} s are given for one")
        new = sorted(there - self._known)
        said = self._client.run(identity, workers=new, on_error="return") if new else {}
        others = [
            f"worker {name} has {_words(answer)}"
            for name, answer in sorted(said.items())
            if answer != identity() and not isinstance(answer, OSError)  # that one has just left
        ]
        if others:
            raise CampaignError(
                f"{self._place}: {', '.join(others)}; this computer has {_words(identity())}:"
                " install the same on all, and start the workers anew"
            )
        self._known |= {name for name, answer in said.items() if answer == identity()}


def compute(asked: str, packed: bytes) -> Any:
    """What a worker does. Raises CampaignError where its wheelhop is not the one `asked` for: it
    may have come since the last look."""
    if identity() != asked:
        name = import_module("distributed").get_worker().address
        raise CampaignError(
            f"--cluster: worker {name} has {_words(identity())}; asked for was {_words(asked)}:"
            " install the same on all, and start the workers anew"
        )
    work, args, options = pickle.loads(packed)
    return work(*args, **options)


def _words(answer: object) -> str:
    return f"wheelhop {answer}" if isinstance(answer, str) else f"no such wheelhop ({answer})"
