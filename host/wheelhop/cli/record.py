"""`wheelhop record`: write what a logger streams, and show it."""

from argparse import Namespace
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

from wheelhop.calibration import examine
from wheelhop.cli.record_view import View
from wheelhop.logger import LoggerError, read_log
from wheelhop.logger.live import Live
from wheelhop.logger.log import log_name
from wheelhop.logger.record import RecordOptions, RecordResult, record

INCOMPLETE = 1


def run(arguments: Namespace) -> int:
    """Record until interrupted or the time is over; raises LoggerError.

    The exit status is 1 where scans are missing from a file, or nothing was recorded.
    """
    options = RecordOptions(
        out=arguments.out,
        port=arguments.port,
        baud=arguments.baud,
        start=arguments.start,
        seconds=arguments.seconds,
    )
    live = Live()
    with ExitStack() as stack:
        view = stack.enter_context(View())
        if arguments.plot:
            from wheelhop.logger.live import LivePlot

            plot = stack.enter_context(LivePlot(live, arguments.plot_port))
            view.say(f"plot: {plot.url}")
        result = record(options, live, view.show)
        view.show(live)
    return _tell(result)


def sensor_findings(file: Path) -> Iterator[str]:
    """What is wrong with the sensors, as far as the recording tells: there may be time to mend it.

    A recording too damaged to be examined says so in `wheelhop info`.
    """
    try:
        recording = read_log(file).recording()
    except LoggerError:
        return
    for finding in examine(recording).findings:
        who = ", ".join(finding.channels) or "all channels"
        yield f"{who}: {finding.what} ({finding.sure}); {finding.remedy}"


def _tell(result: RecordResult) -> int:
    for one in result.files:
        missing = f", {one.lost} missing" if one.lost else ", none missing"
        print(f"{one.path}: {one.written} scans{missing}")
        if one.card is None and one.session >> 16:
            print(
                "  the end of the session was not heard; the card's file:"
                f" wheelhop download {log_name(one.session)}"
            )
        elif one.card and one.card[2] < one.lost:
            words = f"all but {one.card[2]}" if one.card[2] else "all of them"
            print(f"  the card has {words}: wheelhop download {log_name(one.session)}")
        for finding in sensor_findings(one.path):
            print(f"  {finding}")
    if result.clock:
        clock = result.clock
        print(f"clock error {clock.ppm:+.0f} ± {2 * clock.deviation_ppm:.0f} ppm, stored")
    if not result.files:
        print("nothing was recorded")
    return INCOMPLETE if not result.files or any(one.lost for one in result.files) else 0
