"""A run on a road of which the spectrum is known: records as spectra beside those that the road's
makes (thesis figures 4.52 and 4.56 to 4.62).

On such a road no sample can be foretold. Heights below the wheels have the cross spectra G of
`RoadSpectrum`, at the frequency f = v Ω / 2π; the vehicle, linear, makes of them H G Hᴴ. What is
compared is the mean power in each third of an octave, which by chance is χ² about the expected one;
peaks are those of a Gaussian signal (S. O. Rice, Bell Syst. Tech. J. 23 (1944) 282).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, CampaignError, Channel, Run
from wheelhop.compare import InBand
from wheelhop.simulate import Model, frequency_response
from wheelhop.track import CannotClimb
from wheelhop.track.spectrum import RoadSpectrum
from wheelhop.vehicle import axle_name, corner_position, wheels

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

ISO, PER_OCTAVE = "iso8608", 3
CHANCE = 0.05


@dataclass(frozen=True, eq=False)
class RoadRun:
    """One run: k lines in band, n channels, b bands.

    ``predicted`` are cross spectra at the lines, noise of the sensors included; ``lines`` the
    record's own, of a Hann window, scaled as densities; ``band`` says of each line in which third
    of an octave it lies, and ``freedom`` (b,) of how many degrees the power there is χ².
    """

    run: Run
    channels: tuple[Channel, ...]
    frequency_hz: Array  #: (k,)
    predicted: ComplexArray  #: (k, n, n), one-sided, (m/s²)²/Hz
    lines: ComplexArray  #: (k, n)
    band: NDArray[np.int64]  #: (k,)
    freedom: Array  #: (b,)

    @property
    def middle_hz(self) -> Array:
        """Mean frequency of the lines of each band (b,)."""
        return self._mean(self.frequency_hz[:, None])[:, 0]

    @property
    def measured_density(self) -> Array:
        """(b, n), (m/s²)²/Hz."""
        return self._mean(np.abs(self.lines) ** 2)

    @property
    def predicted_density(self) -> Array:
        """(b, n), (m/s²)²/Hz."""
        return self._mean(np.einsum("kii->ki", self.predicted).real)

    @property
    def chance(self) -> tuple[Array, Array]:
        """Between which multiples (b,) of what is predicted 95 % of records lie."""
        from scipy.stats import chi2

        ends = (CHANCE / 2, 1 - CHANCE / 2)
        low, high = (np.asarray(chi2.ppf(end, self.freedom) / self.freedom) for end in ends)
        return low, high

    @property
    def inside(self) -> NDArray[np.bool_]:
        """Whether each band of each channel (b, n) lies between them."""
        ratio, (low, high) = self.measured_density / self.predicted_density, self.chance
        return np.asarray((ratio >= low[:, None]) & (ratio <= high[:, None]))

    def rms(self) -> tuple[Array, Array]:
        """Of the channels (n,) in band, m/s²: measured, predicted."""
        step = self.frequency_hz[1] - self.frequency_hz[0]
        power = np.sum(np.abs(self.lines) ** 2, axis=0)
        expected = np.einsum("kii->i", self.predicted).real
        return np.sqrt(power * step), np.sqrt(expected * step)

    def peaks(self) -> tuple[Array, Array]:
        """Largest of a channel's values (n,), m/s², and how many rise through zero a second, as
        its predicted spectrum makes them of a Gaussian signal as long as the run's."""
        omega = 2 * np.pi * self.frequency_hz[:, None]
        density = np.einsum("kii->ki", self.predicted).real
        power, rate = (np.sum(density * omega**n, axis=0) for n in (0, 2))
        crossings = np.sqrt(rate / power) / (2 * np.pi)
        seconds = 1.0 / (self.frequency_hz[1] - self.frequency_hz[0])
        # Both ways, so twice as many (A. G. Davenport, Proc. ICE 28 (1964) 187).
        reach = np.sqrt(2 * np.log(np.maximum(2 * crossings * seconds, 3.0)))
        return (reach + np.euler_gamma / reach) * self.rms()[1], crossings

    def shown_peaks(self) -> tuple[Array, Array]:
        """What `peaks` says, of the record itself in band."""
        n, rate_hz = len(self.run.time_s), 1.0 / float(self.run.time_s[1] - self.run.time_s[0])
        band = InBand(n, rate_hz, (float(self.frequency_hz[0]), float(self.frequency_hz[-1])))
        signal = band.signal(self.run.record)
        rises = np.sum((signal[:-1] < 0.0) & (signal[1:] >= 0.0), axis=0)
        return np.abs(signal).max(axis=0), rises * rate_hz / n

    def coherence(self, one: int, other: int) -> tuple[Array, Array]:
        """Of two channels in each band (b,): measured, predicted."""
        shown = self.lines[:, one] * self.lines[:, other].conj()
        across, foretold = self._mean(shown[:, None]), self._mean(self.predicted[:, one, [other]])
        power, expected = self.measured_density, self.predicted_density
        return (
            np.abs(across[:, 0]) ** 2 / (power[:, one] * power[:, other]),
            np.abs(foretold[:, 0]) ** 2 / (expected[:, one] * expected[:, other]),
        )

    def delay_s(self, first: int, later: int) -> tuple[float, float]:
        """By how much a channel comes after another, where their correlation is largest within a
        second: measured, predicted."""
        lag = np.arange(0.0, 1.0, 0.001)
        turn = np.exp(2j * np.pi * np.outer(lag, self.frequency_hz))
        both = (self.lines[:, later] * self.lines[:, first].conj(), self.predicted[:, later, first])
        measured, predicted = (float(lag[np.argmax((turn @ each).real)]) for each in both)
        return measured, predicted

    def _mean(self, values: NDArray[Any]) -> NDArray[Any]:
        count = np.bincount(self.band)
        sums = np.zeros((len(count), values.shape[1]), values.dtype)
        np.add.at(sums, self.band, values)
        return np.asarray(sums / count[:, None])


def road_spectra(
    campaign: Campaign, model: Model, road: RoadSpectrum | None = None
) -> list[RoadRun]:
    """Every run on a road whose spectrum is known: its own, `iso8608`, or all runs on `road`.

    Force laws of the model, which are not linear, are left out.

    Raises
    ------
    CampaignError : no run is on such a road, it is too rough for a wheel, or a speed changes.
    """
    found = []
    for run in campaign.runs:
        on = road
        if on is None and run.track.kind == ISO:
            stated = run.track.values
            on = RoadSpectrum(float(stated["unevenness_m3"]), float(stated["waviness"]))
        if on is not None:
            found.append(_compared(campaign, model, run, on))
    if not found:
        raise CampaignError(
            f"{campaign.folder}: no run is on a road of known spectrum (iso8608): say its"
            " unevenness and waviness with --road C:W, such as 6.7e-4:1.36"
        )
    return found


def _compared(campaign: Campaign, model: Model, run: Run, road: RoadSpectrum) -> RoadRun:
    if run.course is not None:
        raise CampaignError(f"run {run.id}: its speed changes on the way: its spectrum does, too")
    n, rate_hz = len(run.time_s), campaign.sample_rate_hz
    low, high = campaign.band_hz
    frequency: Array = np.fft.rfftfreq(n, 1.0 / rate_hz).astype(np.float64)
    kept = (frequency >= low) & (frequency <= high) & (frequency > 0.0)
    window = np.hanning(n)
    record = run.record - run.record.mean(axis=0)
    power = float(np.sum(window**2))
    spectrum = np.fft.rfft(window[:, None] * record, axis=0)[kept]
    lines = spectrum * np.sqrt(2.0 / (rate_hz * power))
    at: Array = frequency[kept]
    band = np.floor(PER_OCTAVE * np.log2(at / at[0])).astype(np.int64)
    band = np.unique(band, return_inverse=True)[1].astype(np.int64)
    # Lines of a window are not independent: n have the power of 2 n / (N Σw⁴/(Σw²)²) squares.
    wide = n * float(np.sum(window**4)) / power**2
    freedom = np.maximum(2.0 * np.bincount(band) / wide, 2.0)
    speed = model.speed_m_s(run.id, run.speed_m_s)
    system = model.system(campaign.channels, "road")
    try:
        heights = ground_spectra(road, model.values, speed, at)
    except CannotClimb as error:
        raise CampaignError(f"run {run.id}: a road as rough as that: {error}") from None
    kept_share = campaign.recorded(at)[:, :, None]
    response = np.asarray(frequency_response(system, at) * kept_share)
    predicted = response @ heights @ np.conj(np.swapaxes(response, 1, 2))
    if campaign.noise_rms is not None:
        noise = (campaign.noise_rms * campaign.noise_scale) ** 2 / (high - low)
        predicted = predicted + np.diag(noise)
    return RoadRun(run, campaign.channels, at, predicted, lines, band, freedom)


def ground_spectra(
    road: RoadSpectrum, values: Mapping[str, float], speed_m_s: float, frequency_hz: Array
) -> ComplexArray:
    """Cross spectra (f, m, m), m²/Hz, of the paths of the wheels' centres of a vehicle, one-sided:
    left and right as alike as the road has them, the rear ones later by what they are behind."""
    there: Sequence[int] = wheels(values)
    wave = 2 * np.pi * frequency_hz / speed_m_s
    places = np.array([corner_position(values, corner) for corner in there])
    ends = [axle_name(corner) for corner in there]
    apart = float(np.ptp(places[:, 1]))
    seen = {
        end: road.under_wheels(wave, apart, values[f"wheel.{end}.radius_m"])
        for end in dict.fromkeys(ends)
    }
    own = np.stack([np.sqrt(seen[end][0] * 2 * np.pi / speed_m_s) for end in ends], axis=1)
    own = own * np.exp(1j * wave[:, None] * places[None, :, 0])
    alike = np.mean([g for _, g in seen.values()], axis=0)
    same = places[:, None, 1] == places[None, :, 1]
    together = np.where(same, 1.0, alike[:, None, None])
    return np.asarray(own[:, :, None] * own[:, None, :].conj() * together)
