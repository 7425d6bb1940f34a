"""`wheelhop sync-check`: are all channels sampled at the same instant?"""

from argparse import Namespace

import numpy as np
from rich.table import Table

from wheelhop.calibration.error import CalibrationError
from wheelhop.calibration.sync.beam_file import read_beam
from wheelhop.calibration.sync.check import SyncCheck, check_synchronicity
from wheelhop.calibration.sync.delay import align
from wheelhop.cli.output import open_console, write_json
from wheelhop.files import check_new
from wheelhop.formats import read, write
from wheelhop.logger.error import LoggerError

NOT_IN_STEP = 1
STYLE = {"pass": "green", "fail": "bold red", "open": "yellow", "not told": "yellow"}


def run(arguments: Namespace) -> int:
    """Check a session on the beam; with `correct`, mend another recording by what it shows.

    The exit status is 1 where a channel fails, or is not told, or something else is wrong.
    """
    if arguments.correct is not None:
        check_new(arguments.correct[1], LoggerError)
    session = read_beam(arguments.beam)
    limit_s = arguments.limit_ms * 1e-3
    recording = read(arguments.recording)
    try:
        check = check_synchronicity(recording, session, limit_s)
    except CalibrationError as error:
        raise CalibrationError(f"{arguments.recording} on {arguments.beam}: {error}") from None
    console = open_console()
    console.print(_table(check))
    for line in _lines(check, arguments.limit_ms):
        console.print(line)
    if arguments.figure is not None:
        from wheelhop.calibration.sync.figure import draw_sync

        draw_sync(check, session, arguments.figure, limit_s)
        console.print(f"{arguments.figure} has the picture")
    if arguments.json is not None:
        write_json(arguments.json, as_json(check))
    if arguments.correct is not None:
        source, target = arguments.correct
        write(align(read(source), check.skews_s), target)
        console.print(f"{target}: {source} with its channels moved into step")
    return 0 if check.passed else NOT_IN_STEP


def as_json(check: SyncCheck) -> dict[str, object]:
    """The result for programs; what cannot be told is null."""
    return {
        "passed": check.passed,
        "frequencies_hz": list(check.frequencies_hz),
        "refused": [{"frequency_hz": f, "reason": reason} for f, reason in check.refused],
        "ramp_s": check.ramp_s,
        "loss_factor": check.loss_factor,
        "loss_expanded": check.loss_expanded,
        "faults": [
            {"kind": f.kind, "channels": list(f.channels), "or": [list(r) for r in f.rivals]}
            for f in check.faults
        ],
        "remarks": list(check.remarks),
        "level": list(check.level),
        "channels": [
            {
                "name": c.name,
                "position_m": c.position_m,
                "skew_s": None if np.isnan(c.skew_s) else c.skew_s,
                "expanded_s": None if np.isnan(c.expanded_s) else c.expanded_s,
                "off_s": None if np.isnan(c.off_s) else c.off_s,
                "measured": list(c.measured),
                "expected": list(c.expected),
                "verdict": c.verdict,
            }
            for c in check.channels
        ],
    }


def _table(check: SyncCheck) -> Table:
    table = Table(box=None, header_style="bold", pad_edge=False)
    table.add_column("channel")
    for title in ("at mm", "later than first µs", "± k=2", "off the others"):
        table.add_column(title, justify="right")
    for frequency in check.frequencies_hz:
        table.add_column(f"{frequency:.1f} Hz: is / theory", justify="right")
    table.add_column("verdict")
    for c in check.channels:
        times = [f"{1e6 * value:.0f}" if not np.isnan(value) else "-" for value in
                 (c.skew_s, c.expanded_s, c.off_s)]  # fmt: skip
        pairs = [f"{m:.2f} / {e:.2f}" for m, e in zip(c.measured, c.expected, strict=True)]
        verdict = f"[{STYLE[c.verdict]}]{c.verdict}[/]"
        table.add_row(c.name, f"{1e3 * c.position_m:.0f}", *times, *pairs, verdict)
    return table


def _lines(check: SyncCheck, limit_ms: float) -> list[str]:
    lines = [f"refused: {reason}" for _, reason in check.refused]
    lines += [
        f"[bold red]{fault}[/] (chi-square falls by {fault.strength:.0f})" for fault in check.faults
    ]
    if check.ramp_s:
        lines.append(
            f"[bold red]sampled in turn[/]: each channel {1e6 * check.ramp_s:.0f} µs after the one"
            " before; --correct mends recordings made like this"
        )
    lines.append(
        f"loss factor of the beam {check.loss_factor:.4f} ± {check.loss_expanded:.4f} (k = 2)"
    )
    for frequency, level in zip(check.frequencies_hz, check.level, strict=False):
        moved = f"at {frequency:.1f} Hz the beam moves {level:.3g} times as much as"
        lines.append(f"{moved} the stated force moves it")
    lines += [f"note: {remark}" for remark in check.remarks]
    if check.passed:
        lines.append(f"[green]in step[/]: all channels within {limit_ms:g} ms")
    else:
        bad = [c.name for c in check.channels if c.verdict != "pass"]
        lines.append(f"not passed at {limit_ms:g} ms: {', '.join(bad) if bad else 'see above'}")
    return lines
