"""`wheelhop emulate`: a logger that is none, for trying out a day in the field."""

from __future__ import annotations

import sys
import tempfile
from argparse import Namespace
from contextlib import ExitStack
from pathlib import Path
from threading import Event

from wheelhop.hil_sim.day import read_day
from wheelhop.hil_sim.double import SerialDouble
from wheelhop.hil_sim.rehearsal import rehearsal
from wheelhop.logger.emulated import announced
from wheelhop.logger.error import LoggerError

TCP = 0 if sys.platform == "win32" else None  # any free port, where there are no pseudo-terminals


def run(arguments: Namespace) -> int:
    """Serve until Ctrl-C; Enter presses the logger's button. Raises LoggerError."""
    if not 0.01 <= arguments.factor <= 1000.0:
        raise LoggerError(f"--factor {arguments.factor:g}: must be from 0.01 to 1000")
    acts = rehearsal(read_day())
    with ExitStack() as stack:
        card = arguments.card
        if card is None:
            card = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="wheelhop-card-")))
        elif not card.is_dir():
            raise LoggerError(f"{card}: there is no such folder")
        double = stack.enter_context(
            SerialDouble(
                acts[-1][1],
                card,
                acts=[signals for _, signals in acts],
                factor=arguments.factor,
                port=TCP,
            )
        )
        stack.enter_context(announced(double.url))
        print(
            f"An emulated logger is at {double.url}; its time runs {arguments.factor:g} times"
            " faster. wheelhop logger, record and download find it by themselves."
        )
        for number, (words, signals) in enumerate(acts, start=1):
            seconds = len(signals.codes) / signals.rate_hz
            print(f"session {number}: {words}; {seconds / arguments.factor:.0f} s")
        print("Enter presses its button: start, stop. Ctrl-C switches it off.", flush=True)
        for _ in sys.stdin:
            double.press_button()
            print("pressed", flush=True)
        Event().wait()  # nobody at the keyboard: until it is interrupted
    return 0
