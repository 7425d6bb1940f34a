"""Where the model fails: the residual's sum of squares cut along every axis at hand."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from wheelhop.campaign import Campaign
from wheelhop.compare.floor import Floor
from wheelhop.compare.locking import Locking, locking
from wheelhop.compare.motion import MOTIONS, motion_matrix
from wheelhop.compare.records import Record
from wheelhop.compare.thirds import third_octave_of, third_octaves

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Slice:
    """One part of the residual: sums of squares in band, summed over samples, in the square of the
    unit in which all channels count (`Campaign.unit`).

    ``noise`` is what the sensors' noise is expected to contribute, ``share`` the part of the
    residual of all slices of the same cut that is in this one, and ``folded`` what motion folded
    into the records of the axles that drive the model may contribute (`Record.folded_power`).
    """

    name: str
    residual: float
    measured: float
    noise: float
    share: float
    folded: float = 0.0

    @property
    def error(self) -> float:
        """Residual relative to the measurement in the same slice."""
        return _root_ratio(self.residual, self.measured)

    @property
    def floor(self) -> float:
        """The error noise alone would leave in this slice."""
        return _root_ratio(self.noise, self.measured)

    @property
    def ratio(self) -> float:
        """Error over floor: about 1 where the model has not failed."""
        return _root_ratio(self.residual, self.noise)

    @property
    def excess(self) -> float:
        """Residual beyond what a right model is expected to leave, at least 0."""
        return max(self.residual - self.noise - self.folded, 0.0)

    def expected(self, tolerance: float) -> float:
        """Residual that a right model may leave, if the noise is wrong by ``tolerance``, relative
        and on amplitudes."""
        return (1.0 + tolerance) ** 2 * self.noise + self.folded


@dataclass(frozen=True, eq=False)
class Grid:
    """The residual cut along two axes at once: sums of squares (n_rows, n_columns)."""

    rows: tuple[str, ...]
    columns: tuple[str, ...]
    residual: Array
    measured: Array
    noise: Array
    folded: Array

    @property
    def by_row(self) -> tuple[Slice, ...]:
        """Slices of the rows, all columns together."""
        return slices(self.rows, *(a.sum(axis=1) for a in self.sums))

    @property
    def by_column(self) -> tuple[Slice, ...]:
        """Slices of the columns, all rows together."""
        return slices(self.columns, *(a.sum(axis=0) for a in self.sums))

    @property
    def ratio(self) -> Array:
        """Residual over noise in each cell, as amplitudes; NaN where nothing was compared."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return np.asarray(
                np.sqrt(np.where(self.noise > 0.0, self.residual / self.noise, np.nan))
            )

    @property
    def sums(self) -> tuple[Array, Array, Array, Array]:
        """Residual, measured, noise and folded."""
        return self.residual, self.measured, self.noise, self.folded


def slices(
    names: Sequence[str], residual: Array, measured: Array, noise: Array, folded: Array
) -> tuple[Slice, ...]:
    """Slices of one cut; their shares sum to 1."""
    total = float(residual.sum())
    share = residual / total if total > 0.0 else np.zeros(len(names))
    columns = (each.tolist() for each in (residual, measured, noise, share, folded))
    return tuple(Slice(*values) for values in zip(names, *columns, strict=True))


def _root_ratio(a: float, b: float) -> float:
    return float(np.sqrt(a / b)) if b > 0.0 else float("nan")


TIME_SLICES = 10
QUARTILES = ("quietest quarter", "second quarter", "third quarter", "loudest quarter")
ENVELOPE_S = 1.0  # the local amplitude is an rms over this long


@dataclass(frozen=True)
class Breakdown:
    """The residual of a set of runs, cut along every axis. Built by `breakdown`.

    ``bands_*`` have third-octaves (nominal centre frequency, Hz) as rows.
    ``bands_motions`` has as columns the motions the channels determine; with all eight points
    they share out the whole residual.
    ``time`` are ten equal parts of every run. ``amplitude`` are quarters of all
    samples of a channel, ordered by the local rms of the measurement;
    ``growth`` is the exponent p of: excess residual ∝ amplitude^p over those quarters
    (1: in proportion, as a wrong parameter of a linear model leaves it; NaN: undetermined).
    ``count`` are the degrees of freedom of the residual, ``tolerance`` is the relative
    uncertainty of the noise floor (on amplitudes), ``points`` say where each channel sits.
    """

    total: Slice
    count: int
    tolerance: float
    points: tuple[str, ...]
    runs_channels: Grid
    bands_channels: Grid
    bands_motions: Grid
    time: tuple[Slice, ...]
    amplitude: tuple[Slice, ...]
    growth: float
    locking: Locking

    @property
    def on_rig(self) -> bool:
        """Whether it is a component on a rig that was compared; "road" is what the rig imposes."""
        return self.points == ("rig",)

    @property
    def run(self) -> tuple[Slice, ...]:
        """By run."""
        return self.runs_channels.by_row

    @property
    def channel(self) -> tuple[Slice, ...]:
        """By channel."""
        return self.runs_channels.by_column

    @property
    def band(self) -> tuple[Slice, ...]:
        """By third-octave."""
        return self.bands_channels.by_row

    @property
    def motion(self) -> tuple[Slice, ...]:
        """By motion of body and axles."""
        return self.bands_motions.by_column


def breakdown(campaign: Campaign, records: Sequence[Record], floor: Floor) -> Breakdown:
    """Cut the residual of ``records`` along every axis; ``floor`` says what noise explains."""
    noise = np.nan_to_num(floor.noise_rms**2)
    runs_channels = Grid(
        tuple(record.run.id for record in records),
        tuple(channel.name for channel in campaign.channels),
        np.array([np.sum(record.residual**2, axis=0) for record in records]),
        np.array([np.sum(record.measured**2, axis=0) for record in records]),
        np.array([np.sum(record.noise_power(noise), axis=0) for record in records]),
        np.array([np.sum(record.folded_power(noise), axis=0) for record in records]),
    )
    sums = (np.array([a.sum()]) for a in runs_channels.sums)
    amplitude = _amplitude(records, noise)
    return Breakdown(
        total=slices(("total",), *sums)[0],
        count=sum(record.count for record in records),
        tolerance=floor.tolerance,
        points=tuple(channel.point for channel in campaign.channels),
        runs_channels=runs_channels,
        bands_channels=_bands_channels(campaign, records, noise),
        bands_motions=_bands_motions(campaign, records, noise),
        time=_time(records, noise),
        amplitude=amplitude,
        growth=_growth(amplitude, floor.tolerance),
        locking=locking(records, noise),
    )


def _bands_channels(campaign: Campaign, records: Sequence[Record], noise: Array) -> Grid:
    names = tuple(channel.name for channel in campaign.channels)
    return _by_band(campaign, records, names, lambda record: np.diag(record.predicted * 1.0), noise)


def _bands_motions(campaign: Campaign, records: Sequence[Record], noise: Array) -> Grid:
    def matrix(record: Record) -> Array:
        return motion_matrix(campaign.channels, record.predicted)

    grid = _by_band(campaign, records, MOTIONS, lambda record: np.nan_to_num(matrix(record)), noise)
    known = [
        any(np.isfinite(matrix(record)[m, 0]) for record in records) for m in range(len(MOTIONS))
    ]
    return Grid(
        grid.rows,
        tuple(name for name, is_known in zip(MOTIONS, known, strict=True) if is_known),
        *(a[:, known] for a in grid.sums),
    )


def _by_band(
    campaign: Campaign,
    records: Sequence[Record],
    columns: tuple[str, ...],
    matrix: Callable[[Record], Array],
    noise: Array,
) -> Grid:
    """Sums of squares by third-octave of the linear combinations ``matrix`` of the channels."""
    bands = third_octaves(campaign.band_hz)
    sums = np.zeros((4, len(bands), len(columns)))
    held = np.zeros(len(bands), dtype=bool)  # a short record has no bin in the narrowest bands
    for record in records:
        number = np.tile(third_octave_of(record.band.frequency_hz), 2)
        member = np.array([number == band.x for band in bands], dtype=float)
        held |= member.any(axis=1)
        combine = matrix(record)
        sums[0] += member @ (record.residual @ combine.T) ** 2
        sums[1] += member @ (record.measured @ combine.T) ** 2
        sums[2] += member @ record.noise_power(noise) @ combine.T**2
        sums[3] += member @ record.folded_power(noise) @ combine.T**2
    names = tuple(band.name for band, is_held in zip(bands, held, strict=True) if is_held)
    return Grid(names, columns, *sums[:, held])


def _time(records: Sequence[Record], noise: Array) -> tuple[Slice, ...]:
    """Ten equal parts of every run, the k-th of all runs together."""
    sums = np.zeros((4, TIME_SLICES))
    for record in records:
        edges = np.linspace(0, record.band.n, TIME_SLICES + 1).astype(int)
        for row, part in enumerate((record.residual, record.measured)):
            power = np.sum(record.band.from_coefficients(part) ** 2, axis=1)
            sums[row] += np.add.reduceat(power, edges[:-1])
        for row, part in enumerate((record.noise_power(noise), record.folded_power(noise)), 2):
            sums[row] += np.diff(edges) / record.band.n * float(np.sum(part))
    names = [f"{10 * k}-{10 * k + 10} %" for k in range(TIME_SLICES)]
    return slices(names, *sums)


def _amplitude(records: Sequence[Record], noise: Array) -> tuple[Slice, ...]:
    """Quarters of the samples of each channel by local amplitude, over all runs."""
    sums = np.zeros((4, len(QUARTILES)))
    for c in range(len(noise)):
        used = [record for record in records if record.predicted[c]]
        if not used:
            continue
        measured, residual = (
            [r.band.from_coefficients(part[:, [c]])[:, 0] ** 2 for r, part in pairs]
            for pairs in ([(r, r.measured) for r in used], [(r, r.residual) for r in used])
        )
        window = max(1, round(ENVELOPE_S * used[0].band.rate_hz))
        local = np.concatenate(
            [ndimage.uniform_filter1d(y, window, mode="nearest") for y in measured]
        )
        quarter = np.searchsorted(np.quantile(local, (0.25, 0.5, 0.75)), local)
        for row, power in enumerate((np.concatenate(residual), np.concatenate(measured))):
            sums[row] += np.bincount(quarter, power, len(QUARTILES))
        lengths = [r.band.n for r in used]
        for row, parts in enumerate(
            ([r.noise_power(noise) for r in used], [r.folded_power(noise) for r in used]), 2
        ):
            each = [part[:, c].sum() / n for part, n in zip(parts, lengths, strict=True)]
            sums[row] += np.bincount(quarter, np.repeat(each, lengths), len(QUARTILES))
    return slices(QUARTILES, *sums)


def _growth(amplitude: Sequence[Slice], tolerance: float) -> float:
    """Slope of log excess over log measured power, over quarters where the excess is certain."""
    certain = [
        s
        for s in amplitude
        if s.measured > 0.0 and s.noise > 0.0 and s.residual > s.expected(2.0 * tolerance)
    ]
    if len(certain) < 3:
        return float("nan")
    return float(
        np.polyfit(np.log([s.measured for s in certain]), np.log([s.excess for s in certain]), 1)[0]
    )
