"""An emulated logger that the host's programs find by themselves, with the sessions of a day."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from wheelhop.hil_sim.day import read_day
from wheelhop.hil_sim.double.serial_double import SerialDouble
from wheelhop.hil_sim.rehearsal import rehearsal
from wheelhop.hil_sim.signals import Signals
from wheelhop.logger.emulated import announced

TCP = 0 if sys.platform == "win32" else None  # any free port, where there are no pseudo-terminals

Acts = tuple[tuple[str, Signals], ...]


@contextmanager
def emulated_logger(
    card: Path | None, factor: float, acts: Acts = ()
) -> Iterator[tuple[SerialDouble, Acts]]:
    """The double while the block runs, and what happens in its sessions, in words and signals:
    `acts`, or those of a day in the field.

    Its time runs `factor` times faster; `card` is a folder, None: one that is gone at the end.
    Raises LoggerError if another emulated logger is there already.
    """
    acts = acts or rehearsal(read_day())
    with ExitStack() as stack:
        if card is None:
            card = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="wheelhop-card-")))
        signals = [signals for _, signals in acts]
        double = stack.enter_context(
            SerialDouble(signals[-1], card, acts=signals, factor=factor, port=TCP)
        )
        stack.enter_context(announced(double.url))
        yield double, acts
