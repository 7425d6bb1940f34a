"""Constants of several sessions in one file: sensors calibrated one after the other."""

from dataclasses import replace

from wheelhop.calibration.constants import Constants
from wheelhop.calibration.error import CalibrationError


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
