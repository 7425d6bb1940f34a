"""A calibration session's TOML file: the recordings, the reference, the sensors, the conditions."""

import datetime as dt
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from wheelhop.calibration.conditions import Conditions
from wheelhop.calibration.error import CalibrationError
from wheelhop.files import Table, read_toml
from wheelhop.formats import read, read_mapping
from wheelhop.logger import read_log
from wheelhop.logger.recording import ACCELERATION, CODE, Recording

KEYS = (
    *("format", "id", "date", "valid_until", "temperature_C", "supply_V"),
    *("reference", "logger", "sensors", "rig"),
)
REFERENCE_KEYS = (
    *("file", "mapping", "channel", "unit", "sensor", "certificate", "expanded_percent"),
    *("charge_pC_per_m_s2", "amplifier_mV_per_pC", "sensitivity_mV_per_m_s2", "high_pass_hz"),
)
LOGGER_KEYS = ("file", "mapping", "unit")
RIG_KEYS = (
    *("tilt_deg", "transverse_percent", "cross_axis_percent"),
    *("temperature_range_K", "axis"),
)
VALID_DAYS = 365
LONGEST_ID = 15  # of the logger's header, firmware/SPEC.md


@dataclass(frozen=True, eq=False)
class Session:
    """What was recorded and how. `reference` is in m/s², one channel; None if the file has none."""

    conditions: Conditions
    log: Recording
    reference: Recording | None


def read_session(path: Path) -> Session:
    """Read a session file and its recordings, whose paths are relative to it.

    A log by itself will do where no reference is needed: then it is the file to give. Raises
    CalibrationError with file, table and key, or what the recordings' reader raises.
    """
    if path.suffix.lower() != ".toml":
        day = dt.datetime.now(dt.UTC).date()
        valid = day + dt.timedelta(VALID_DAYS)
        log = _recording(path, None)
        return Session(Conditions(f"flip-{day:%y%m%d}", day, valid), log, None)
    table = read_toml(path, CalibrationError)
    table.only(KEYS)
    table.format()
    log = _read_logger(table, path.parent)
    reference = None
    if "reference" in table.values:
        reference = _read_reference(table.table_if_any("reference"), path.parent)
    return Session(_read_conditions(table), log, reference)


def _read_conditions(table: Table) -> Conditions:
    day = table.date("date")
    valid = table.date("valid_until") if "valid_until" in table.values else None
    name = table.text("id")
    if len(name) > LONGEST_ID or not name.isascii():
        raise table.error(f"id: at most {LONGEST_ID} plain characters, as the logger keeps it")
    reference, rig = table.table_if_any("reference"), table.table_if_any("rig")
    rig.only(RIG_KEYS)
    default = Conditions(name, day, valid or day + dt.timedelta(VALID_DAYS))
    axis = rig.text("axis", default.axis)
    if axis not in ("up", "horizontal"):
        raise rig.error(f'axis = "{axis}" must be "up" or "horizontal"')
    return replace(
        default,
        reference=reference.text("sensor", ""),
        certificate=reference.text("certificate", ""),
        reference_expanded=reference.number("expanded_percent", 0, at_least=0) / 100,
        high_pass_hz=reference.number("high_pass_hz", 0, at_least=0),
        tilt_deg=rig.number("tilt_deg", default.tilt_deg, at_least=0),
        transverse=rig.number("transverse_percent", 100 * default.transverse, at_least=0) / 100,
        cross_axis=rig.number("cross_axis_percent", 100 * default.cross_axis, at_least=0) / 100,
        temperature_C=_optional(table, "temperature_C"),
        temperature_range_K=rig.number(
            "temperature_range_K", default.temperature_range_K, at_least=0
        ),
        supply_V=_optional(table, "supply_V"),
        axis=axis,
    )


def _optional(table: Table, key: str) -> float:
    return table.number(key) if key in table.values else math.nan


def _read_logger(table: Table, folder: Path) -> Recording:
    logger, sensors = table.table_if_any("logger"), table.table_if_any("sensors")
    logger.only(LOGGER_KEYS)
    log = _recording(folder / logger.text("file"), logger, folder)
    names = [channel.name for channel in log.channels]
    for name in sensors.values:
        if name not in names:
            raise sensors.error(f"no channel {name} in the log, it has {', '.join(names)}")
    chosen = [i for i, name in enumerate(names) if name in sensors.values] or range(len(names))
    channels = [log.channels[i] for i in chosen]
    unit = logger.text("unit", "")
    channels = [
        replace(c, sensor=sensors.text(c.name, ""), unit=unit or _unit(c.name, c.unit))
        for c in channels
    ]
    for channel in channels:
        if channel.unit not in (CODE, ACCELERATION):
            raise logger.error(
                f'channel {channel.name}: give unit = "code" or "m/s²", not "{channel.unit}"'
            )
    return replace(log, values=log.values[:, list(chosen)], channels=tuple(channels))


def _read_reference(table: Table, folder: Path) -> Recording:
    table.only(REFERENCE_KEYS)
    recording = _recording(folder / table.text("file"), table, folder)
    names = [channel.name for channel in recording.channels]
    name = table.text("channel", names[0] if len(names) == 1 else "")
    if name not in names:
        raise table.error(f"channel: say which of {', '.join(names)} is the reference's")
    column = names.index(name)
    unit = table.text("unit", "") or _unit(name, recording.channels[column].unit)
    if unit == "V":
        scale = 1 / _volts_per_m_s2(table)
    elif unit == ACCELERATION:
        scale = 1.0
    else:
        raise table.error(f'channel {name}: give unit = "V" or "m/s²", not "{unit}"')
    channel = replace(recording.channels[column], unit=ACCELERATION)
    values = recording.values[:, [column]] * scale
    return replace(recording, values=values, channels=(channel,))


def _volts_per_m_s2(table: Table) -> float:
    """Of the whole chain: charge sensitivity times the amplifier's gain, or as one figure."""
    if "sensitivity_mV_per_m_s2" in table.values:
        return table.number("sensitivity_mV_per_m_s2", above=0) / 1000
    charge = table.number("charge_pC_per_m_s2", above=0)
    return charge * table.number("amplifier_mV_per_pC", above=0) / 1000


def _unit(name: str, unit: str) -> str:
    return unit or (ACCELERATION if name.endswith("_m_s2") else "")


def _recording(path: Path, table: Table | None, folder: Path = Path()) -> Recording:
    mapping = table.text("mapping", "") if table else ""
    if path.suffix.lower() == ".hop":
        recording = read_log(path).recording()
    else:
        recording = read(path, read_mapping(folder / mapping) if mapping else None)
    if np.isnan(recording.values).all():
        raise CalibrationError(f"{path}: there are no samples in it")
    return recording
