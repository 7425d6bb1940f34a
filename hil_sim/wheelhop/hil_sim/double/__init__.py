"""The serial double: the logger's protocol in Python, for tests and trials without a board.

    with SerialDouble(from_campaign("examples/clean", "sweep"), card="card") as logger:
        print(logger.url)  # wheelhop record --port …

It speaks what `firmware/SPEC.md` says, as the firmware does; `tests/logger/test_conformance.py`
holds both to it. Of the firmware it lacks the HOP.CFG, the LED, the file system and late triggers.
"""

from wheelhop.hil_sim.double.codes import from_campaign
from wheelhop.hil_sim.double.faults import DoubleFaults
from wheelhop.hil_sim.double.scans import scan_sums
from wheelhop.hil_sim.double.serial_double import SerialDouble

__all__ = ["DoubleFaults", "SerialDouble", "from_campaign", "scan_sums"]
