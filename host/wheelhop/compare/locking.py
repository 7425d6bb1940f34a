"""What the residual is locked to: the road, the clock, or neither."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft, linalg, ndimage, optimize

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
"""So far to both sides of a line a run may have it: its source wanders, as an engine's speed does.
In one run it holds half as much."""
SPEED_SPREAD = 1.1  # runs differ in speed if the fastest is this much faster


@dataclass(frozen=True)
class Line:
    """A line of the residual's spectrum that does not move with speed.

    ``share`` is its part of the residual's sum of squares, ``runs`` those in which it
    stands out, at frequencies from ``lowest_hz`` to ``highest_hz``. Where these are told apart, the
    line wanders from run to run.
    """

    frequency_hz: float
    share: float
    runs: tuple[str, ...]
    lowest_hz: float
    highest_hz: float

    @property
    def wanders(self) -> bool:
        """Whether runs have it at frequencies that are told apart."""
        return self.lowest_hz < self.highest_hz


@dataclass(frozen=True)
class _Found:
    """A line: its frequency, that in each run that shows it, by the run's number."""

    frequency_hz: float
    by_run_hz: dict[int, float]

    def basis(self, record: Record, number: int) -> Array:
        """Orthonormal basis (count, q) of the line in a run: where it does not stand out, a sine;
        else all within half a skirt of where it does, too."""
        if number not in self.by_run_hz:
            return _sine(record, self.frequency_hz)
        own_hz = self.by_run_hz[number]
        frequency = np.tile(record.band.frequency_hz, 2)
        near = np.flatnonzero(np.abs(frequency - own_hz) <= 0.5 * SKIRT_HZ)
        skirt = np.eye(len(frequency))[:, near]
        return np.hstack([skirt, _beyond(_sine(record, own_hz), skirt)])


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
    for i, (record, bases) in enumerate(zip(records, roads, strict=True)):
        at_lines = [line.basis(record, i) for line in found]
        for columns, basis in bases:
            from_road, *from_lines = _shares(record.residual[:, columns], [basis, *at_lines])
            road += from_road
            per_line += from_lines
    lines = tuple(
        _line(records, line, float(share))
        for line, share in zip(found, per_line / total, strict=True)
        if share > LEAST_SHARE
    )
    time = sum((line.share for line in lines), 0.0)
    road = min(max(road / total, 0.0), 1.0 - time)
    expected = sum(float(np.sum(r.noise_power(noise))) for r in records) / total
    return Locking(road, time, 1.0 - road - time, expected, lines)


def _line(records: Sequence[Record], found: _Found, share: float) -> Line:
    """A line as it is said; frequencies within a line of the spectra are one."""
    own = found.by_run_hz
    lowest, highest = min(own.values()), max(own.values())
    if highest - lowest <= max(records[i].band.rate_hz / records[i].band.n for i in own):
        lowest = highest = found.frequency_hz
    runs = tuple(records[i].run.id for i in own)
    return Line(found.frequency_hz, share, runs, lowest, highest)


def _shares(residual: Array, bases: Sequence[Array]) -> list[float]:
    """Sums of squares of channels (count, k) along each basis, less those before it.

    From each is taken what that many degrees of freedom of the remainder hold on average,
    so that white noise counts as locked to nothing.
    """
    known, powers, freedom = np.zeros((len(residual), 0)), [], []
    for basis in bases:
        own = _beyond(basis, known)
        powers.append(np.sum((own.T @ residual) ** 2, axis=0))
        freedom.append(own.shape[1])
        known = np.hstack([known, own])
    free = len(residual) - sum(freedom)
    level = np.maximum(np.sum(residual**2, axis=0) - sum(powers), 0.0) / max(free, 1)
    return [float(np.sum(p - n * level)) for p, n in zip(powers, freedom, strict=True)]


def _beyond(basis: Array, known: Array) -> Array:
    """Orthonormal columns of what an orthonormal basis adds to those known."""
    if not known.shape[1] or not basis.shape[1]:
        return basis
    u, size, _ = linalg.svd(basis - known @ (known.T @ basis), full_matrices=False)
    return np.asarray(u[:, size**2 > RANK_TOLERANCE])


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


def _sine(record: Record, frequency_hz: float) -> Array:
    """Orthonormal basis (count, 2) of a sine."""
    angle = 2.0 * np.pi * frequency_hz * np.arange(record.band.n) / record.band.rate_hz
    columns = record.band.coefficients(np.stack([np.cos(angle), np.sin(angle)], axis=1))
    return np.asarray(linalg.qr(columns, mode="economic")[0])


def _find_lines(records: Sequence[Record], roads: Sequence[Bases]) -> list[_Found]:
    """Lines, strongest first, that at least half the runs show at one frequency.

    The runs that show it must differ in speed (a standing vehicle settles it): only then
    is the clock, and not the road or a wheel, what the line follows. The search is on the
    residual with the part locked to the road taken out. A rig often imposes the same sines, so
    that lines prove nothing there.
    """
    if any(isinstance(record.run, RigRun) for record in records):
        return []
    rest = [_without_road(*pair) for pair in zip(records, roads, strict=True)]
    found: list[_Found] = []
    while len(found) < MOST_LINES:
        line = _strongest_line(records, rest, [known.frequency_hz for known in found])
        if line is None:
            break
        found.append(line)
        for i, record in enumerate(records):
            basis = line.basis(record, i)
            rest[i] = rest[i] - basis @ (basis.T @ rest[i])
    return found


def _without_road(record: Record, bases: Bases) -> Array:
    rest = record.residual.copy()
    for columns, basis in bases:
        rest[:, columns] -= basis @ (basis.T @ rest[:, columns])
    return rest


def _strongest_line(
    records: Sequence[Record], rest: Sequence[Array], known_hz: Sequence[float]
) -> _Found | None:
    """The line that stands out most in half of the runs, if that is not a coincidence.

    Not looked for beside a line already known: an unsteady one has a skirt.
    """
    frequency = max((record.band.frequency_hz for record in records), key=len)
    prominence = np.array(
        [_prominence(*pair, frequency) for pair in zip(records, rest, strict=True)]
    )
    beside = np.ones(len(frequency), dtype=bool)
    for known in known_hz:
        beside &= np.abs(frequency - known) >= SKIRT_HZ
    runs = len(records)
    needed = runs - (runs - 1) // 2
    typical = np.sort(prominence, axis=0)[runs - needed]
    alike = _alike(records)
    for k in np.argsort(-typical):
        near = np.abs(frequency - frequency[k]) < SKIRT_HZ
        shown = [i for i in range(runs) if prominence[i, k] >= typical[k]]
        if not beside[k] or _by_chance(prominence[:, beside & ~near], typical[k], shown, alike):
            continue
        speeds = [records[i].run.speed_m_s for i in shown]
        if min(speeds) == 0.0 or max(speeds) > SPEED_SPREAD * min(speeds):
            own = np.where(near, prominence, 0.0)
            by_run = {
                i: _refine(float(frequency[np.argmax(own[i])]), [records[i]], [rest[i]])
                for i in range(runs)
                if own[i].max() >= typical[k]
            }
            steady = _refine(float(frequency[k]), records, rest)
            return _Found(steady, by_run)
    return None


def _alike(records: Sequence[Record]) -> list[list[int]]:
    """The runs, by number, by track and speed: what those have in common that are alike in both
    proves nothing."""
    groups: list[list[int]] = []
    for i in sorted(range(len(records)), key=lambda i: records[i].run.speed_m_s):
        run = records[i].run
        for group in groups:
            first = records[group[0]].run
            if first.track == run.track and run.speed_m_s <= SPEED_SPREAD * first.speed_m_s:
                group.append(i)
                break
        else:
            groups.append([i])
    return groups


def _by_chance(
    elsewhere: Array, level: float, shown: Sequence[int], alike: Sequence[Sequence[int]]
) -> bool:
    """Whether the runs shown may well stand as high at one of the frequencies by coincidence.

    In noise a periodogram is exponentially distributed, with median ln 2, and two bins are looked
    at. What a model gets wrong of a periodic track stands out at every harmonic, and of runs at
    several speeds harmonics coincide: a run does so by chance as often as it does `elsewhere`
    (runs, f). Of runs alike only one counts.
    """
    count = np.array([1.0])  # chance of 0, 1, 2, … kinds of runs
    for runs in alike:
        in_noise = 1.0 - (1.0 - np.exp(-level * np.log(2.0))) ** (2 * len(runs))
        as_high = np.any(elsewhere[runs] >= level, axis=0)
        one = max(float(in_noise), float(np.mean(as_high)) if as_high.size else 0.0)
        count = np.convolve(count, [1.0 - one, one])
    needed = sum(any(i in shown for i in runs) for runs in alike)
    return bool(max(elsewhere.shape[1], 1) * count[needed:].sum() > FALSE_ALARM)


def _prominence(record: Record, rest: Array, frequency_hz: Array) -> Array:
    """Power spectrum over its local median, all channels together, at the given frequencies; 0
    where the model has as strong a line itself: that may be what it gets wrong."""
    power, background = _spectrum(record, rest)
    modelled, around = _spectrum(record, record.model)
    over = power / np.maximum(background, np.finfo(float).tiny)
    over[power <= modelled - around] = 0.0
    # The nearest bins of a coarser or finer spectrum: a line falls between two at worst.
    step = record.band.rate_hz / record.band.n
    position = np.clip((frequency_hz - record.band.frequency_hz[0]) / step, 0, len(over) - 1)
    low = np.floor(position).astype(int)
    return np.asarray(np.maximum(over[low], over[np.minimum(low + 1, len(over) - 1)]))


def _spectrum(record: Record, coefficients: Array) -> tuple[Array, Array]:
    """Power spectrum in band, all channels together, and its local median."""
    n, rate = record.band.n, record.band.rate_hz
    time_signal = record.band.from_coefficients(coefficients) * hann(n)[:, None]
    power = np.sum(np.abs(fft.rfft(time_signal, axis=0)) ** 2, axis=1)
    step = rate / n
    first, last = (round(f / step) for f in record.band.frequency_hz[[0, -1]])
    power = power[first : last + 1]
    width = max(5, round(BACKGROUND_HZ / step) | 1)
    return power, ndimage.median_filter(power, width, mode="nearest")


def _refine(near_hz: float, records: Sequence[Record], rest: Sequence[Array]) -> float:
    """Frequency within two bins of ``near_hz`` at which a line explains most of all runs."""
    step = max(record.band.rate_hz / record.band.n for record in records)

    def explained(frequency: float) -> float:
        return sum(
            float(np.sum((_sine(record, frequency).T @ part) ** 2))
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
