"""How long a test waits for what must come: a limit on a hang, never a measure of speed."""

import time
from collections.abc import Callable

PATIENCE_S = 600.0  # a machine that does ten other things, too, needs a tenth of it


def wait_until(holds: Callable[[], object]) -> None:
    """Return as soon as `holds()` does; fail where it never does."""
    end_s = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < end_s, "what was waited for has not come"
        time.sleep(2e-3)
