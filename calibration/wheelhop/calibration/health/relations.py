"""What channels tell of each other in a vehicle: which is inverted, which two are exchanged.

The body is moved by its four struts, and a strut by what its two ends do: with u = (A − B)/s² the
strut's stretch and s u its speed, each body point obeys

    B_k = Σ_j (α_j + β_j s) u_j          j: own corner, same axle, same side, diagonal

with real constants that left and right share, and the body is rigid, B1 − B2 − B3 + B4 = 0. The
ground does not appear. Every inversion or exchange of channels breaks this in its own way; the one
that mends it best is named, with those that are nearly as good. The pattern is Newton's law with
linear struts (docs/theory.md); what is nonlinear in a vehicle widens the residual, not the pattern.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.sync.delay import stretches
from wheelhop.logger.recording import Recording

POINTS = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")
BAND_HZ = (1.5, 15.0)
NOISE_HZ = 0.35  # of the rate: above it, noise is estimated
STRUT_RAD_S = 20.0  # about where a strut's stretch, found by integrating twice, is as noisy as B
MODEL_ERROR = 0.05  # of the body's motion, that the law above may miss
TWIST_ERROR = 0.10  # and its rigidity
SHORTEST_S = 4.0
BROKEN = 3.0  # misfit above which the law does not hold
BETTER = 3.0  # by this factor a change must mend it
RIVAL = 1.5  # and what mends it within this factor of the best is as likely
CORNERS = np.array([[0, 1, 2, 3], [1, 0, 3, 2], [2, 3, 0, 1], [3, 2, 1, 0]])
TWIST = np.array([1.0, -1.0, -1.0, 1.0, 0.0, 0.0, 0.0, 0.0])

Real = NDArray[np.float64]


@dataclass(frozen=True)
class Change:
    """`kind` "none", "polarity" or "swapped" of the `points`; `misfit` is what is left with it."""

    kind: str
    points: tuple[str, ...]
    misfit: float


@dataclass(frozen=True)
class Relations:
    """`as_is` and the other changes, best first."""

    as_is: Change
    others: tuple[Change, ...]

    @property
    def broken(self) -> bool:
        """The law does not hold as the channels are."""
        return self.as_is.misfit > BROKEN

    @property
    def settled(self) -> bool:
        """No change comes near to the channels as they are."""
        return self.others[0].misfit > BETTER * self.as_is.misfit

    @property
    def mending(self) -> tuple[Change, ...]:
        """The change that mends it, first, and those that do so about as well."""
        best = self.others[0].misfit
        if not self.broken or best * BETTER > self.as_is.misfit:
            return ()
        return tuple(change for change in self.others if change.misfit < RIVAL * best)

    @property
    def untold(self) -> tuple[Change, ...]:
        """Changes that would not show: the recording is too uniform or too quiet to tell them."""
        limit = BETTER * max(self.as_is.misfit, 1.0)
        return () if self.broken else tuple(c for c in self.others if c.misfit < limit)


def relate(recordings: Sequence[Recording]) -> Relations | None:
    """Judge recordings of one set-up together; None where a point or enough samples are missing."""
    parts = [part for recording in recordings if (part := _sums(recording)) is not None]
    if not parts:
        return None
    law = np.sum([part[0] for part in parts], axis=0)
    twist = np.sum([part[1] for part in parts], axis=0)
    count = 5 * sum(part[2] for part in parts)

    def misfit(order: NDArray[np.int64], sign: Real) -> float:
        """Mean square of the weighted residuals with the channels changed; about 1 if right."""
        all_three = np.concatenate([order, order + 8, order + 16])
        signs = np.tile(sign, 3)
        changed = law[np.ix_(all_three, all_three)] * np.outer(signs, signs)
        body = twist[np.ix_(order, order)] * np.outer(sign, sign)
        return float((_law_residual(changed) + TWIST @ body @ TWIST) / count)

    identity, upright = np.arange(8), np.ones(8)
    others = []
    for i in range(8):
        sign = upright.copy()
        sign[i] = -1.0
        others.append(Change("polarity", (POINTS[i],), misfit(identity, sign)))
    for i, j in combinations(range(8), 2):
        order = identity.copy()
        order[[i, j]] = j, i
        pair = tuple(sorted((POINTS[i], POINTS[j])))
        others.append(Change("swapped", pair, misfit(order, upright)))
    as_is = Change("none", (), misfit(identity, upright))
    return Relations(as_is, tuple(sorted(others, key=lambda change: change.misfit)))


def _sums(recording: Recording) -> tuple[Real, Real, int] | None:
    """Weighted sums of products over the band: (24, 24) of x, x/s² and x/s for the law, (8, 8) of x
    for the rigid body, and the number of lines. Constants are real, so the real part is all."""
    names = [channel.point or channel.name for channel in recording.channels]
    if any(names.count(point) != 1 for point in POINTS):
        return None
    start, stop = max(stretches(~recording.missing), key=lambda s: s[1] - s[0], default=(0, 0))
    n = stop - start
    if n < SHORTEST_S * recording.rate_hz:
        return None
    values = recording.values[start:stop, [names.index(point) for point in POINTS]]
    window = np.hanning(n)[:, None] / np.sqrt(n)
    x = np.fft.rfft((values - values.mean(axis=0)) * window, axis=0)
    grid = np.fft.rfftfreq(n, 1 / recording.rate_hz)
    band = (grid >= BAND_HZ[0]) & (grid <= BAND_HZ[1])
    floor = np.median(np.abs(x[grid > NOISE_HZ * recording.rate_hz]) ** 2) / np.log(2)
    x = x[band]
    omega = 2 * np.pi * grid[band][:, None]
    moved = float(np.mean(np.abs(x[:, :4]) ** 2)) + np.finfo(float).tiny
    variance = floor * (1 + 2 * (STRUT_RAD_S / omega) ** 4) + MODEL_ERROR**2 * moved
    ratio = STRUT_RAD_S / (1j * omega)
    features = np.hstack([x, x * ratio**2, x * ratio]) / np.sqrt(variance)
    rigid = (x.conj().T @ x).real / (4 * floor + TWIST_ERROR**2 * moved)
    return (features.conj().T @ features).real, rigid, len(x)


def _law_residual(products: Real) -> float:
    """What the law leaves of B1 … B4, from the sums of products (24, 24)."""
    left = 0.0
    for axle in ((0, 1), (2, 3)):
        normal, moment, power = np.zeros((8, 8)), np.zeros(8), 0.0
        for k in axle:
            ends = 8 + np.concatenate([CORNERS[k], 8 + CORNERS[k]])
            pick = np.zeros((8, 24))
            pick[np.arange(8), ends + 4], pick[np.arange(8), ends] = 1.0, -1.0
            normal += pick @ products @ pick.T
            moment += pick @ products[:, k]
            power += products[k, k]
        found = np.linalg.lstsq(normal, moment, rcond=1e-10)[0]
        left += power - float(found @ moment)
    return left
