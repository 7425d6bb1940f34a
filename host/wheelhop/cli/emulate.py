"""`wheelhop emulate`: a logger that is none, for trying out a day in the field."""

from __future__ import annotations

import sys
from argparse import Namespace
from threading import Event

from wheelhop.hil_sim.emulated import emulated_logger
from wheelhop.logger.error import LoggerError


def run(arguments: Namespace) -> int:
    """Serve until Ctrl-C; Enter presses the logger's button. Raises LoggerError."""
    if not 0.01 <= arguments.factor <= 1000.0:
        raise LoggerError(f"--factor {arguments.factor:g}: must be from 0.01 to 1000")
    card = arguments.card
    if card is not None and not card.is_dir():
        raise LoggerError(f"{card}: there is no such folder")
    with emulated_logger(card, arguments.factor) as (double, acts):
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
