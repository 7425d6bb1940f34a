"""`wheelhop calibrate`: from a shaker session, or from sensors turned over, to calibration.toml."""

from argparse import Namespace
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from wheelhop.calibration import CalibrationError, Constants, Value, read_constants
from wheelhop.calibration.flip import CANNOT_TELL, GUIDE, Flip, flip_calibration
from wheelhop.calibration.flip_figure import draw_flip
from wheelhop.calibration.merge import put_constants
from wheelhop.calibration.session import Session, read_session
from wheelhop.calibration.shaker.comparison import compare_with_reference
from wheelhop.calibration.shaker.figure import draw
from wheelhop.calibration.shaker.result import (
    LEAST_COHERENCE,
    REFERENCE_HZ,
    ChannelCalibration,
    Comparison,
)
from wheelhop.cli.output import open_console
from wheelhop.cli.progress import stages
from wheelhop.files import check_picture, check_target
from wheelhop.logger.recording import CODE


def run(arguments: Namespace) -> int:
    """Calibrate, print what was found, write constants and picture; raises CalibrationError."""
    console = open_console()
    if arguments.session is None:
        if not arguments.flip:
            raise CalibrationError("say which session: wheelhop calibrate SESSION.toml, or --flip")
        _guide(console)
        return 0
    figure = arguments.figure or arguments.out.with_suffix(".png")
    _check_outputs(arguments.out, figure)
    with stages() as stage:
        stage("reading the recordings")
        session = read_session(arguments.session)
        found: Flip | Comparison
        if arguments.flip:
            found = flip_calibration(session.log, session.conditions)
        else:
            found = _compare(session, arguments.session, stage)
    if isinstance(found, Flip):
        _show_flip(console, found)
        draw_flip(found, session.log, figure)
    else:
        _show_comparison(console, found)
        draw(found, figure)
    console.print(Text(f"{figure}: the picture"))
    if any(channel.unit != CODE for channel in session.log.channels):
        console.print(Text("no constants are written: the sensor's channels are not in codes"))
        return 0
    _write(console, found.constants(), arguments.out)
    return 0


def _check_outputs(out: Path, figure: Path) -> None:
    """Better to know before the work than after it."""
    check_picture(figure, CalibrationError)
    if out.exists():
        read_constants(out)
    check_target(out, CalibrationError)


def _compare(session: Session, path: Path, stage: Callable[[str], None]) -> Comparison:
    if session.reference is None:
        raise CalibrationError(
            f"{path}: there is no [reference]: give one, or --flip for sensors turned over"
        )
    return compare_with_reference(session.reference, session.log, session.conditions, stage)


def _write(console: Console, constants: Constants, out: Path) -> None:
    kept = put_constants(constants, out)
    note = f"; kept as they were: {', '.join(kept)}" if kept else ""
    new = ", ".join(sensor.channel for sensor in constants.sensors)
    console.print(Text(f"{out}: constants of {new}{note}"))


def _guide(console: Console) -> None:
    console.print(Text("Field calibration by gravity: six minutes", style="bold"))
    for number, step in enumerate(GUIDE, start=1):
        console.print(Text(f"  {number}. {step}."))
    console.print(Text("Then: wheelhop calibrate --flip HOP00012.HOP (or a session file)"))
    console.print(Text(f"It does not tell {CANNOT_TELL}."))


def _show_comparison(console: Console, found: Comparison) -> None:
    conditions = found.conditions
    how = "stepped" if found.stepped else "swept"
    console.print(Text(f"Calibration {conditions.id}, {how} sine", style="bold"))
    console.print(Text(f"reference  {conditions.reference} {conditions.certificate}".rstrip()))
    console.print(
        Text(
            f"clocks     reference = logger + {found.offset_s.value:.5f} s"
            f" ± {1e3 * found.offset_s.expanded:.3f} ms; drift {found.drift_ppm} ppm"
        )
    )
    for channel in found.channels:
        console.print(_frequencies(channel))
    console.print(_summary(found.channels))
    console.print(_budget([(c.name, c.budget) for c in found.channels], "sensitivity at 10 Hz"))
    _tell(console, found.findings)


def _frequencies(channel: ChannelCalibration) -> Table:
    """One line a frequency."""
    table = _table(
        f"{channel.name} {channel.serial}".strip(),
        *("Hz", "m/s²", f"{channel.unit} per m/s²", "± %", "off the line, %", "phase, °"),
        *("coherence", ""),
    )
    used = iter(zip(channel.deviation, channel.expanded, channel.phase_rad, strict=True))
    points = channel.points
    for i in range(len(points)):
        usable = points.coherence[i] >= LEAST_COHERENCE
        off, expanded, phase = next(used) if usable else (float("nan"),) * 3
        doubt = "" if usable else "unusable"
        if usable and abs(off) > expanded:
            doubt = "disagrees"
        table.add_row(
            f"{points.frequency_hz[i]:.2f}",
            f"{points.amplitude_m_s2[i]:.2f}",
            f"{abs(points.ratio[i]):.4f}",
            _percent(expanded),
            _percent(off),
            f"{phase * 57.29578:+.2f}" if usable else "-",
            f"{points.coherence[i]:.3f}",
            doubt,
        )
    return table


def _summary(channels: Sequence[ChannelCalibration]) -> Table:
    unit = channels[0].unit
    table = _table(
        f"Constants: gain in m/s² per {unit}, offset and noise in {unit}; ±: expanded, k = 2."
        f" Delay at {REFERENCE_HZ:g} Hz",
        *("channel", "static gain", f"at {REFERENCE_HZ:g} Hz", "± %", "offset"),
        *("corner, Hz", "delay, ms", "noise", "linear, %"),
    )
    for channel in channels:
        linear = channel.nonlinearity
        table.add_row(
            channel.name,
            str(channel.gain),
            f"{channel.sensitivity.value:.4f}",
            _percent(channel.sensitivity.relative),
            str(channel.offset),
            str(channel.corner_hz or "none seen"),
            str(Value(1e3 * channel.delay_s.value, 1e3 * channel.delay_s.expanded)),
            f"{channel.noise:.3g}",
            f"< {_percent(max(linear.value, linear.expanded))}" if linear else "not tested",
        )
    return table


def _budget(rows: Iterable[tuple[str, tuple[tuple[str, float], ...]]], what: str) -> Table:
    rows = list(rows)
    parts = [name for name, _ in rows[0][1]]
    table = _table(f"Standard uncertainties of the {what}, %", "channel", *parts, "combined")
    for name, budget in rows:
        combined = sum(part**2 for _, part in budget) ** 0.5
        table.add_row(name, *(_percent(part) for _, part in budget), _percent(combined))
    return table


def _show_flip(console: Console, found: Flip) -> None:
    console.print(Text(f"Calibration {found.conditions.id}, turned over", style="bold"))
    table = _table("Rests", "from, s", "to, s", "axis", *(c.name for c in found.channels))
    for rest, sign in zip(found.rests, found.orientations, strict=True):
        codes = (f"{code:.2f}" for code in rest.codes)
        table.add_row(
            *(f"{rest.start_s:.0f}", f"{rest.end_s:.0f}", "up" if sign > 0 else "down"), *codes
        )
    console.print(table)
    table = _table(
        "Constants (± expanded, k = 2)",
        *("channel", "gain, m/s² per code", "±, %", "offset", "noise, code"),
    )
    for channel in found.channels:
        table.add_row(
            *(channel.name, str(channel.gain), _percent(channel.gain.relative)),
            *(str(channel.offset), f"{channel.noise_code:.3f}"),
        )
    console.print(table)
    console.print(_budget([(c.name, c.budget) for c in found.channels], "gain"))
    _tell(console, found.findings)
    console.print(Text(f"This does not tell {CANNOT_TELL}."))


def _table(title: str, *headings: str) -> Table:
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    return table


def _tell(console: Console, findings: Sequence[str]) -> None:
    for finding in findings:
        console.print(Text(f"! {finding}", style="yellow"))


def _percent(value: float) -> str:
    return "-" if value != value else f"{100 * value:.2f}"
