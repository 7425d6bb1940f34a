"""Stepped sines: find the steady pieces, and what each says of the response.

ISO 16063-21: the sensor is compared with a reference on the same table, frequency by frequency.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.shaker.align import Clock, window_mean
from wheelhop.calibration.shaker.points import Points
from wheelhop.calibration.shaker.quantisation import DRAWS, rounding_errors
from wheelhop.calibration.shaker.response import averaging
from wheelhop.calibration.shaker.sine import Sine, fit_known, fit_unknown, strongest_frequency_hz
from wheelhop.logger.recording import CODE, Recording

Array = NDArray[np.float64]

LOOK_HZ = 160.0  # rate at which steps are looked for
BLOCK_S, HOP_S = 2.0, 0.5
SETTLE_S = 0.5  # left out at both ends of a step
SHORTEST_S = 2.5
FEWEST_CYCLES = 3
STEADY = 0.01  # relative change of frequency within a step
STEADY_AMPLITUDE = 0.05
PURE = 0.15  # largest residual of a steady sine and its harmonics, relative
HARMONICS = 3
FEWEST_STEPS = 3
BLOCKS = 6  # pieces of a step whose scatter shows how repeatable it is


@dataclass(frozen=True)
class Step:
    """A steady piece of the reference's recording, on its own clock, and its sine there."""

    start_s: float
    end_s: float
    sine: Sine


def find_steps(reference: Recording) -> list[Step]:
    """The pieces where the reference is a steady sine; none if the motion was swept."""
    first_s, last_s = (float(t) for t in reference.time_s[[0, -1]])
    time_s = np.arange(first_s, last_s, 1 / LOOK_HZ)
    values = window_mean(reference.time_s, reference.values[:, 0], time_s, 1 / LOOK_HZ)
    size, hop = round(BLOCK_S * LOOK_HZ), round(HOP_S * LOOK_HZ)
    runs: list[list[tuple[float, float, float, float]]] = []
    steady: tuple[float, float] | None = None
    largest = float(np.abs(values).max())
    for first in range(0, len(values) - size, hop):
        t, y = time_s[first : first + size], values[first : first + size]
        sine = None
        frequency = strongest_frequency_hz(y, LOOK_HZ)
        if np.ptp(y) > 0.01 * largest and frequency * BLOCK_S > 1:
            sine = fit_unknown(t, y, frequency, min(2, _harmonics(frequency, LOOK_HZ)))
        if sine is None or sine.residual_rms > PURE * sine.amplitude / np.sqrt(2):
            steady = None
            continue
        here = sine.frequency_hz, sine.amplitude
        if steady is None or not _same(steady, here):
            steady = here
            runs.append([])
        runs[-1].append((float(t[0]), float(t[-1]), *here))
    steps = []
    for run in runs:
        start, end = run[0][0] + SETTLE_S, run[-1][1] - SETTLE_S
        frequency = float(np.median([seen[2] for seen in run]))
        if end - start >= SHORTEST_S and (end - start) * frequency >= FEWEST_CYCLES:
            t, y = _piece(reference, 0, start, end)
            if not np.isnan(y).any():
                steps.append(Step(start, end, fit_unknown(t, y, frequency, HARMONICS)))
    return steps if len(steps) >= FEWEST_STEPS else []


def _same(one: tuple[float, float], other: tuple[float, float]) -> bool:
    return abs(other[0] / one[0] - 1) < STEADY and abs(other[1] / one[1] - 1) < STEADY_AMPLITUDE


def stepped_drift(
    reference: Recording, log: Recording, column: int, steps: list[Step], clock: Clock
) -> float:
    """Drift from the ratio of the frequencies that the two recorders saw, step by step."""
    ratios, weights = [], []
    for step in steps:
        start, end = clock.on_logger(np.array([step.start_s + 0.3, step.end_s - 0.3]))
        t, y = _piece(log, column, start, end)
        if np.isfinite(y).sum() < 0.8 * (end - start) * log.rate_hz:
            continue
        frequency = step.sine.frequency_hz
        ours = fit_unknown(t, y, frequency, _harmonics(frequency, log.rate_hz))
        noise = ours.residual_rms / max(ours.amplitude, 1e-9)
        if noise < 0.5:
            ratios.append(ours.frequency_hz / frequency - 1)
            weights.append((frequency * (end - start) / max(noise, 1e-3)) ** 2)
    if not ratios:
        return 0.0
    order = np.argsort(ratios)
    share = np.cumsum(np.array(weights)[order])
    return float(np.array(ratios)[order][np.searchsorted(share, share[-1] / 2)])


def stepped_points(
    reference: Recording, log: Recording, column: int, steps: list[Step], clock: Clock
) -> Points:
    """The response of one channel at every step, from three-parameter fits of both recordings.

    Frequencies are those of the four-parameter fits to the reference. Both records of a step are
    cut into the same pieces; their ratios' scatter, and the noise that the fits leave, give the
    uncertainty. Coherence is the part of the channel's power that is in the sine.
    """
    rows = []
    for number, step in enumerate(steps):
        start, end = clock.on_logger(np.array([step.start_s, step.end_s]))
        t_l, y_l = _piece(log, column, start, end)
        if len(t_l) < 0.9 * (end - start) * log.rate_hz or np.isnan(y_l).mean() > 0.1:
            continue  # the logger did not run, or lost too much
        t_r, y_r = _piece(reference, 0, step.start_s, step.end_s)
        theirs = step.sine
        frequency = theirs.frequency_hz * (1 + clock.drift)
        harmonics = _harmonics(frequency, log.rate_hz)
        ratios = []
        for part_l in _parts(t_l, frequency):
            ours = fit_known(t_l[part_l], y_l[part_l], frequency, harmonics)
            middle = float(clock.on_reference(np.array(ours.middle_s)))
            half = (t_l[part_l][-1] - t_l[part_l][0]) / 2
            part_r = np.abs(t_r - middle) <= half
            piece = fit_known(t_r[part_r], y_r[part_r], theirs.frequency_hz, HARMONICS)
            ratios.append(ours.phasors[0] / piece.phasor_at(middle))
        ratio = np.array(ratios)
        whole = fit_known(t_l, y_l, frequency, harmonics)
        mean = complex(ratio.mean())
        power = float((np.abs(whole.phasors) ** 2).sum()) / 2
        coherence = power / (power + whole.residual_rms**2)
        white = whole.residual_rms * np.sqrt(2 / whole.count) / whole.amplitude
        scatter = np.std(np.abs(ratio), ddof=1) / np.sqrt(len(ratio)) / abs(mean)
        rounding = np.zeros(DRAWS, dtype=complex)
        if log.channels[column].unit == CODE:
            rounding = rounding_errors(log, column, whole, number)
        sizes = np.abs(theirs.phasors)
        rows.append(
            (
                *(theirs.frequency_hz, whole.middle_s, theirs.amplitude, mean),
                *(max(white, scatter), rounding, whole.offset, whole.residual_rms, coherence),
                float(np.sqrt((sizes[1:] ** 2).sum()) / sizes[0]),
            )
        )
    points = Points.of(rows)
    window = averaging(log, column, points.frequency_hz * (1 + clock.drift))
    return points.corrected(window)


def _piece(recording: Recording, column: int, start_s: float, end_s: float) -> tuple[Array, Array]:
    """Times and values from a start to an end by the recording's own clock."""
    first, last = (
        int(np.clip(np.ceil((t - recording.start_s) * recording.rate_hz), 0, len(recording.values)))
        for t in (start_s, end_s)
    )
    time_s = recording.start_s + np.arange(first, last) / recording.rate_hz
    return time_s, recording.values[first:last, column]


def _parts(time_s: Array, frequency_hz: float) -> list[NDArray[np.intp]]:
    cycles = frequency_hz * (time_s[-1] - time_s[0])
    return np.array_split(np.arange(len(time_s)), int(np.clip(cycles // 2, 2, BLOCKS)))


def _harmonics(frequency_hz: float, rate_hz: float) -> int:
    """As many as the recorder can tell from the fundamental and from its aliases."""
    return int(np.clip(0.45 * rate_hz // frequency_hz, 1, HARMONICS))
