"""Is a sensor dead, or does it only stand still? Its self-test tells: a force on its own mass.

The logger drives the ST pins of all sensors together (`firmware/BUILD.md`, "Self-test"). By the
data sheet of the ADXL326 its Z output then rises by 29 to 190 mV, typically 105, at 3 V of supply,
and by the cube of the supply. Codes are a ratio to the same supply, so they go with its square.
"""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.logger.block import scan_bytes, unpack_scans
from wheelhop.logger.error import LoggerError
from wheelhop.logger.frames import streamed_scan
from wheelhop.logger.link import Link, Refused
from wheelhop.logger.settings import Settings, parse_settings

SHEET_V = 3.0
SHEET_RISE_V = (0.029, 0.105, 0.190)
"""Least, typical and most rise of Z at `SHEET_V` (ADXL326 data sheet, self-test 0 to 1)."""
SUPPLY_V = 3.3
CODES = 1024
SCANS = 50
SETTLING_SCANS = 20  # the sensor's filter takes some 20 ms
PATIENCE_S = 10.0  # for the scans of a step
SURE = 4.0  # standard errors
NOTHING = 2.0  # codes: less is no answer
UNSTEADY = 20.0  # codes, rms: somebody is handling the sensors


@dataclass(frozen=True)
class Answer:
    """What a sensor did: it rests at code `level`, `noise` its rms, and the self-test moved it by
    `shift` codes. `verdict` is "moves", "dead", "weak", "strong", "inverted" or "unsteady"."""

    channel: str
    level: float
    noise: float
    shift: float
    verdict: str


WORDS = {
    "moves": "its mass moves: alive",
    "dead": "does not answer: dead, or its ST is not connected",
    "weak": "answers less than the data sheet allows: check its supply",
    "strong": "answers more than the data sheet allows: another sensor, or another axis?",
    "inverted": "answers downwards: X in place of Z, or wired upside down",
    "unsteady": "was moved meanwhile: do it again at rest",
}


def expected_codes() -> tuple[float, float, float]:
    """Least, typical and most rise of a sensor whose supply is the converter's reference, codes."""
    scale = (SUPPLY_V / SHEET_V) ** 3 / SUPPLY_V * CODES
    least, typical, most = (volts * scale for volts in SHEET_RISE_V)
    return least, typical, most


def self_test(link: Link) -> list[Answer]:
    """Ask every sensor that is recorded, without a session; it takes a few seconds.

    The self-test is off again afterwards, and the stream as it was before. Raises LoggerError where
    a session runs, or the firmware is one of before 1.4.
    """
    info = link.info()
    settings = parse_settings(info, link.port.name)
    if link.status().get("state") == "recording":
        raise LoggerError(f"{link.port.name}: a session runs: stop it first")
    link.stream(True)
    try:
        before = _scans(link, settings)
        _switch(link, "on")
        moved = _scans(link, settings)
        _switch(link, "off")
        after = _scans(link, settings)
    finally:
        link.stream(False)
    names = [name for _, name in settings.inputs]
    return [judged(*column) for column in zip(names, before.T, moved.T, after.T, strict=True)]


def judged(
    channel: str,
    before: NDArray[np.float64],
    moved: NDArray[np.float64],
    after: NDArray[np.float64],
) -> Answer:
    """Say what (n,) codes before, during and after the self-test mean."""
    rest = np.concatenate([before, after])
    level = (before.mean() + after.mean()) / 2
    shift = float(moved.mean() - level)
    noise = float(
        max(before.std(), moved.std(), after.std(), abs(before.mean() - after.mean()) / 2)
    )
    least, _, most = expected_codes()
    error = SURE * noise / np.sqrt(len(before)) + 1.0  # rounding may hide a code
    if noise > UNSTEADY:
        verdict = "unsteady"
    elif abs(shift) < max(NOTHING, SURE * noise / np.sqrt(len(before))):
        verdict = "dead"
    elif shift < 0:
        verdict = "inverted"
    elif shift < least - error:
        verdict = "weak"
    else:
        verdict = "strong" if shift > most + error else "moves"
    return Answer(channel, float(rest.mean()), noise, shift, verdict)


def _switch(link: Link, state: str) -> None:
    try:
        link.command(f"test {state}")
    except Refused as error:
        if "unknown command" not in str(error):
            raise
        raise LoggerError(
            f"{link.port.name}: its firmware has no self-test: wheelhop flash writes one that has"
        ) from None


def _scans(link: Link, settings: Settings) -> NDArray[np.float64]:
    """(SCANS, channels) codes from now on, once the sensors have settled."""
    channels, bits = len(settings.inputs), settings.sum_bits
    link.receive(0.0)
    stored: list[bytes] = []
    deadline = time.monotonic() + PATIENCE_S
    while len(stored) < SETTLING_SCANS + SCANS:
        if time.monotonic() > deadline:
            raise LoggerError(f"{link.port.name}: the stream stays away: is the cable sound?")
        scans = [streamed_scan(frame) for frame in link.receive() if frame.kind == "D"]
        size = scan_bytes(channels, bits)
        stored += [scan.stored for scan in scans if scan and len(scan.stored) == size]
    kept = b"".join(stored[SETTLING_SCANS : SETTLING_SCANS + SCANS])
    return settings.codes(unpack_scans(kept, channels, bits))
