"""Constants of several sessions in one file: sensors calibrated one after the other."""

from dataclasses import replace
from pathlib import Path

from wheelhop.calibration.constants import Constants
from wheelhop.calibration.constants_file import read_constants, write_constants
from wheelhop.calibration.error import CalibrationError
from wheelhop.files import locked


def merged(old: Constants, new: Constants) -> Constants:
    """`old` with the sensors of `new` in place of those on the same channels, under the new id.

    Raises CalibrationError if they belong to different loggers.
    """
    if old.device and new.device and old.device != new.device:
        raise CalibrationError(
            f"{old.source}: belongs to logger {old.device}, this session to {new.device}: write to"
            " another file with --out"
        )
    fresh = {sensor.channel: sensor for sensor in new.sensors}
    kept = [fresh.pop(sensor.channel, sensor) for sensor in old.sensors]
    return replace(new, sensors=(*kept, *fresh.values()), device=new.device or old.device)


def put_constants(constants: Constants, out: Path) -> tuple[str, ...]:
    """Write constants into a file, beside those of other sensors that it has: their channels.

    Raises CalibrationError where they belong to another logger, or the file cannot be written.
    """
    new = [sensor.channel for sensor in constants.sensors]
    with locked(out.parent):
        if out.exists():
            constants = merged(read_constants(out), replace(constants, source=str(out)))
        write_constants(constants, out)
    return tuple(s.channel for s in constants.sensors if s.channel not in new)
