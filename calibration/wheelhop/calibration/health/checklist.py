"""Is the logger on the vehicle ready to drive? One session at rest answers, step by step.

Firmware/BUILD.md says what to do in that session: ten seconds hands off, a strike downwards beside
each sensor in the order of the channels, some seconds apart, and stop.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from wheelhop.calibration.health.channel import channel_findings
from wheelhop.calibration.health.finding import Finding
from wheelhop.calibration.health.recorder import recorder_findings
from wheelhop.calibration.health.spectrum import spectrum_findings
from wheelhop.calibration.health.taps import Taps, find_taps
from wheelhop.logger.error import LoggerError
from wheelhop.logger.recording import CODE, Recording
from wheelhop.logger.settings import number

SUPPLIES = ("supply_mv", "low_supply_mv", "end_supply_mv")
PASS, FAIL, OPEN = "pass", "fail", "open"
REST_S = 10.0  # hands off, before the first strike
REST_LEFT_S = 6.0  # of it, at least: what is needed to tell hum
QUIET_CODES = 1.0  # rms at rest: sensor, converter and rounding together make 0.4
SURE = 1.3  # product of the right pairing over the next best one's
AT_REST = {"level", "clipping", "drift", "hum"}


@dataclass(frozen=True)
class Check:
    """One step: its `verdict` ("pass", "fail", "open": cannot be told), what was `seen`, and what
    there is to do about it, nothing if passed."""

    step: str
    verdict: str
    seen: str
    remedies: tuple[str, ...] = ()


def check_commissioning(recording: Recording) -> tuple[Check, ...]:
    """Go through the steps that a session tells.

    Raises LoggerError if it is empty, or not as the logger recorded it: m/s² no longer say what
    the converter saw.
    """
    if any(channel.unit != CODE for channel in recording.channels) or not recording.notes:
        raise LoggerError("the checklist needs the logger's own file, HOP?????.HOP")
    if not recording.channels or recording.missing.all():
        raise LoggerError("no scan in it: there is nothing to check")
    findings = list(recorder_findings(recording))
    taps = find_taps(recording, len(recording.channels))
    return (
        _settings(recording),
        _supply(recording, [f for f in findings if f.kind not in {"gap", "late"}]),
        _card(recording, [f for f in findings if f.kind == "gap"]),
        _clock(recording, [f for f in findings if f.kind == "late"]),
        _quiet(_rest(recording, taps)),
        _places(recording, taps),
        _upright(recording, taps),
    )


def _settings(recording: Recording) -> Check:
    notes = recording.notes
    wrong = []
    if not number(notes, "device"):
        wrong.append("the logger has no number (wheelhop logger --set device=1)")
    if not notes.get("calibration"):
        wrong.append("no calibration is named (wheelhop calibrate, then --set calibration=…)")
    if number(notes, "config_errors"):
        wrong.append("HOP.CFG has lines that were not understood (wheelhop logger)")
    seen = (
        f"logger {notes.get('device', '?')}, firmware {notes.get('firmware', '?')}, calibration"
        f" {notes.get('calibration') or 'none'}, {recording.rate_hz:g} scans/s"
    )
    return _judged("settings", seen, wrong)


def _supply(recording: Recording, findings: list[Finding]) -> Check:
    notes = recording.notes
    volts = [notes[key] for key in SUPPLIES if number(notes, key)]
    seen = f"{' to '.join(dict.fromkeys(volts)) or 'unknown'} mV, reset: {notes.get('reset', '?')}"
    wrong = [f.remedy for f in findings]
    if notes.get("reset") == "watchdog":
        wrong.append("the program had stopped and was restarted: tell the makers of the firmware")
    if not wrong and not volts:
        return _open("supply", seen, "is AREF tied to the sensors' 3.3 V?")
    return _judged("supply", seen, wrong)


def _card(recording: Recording, findings: list[Finding]) -> Check:
    notes = recording.notes
    if notes.get("source") == "stream":
        return _open("card", "recorded over the serial line", "give the card's own file")
    seen = (
        f"end: {notes.get('end', 'not closed')}, {notes.get('lost', '?')} scans lost,"
        f" longest stall {notes.get('stall_ms', '?')} ms"
    )
    wrong = [f.remedy for f in findings]
    if notes.get("end") not in {"button", "command"}:
        wrong.append("stop by the button, the LED blinks slowly then; does the supply last?")
    if number(notes, "lost") or number(notes, "card_errors"):
        wrong.append("look at the socket's contacts, or take another card")
    return _judged("card", seen, wrong)


def _clock(recording: Recording, findings: list[Finding]) -> Check:
    ppm = recording.notes.get("clock_ppm", "")
    wrong = [f.remedy for f in findings]
    if not ppm:
        wrong.append("measure it when warm: wheelhop record --start --seconds 90")
    return _judged("clock", f"{ppm} ppm" if ppm else "never measured", wrong)


def _rest(recording: Recording, taps: Taps | int) -> Recording:
    """The part before the first strike, or where that should be."""
    stop = round(REST_S * recording.rate_hz)
    if isinstance(taps, Taps):
        stop = min(stop, int(taps.rows[0] - recording.rate_hz))
    return replace(recording, values=recording.values[: max(stop, 0)])


def _quiet(rest: Recording) -> Check:
    present = rest.values[~rest.missing]
    if len(present) < REST_LEFT_S * rest.rate_hz:
        seen = f"only {len(present) / rest.rate_hz:.1f} s before the first strike"
        return _open("quiet", seen, f"keep hands off for {REST_S:g} s first")
    found = [*channel_findings(rest), *spectrum_findings(rest)]
    rms = present.std(axis=0)
    wrong = [f"{', '.join(f.channels)} {f.what}: {f.remedy}" for f in found if f.kind in AT_REST]
    loud = [c.name for c, r in zip(rest.channels, rms, strict=True) if r > QUIET_CODES]
    if loud:
        wrong.append(f"{', '.join(loud)}: engine off? shield, sensor's ground, plug")
    worst = int(np.argmax(rms))
    return _judged(
        "quiet", f"{rms[worst]:.2f} codes rms on {rest.channels[worst].name}, the most", wrong
    )


def _places(recording: Recording, taps: Taps | int) -> Check:
    names = [channel.name for channel in recording.channels]
    if isinstance(taps, int):
        seen = f"{taps} strikes stand out, not {len(names)}"
        how = f"strike once beside each of {' '.join(names)}, 3 s apart, and do nothing else"
        return _open("places", seen, how)
    pairing, sure = taps.pairing()
    felt = [names[channel] for channel in pairing]
    seen = f"strikes felt by {' '.join(felt)} ({sure:.2g} times surer than any other order)"
    if sure < SURE:
        return _open("places", seen, "strike nearer to the sensors, and harder")
    wrong = [
        f"strike {k + 1} was for {name}, and {other} felt it"
        for k, (name, other) in enumerate(zip(names, felt, strict=True))
        if name != other
    ]
    return _judged(
        "places", seen, [*wrong, "was it in that order? then exchange the plugs"] if wrong else []
    )


def _upright(recording: Recording, taps: Taps | int) -> Check:
    if isinstance(taps, int):
        return _open("upright", "no strike to judge by", "strike as the step before says")
    pairing, _ = taps.pairing()
    own = taps.felt[np.arange(len(pairing)), pairing]
    faint = sorted(_names(recording, pairing[np.abs(own) < 2 * QUIET_CODES]))
    rose = sorted(_names(recording, pairing[own > 0]))
    seen = f"weakest strike {np.abs(own).min():.1f} codes"
    if faint:
        return _open("upright", seen, f"strike harder beside {', '.join(faint)}")
    wrong = [f"{', '.join(rose)} rose when struck downwards: upside down"] if rose else []
    return _judged("upright", seen, wrong)


def _names(recording: Recording, channels: np.ndarray) -> Iterator[str]:
    return (recording.channels[int(c)].name for c in channels)


def _open(step: str, seen: str, remedy: str) -> Check:
    return Check(step, OPEN, seen, (remedy,))


def _judged(step: str, seen: str, wrong: list[str]) -> Check:
    return Check(step, FAIL if wrong else PASS, seen, tuple(dict.fromkeys(wrong)))
