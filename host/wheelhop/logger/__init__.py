"""The data logger as the host sees it: writing its firmware, reading its logs."""

from wheelhop.logger.correct import correct_clock, correct_sensor, correct_window
from wheelhop.logger.error import LoggerError
from wheelhop.logger.flash import Upload, plan_upload, upload
from wheelhop.logger.info import describe
from wheelhop.logger.link import Link, connect
from wheelhop.logger.log import Damage, Gap, Log
from wheelhop.logger.read import read_log
from wheelhop.logger.recording import Channel, Recording
from wheelhop.logger.recovery import Recovered, recover

__all__ = [
    "Channel",
    "Damage",
    "Gap",
    "Link",
    "Log",
    "LoggerError",
    "Recording",
    "Recovered",
    "Upload",
    "connect",
    "correct_clock",
    "correct_sensor",
    "correct_window",
    "describe",
    "plan_upload",
    "read_log",
    "recover",
    "upload",
]
