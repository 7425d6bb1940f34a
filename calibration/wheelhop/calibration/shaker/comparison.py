"""Calibration by comparison with a reference on a shaker (ISO 16063-21), its uncertainties by GUM.

The two recorders share no clock: offset and drift come out of the same signals.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.conditions import Conditions
from wheelhop.calibration.constants import Value, device_of
from wheelhop.calibration.error import CalibrationError
from wheelhop.calibration.shaker.align import Clock, rough_clock, swept_clock, whole_clock
from wheelhop.calibration.shaker.chain import (
    CONSTANT,
    GAIN,
    OFFSET,
    Chain,
    fit_chain,
    lock,
    rephased,
)
from wheelhop.calibration.shaker.findings import find
from wheelhop.calibration.shaker.points import Points
from wheelhop.calibration.shaker.response import averaging, high_pass, one_pole
from wheelhop.calibration.shaker.result import (
    ALIKE,
    LEAST_COHERENCE,
    REFERENCE_HZ,
    ChannelCalibration,
    Comparison,
)
from wheelhop.calibration.shaker.steps import Step, find_steps, stepped_drift, stepped_points
from wheelhop.calibration.shaker.sweep import swept_points, usable_band_hz
from wheelhop.files.units import STANDARD_GRAVITY_M_S2
from wheelhop.logger.recording import CODE, Recording
from wheelhop.logger.supply import supply_change

Array = NDArray[np.float64]

LOCK_S = 0.03  # what the rough clocks may be off by
PERIODS_S = 0.5  # and by which they are, where steady sines have matched a period too early
FEWEST_FREQUENCIES = 3
HIGHEST_CODE = 1023
NO_FIT = 100.0  # times what the points' own scatter allows


def compare_with_reference(
    reference: Recording,
    log: Recording,
    conditions: Conditions,
    tell: Callable[[str], None] = lambda text: None,
) -> Comparison:
    """Calibrate all channels of `log` against the only one of `reference`, which is in m/s².

    Steps are recognised; a motion that has none counts as swept. `tell` hears of progress. Raises
    CalibrationError where the recordings have too little in common.
    """
    tell("looking for steady sines")
    steps = find_steps(reference)
    loudest = int(np.nanargmax(np.nanstd(log.values, axis=0)))
    _check_frequencies(steps)
    _check_range(log)
    tell("comparing the clocks")
    clock = rough_clock(reference, log, loudest)
    if steps:
        clock = Clock(clock.offset_s, stepped_drift(reference, log, loudest, steps, clock))
        clock = whole_clock(reference, log, loudest, clock)
    else:
        clock = swept_clock(reference, log, loudest, clock)
    found, usable, chain = _fitted(reference, log, loudest, steps, clock, conditions, tell)
    if chain.birge.min() > NO_FIT:  # some period too early or too late
        clock, _ = lock(usable[loudest], clock, PERIODS_S)
        found, usable, chain = _fitted(reference, log, loudest, steps, clock, conditions, tell)
    if chain.birge.min() > NO_FIT:
        raise CalibrationError(
            "no clock and no filter make the phases of the two recordings agree: are they of the"
            " same session, and did both run without a pause?"
        )
    channels = tuple(
        _channel(log, column, usable[column], found[column], chain, conditions)
        for column in range(len(found))
    )
    drift = Value(chain.clock.drift * 1e6, 2e6 * chain.deviation(np.eye(len(chain.parameters))[0]))
    mean = np.zeros(len(chain.parameters))
    mean[1 + OFFSET :: 3] = 1 / len(channels)
    offset = Value(chain.clock.offset_s, 2 * chain.deviation(mean))
    change = supply_change(log.notes)
    findings = (
        *([change.text] if change else ()),
        *find(channels, usable, chain, conditions),
    )
    return Comparison(conditions, device_of(log), bool(steps), offset, drift, channels, findings)


def _fitted(
    reference: Recording,
    log: Recording,
    loudest: int,
    steps: list[Step],
    clock: Clock,
    conditions: Conditions,
    tell: Callable[[str], None],
) -> tuple[list[Points], list[Points], Chain]:
    """All points of every channel, those usable with the clocks locked, and their fit."""
    found = []
    for column, channel in enumerate(log.channels):
        tell(f"fitting channel {channel.name}")
        found.append(_points(reference, log, column, steps, clock, conditions))
    usable = [points.where(points.coherence >= LEAST_COHERENCE) for points in found]
    exact, _ = lock(usable[loudest], clock, LOCK_S)
    usable = [rephased(points, clock, exact) for points in usable]
    raw = any(channel.unit == CODE for channel in log.channels)
    return found, usable, fit_chain(usable, exact, fixed_corner=not raw)


def _check_frequencies(steps: list[Step]) -> None:
    """A sine alone fits the other a period later as well, and with any filter."""
    seen = np.sort([step.sine.frequency_hz for step in steps])
    count = 1 + int((seen[1:] > seen[:-1] * (1 + ALIKE)).sum())
    if steps and count < FEWEST_FREQUENCIES:
        raise CalibrationError(
            f"the reference has steady sines at {count} frequencies only, clocks and filter need"
            f" {FEWEST_FREQUENCIES}: drive it at 5, 10 and 20 Hz at least"
        )


def _check_range(log: Recording) -> None:
    """What is cut off is no sine, and looks like a smaller one."""
    for column, channel in enumerate(log.channels):
        values = log.values[:, column]
        if channel.unit == CODE and (np.nanmin(values) < 1 or np.nanmax(values) > HIGHEST_CODE - 1):
            raise CalibrationError(
                f"channel {channel.name}: its codes reach the end of the converter's range:"
                " repeat with less amplitude, or look for a loose wire"
            )


def _points(
    reference: Recording,
    log: Recording,
    column: int,
    steps: list[Step],
    clock: Clock,
    conditions: Conditions,
) -> Points:
    """Points of a channel, the averaging and the reference's own filter taken out."""
    if steps:
        points = stepped_points(reference, log, column, steps, clock)
    else:
        points = swept_points(reference, log, column, clock)
    frequency = points.frequency_hz
    own = averaging(reference, 0, frequency) * high_pass(frequency, conditions.high_pass_hz)
    points = points.corrected(1 / own)
    if (points.coherence >= LEAST_COHERENCE).sum() < 2:
        raise CalibrationError(
            f"channel {log.channels[column].name}: follows the reference at fewer than two"
            " frequencies: is this sensor on the table? If not, leave it out of [sensors]"
        )
    return points


def _channel(
    log: Recording,
    column: int,
    points: Points,
    all_points: Points,
    chain: Chain,
    conditions: Conditions,
) -> ChannelCalibration:
    at = np.array([REFERENCE_HZ])
    constant = chain.parameters[chain.of(column, CONSTANT)]
    pole = complex(one_pole(at, constant)[0])
    static, dynamic, late = (np.zeros(len(chain.parameters)) for _ in range(3))
    static[chain.of(column, GAIN)] = dynamic[chain.of(column, GAIN)] = 1
    omega = 2 * np.pi * REFERENCE_HZ
    dynamic[chain.of(column, CONSTANT)] = -(-1j * omega * pole).real
    late[chain.of(column, CONSTANT)] = 1 / (1 + (omega * constant) ** 2)
    late[1 + OFFSET :: 3] += 1 / len(chain.polarity)
    late[chain.of(column, OFFSET)] -= 1
    own = (
        ("reference", conditions.reference_part),
        ("alignment", conditions.alignment_part),
        ("temperature", conditions.temperature_part),
    )
    budget = (*own, *chain.parts(dynamic))
    static_part = np.sqrt(sum(u**2 for _, u in (*own, *chain.parts(static))))
    dynamic_part = np.sqrt(sum(u**2 for _, u in budget))
    gain = chain.gain(column)
    sensitivity = gain / abs(pole)
    offsets = chain.parameters[1 + OFFSET :: 3]
    delay = -np.angle(pole) / omega + offsets.mean() - offsets[column]
    deviation, phase = chain.residuals[column].real, chain.residuals[column].imag
    return ChannelCalibration(
        name=log.channels[column].name,
        unit=log.channels[column].unit,
        serial=log.channels[column].sensor,
        points=all_points,
        gain=Value(gain, 2 * abs(gain) * float(static_part)),
        sensitivity=Value(sensitivity, 2 * abs(sensitivity) * float(dynamic_part)),
        corner_hz=_corner(constant, chain, column),
        delay_s=Value(float(delay), 2 * chain.deviation(late)),
        offset=_offset(points, gain, conditions),
        noise=float(np.median(points.noise)),
        nonlinearity=_nonlinearity(points, deviation),
        deviation=deviation,
        expanded=2 * points.uncertainty,
        phase_rad=phase,
        budget=budget,
        usable_hz=usable_band_hz(all_points, LEAST_COHERENCE),
    )


def _corner(constant: float, chain: Chain, column: int) -> Value | None:
    """Corner frequency, None where the data do not show one."""
    weights = np.zeros(len(chain.parameters))
    weights[chain.of(column, CONSTANT)] = 1
    expanded = 2 * chain.deviation(weights)
    if constant <= expanded:
        return None
    corner = float(1 / (2 * np.pi * constant))
    return Value(corner, float(corner * expanded / constant))


def _offset(points: Points, gain: float, conditions: Conditions) -> Value:
    """The code at rest with the axis as in use, and what temperature leaves open of it."""
    weight = 1 / np.maximum(points.noise, 1e-6) ** 2
    mean = float((points.offset * weight).sum() / weight.sum())
    scatter = float(points.offset.std(ddof=1) / np.sqrt(len(points)))
    parts = [scatter, conditions.offset_part_m_s2 / abs(gain)]
    if conditions.axis == "horizontal":
        mean += STANDARD_GRAVITY_M_S2 / gain
        tilt = np.sin(np.radians(conditions.tilt_deg)) / np.sqrt(3)
        parts.append(STANDARD_GRAVITY_M_S2 / abs(gain) * float(tilt))
    return Value(mean, 2 * float(np.sqrt(np.square(parts).sum())))


def _nonlinearity(points: Points, deviation: Array) -> Value | None:
    """Largest difference of gain between amplitudes at one frequency; None if there was only one.

    Its uncertainty is that of the two points.
    """
    worst: Value | None = None
    for one in range(len(points)):
        for other in range(one + 1, len(points)):
            alike = abs(points.frequency_hz[one] / points.frequency_hz[other] - 1) < ALIKE
            ratio = points.amplitude_m_s2[one] / points.amplitude_m_s2[other]
            if alike and not 2 / 3 < ratio < 1.5:
                size = float(abs(deviation[one] - deviation[other]))
                limit = 2 * float(np.hypot(points.uncertainty[one], points.uncertainty[other]))
                if worst is None or size / limit > worst.value / worst.expanded:
                    worst = Value(size, limit)
    return worst
