"""From any recording on disk to what a campaign holds: m/s², at true time."""

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

import numpy as np

from wheelhop.calibration import Constants, nominal_constants, read_constants
from wheelhop.calibration.constants import NOMINAL_CORNER_HZ, NOMINAL_CORNER_LIMITS
from wheelhop.campaign.types import Channel
from wheelhop.files.units import is_measured
from wheelhop.formats import read
from wheelhop.formats.table import POINTS
from wheelhop.logger import correct_clock, correct_sensor, read_log
from wheelhop.logger.beside import with_beside
from wheelhop.logger.recording import ACCELERATION, CODE, Recording

LOG = ".hop"
CROSS_AXIS = 0.01  # ADXL326, Analog Devices, data sheet rev. 0, table 1
UNMEASURED_CORNER = float(np.hypot(*NOMINAL_CORNER_LIMITS) / np.sqrt(3))


def read_recording(
    file: Path, constants_file: Path | None = None, nominal: bool = False
) -> Recording:
    """Read a recording; codes become m/s² if there are constants, or if `nominal` ones will do.

    What a logger has beside its eight inputs are channels, too. The error of the logger's clock,
    where it was measured, and the sensors' own low-pass are undone; the averaging of each sample is
    not, since the model averages, too. Raises ExchangeError, LoggerError or CalibrationError.
    """
    recording = read(file)
    own_s = recording.time_s
    beside = (
        read_log(file).beside
        if recording.notes.get("beside") and file.suffix.lower() == LOG
        else None
    )
    return with_beside(_in_si(recording, constants_file, nominal), beside, own_s)


def _in_si(recording: Recording, constants_file: Path | None, nominal: bool) -> Recording:
    if recording.notes.get("clock_ppm"):
        recording = correct_clock(recording)
    if all(channel.unit != CODE for channel in recording.channels):
        return recording  # of another instrument, or calibrated before
    if constants_file is not None:
        return _calibrated(recording, read_constants(constants_file))
    if nominal:
        coded = [c.name for c in recording.channels if c.unit == CODE]
        return _calibrated(recording, nominal_constants(coded))
    return recording


def accelerations(recording: Recording, asked: Collection[str] = ()) -> tuple[Recording, list[str]]:
    """The accelerations of a recording and what else is `asked` for by name, and what was left out,
    in words. What is not calibrated yet stays, and what is at a place and does not say its unit:
    that is refused."""
    kept = [
        k
        for k, channel in enumerate(recording.channels)
        if channel.unit in (ACCELERATION, CODE)
        or channel.name in asked
        or (channel.name in POINTS and not is_measured(channel.unit))
    ]
    if len(kept) == len(recording.channels) or not kept:
        return recording, []
    left_out = [
        f"{channel.name} ({f'in {channel.unit}' if channel.unit else 'its unit is not said'})"
        for k, channel in enumerate(recording.channels)
        if k not in kept
    ]
    taken = recording.after(
        f"left out, no accelerations: {', '.join(left_out)}",
        values=recording.values[:, kept],
        channels=tuple(recording.channels[k] for k in kept),
    )
    return taken, left_out


def with_uncertainty(channel: Channel, constants: Constants) -> Channel:
    """The channel with what its constants say of its gain and of the corner of its low-pass.

    What it shows of motion across its axis, ±1 % by the data sheet, is taken as rectangular (GUM
    4.3.7), of motion about as large as that along it. So are the tolerances of a corner that was
    not measured. A channel without constants stays as it is.
    """
    if channel.name not in {sensor.channel for sensor in constants.sensors}:
        return channel
    known = constants.of(channel.name)
    gain, across = known.gain.relative / 2, CROSS_AXIS / np.sqrt(3)
    corner = known.corner_hz
    return replace(
        channel,
        scale_uncertainty=float(np.hypot(gain, across)),
        gain_uncertainty=gain,
        corner_hz=corner.value if corner else NOMINAL_CORNER_HZ,
        corner_uncertainty=corner.relative / 2 if corner else UNMEASURED_CORNER,
    )


def _calibrated(recording: Recording, constants: Constants) -> Recording:
    """What is in codes, by its constants; what is measured otherwise stays."""
    coded = np.array([channel.unit == CODE for channel in recording.channels])
    codes = replace(
        recording,
        values=recording.values[:, coded],
        channels=tuple(c for c in recording.channels if c.unit == CODE),
    )
    calibrated = constants.apply(codes)
    corners = [constants.of(channel.name).corner_hz for channel in calibrated.channels]
    # Gravity does not tell the corner; without one every body resonance would come out too low.
    known = [corner.value if corner else NOMINAL_CORNER_HZ for corner in corners]
    done = correct_sensor(calibrated, known)
    values = recording.values.copy()
    values[:, coded] = done.values
    made = iter(done.channels)
    channels = tuple(next(made) if c.unit == CODE else c for c in recording.channels)
    return replace(done, values=values, channels=channels)
