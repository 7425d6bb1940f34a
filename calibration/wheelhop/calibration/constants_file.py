"""calibration.toml: constants for people and programs to read (docs/calibration.md)."""

import math
from collections.abc import Iterator
from pathlib import Path

from wheelhop.calibration.constants import Constants, SensorConstants, Value
from wheelhop.calibration.error import CalibrationError
from wheelhop.files import Table, quoted, read_toml, write_text

EXPANDED = "_expanded"
QUANTITIES = {
    "gain": "gain_m_s2_per_code",
    "offset": "offset_code",
    "corner_hz": "corner_hz",
    "delay_s": "delay_s",
}
TEXTS = ("channel", "serial", "method", "reference", "certificate")
NUMBERS = ("temperature_C", "supply_V")
DAYS = ("date", "valid_until")
KEYS = (
    *(*TEXTS, *NUMBERS, *DAYS),
    *(key + end for key in QUANTITIES.values() for end in ("", EXPANDED)),
)


def read_constants(path: Path | str) -> Constants:
    """Read calibration.toml. Raises CalibrationError with file, table and key."""
    table = read_toml(Path(path), CalibrationError)
    table.only(("format", "id", "device", "sensor"))
    table.format()
    sensors = tuple(_read_sensor(item) for item in table.tables("sensor", "channel"))
    names = [sensor.channel for sensor in sensors]
    for name in names:
        if names.count(name) > 1:
            raise table.error(f"channel {name} has several [[sensor]] tables: leave one")
    device = table.number("device", 0, at_least=0)
    return Constants(table.text("id"), int(device), sensors, source=str(path))


def _read_sensor(table: Table) -> SensorConstants:
    table.only(KEYS)
    gain, offset = (_read_value(table, QUANTITIES[name]) for name in ("gain", "offset"))
    if gain.value == 0:
        raise table.error("gain_m_s2_per_code must not be 0")
    return SensorConstants(
        channel=table.text("channel"),
        serial=table.text("serial", ""),
        gain=gain,
        offset=offset,
        date=table.date("date"),
        valid_until=table.date("valid_until"),
        method=table.text("method", ""),
        temperature_C=_optional(table, "temperature_C"),
        supply_V=_optional(table, "supply_V"),
        reference=table.text("reference", ""),
        certificate=table.text("certificate", ""),
        corner_hz=_read_value(table, "corner_hz", above=0) if "corner_hz" in table.values else None,
        delay_s=_read_value(table, "delay_s") if "delay_s" in table.values else None,
    )


def _optional(table: Table, key: str) -> float:
    return table.number(key) if key in table.values else math.nan


def _read_value(table: Table, key: str, above: float | None = None) -> Value:
    return Value(table.number(key, above=above), table.number(key + EXPANDED, at_least=0))


def write_constants(constants: Constants, path: Path | str) -> None:
    """Write calibration.toml, whole or not at all. Raises CalibrationError."""
    write_text(Path(path), "\n".join(_lines(constants)) + "\n", CalibrationError)


def _lines(constants: Constants) -> Iterator[str]:
    yield "format = 1"
    yield f"id = {quoted(constants.id)}"
    yield f"device = {constants.device}"
    yield ""
    yield "# acceleration in m/s² = gain · (code − offset); offset: at rest, mounted as in use"
    yield f"# KEY{EXPANDED}: expanded uncertainty, coverage factor 2"
    for sensor in constants.sensors:
        yield ""
        yield "[[sensor]]"
        for name in ("channel", "serial"):
            yield f"{name} = {quoted(getattr(sensor, name))}"
        for name, key in QUANTITIES.items():
            value = getattr(sensor, name)
            if value is not None:
                yield f"{key} = {_number(value.value)}"
                yield f"{key}{EXPANDED} = {_number(value.expanded)}"
        yield from (f"{day} = {getattr(sensor, day).isoformat()}" for day in DAYS)
        for name in NUMBERS:
            if math.isfinite(getattr(sensor, name)):
                yield f"{name} = {_number(getattr(sensor, name))}"
        for name in ("method", "reference", "certificate"):
            yield f"{name} = {quoted(getattr(sensor, name))}"


def _number(value: float) -> str:
    return repr(float(f"{value:.7g}"))
