"""What the residual is locked to: the road, the clock, or neither."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft, linalg, ndimage, optimize, special

from wheelhop.campaign import RigRun
from wheelhop.compare.records import Record
from wheelhop.compare.thirds import third_octave_of
from wheelhop.compare.windows import hann

Array = NDArray[np.float64]
Bases = list[tuple[NDArray[np.int_], Array]]  # (channels, orthonormal columns (count, q))

FEWEST_WAVELENGTHS = 3.0  # below, repeating per wavelength cannot be told from coincidence
RANK_TOLERANCE = 0.01  # harmonics with less of their power in band are no direction in it
MOST_LINES = 5
LEAST_SHARE = 1e-3  # of the residual: taking out the road leaves traces below it
FALSE_ALARM = 1e-3  # that noise alone shows any line, per search
BACKGROUND_HZ = 2.0  # a line stands above the median of the spectrum this wide around it
SKIRT_HZ = 1.0
SPEED_SPREAD = 1.1  # runs differ in speed if the fastest is this much faster


@dataclass(frozen=True)
class Line:
    """A line of the residual's spectrum that does not move with speed.

    ``share`` is its part of the residual's sum of squares, ``runs`` those in which it
    stands out.
    """

    frequency_hz: float
    share: float
    runs: tuple[str, ...]


@dataclass(frozen=True)
class Locking:
    """Shares of the residual's sum of squares; road + time + neither = 1.

    ``road`` repeats with the track's wavelength (periodic tracks) or is coherent with the
    modelled response to the road (others); ``time`` is in ``lines``. What a subspace of as
    many dimensions would hold of the remainder by chance is already subtracted from both.
    ``neither`` is the rest and includes the noise, whose expected share is ``noise``, and what
    motion folded into measured axles adds.
    """

    road: float
    time: float
    neither: float
    noise: float
    lines: tuple[Line, ...]


def locking(records: Sequence[Record], noise: Array) -> Locking:
    """Split the residual; ``noise`` (n_channels,) is the mean square of each channel's noise."""
    total = sum(float(np.sum(record.residual**2)) for record in records)
    if not total > 0.0:
        return Locking(0.0, 0.0, 0.0, 0.0, ())
    roads = [_road_bases(record) for record in records]
    found = _find_lines(records, roads)
    road, per_line = 0.0, np.zeros(len(found))
    for record, bases in zip(records, roads, strict=True):
        at_lines = [_line_basis(record, frequency) for frequency, _ in found]
        for columns, basis in bases:
            from_road, from_lines = _shares(record.residual[:, columns], at_lines, basis)
            road += from_road
            per_line += from_lines
    shares = per_line / total
    lines = tuple(
        Line(frequency, float(share), runs)
        for (frequency, runs), share in zip(found, shares, strict=True)
        if share > LEAST_SHARE
    )
    time = sum((line.share for line in lines), 0.0)
    road = min(max(road / total, 0.0), 1.0 - time)
    expected = sum(float(np.sum(r.noise_power(noise))) for r in records) / total
    return Locking(road, time, 1.0 - road - time, expected, lines)


def _shares(residual: Array, lines: Sequence[Array], road: Array) -> tuple[float, Array]:
    """Sums of squares of channels (count, k) along the road's basis and along each line.

    From each is taken what that many degrees of freedom of the remainder hold on average,
    so that white noise counts as locked to nothing.
    """
    basis = linalg.qr(np.hstack([*lines, road]), mode="economic")[0] if lines else road
    power = (basis.T @ residual) ** 2
    free = len(residual) - len(power)
    level = (np.sum(residual**2, axis=0) - power.sum(axis=0)) / max(free, 1)
    above = np.sum(power - np.maximum(level, 0.0), axis=1)
    at_line = 2 * len(lines)
    return float(above[at_line:].sum()), above[:at_line].reshape(-1, 2).sum(axis=1)


def _road_bases(record: Record) -> Bases:
    """What the road can cause, as orthonormal bases of the channels they hold for."""
    predicted = np.flatnonzero(record.predicted)
    harmonics = _harmonics(record)
    if harmonics is not None:
        return [(predicted, harmonics)]
    frequency = record.band.frequency_hz
    return [(np.array([c]), _coherent_basis(record.model[:, c], frequency)) for c in predicted]


def _harmonics(record: Record) -> Array | None:
    """Harmonics of the track's wavelength along the modelled path; None off periodic tracks."""
    position, pitch = record.position_m, record.run.track.values.get("pitch_m")
    if position is None or not isinstance(pitch, float):
        return None
    band = record.band
    wavelengths = abs(position[-1] - position[0]) / pitch
    if wavelengths < FEWEST_WAVELENGTHS:
        return None
    highest = int(band.frequency_hz[-1] * band.n / band.rate_hz / wavelengths)
    angle = np.outer(2.0 * np.pi * position / pitch, np.arange(1, highest + 1))
    basis = band.coefficients(np.hstack([np.cos(angle), np.sin(angle)]) * np.sqrt(2.0 / band.n))
    if not basis.size:
        return None
    power, direction = linalg.eigh(basis.T @ basis)
    inside = power > RANK_TOLERANCE
    return np.asarray(basis @ (direction[:, inside] / np.sqrt(power[inside])))


def _coherent_basis(model: Array, frequency_hz: Array) -> Array:
    """What one complex factor per third-octave can make of the modelled signal (count,).

    The model's response is linear in the road, so the residual's part that is coherent with
    it is coherent with the road. Two dimensions per third-octave: in phase and in quadrature.
    """
    half = len(frequency_hz)
    quadrature = np.concatenate([-model[half:], model[:half]])
    number = np.tile(third_octave_of(frequency_hz), 2)
    columns = []
    for x in np.unique(number):
        inside = number == x
        size = float(np.linalg.norm(model[inside]))
        # A band of one bin is matched by any factor: that proves nothing.
        if size > 0.0 and np.count_nonzero(inside) > 4:
            columns += [model * inside / size, quadrature * inside / size]
    return np.array(columns).reshape(-1, 2 * half).T


def _line_basis(record: Record, frequency_hz: float) -> Array:
    """Orthonormal basis (count, 2) of a line at one frequency."""
    angle = 2.0 * np.pi * frequency_hz * np.arange(record.band.n) / record.band.rate_hz
    columns = record.band.coefficients(np.stack([np.cos(angle), np.sin(angle)], axis=1))
    return np.asarray(linalg.qr(columns, mode="economic")[0])


def _find_lines(
    records: Sequence[Record], roads: Sequence[Bases]
) -> list[tuple[float, tuple[str, ...]]]:
    """Frequencies, strongest first, at which at least half the runs show a line, with those runs.

    The runs that show it must differ in speed (a standing vehicle settles it): only then
    is the clock, and not the road or a wheel, what the line follows. The search is on the
    residual with the part locked to the road taken out. A rig often imposes the same sines, so
    that lines prove nothing there.
    """
    if any(isinstance(record.run, RigRun) for record in records):
        return []
    rest = [_without_road(*pair) for pair in zip(records, roads, strict=True)]
    found: list[tuple[float, tuple[str, ...]]] = []
    while len(found) < MOST_LINES:
        line = _strongest_line(records, rest, [frequency for frequency, _ in found])
        if line is None:
            break
        found.append(line)
        for i, record in enumerate(records):
            basis = _line_basis(record, line[0])
            rest[i] = rest[i] - basis @ (basis.T @ rest[i])
    return found


def _without_road(record: Record, bases: Bases) -> Array:
    rest = record.residual.copy()
    for columns, basis in bases:
        rest[:, columns] -= basis @ (basis.T @ rest[:, columns])
    return rest


def _strongest_line(
    records: Sequence[Record], rest: Sequence[Array], known_hz: Sequence[float]
) -> tuple[float, tuple[str, ...]] | None:
    """The line that stands out most in half of the runs, if that is not a coincidence.

    Not looked for beside a line already known: an unsteady one has a skirt.
    """
    frequency = max((record.band.frequency_hz for record in records), key=len)
    prominence = np.array(
        [_prominence(*pair, frequency) for pair in zip(records, rest, strict=True)]
    )
    runs = len(records)
    needed = runs - (runs - 1) // 2
    typical = np.sort(prominence, axis=0)[runs - needed]
    # In noise a periodogram is exponentially distributed, with median ln 2, and two bins are
    # looked at. That `needed` runs exceed a level at one of the frequencies is a binomial tail.
    one_run = 1.0 - (1.0 - np.exp(-typical * np.log(2.0))) ** 2
    by_chance = len(frequency) * special.bdtrc(needed - 1, runs, one_run)
    for known in known_hz:
        by_chance[np.abs(frequency - known) < SKIRT_HZ] = 1.0
    for k in np.argsort(-typical):
        if by_chance[k] > FALSE_ALARM:
            continue
        shown = [i for i in range(runs) if prominence[i, k] >= typical[k]]
        speeds = [records[i].run.speed_m_s for i in shown]
        if min(speeds) == 0.0 or max(speeds) > SPEED_SPREAD * min(speeds):
            refined = _refine(float(frequency[k]), records, rest)
            return refined, tuple(records[i].run.id for i in shown)
    return None


def _prominence(record: Record, rest: Array, frequency_hz: Array) -> Array:
    """Power spectrum over its local median, all channels together, at the given frequencies."""
    n, rate = record.band.n, record.band.rate_hz
    window = hann(n)[:, None]
    time_signal = record.band.from_coefficients(rest) * window
    power = np.sum(np.abs(fft.rfft(time_signal, axis=0)) ** 2, axis=1)
    step = rate / n
    first, last = (round(f / step) for f in record.band.frequency_hz[[0, -1]])
    power = power[first : last + 1]
    background = ndimage.median_filter(
        power, max(5, round(BACKGROUND_HZ / step) | 1), mode="nearest"
    )
    over = power / np.maximum(background, np.finfo(float).tiny)
    # The nearest bins of a coarser or finer spectrum: a line falls between two at worst.
    position = np.clip((frequency_hz - record.band.frequency_hz[0]) / step, 0, len(over) - 1)
    low = np.floor(position).astype(int)
    return np.asarray(np.maximum(over[low], over[np.minimum(low + 1, len(over) - 1)]))


def _refine(near_hz: float, records: Sequence[Record], rest: Sequence[Array]) -> float:
    """Frequency within two bins of ``near_hz`` at which a line explains most of all runs."""
    step = max(record.band.rate_hz / record.band.n for record in records)

    def explained(frequency: float) -> float:
        return sum(
            float(np.sum((_line_basis(record, frequency).T @ part) ** 2))
            for record, part in zip(records, rest, strict=True)
        )

    # The main lobe is two bins wide: one of these is on its flank, and the search climbs from it.
    best = max(near_hz + step * np.linspace(-2.0, 2.0, 17), key=explained)
    climb = optimize.minimize_scalar(
        lambda frequency: -explained(frequency),
        bounds=(best - 0.3 * step, best + 0.3 * step),
        method="bounded",
        options={"xatol": 1e-4 * step},
    )
    return float(climb.x)
