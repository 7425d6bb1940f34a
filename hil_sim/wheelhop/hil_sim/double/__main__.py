"""`python -m wheelhop.hil_sim.double`: an emulated logger, on a pseudo-terminal or on TCP."""

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from wheelhop.files import InputError
from wheelhop.hil_sim.double.codes import from_campaign
from wheelhop.hil_sim.double.faults import DoubleFaults
from wheelhop.hil_sim.double.serial_double import SerialDouble

BAD_INPUT = 2


def main(argv: Sequence[str] | None = None) -> int:
    """Serve until interrupted; the exit status is 0, 2 for bad input."""
    arguments = _parser().parse_args(argv)
    try:
        return _serve(arguments)
    except KeyboardInterrupt:
        return 0
    except InputError as error:
        line = str(error)
    except OSError as error:
        line = f"{error.filename or arguments.tcp}: {error.strerror}"
    print(f"wheelhop.hil_sim.double: {line}", file=sys.stderr)
    return BAD_INPUT


def _serve(arguments: argparse.Namespace) -> int:
    signals = None
    if arguments.campaign:
        signals = from_campaign(arguments.campaign, arguments.run or "")
    faults = DoubleFaults(
        noise=arguments.noise,
        disconnects=tuple(arguments.disconnect),
        resets=tuple(arguments.reset),
        stalls=dict(arguments.stall),
        garbled=arguments.garbled,
    )
    options = {"factor": arguments.factor, "clock_ppm": arguments.clock_ppm}
    with SerialDouble(
        signals, arguments.card, faults, port=arguments.tcp, link=arguments.link, **options
    ) as double:
        print(f"serial port {double.url}", flush=True)
        end_s = time.monotonic() + (arguments.seconds or float("inf"))
        while time.monotonic() < end_s:
            time.sleep(min(0.2, max(end_s - time.monotonic(), 0.0)))
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="wheelhop.hil_sim.double", description=__doc__)
    add = parser.add_argument
    add("--campaign", metavar="FOLDER", type=Path, help="what the sensors feel (default: sines)")
    add("--run", metavar="ID", help="the run of that campaign")
    add("--card", metavar="FOLDER", type=Path, help="folder that is the card (default: no card)")
    add("--tcp", metavar="PORT", type=int, help="be there as socket://127.0.0.1:PORT (0: any)")
    add("--link", metavar="FILE", type=Path, help="name for the pseudo-terminal")
    add("--factor", metavar="X", type=float, default=1.0, help="times faster than real time")
    add("--clock-ppm", metavar="X", type=float, default=0.0, help="error of the logger's clock")
    add("--seconds", metavar="S", type=float, help="end after so long")
    add("--noise", metavar="P", type=float, default=0.0, help="chance of a wrong bit in a byte")
    add("--garbled", action="store_true", help="be heard at a wrong speed")
    add("--reset", metavar="S", type=float, action="append", default=[], help="restart then")
    add("--disconnect", metavar="S:FOR", type=_pair, action="append", default=[], help="no line")
    add("--stall", metavar="BLOCK:S", type=_stall, action="append", default=[], help="busy card")
    return parser


def _pair(text: str) -> tuple[float, float]:
    first, second = text.split(":")
    return float(first), float(second)


def _stall(text: str) -> tuple[int, float]:
    block, seconds = _pair(text)
    return int(block), seconds


if __name__ == "__main__":
    sys.exit(main())
