"""What the logger is switched on for, step by step, and what each recording then says."""

from __future__ import annotations

import tempfile
from base64 import b64encode
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from wheelhop.campaign.read import CONSTANTS_FILE

BEAM_FILE = "beam.toml"
LIMIT_S = 0.5e-3


@dataclass(frozen=True)
class Kind:
    """A kind of session: its name, what to do in order, what the button is called that evaluates a
    recording of it ("": its stretches become runs), and how: from a recording and the folder it is
    in to HTML. That raises InputError."""

    name: str
    steps: Sequence[str]
    evaluate_words: str = ""
    evaluate: Callable[[Path, Path], str] | None = None


def kinds() -> dict[str, Kind]:
    """Every kind of session, in the order of a day."""
    from wheelhop.calibration.flip import GUIDE

    turn = [step.replace("Start the logger (button)", "Press Start recording") for step in GUIDE]
    turn = [step.replace("stop the logger", "press Stop") for step in turn]
    return {
        "turn": Kind(
            "Calibrate: turn the sensors over", turn, "Work out the constants", calibrated
        ),
        "strike": Kind(
            "Check: strike beside each sensor",
            (
                "All sensors are on the vehicle, which stands still, engine off",
                "Press Start recording. Hands off for 12 s",
                "Strike downwards beside each sensor, one every 4 s, in the order of the inputs:"
                " B1 … B4, A1 … A4",
                "Press Stop",
            ),
            "Go through the checklist",
            checked,
        ),
        "beam": Kind(
            "Synchronicity: all sensors on a beam",
            (
                "Clamp a ruler at one end; put the sensors along it, all the same way up, and"
                " measure their places to the millimetre",
                f"Write beam, drive and places into {BEAM_FILE} in the folder of the recordings"
                " (docs/synchronicity.md has its keys)",
                "Drive it at two or three frequencies between its natural frequencies; let it"
                " settle",
                "Press Start recording; 20 s or more at each frequency; press Stop",
            ),
            "Are they in step?",
            in_step,
        ),
        "drive": Kind(
            "Drive",
            (
                "Press Start recording, then stand still for a few seconds",
                "Drive over a track at a speed held as well as you can; several tracks, two speeds"
                " each",
                "Stand still for a few seconds between the drives: that is how they are found",
                "Press Stop, then take the stretches as runs",
            ),
        ),
    }


def calibrated(file: Path, folder: Path) -> str:
    """Constants of sensors turned over, written into the folder's calibration.toml."""
    from wheelhop.calibration.flip import CANNOT_TELL, flip_calibration
    from wheelhop.calibration.flip_figure import draw_flip
    from wheelhop.calibration.merge import put_constants
    from wheelhop.calibration.session import read_session

    session = read_session(file)
    found = flip_calibration(session.log, session.conditions)
    with tempfile.TemporaryDirectory() as other:
        picture = Path(other) / "flip.svg"
        draw_flip(found, session.log, picture)
        source = b64encode(picture.read_bytes()).decode()
    put_constants(found.constants(), folder / CONSTANTS_FILE)
    rows = [
        (channel.name, str(channel.gain), str(channel.offset), f"{channel.noise_code:.2f}")
        for channel in found.channels
    ]
    heads = ("channel", "gain, m/s² per code", "offset, code", "noise, code rms")
    return (
        f"<p>The constants are in <code>{escape(str(folder / CONSTANTS_FILE))}</code>; ± is"
        " expanded, k = 2. Recordings taken into a campaign from here use them.</p>"
        f"{_table(heads, rows)}{_list(found.findings)}"
        f'<img class="wide" alt="the rests, and how well they repeat"'
        f' src="data:image/svg+xml;base64,{source}">'
        f"<p class='soft'>Not told: {escape(CANNOT_TELL)}.</p>"
    )


def checked(file: Path, folder: Path) -> str:
    """The checklist of commissioning."""
    from wheelhop.calibration.health.checklist import PASS, check_commissioning
    from wheelhop.formats import read

    checks = check_commissioning(read(file))
    rows = [(c.step, c.verdict, c.seen, "; ".join(c.remedies)) for c in checks]
    ready = all(check.verdict == PASS for check in checks)
    words = "Ready to drive." if ready else "Not ready yet: see what to do in the last column."
    return f"<p>{words}</p>{_table(('step', 'verdict', 'seen', 'what to do'), rows)}"


def in_step(file: Path, folder: Path) -> str:
    """How much later than the first each channel is sampled."""
    from wheelhop.calibration import check_synchronicity, read_beam
    from wheelhop.formats import read

    check = check_synchronicity(read(file), read_beam(folder / BEAM_FILE), LIMIT_S)
    rows = [
        (
            channel.name,
            f"{1e3 * channel.position_m:.0f}",
            f"{1e6 * channel.skew_s:.0f} ± {1e6 * channel.expanded_s:.0f}",
            channel.verdict,
        )
        for channel in check.channels
    ]
    heads = ("channel", "at, mm", "later than the first, µs ± (k = 2)", "verdict")
    passed = f"All channels are within {1e3 * LIMIT_S:g} ms." if check.passed else "Not in step."
    said = [*map(str, check.faults), *check.remarks]
    said += [f"not used: {reason}" for _, reason in check.refused]
    return f"<p>{passed}</p>{_table(heads, rows)}{_list(said)}"


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f"<th>{escape(text)}</th>" for text in heads)
    body = "".join(
        f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows
    )
    return (
        f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
        "</div>"
    )


def _list(lines: Sequence[str]) -> str:
    items = "".join(f"<li>{escape(line)}</li>" for line in lines)
    return f"<ul>{items}</ul>" if items else ""
