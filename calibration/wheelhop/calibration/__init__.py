"""From codes to m/s²: constants with their uncertainty, and how they are found."""

from wheelhop.calibration.constants import (
    Constants,
    SensorConstants,
    Value,
    nominal_constants,
)
from wheelhop.calibration.constants_file import read_constants, write_constants
from wheelhop.calibration.error import CalibrationError
from wheelhop.calibration.health.examine import Health, examine, examine_relations
from wheelhop.calibration.health.finding import Finding
from wheelhop.calibration.sync.beam_file import BeamSession, read_beam
from wheelhop.calibration.sync.check import SyncCheck, check_synchronicity
from wheelhop.calibration.sync.delay import align

__all__ = [
    "BeamSession",
    "CalibrationError",
    "Constants",
    "Finding",
    "Health",
    "SensorConstants",
    "SyncCheck",
    "Value",
    "align",
    "check_synchronicity",
    "examine",
    "examine_relations",
    "nominal_constants",
    "read_beam",
    "read_constants",
    "write_constants",
]
