"""`wheelhop record`: write what a logger streams, and show it."""

from argparse import Namespace
from contextlib import ExitStack

from wheelhop.cli.record_view import View
from wheelhop.logger.live import Live
from wheelhop.logger.record import RecordOptions, RecordResult, log_name, record

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
            from wheelhop.logger.live_plot import LivePlot

            plot = stack.enter_context(LivePlot(live, arguments.plot_port))
            view.say(f"plot: {plot.url}")
        result = record(options, live, view.show)
        view.show(live)
    return _tell(result)


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
    if result.clock:
        clock = result.clock
        print(f"clock error {clock.ppm:+.0f} ± {2 * clock.deviation_ppm:.0f} ppm, stored")
    if not result.files:
        print("nothing was recorded")
    return INCOMPLETE if not result.files or any(one.lost for one in result.files) else 0
