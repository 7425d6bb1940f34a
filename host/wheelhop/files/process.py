"""How processes of our own are started: with the modules that this process would find."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

SAFE_PATH = "PYTHONSAFEPATH"


@contextmanager
def away_from_here() -> Iterator[None]:
    """Processes that multiprocessing starts within the block take no module from the folder we are
    in, a campaign's perhaps: their `python -c` would look there first, for `pickle.py` say."""
    before = os.environ.get(SAFE_PATH)
    os.environ[SAFE_PATH] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[SAFE_PATH]
        else:
            os.environ[SAFE_PATH] = before
