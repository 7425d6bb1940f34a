"""How well a run's description explains its record: the likelihood of track, speed and places.

Nothing is fitted. On a track that repeats, the nominal linear vehicle says which pattern of
amplitudes and phases each harmonic of the pitch leaves on the channels, and the run's own spectral
matrix says how much of its power has that pattern. Any other description (the speed in m/s, left
and right exchanged, another run's track) gives another pattern at other frequencies; the one that
explains most is the likeliest. On a track that does not repeat, or that nobody surveyed, the rear
axle follows the front one after a wheelbase.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, Run, TrackSpec
from wheelhop.gate.by_travel import ByTravel, Struts
from wheelhop.gate.match import MOST, Match, Places, log_likelihood
from wheelhop.gate.spectra import PADDING, Spectra
from wheelhop.simulate import Model, frequency_response
from wheelhop.track import make_track, wheel_envelope
from wheelhop.vehicle import Vehicle, axle_name, behind_m, corner_position, wheels

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

REACH = 0.12
"""A speed held by hand stays within this fraction of the nominal one. Beyond it the campaign says
something wrong, though the fit may find its way (`fit/placement.py`)."""
HARMONICS = 4
STEP_HZ = 0.05  # of the nominal vehicle's response
SAMPLES = 128  # of a wheel's path within one pitch
BROAD = 1 / 3
"""A delay is told from a record that fills so much of its band: what repeats would fit many."""


class Drive(Protocol):
    """A run that says something of its speed."""

    @property
    def run(self) -> Run:
        """The run."""

    def match(self, speeds_m_s: Array, places: Sequence[Places], rate: float = 1.0) -> list[Match]:
        """How well the best of some speeds explains the run, for several ways in which its channels
        may be placed; ``rate`` is the true sample rate over the stated one."""

    def is_told(self, speed: float, gain: float) -> bool:
        """Whether the run should hold more than noise at the stated speed times `speed`, its record
        being exp(`gain`) times what is predicted."""


class Nominal:
    """What the nominal linear vehicle makes of any periodic track at any speed, and of measured
    travel; `noise` (c,) is how noisy the channels are, one beside the other."""

    def __init__(self, campaign: Campaign, vehicle: Vehicle, noise: Array) -> None:
        self.campaign, self.vehicle, self.values = campaign, vehicle, vehicle.values
        self.noise = noise / campaign.noise_scale
        self.grid_hz = np.arange(STEP_HZ, 2 * campaign.band_hz[1], STEP_HZ)
        unknown = {
            f"{c.key}.{axis}": 0.0
            for c in campaign.channels
            if c.point == "body"
            for axis in ("x_m", "y_m")
        }
        system = Model(values={**self.values, **unknown}).system(campaign.channels, "road")
        response = frequency_response(system, self.grid_hz) / campaign.noise_scale[:, None]
        self._response = response * campaign.recorded(self.grid_hz)[:, :, None]
        self._paths: dict[tuple[object, ...], ComplexArray] = {}

    def at(self, frequency_hz: Array) -> ComplexArray:
        """Response (…, c, wheels) at the grid's points next to some frequencies."""
        step = self.grid_hz[1] - self.grid_hz[0]
        index = np.rint((frequency_hz - self.grid_hz[0]) / step).astype(int)
        return np.asarray(self._response[np.clip(index, 0, len(self.grid_hz) - 1)])

    def paths(self, spec: TrackSpec) -> ComplexArray:
        """Amplitudes (HARMONICS, wheels), m, of what the wheels' centres do on a periodic track."""
        key = (spec.kind, *sorted(spec.values.items()))
        if key not in self._paths:
            self._paths[key] = self._follow(spec)
        return self._paths[key]

    def _follow(self, spec: TrackSpec) -> ComplexArray:
        track = make_track(spec)
        pitch = track.period_m or 1.0
        x = np.arange(SAMPLES) * pitch / SAMPLES
        rolling = wheels(self.values)
        height = np.empty((SAMPLES, len(rolling)))
        for j, i in enumerate(rolling):
            radius = self.values[f"wheel.{axle_name(i)}.radius_m"]
            path = wheel_envelope(track, corner_position(self.values, i)[1], radius, 0.0, pitch)
            height[:, j] = path.height(x)
        shape = np.fft.rfft(height, axis=0)[1 : HARMONICS + 1] * 2 / SAMPLES
        behind = np.array([behind_m(self.values, i) for i in rolling])
        order = np.arange(1, HARMONICS + 1)[:, None]
        return np.asarray(shape * np.exp(-2j * np.pi * order * behind / pitch))


@dataclass(frozen=True, eq=False)
class OnWaves:
    """A run over a track that repeats."""

    spectra: Spectra
    nominal: Nominal
    pitch_m: float
    paths: ComplexArray

    @property
    def run(self) -> Run:
        """The run."""
        return self.spectra.run

    def match(self, speeds_m_s: Array, places: Sequence[Places], rate: float = 1.0) -> list[Match]:
        """By the pattern of the pitch's harmonics, their amplitudes in the proportion predicted."""
        predicted, measured = self._predicted(speeds_m_s, rate)
        frequency = speeds_m_s[:, None] * np.arange(1, HARMONICS + 1) / self.pitch_m
        total = max(float(self.spectra.power.sum()), 1e-300)
        stated = _AsStated(predicted, measured, frequency)
        found: dict[int, Match] = {}
        for some in _alike(places, predicted.shape[2]):
            along, size = stated.but([places[i] for i in some])
            reach = np.sqrt(np.maximum(along, 0.0)).sum(axis=1)  # Σ |r| |q|: (v, p)
            share = np.minimum(reach**2 / size / 2 / total, MOST)
            for p, (i, best) in enumerate(zip(some, share.argmax(axis=0), strict=True)):
                explained, gain = float(share[best, p]), float(reach[best, p] / size[best, p])
                likely = log_likelihood(self.spectra, explained)
                found[i] = Match(explained, gain, float(speeds_m_s[best]), likely)
        return [found[i] for i in range(len(places))]

    def predicted_power(self, speed: float = 1.0) -> float:
        """Mean square, m²/s⁴, summed over channels, that the track should cause in band at the
        stated speed times `speed`."""
        predicted = self._predicted(np.array([speed * self.run.speed_m_s]), 1.0)[0]
        return float(np.sum(np.abs(predicted) ** 2) / 2)

    def is_told(self, speed: float, gain: float) -> bool:
        """Whether the track should cause more than the noise that the record at least holds."""
        expected = np.exp(2 * gain) * self.predicted_power(speed)
        return bool(expected > len(self.spectra.power) * self.spectra.quietest())

    def _predicted(self, speeds_m_s: Array, rate: float) -> tuple[ComplexArray, ComplexArray]:
        """Lines as predicted (v, k, c), none out of band, and the spectral matrix (v, k, c, c)
        there, or as near as it is known."""
        frequency = speeds_m_s[:, None] * np.arange(1, HARMONICS + 1) / self.pitch_m  # true
        seen, grid = frequency / rate, self.spectra.frequency_hz
        inside = (seen >= grid[0]) & (seen <= grid[-1]) & (frequency <= self.nominal.grid_hz[-1])
        index = np.rint((seen - grid[0]) / self.spectra.step_hz).astype(int)
        measured = self.spectra.lines[np.clip(index, 0, len(grid) - 1)]
        response = self.nominal.at(frequency) * inside[..., None, None]
        return np.einsum("vkcw,kw->vkc", response, self.paths), measured


@dataclass(frozen=True, eq=False)
class Passing:
    """A run over anything else: the rear axle's channels follow the front's."""

    spectra: Spectra
    wheelbase_m: float
    pairs: tuple[tuple[int, int], ...]

    @property
    def run(self) -> Run:
        """The run."""
        return self.spectra.run

    def match(self, speeds_m_s: Array, places: Sequence[Places], rate: float = 1.0) -> list[Match]:
        """By the correlation of the rear axle with the front one, a wheelbase later, every
        frequency counting alike."""
        lag = self.wheelbase_m / speeds_m_s
        turn = np.exp(2j * np.pi * np.outer(lag, self.spectra.frequency_hz * rate))
        cross = (turn @ self._coherency).real.reshape(len(lag), *self._shape)  # (v, c, c)
        found = []
        for place in places:
            correlation = np.zeros(len(lag))
            for front, rear in self.pairs:
                (f, front_gain), (r, rear_gain) = place.of(front), place.of(rear)
                correlation += np.sign(front_gain * rear_gain) * cross[:, r, f] / len(self.pairs)
            best = int(np.argmax(correlation))
            share = min(max(float(correlation[best]), 0.0) ** 2, MOST)
            likely = -self.spectra.resolved * float(np.log1p(-share))
            found.append(Match(share, float("nan"), float(speeds_m_s[best]), likely))
        return found

    def is_told(self, speed: float, gain: float) -> bool:
        """A record that fills its band is."""
        return True

    @property
    def _shape(self) -> tuple[int, int]:
        return self.spectra.lines.shape[1], self.spectra.lines.shape[2]

    @cached_property
    def _coherency(self) -> ComplexArray:
        """Spectral matrix over the geometric mean of the two spectra (f, c · c), per frequency."""
        power = np.einsum("fcc->fc", self.spectra.lines).real
        size = np.sqrt(np.maximum(power[:, :, None] * power[:, None, :], 1e-300))
        scaled = self.spectra.lines / size / len(self.spectra.frequency_hz)
        return np.asarray(scaled.reshape(len(scaled), -1))


class _AsStated:
    """How lines r (v, k, c), as predicted, lie along what is measured, a spectral matrix (v, k,
    c, c), at some frequencies (v, k), Hz: as stated, and with some channels in other places.

    Another place adds d to r in the m channels that it concerns, so that r*Mr grows by
    2 Re d*Mr + d*Md, and no matrix larger than (m, m) is needed for each.
    """

    def __init__(self, r: ComplexArray, measured: ComplexArray, frequency_hz: Array) -> None:
        self._r, self._measured, self._frequency_hz = r, measured, frequency_hz
        self._product = (measured @ r[..., None])[..., 0]
        self._along = (r.conj() * self._product).sum(axis=2).real
        self._size = (np.abs(r) ** 2).sum(axis=(1, 2))

    def but(self, places: Sequence[Places]) -> tuple[Array, Array]:
        """|r|² |q|², (v, k, p), and Σ |r|², (v, p), of places with equally many columns."""
        columns = np.array([place.columns for place in places], dtype=np.intp)
        order = np.array([place.order for place in places], dtype=np.intp)
        late_s = np.array([place.late_s for place in places])
        turn = np.exp(-2j * np.pi * self._frequency_hz[..., None, None] * late_s)
        was = self._r[:, :, columns]
        now = self._r[:, :, order] * np.array([place.gain for place in places]) * turn
        d = now - was
        among = self._measured[:, :, columns[:, :, None], columns[:, None, :]]
        grown = 2 * (d.conj() * self._product[:, :, columns]).sum(axis=3)
        grown += (d.conj()[..., None, :] @ among @ d[..., None])[..., 0, 0]
        size = self._size[:, None] + (np.abs(now) ** 2 - np.abs(was) ** 2).sum(axis=(1, 3))
        return self._along[..., None] + grown.real, np.maximum(size, 1e-300)


def _alike(places: Sequence[Places], channels: int) -> Iterator[list[int]]:
    """The numbers of places with equally many columns, so few at a time that they take no more
    memory than a spectral matrix of all channels."""
    for width in {len(place.columns): None for place in places}:
        of_it = [i for i, place in enumerate(places) if len(place.columns) == width]
        step = channels**2 // max(width, 1) ** 2
        yield from (of_it[k : k + step] for k in range(0, len(of_it), step))


def drive_of(campaign: Campaign, spectra: Spectra, nominal: Nominal) -> Drive | None:
    """What a run says of its speed; None if it stands, has no two axles to compare, or its speed
    changes along the track."""
    run = spectra.run
    if run.speed_m_s <= 0 or run.course is not None or _changes(run):
        return None
    if run.track.kind not in ("unknown", "flat"):
        period = make_track(run.track).period_m
        way = run.speed_m_s * float(run.time_s[-1] - run.time_s[0])
        if period is not None and 2 * period < way:
            return OnWaves(spectra, nominal, period, nominal.paths(run.track))
    if run.track.kind == "unknown":
        at_hz = spectra.frequency_hz[::PADDING]
        struts = Struts.of(campaign, nominal.vehicle, at_hz, nominal.noise)
        if struts is not None:
            return ByTravel(spectra, struts, len(campaign.runs))
    points = [channel.point for channel in campaign.channels]
    pairs = tuple(
        (points.index(front), points.index(rear))
        for front, rear in (("A1", "A3"), ("A2", "A4"))
        if front in points and rear in points
    )
    told = pairs and spectra.spread([column for pair in pairs for column in pair]) > BROAD
    return Passing(spectra, behind_m(nominal.values, 2), pairs) if told else None


def _changes(run: Run) -> bool:
    """Whether a channel shows a speed that no hand held."""
    if run.driven is None:
        return False
    return bool(np.abs(run.driven.faster(run.time_s) - 1.0).max() > REACH)


def speeds_about(speed_m_s: float, reach: float = REACH, count: int = 17) -> Array:
    """Speeds within a fraction of one, m/s."""
    return np.asarray(speed_m_s * np.linspace(1 - reach, 1 + reach, count))
