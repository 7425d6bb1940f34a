"""Inputs beside the eight: marks, a wheel's pulses, a temperature (SPEC.md, "Inputs beside …")."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.logger.recording import Channel, Recording
from wheelhop.logger.settings import CODE_BITS, CONVERSION_S, Settings, number

RECORD = np.dtype(
    [("pulses", "<u2"), ("since", "<u2"), ("temperature", "<u2"), ("marks", "u1"), ("zero", "u1")]
)
RECORDS_AT = 6  # in a payload, behind first scan (4), scans per record (1) and records (1)
LONG_AGO = 65535  # at which the count since the last pulse stays
ROUND = 1 << 16  # of the pulses' count
STANDS_S = 1.0  # without a pulse: a wheel that turns slower is taken to stand
REFERENCE_V, VOLTS_PER_K, ZERO_C_V = 3.3, 0.010, 0.5  # AREF, and a TMP36
COLDEST_C, HOTTEST_C = -40.0, 125.0  # that a TMP36 tells: what is beyond is none

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Beside:
    """What (n,) records say, of the state when scan number `scan` − 1 had ended, at `time_s` of the
    logger's clock behind the first conversion.

    `pulses` counts from the session's start; the last one before a record came at `pulse_s`, NaN
    where there was none of late. `temperature_code` is of 1024, 0 before the first reading.
    `pulses_per_km` is 0 where nobody has said it.
    """

    scan: NDArray[np.int64]
    time_s: Array
    pulses: NDArray[np.int64]
    pulse_s: Array
    temperature_code: Array
    marks: NDArray[np.int64]
    pulses_per_km: float

    @property
    def marks_s(self) -> Array:
        """(m,) when the button for marks was found pressed, number 1 first; to 0.1 s."""
        rises = np.diff(self.marks, prepend=0)
        return np.asarray(np.repeat(self.time_s, np.maximum(rises, 0)))

    @property
    def found(self) -> tuple[str, ...]:
        """The names of the channels that something is connected to."""
        return tuple(channel.name for channel, _ in self._channels(self.time_s))

    def pulse_rate_hz(self, time_s: Array) -> Array:
        """(m,) pulses a second at any times: between two that are known, their mean.

        Before the first and behind the last no more than what would have brought another pulse;
        0 where none came for a second.
        """
        known = np.isfinite(self.pulse_s)
        count, first = np.unique(self.pulses[known], return_index=True)
        at = self.pulse_s[known][first]
        if len(count) < 2:
            return np.zeros(len(time_s))
        rate = np.diff(count) / np.maximum(np.diff(at), CONVERSION_S)
        rate[np.diff(at) / np.diff(count) > STANDS_S] = 0.0
        piece = np.clip(np.searchsorted(at, time_s, "right") - 1, 0, len(rate) - 1)
        away = np.maximum(np.maximum(time_s - at[-1], at[0] - time_s), 1e-9)
        most = np.where(away > STANDS_S, 0.0, 1 / away)
        return np.asarray(np.minimum(rate[piece], most))

    def speed_m_s(self, time_s: Array) -> Array:
        """(m,) speed at any times, by `pulses_per_km`."""
        return self.pulse_rate_hz(time_s) * 1000 / self.pulses_per_km

    def temperature_c(self, time_s: Array) -> Array:
        """(m,) °C at any times; NaN where there is no sensible reading."""
        celsius = (self.temperature_code / 2**CODE_BITS * REFERENCE_V - ZERO_C_V) / VOLTS_PER_K
        good = (celsius >= COLDEST_C) & (celsius <= HOTTEST_C)
        if not good.any():
            return np.full(len(time_s), np.nan)
        return np.asarray(np.interp(time_s, self.time_s[good], celsius[good]))

    def _channels(self, time_s: Array) -> list[tuple[Channel, Array]]:
        columns = []
        if self.pulses[-1] > 0 and self.pulses_per_km:
            columns.append((Channel("speed", "m/s"), self.speed_m_s(time_s)))
        elif self.pulses[-1] > 0:
            columns.append((Channel("pulses", "Hz"), self.pulse_rate_hz(time_s)))
        celsius = self.temperature_c(time_s)
        if np.isfinite(celsius).all():
            columns.append((Channel("temperature", "°C"), celsius))
        return columns


def joined(
    payloads: Sequence[bytes], settings: Settings, header: Mapping[str, str]
) -> Beside | None:
    """Return what the payloads of a session's `I` blocks say, in their order; None: nothing."""
    scans, records = [], []
    for payload in payloads:
        count = min(payload[5], (len(payload) - RECORDS_AT) // RECORD.itemsize)
        scans.append(int.from_bytes(payload[:4], "little") + np.arange(count) * payload[4])
        records.append(np.frombuffer(payload, RECORD, count, RECORDS_AT))
    scan, record = np.concatenate(scans).astype(np.int64), np.concatenate(records)
    if not len(scan) or (np.diff(scan) <= 0).any():
        return None
    end_s = (scan * settings.steps - 1) * settings.step_s
    pulses = _unrolled(record["pulses"], ROUND)
    since_s = (record["since"] + 0.5) * settings.step_s
    return Beside(
        scan,
        end_s,
        pulses,
        np.where(record["since"] == LONG_AGO, np.nan, end_s - since_s),
        record["temperature"] / 2.0 ** (settings.code_bits - CODE_BITS),
        _unrolled(record["marks"], 1 << 8),
        number(header, "pulses_per_km"),
    )


def with_beside(recording: Recording, beside: Beside | None, own_s: Array) -> Recording:
    """Return the recording with the channels of what was connected beside the eight inputs.

    `own_s` (n,) are its rows by the logger's own clock, where its times are corrected for that.
    """
    columns = beside._channels(own_s) if beside and len(own_s) else []
    if not columns:
        return recording
    assert beside is not None
    own_rate_hz = (len(own_s) - 1) / (own_s[-1] - own_s[0]) if len(own_s) > 1 else recording.rate_hz
    scale = [
        recording.rate_hz / own_rate_hz if c.unit in ("m/s", "Hz") else 1.0 for c, _ in columns
    ]
    values = [column * factor for (_, column), factor in zip(columns, scale, strict=True)]
    names = ", ".join(channel.name for channel, _ in columns)
    return replace(
        recording.after(f"beside the eight inputs: {names}, ten records a second"),
        values=np.column_stack([recording.values, *values]),
        channels=(*recording.channels, *(channel for channel, _ in columns)),
    )


def _unrolled(count: NDArray[np.unsignedinteger], modulus: int) -> NDArray[np.int64]:
    """A count modulo `modulus` as one that only grows; it begins at 0."""
    steps = np.diff(count.astype(np.int64), prepend=0) % modulus
    return np.asarray(np.cumsum(steps))
