"""Which sensor sits where, and which way up: strike beside each of them in turn.

Let h_ij(t) be the velocity of place j after a strike of impulse 1 at place i. Whatever the vehicle
is like, h is symmetric (Rayleigh's reciprocity), and a positive definite function of time (strikes
do work, the vehicle does none): |h_ij(t)|² ≤ h_ii(0)·h_jj(0). So, of all pairings σ of strikes with
places, the product over the strikes of the largest |h_iσ(i)| is greatest for the right one. The
strengths of the strikes and the gains of the sensors multiply the products of all pairings alike:
the pairing with the largest product of *measured* velocities is the right one.

A sensor that is struck downwards moves down first, and never as fast in any direction again:
|h_ii(t)| ≤ h_ii(0). Window and filter round the first velocity off more than those that follow; so
the sign of the first one that is half as large as the largest tells which way up the sensor is.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.logger.recording import Recording

APART_S = 1.0  # what is nearer than this belongs to the same strike
FELT_S = 0.05  # before and after its strongest sample
BEFORE_S = 0.4  # mean over which is taken for rest
CLEAR = 2.0  # the weakest strike over the strongest of what else happened
MOST_SURE = 1e6
FAINT = 0.5  # codes summed; below, rounding decides

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Taps:
    """Strikes in order of time.

    `rows` (k,) is where each was strongest. `felt` (k, n_channels) is the largest velocity of each
    channel then, codes summed over samples, with the sign of the first that is half as large.
    """

    rows: NDArray[np.int64]
    felt: Array

    def pairing(self) -> tuple[NDArray[np.int64], float]:
        """(k,) the channel of each strike, k = n_channels, and how many times larger its product
        is than the next best pairing's, a million at most."""
        size = np.log(np.maximum(np.abs(self.felt), FAINT))
        best, total = _assign(size)
        runners_up = []
        for strike, channel in enumerate(best):
            without = size.copy()
            without[strike, channel] = -100.0
            runners_up.append(_assign(without)[1])
        return best, float(min(np.exp(total - max(runners_up)), MOST_SURE))


def find_taps(recording: Recording, count: int) -> Taps | int:
    """Return the `count` strikes of a recording at rest, or how many stand out if not so many."""
    deviation = np.nan_to_num(recording.values - np.nanmedian(recording.values, axis=0))
    apart, around = round(APART_S * recording.rate_hz), round(FELT_S * recording.rate_hz)
    activity = np.abs(deviation).max(axis=1)
    rows: list[int] = []
    strengths: list[float] = []
    while len(rows) < 3 * count and activity.any():
        row = int(np.argmax(activity))
        rows.append(row)
        strengths.append(float(activity[row]))
        activity[max(row - apart, 0) : row + apart + 1] = 0.0
    drops = np.array(strengths) / np.maximum([*strengths[1:], 0.0], FAINT)
    if len(rows) < count or drops[count - 1] < CLEAR:
        return int(np.argmax(drops)) + 1 if len(rows) and drops.max() >= CLEAR else 0
    found = np.sort(rows[:count])
    before = round(BEFORE_S * recording.rate_hz)
    felt = []
    for row in found:
        rest = deviation[max(row - around - before, 0) : max(row - around, 1)].mean(axis=0)
        window = deviation[max(row - around, 0) : row + around + 1] - rest
        felt.append(_largest(np.cumsum(window, axis=0)))
    return Taps(found, np.array(felt))


def _largest(velocity: Array) -> Array:
    largest = np.abs(velocity).max(axis=0)
    first = np.argmax(np.abs(velocity) >= largest / 2, axis=0)
    return np.asarray(np.sign(velocity[first, np.arange(velocity.shape[1])]) * largest)


def _assign(size: Array) -> tuple[NDArray[np.int64], float]:
    from scipy.optimize import linear_sum_assignment

    strikes, channels = linear_sum_assignment(size, maximize=True)
    return channels, float(size[strikes, channels].sum())
