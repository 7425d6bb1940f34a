"""A filter that nobody stated: the noise of the sensors dies before half the sample rate.

Noise of a sensor is white. Where it lies above the motion, from the top of the band on, its
spectrum is flat up to the corner of the recorder's filter and falls behind it; motion has no flat
part, and what is added behind the filter does not fall. So order and corner are seen where the
sensors' noise is, and nothing is said elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, Run
from wheelhop.gate.finding import Finding

Array = NDArray[np.float64]

ORDERS = range(1, 11)
ADDED_DB = (-80.0, -50.0, -40.0, -30.0, -20.0, -15.0)
"""Noise behind the filter over that before it: codes, and the recorder's own."""
FALL_DB = 6.0
"""By so much at least the spectrum falls: a quarter of all windows tells it to a decibel."""
FLAT_DB = 2.0
"""And so little it changes before, from the top of the band to `BELOW` of the corner."""
BELOW = 0.7
FLAT_OCTAVES = 0.3
"""How long the flat part has to be."""
TOP = 0.95
"""Of half the sample rate; the last bins hold what a window folds."""


@dataclass(frozen=True)
class Seen:
    """The Butterworth filter that spectra look like, by how much they fall behind it, in decibels,
    and the standard deviations of order and corner over the channels."""

    order: int
    corner_hz: float
    fall_db: float
    order_spread: float
    corner_spread_hz: float


def filter_findings(campaign: Campaign) -> Iterator[Finding]:
    """Of a campaign that states neither a filter nor means."""
    if any(campaign.filters) or campaign.averaging_s > 0.0:
        return
    seen = seen_filter(campaign)
    if seen is None:
        return
    line = f'filter = {{ kind = "butterworth", order = {seen.order}, corner_hz = '
    yield Finding(
        "before",
        "filter",
        "filter",
        f"The noise of the sensors is flat up to about {BELOW * seen.corner_hz:.0f} Hz and falls by"
        f" {seen.fall_db:.0f} dB towards half the sample rate, as behind a filter of order"
        f" {seen.order} ± {max(seen.order_spread, 0.5):.1g} at {seen.corner_hz:.3g} ±"
        f" {max(seen.corner_spread_hz, 0.01 * seen.corner_hz):.2g} Hz: what filtered them?",
        f"Look into the recorder's data sheet; if it has such a filter, state {line}"
        f"{seen.corner_hz:.3g} }}. Unless one is stated, diagnose fits order and corner itself.",
        "likely",
    )


def seen_filter(campaign: Campaign) -> Seen | None:
    """The filter that most channels show; None if there is none, or no noise to tell it by."""
    if not campaign.runs:
        return None
    at, quiet = quiet_spectra(campaign)
    used = (at >= campaign.band_hz[1]) & (at <= TOP * campaign.sample_rate_hz / 2)
    level = 10 * np.log10(np.maximum(quiet[used], 1e-300))
    if used.sum() < 3 or not (quiet[used] > 0.0).all():
        return None
    rate_hz = campaign.sample_rate_hz
    order, corner, fall = _likeliest(at[used], level, rate_hz)
    flat = at[used] <= BELOW * corner
    octaves = np.log2(BELOW * corner / campaign.band_hz[1])
    if fall < FALL_DB or octaves < FLAT_OCTAVES:
        return None
    slope = np.polyfit(np.log2(at[used][flat]), level[flat], 1)[0]
    if np.median(np.abs(slope * octaves)) > FLAT_DB:
        return None
    each = [_likeliest(at[used], level[:, [i]], rate_hz) for i in range(level.shape[1])]
    agreeing = [one for one in each if one[2] >= FALL_DB]
    if 2 * len(agreeing) <= len(each):
        return None
    orders, corners, _ = np.array(agreeing).T
    return Seen(order, corner, fall, float(orders.std()), float(corners.std()))


def quiet_spectra(campaign: Campaign) -> tuple[Array, Array]:
    """Frequencies (f,), Hz, and the power (f, c) of channels in their quieter windows: of windows
    of a second the quarter in which least moves, at every frequency."""
    n = round(campaign.sample_rate_hz)
    windows = np.concatenate([_windows(run, n) for run in campaign.runs if len(run.time_s) >= n])
    at = np.fft.rfftfreq(n, 1.0 / campaign.sample_rate_hz)
    return np.asarray(at, np.float64), np.quantile(windows, 0.25, axis=0)


def _windows(run: Run, n: int) -> Array:
    """Powers (w, f, c) of windows that overlap by half."""
    taper = np.hanning(n)[:, None]
    starts = range(0, len(run.time_s) - n + 1, n // 2)
    pieces = [run.record[i : i + n] - run.record[i : i + n].mean(axis=0) for i in starts]
    return np.abs(np.fft.rfft(taper * np.array(pieces), axis=1)) ** 2


def _likeliest(at_hz: Array, level_db: Array, rate_hz: float) -> tuple[int, float, float]:
    """Order, corner and fall of the filter whose shape levels (f, c) have, each at its height, with
    what is folded from beyond half the sample rate, and some noise added behind it."""
    corners = np.geomspace(at_hz[0], at_hz[-1], 60)  # to 2 %
    folded = np.abs(at_hz[:, None] + rate_hz * np.arange(-3, 4))
    about = level_db - level_db.mean(axis=0)
    best = (np.inf, 1, corners[0], 0.0)
    for order, added in product(ORDERS, ADDED_DB):
        ratio = folded / corners[:, None, None]
        passed = (1.0 / (1.0 + ratio ** (2 * order))).sum(axis=2)
        shapes = 10 * np.log10(passed + 10 ** (added / 10))
        falls = shapes[:, 0] - shapes[:, -1]
        shapes -= shapes.mean(axis=1, keepdims=True)
        left = ((about[None] - shapes[:, :, None]) ** 2).mean(axis=(1, 2))
        k = int(np.argmin(left))
        if left[k] < best[0]:
            best = (float(left[k]), order, float(corners[k]), float(falls[k]))
    return best[1], best[2], best[3]
