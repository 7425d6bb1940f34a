"""Field calibration by turning the sensors over: gravity is the reference.

At rest with its axis up a sensor shows +1 g, upside down −1 g: half the difference of the codes is
1 g, and the code upright is the offset (ISO 16063-16 calibrates so, with more angles). Rest says
nothing about frequency: corner and delay stay unknown.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.conditions import Conditions
from wheelhop.calibration.constants import (
    NOMINAL_CODES_PER_G,
    NOMINAL_GAIN_LIMIT,
    NOMINAL_ZERO_G_CODE,
    NOMINAL_ZERO_G_LIMIT_CODE,
    Constants,
    SensorConstants,
    Value,
    device_of,
)
from wheelhop.calibration.error import CalibrationError
from wheelhop.files.units import STANDARD_GRAVITY_M_S2
from wheelhop.logger.recording import CODE, Recording
from wheelhop.logger.supply import supply_change

Array = NDArray[np.float64]

GRAVITY_PART = 0.0027 / np.sqrt(3)
"""Gravity is 9.780 … 9.832 m/s² at sea level: relative standard uncertainty where it is unknown."""
BLOCK_S = 1.0
SHORTEST_REST_S = 8.0
QUIET_CODE = 0.6  # rms within a second, and change from one second to the next, of a sensor at rest
STILL_ROUNDING = 1 / np.sqrt(12)
"""A sensor that stands still on one code is not dithered: its level is uncertain by a code's
width, rectangular."""
TURNED = 0.5  # of the nominal swing: less is no turn
WIDEST_SWING = 1.5
METHOD = "turned over in the field, ±1 g"
GUIDE = (
    "Put all sensors on a level table, axis up as on the vehicle, cables free",
    "Start the logger (button). Leave everything alone for 60 s",
    "Turn every sensor upside down, onto its lid; level to 2°. Leave it alone for 60 s",
    "Turn them back, axis up. Leave everything alone for 60 s",
    "Once more upside down, 60 s, and axis up again, 60 s; then stop the logger",
)
CANNOT_TELL = (
    "frequency response and delay, linearity beyond ±1 g, and polarity (the first rest is taken"
    " for 'axis up'): these need wheelhop calibrate with a shaker"
)


@dataclass(frozen=True)
class Rest:
    """A piece at rest: `codes` (channels,) mean and `spread` (channels,) rms of a row."""

    start_s: float
    end_s: float
    codes: Array
    spread: Array


@dataclass(frozen=True)
class FlippedChannel:
    """One channel: `up_code` and `down_code` at rest, `budget` relative standard uncertainties of
    the gain."""

    name: str
    serial: str
    gain: Value
    offset: Value
    up_code: float
    down_code: float
    noise_code: float
    budget: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Flip:
    """What a flip session says. `orientations` are +1 (up) and -1 of the `rests`."""

    conditions: Conditions
    device: int
    rests: tuple[Rest, ...]
    orientations: tuple[int, ...]
    channels: tuple[FlippedChannel, ...]
    findings: tuple[str, ...]

    def constants(self) -> Constants:
        """What calibration.toml holds."""
        conditions = self.conditions
        sensors = tuple(
            SensorConstants(
                channel=channel.name,
                serial=channel.serial,
                gain=channel.gain,
                offset=channel.offset,
                date=conditions.day,
                valid_until=conditions.valid_until,
                method=METHOD,
                temperature_C=conditions.temperature_C,
                supply_V=conditions.supply_V,
                reference="gravity",
            )
            for channel in self.channels
        )
        return Constants(conditions.id, self.device, sensors)


def flip_calibration(log: Recording, conditions: Conditions) -> Flip:
    """Evaluate a recording in codes of sensors at rest, turned over in between.

    Raises CalibrationError if it was not done right, saying which sensor and what to repeat.
    """
    if any(channel.unit != CODE for channel in log.channels):
        raise CalibrationError("the recording is not in codes: give the logger's own file")
    rests = find_rests(log)
    if len(rests) < 2:
        raise CalibrationError(
            f"{len(rests)} rests of {SHORTEST_REST_S:g} s or more, two at least are needed,"
            " up and down: leave all sensors alone for 60 s each time"
        )
    codes = np.array([rest.codes for rest in rests])
    for column, channel in enumerate(log.channels):
        _check_swing(channel.name, float(np.ptp(codes[:, column])))
    above = codes > (codes.max(axis=0) + codes.min(axis=0)) / 2
    turned = above != above[0]
    together = (turned == turned[:, :1]).all(axis=1)  # in others some are turned, some not yet
    rests = [rest for rest, kept in zip(rests, together, strict=True) if kept]
    orientations = np.where(turned[together, 0], -1, 1)
    if not (orientations < 0).any():
        raise CalibrationError(
            "at no time were all sensors upside down together and at rest: turn them all, then"
            " leave them alone for 60 s"
        )
    channels = tuple(
        _channel(log, column, rests, orientations, conditions)
        for column in range(len(log.channels))
    )
    change = supply_change(log.notes)
    findings = (
        *([change.text] if change else ()),
        *_findings(channels, rests, orientations),
    )
    return Flip(
        *(conditions, device_of(log), tuple(rests)),
        *(tuple(int(sign) for sign in orientations), channels, findings),
    )


def _check_swing(name: str, swing: float) -> None:
    nominal = 2 * NOMINAL_CODES_PER_G
    if swing < TURNED * nominal:
        raise CalibrationError(
            f"channel {name}: swings by {swing:.1f} codes, not {nominal:.0f}: was this sensor"
            " turned over? If it is not there, leave it out of [sensors]"
        )
    if swing > WIDEST_SWING * nominal:
        raise CalibrationError(
            f"channel {name}: swings by {swing:.1f} codes, not {nominal:.0f}: more than gravity"
            " acted on it, or it is no ADXL326"
        )


def find_rests(log: Recording) -> list[Rest]:
    """The pieces in which all channels are quiet, without the second at either end."""
    size = round(BLOCK_S * log.rate_hz)
    count = len(log.values) // size
    blocks = log.values[: count * size].reshape(count, size, -1)
    level = blocks.mean(axis=1)
    quiet = (blocks.std(axis=1) < QUIET_CODE).all(axis=1)
    alike = (np.abs(np.diff(level, axis=0)) < QUIET_CODE).all(axis=1)
    starts = np.concatenate([[0], np.flatnonzero(~(alike & quiet[1:] & quiet[:-1])) + 1, [count]])
    rests = []
    for first, last in pairwise(starts):
        inner = slice(first + 1, last - 1)
        if (inner.stop - inner.start) * BLOCK_S >= SHORTEST_REST_S and quiet[inner].all():
            rows = blocks[inner].reshape(-1, blocks.shape[2])
            start, end = (log.start_s + k * size / log.rate_hz for k in (inner.start, inner.stop))
            rests.append(Rest(start, end, rows.mean(axis=0), rows.std(axis=0)))
    return rests


def _channel(
    log: Recording, column: int, rests: list[Rest], orientations: NDArray[np.int_], c: Conditions
) -> FlippedChannel:
    codes = np.array([rest.codes[column] for rest in rests])
    noise = float(np.median([rest.spread[column] for rest in rests]))
    up, down = codes[orientations > 0], codes[orientations < 0]
    per_g = (up.mean() - down.mean()) / 2
    gain = STANDARD_GRAVITY_M_S2 / per_g
    scatter = np.hypot(_scatter(up), _scatter(down)) / 2
    # Two levels, each off by the rounding that its noise does not dither away.
    rounding = _undithered(noise) / np.sqrt(2)
    tilt = np.radians(c.tilt_deg) ** 2 / 2 / np.sqrt(3)
    budget = (
        ("gravity", float(GRAVITY_PART)),
        ("alignment", float(tilt)),
        ("temperature", c.temperature_part),
        ("repeatability", float(scatter / abs(per_g))),
        ("quantisation", float(rounding / abs(per_g))),
    )
    relative = np.sqrt(sum(part**2 for _, part in budget))
    parts = (_scatter(up), _undithered(noise), c.offset_part_m_s2 / abs(gain), tilt * abs(per_g))
    return FlippedChannel(
        name=log.channels[column].name,
        serial=log.channels[column].sensor,
        gain=Value(float(gain), float(2 * relative * abs(gain))),
        offset=Value(float(up.mean()), float(2 * np.sqrt(np.square(parts).sum()))),
        up_code=float(up.mean()),
        down_code=float(down.mean()),
        noise_code=noise,
        budget=budget,
    )


def _scatter(codes: Array) -> float:
    """Standard uncertainty of a mean of rests; with one rest nothing is known of it."""
    return float(codes.std(ddof=1) / np.sqrt(len(codes))) if len(codes) > 1 else 0.0


def _undithered(noise_code: float) -> float:
    """Standard uncertainty of a level that was rounded down, in codes, by the noise of a row.

    Of the rounding error, noise of s codes rms leaves exp(−2π² s²) (Widrow and Kollár, Quantization
    Noise, 2008); single conversions are noisier than a row, which leaves less.
    """
    return float(STILL_ROUNDING * np.exp(-2 * np.pi**2 * noise_code**2))


def _findings(
    channels: tuple[FlippedChannel, ...], rests: list[Rest], orientations: NDArray[np.int_]
) -> list[str]:
    found = []
    if min((orientations > 0).sum(), (orientations < 0).sum()) < 2:
        found.append("one orientation was recorded only once: how repeatable it is is not known")
    for number, channel in enumerate(channels):
        per_g = abs(STANDARD_GRAVITY_M_S2 / channel.gain.value)
        if abs(per_g / NOMINAL_CODES_PER_G - 1) > NOMINAL_GAIN_LIMIT:
            found.append(
                f"{channel.name}: {per_g:.2f} codes per g, outside the data sheet's"
                f" {NOMINAL_CODES_PER_G:.2f} ± 10 %"
            )
        zero = (channel.up_code + channel.down_code) / 2
        if abs(zero - NOMINAL_ZERO_G_CODE) > NOMINAL_ZERO_G_LIMIT_CODE:
            found.append(
                f"{channel.name}: {zero:.0f} codes at 0 g, outside the data sheet's limits"
            )
        if channel.gain.value < 0:
            found.append(f"{channel.name}: the first rest shows fewer codes: its axis points down")
        up = [
            rest.codes[number] for rest, sign in zip(rests, orientations, strict=True) if sign > 0
        ]
        if len(up) > 1 and np.ptp(up) > 1.0:
            found.append(
                f"{channel.name}: upright it was off by {np.ptp(up):.1f} codes from one rest to the"
                " other: it drifts, or lay differently"
            )
    return found
