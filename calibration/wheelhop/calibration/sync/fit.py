"""Complex amplitudes of a recording at the frequencies of its drive, with their uncertainty.

Fits of sines of common frequency to short blocks (IEEE 1057, three parameters, several sines at
once); their scatter from block to block is the uncertainty (GUM 4.2: type A). Only ratios between
channels are kept, so neither the drive's level nor the clocks' difference matters.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.error import CalibrationError

BLOCK_PERIODS = 8
SHORTEST_BLOCK_S = 0.5
FEWEST_BLOCKS = 4
SEARCHED = 0.01  # the drive's frequency may differ from what is written by this fraction
ACTIVE = 0.5  # a block in which the drive has this part of its largest power takes part
LOUD = 0.1  # power of a tone over what no tone explains
WHOLE = 0.8  # part of a block's rows that must be there

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Tones:
    """What the channels share at each frequency.

    `frequencies_hz` (f,) as found, by the recorder's clock. `ratios` (f, c) are relative complex
    amplitudes, Σ|ratio|² = 1; `uncertainty` (f, c) is the standard uncertainty of their real, and
    of their imaginary part. `amplitudes` (f,) scales them back to the channels' unit. `blocks` (f,)
    have been used.
    """

    frequencies_hz: Real
    ratios: Complex
    uncertainty: Real
    amplitudes: Real
    blocks: NDArray[np.int64]


def fit_tones(values: Real, rate_hz: float, nominal_hz: tuple[float, ...]) -> Tones:
    """Fit sines near `nominal_hz` to `values` (n, c), rows with NaN left out.

    Raises CalibrationError where a frequency is not in the recording, or the recording is short.
    """
    if max(nominal_hz) > 0.45 * rate_hz:
        raise CalibrationError(
            f"a drive at {max(nominal_hz):g} Hz cannot be seen at {rate_hz:g} samples a second:"
            f" drive below {0.45 * rate_hz:g} Hz"
        )
    nominal = np.array(nominal_hz)
    spacing = np.diff(nominal).min(initial=np.inf)
    seconds = max(SHORTEST_BLOCK_S, BLOCK_PERIODS / nominal[0], 3.0 / spacing)
    n = max(8 * len(nominal), round(seconds * rate_hz))
    if len(values) < FEWEST_BLOCKS * n:
        raise CalibrationError(
            f"{len(values) / rate_hz:.3g} s are too short: with these frequencies record"
            f" {2 * FEWEST_BLOCKS * n / rate_hz:.0f} s or more"
        )
    if np.isnan(values).any(axis=1).mean() > 1 - WHOLE:
        raise CalibrationError("more than a fifth of the samples are missing: record again")
    frequencies = np.array([_peak(values, rate_hz, each) for each in nominal])
    for _ in range(3):
        blocks, _ = _blocks(values, rate_hz, frequencies, n)
        frequencies = frequencies + [
            _slope(blocks[_active(blocks[:, f]), f]) * rate_hz / n for f in range(len(nominal))
        ]
    blocks, rest = _blocks(values, rate_hz, frequencies, n)
    found = []
    for f, frequency in enumerate(nominal):
        active = _active(blocks[:, f])
        found.append(_shared(blocks[active, f], rest[active], float(frequency)))
    ratios, uncertainty, amplitudes, counts = (np.array(part) for part in zip(*found, strict=True))
    return Tones(frequencies, ratios, uncertainty, amplitudes, counts)


def _peak(values: Real, rate_hz: float, nominal_hz: float) -> float:
    """The frequency near the nominal one at which all channels together are loudest."""
    present = np.nan_to_num(values - np.nanmean(values, axis=0))
    size = 4 * len(values)
    power = np.sum(
        np.abs(np.fft.rfft(present * np.hanning(len(values))[:, None], size, axis=0)) ** 2, axis=1
    )
    grid = np.fft.rfftfreq(size, 1 / rate_hz)
    near = np.flatnonzero(np.abs(grid - nominal_hz) <= max(SEARCHED * nominal_hz, grid[4]))
    return float(grid[near[np.argmax(power[near])]])


def _blocks(values: Real, rate_hz: float, frequencies_hz: Real, n: int) -> tuple[Complex, Real]:
    """(blocks, f, c) amplitudes of e^{iωt}, t from the recording's start, and the power (blocks,)
    that they leave of all channels; NaN where a block has not enough rows."""
    count, channels = len(values) // n, values.shape[1]
    out = np.full((count, len(frequencies_hz), channels), np.nan, dtype=np.complex128)
    rest = np.full(count, np.nan)
    root_window = np.sqrt(np.hanning(n + 2)[1:-1])
    offset = (np.arange(n) - (n - 1) / 2) / n
    for b in range(count):
        rows = values[b * n : (b + 1) * n]
        there = ~np.isnan(rows).any(axis=1)
        if there.mean() < WHOLE:
            continue
        angle = 2 * np.pi * np.outer(np.arange(b * n, (b + 1) * n) / rate_hz, frequencies_hz)
        design = np.hstack([np.cos(angle), -np.sin(angle), np.ones((n, 1)), offset[:, None]])
        weight = root_window[there, None]
        fit = np.linalg.lstsq(design[there] * weight, rows[there] * weight, rcond=None)[0]
        f = len(frequencies_hz)
        out[b] = fit[:f] + 1j * fit[f : 2 * f]
        rest[b] = float(np.sum(np.mean((rows[there] - design[there] @ fit) ** 2, axis=0)))
    return out, rest


def _active(blocks: Complex) -> NDArray[np.int64]:
    """Blocks of a frequency that are driven, and whose neighbours are: there the beam is steady."""
    power = np.nan_to_num(np.sum(np.abs(blocks) ** 2, axis=1))
    on = power > ACTIVE * power.max()
    inner = on & np.append(on[1:], True) & np.insert(on[:-1], 0, True)
    return np.flatnonzero(inner if inner.sum() >= FEWEST_BLOCKS else on)


def _slope(blocks: Complex) -> float:
    """Turns per block by which the phase of all channels drifts."""
    if len(blocks) < 2:
        return 0.0
    return float(np.angle(np.sum(blocks[1:] * blocks[:-1].conj())) / (2 * np.pi))


def _shared(blocks: Complex, rest: Real, nominal_hz: float) -> tuple[Complex, Real, float, int]:
    """Amplitudes (b, c) as one pattern times a level for each block: the strongest component."""
    if len(blocks) < FEWEST_BLOCKS:
        raise CalibrationError(
            f"the drive at {nominal_hz:g} Hz lasts for {len(blocks)} steady blocks, not"
            f" {FEWEST_BLOCKS}: record longer, or correct frequencies_hz"
        )
    level, size, pattern = np.linalg.svd(blocks, full_matrices=False)
    power = np.sum(size**2)
    if size[0] ** 2 < 0.5 * power or power / len(blocks) / 2 <= LOUD * rest.mean():
        raise CalibrationError(
            f"the recording has no steady vibration at {nominal_hz:g} Hz: correct frequencies_hz,"
            " or drive harder"
        )
    ratios = pattern[0]
    scaled = blocks / (level[:, :1] * size[0])
    scatter = np.mean(np.abs(scaled - ratios) ** 2, axis=0) / 2
    uncertainty = np.sqrt(scatter / (len(blocks) - 1))
    return ratios, uncertainty, float(size[0] / np.sqrt(len(blocks))), len(blocks)
