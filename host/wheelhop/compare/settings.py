"""Settings of one vehicle over one course: which differs, where, and in which band.

It takes no model, no speed and no survey, and one sensor is enough; so it says what a change did
and not why. Power densities by Welch's method (P. Welch, IEEE Trans. Audio Electroacoust. 15
(1967) 70) are compared as logarithms of band powers. Two things blur them: a record is short, and a
driver does not hold the same speed twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal, stats

from wheelhop.campaign import Campaign, CampaignError, Run
from wheelhop.compare.decays import FreeDecays, free_decays
from wheelhop.compare.thirds import third_octaves

Array = NDArray[np.float64]

WAVES = 2
"""Segments hold so many waves of the slowest frequency in band, which a Hann window just tells from
a constant."""

LEAST_SEGMENTS = 8
"""Of a setting: a spread told by fewer is not known, and its t-quantile grows fast."""

OVERLAPPING = 1.0 + 2.0 / 36.0
"""Variance of a mean over half-overlapping Hann segments per that of independent ones: neighbours
have a correlation of 1/36 (Welch 1967, section on overlapping)."""

HELD = 0.03
"""A driver holds the same speed again to this standard deviation, relative. Another speed moves the
road's frequencies and their power in proportion."""

SURE = 0.95
"""Where nothing differs, with this chance nothing at all is claimed, all bands together."""


@dataclass(frozen=True, eq=False)
class SettingSpectrum:
    """Power density (f,) of one channel with one setting, unit²/Hz, between `low` and `high` in
    95 % of all such drives; its rms in band; how many runs and how much record."""

    setting: str
    channel: str
    unit: str
    runs: tuple[str, ...]
    seconds: float
    frequency_hz: Array
    density: Array
    low: Array
    high: Array
    rms: float


@dataclass(frozen=True)
class BandDifference:
    """Power of a setting over that of the reference in one band, dB, and the interval that holds it
    for all bands, channels and settings together in 95 % of all comparisons."""

    setting: str
    channel: str
    from_hz: float
    to_hz: float
    power_db: float
    low_db: float
    high_db: float

    @property
    def differs(self) -> bool:
        """Whether neither shortness nor speed explains it."""
        return self.low_db > 0.0 or self.high_db < 0.0


@dataclass(frozen=True, eq=False)
class SettingsComparison:
    """Every setting beside the `reference`, which is one of `settings`."""

    title: str
    reference: str
    settings: tuple[str, ...]
    spectra: tuple[SettingSpectrum, ...]
    differences: tuple[BandDifference, ...]
    decays: tuple[FreeDecays, ...]
    speed_apart: float  #: the largest difference of nominal speeds, relative


def settings_of(campaign: Campaign) -> dict[str, tuple[Run, ...]]:
    """The runs of every setting, in the order in which they are listed; runs without one take no
    part.

    Raises
    ------
    CampaignError
        There are fewer than two, or their runs are over different tracks.
    """
    where = campaign.folder / "campaign.toml"
    found: dict[str, tuple[Run, ...]] = {}
    for run in campaign.runs:
        if run.setting:
            found[run.setting] = (*found.get(run.setting, ()), run)
    if len(found) < 2:
        raise CampaignError(
            f'{where}: {len(found) or "no"} setting is stated: write setting = "…" below each'
            " [[run]], and compare two or more"
        )
    runs = [run for own in found.values() for run in own]
    for run in runs:
        if (run.track.kind, run.track.values) != (runs[0].track.kind, runs[0].track.values):
            raise CampaignError(
                f'{where}: run "{run.id}" is over another track than "{runs[0].id}": settings are'
                " compared over one course; delete setting from the runs on others"
            )
    return found


def compare_settings(campaign: Campaign, reference: str = "") -> SettingsComparison:
    """Compare every setting of a campaign with the `reference`, by default the first one.

    A band differs if the ratio of powers lies beyond a t-quantile of its spread: that of the
    segments, by the jackknife of the logarithm (D. Thomson, A. Chave, in S. Haykin (ed.), Advances
    in spectrum analysis and array processing, vol. 1, 1991), and what another speed would make of
    the very spectrum. Runs of one setting that differ more than that widen it. The chance of any
    false claim is shared out over all bands, channels and settings (Šidák).

    Raises
    ------
    CampaignError
        No two settings, different tracks, no such reference, or too short records.
    """
    settings = settings_of(campaign)
    reference = reference or next(iter(settings))
    if reference not in settings:
        raise CampaignError(
            f'{campaign.folder / "campaign.toml"}: there is no setting "{reference}": choose from'
            f" {', '.join(settings)}"
        )
    edges = band_edges(campaign.band_hz)
    nominal = {name: np.mean([r.speed_m_s for r in runs]) for name, runs in settings.items()}
    speeds = np.array([speed / nominal[reference] for speed in nominal.values() if speed > 0])
    apart = float(np.abs(speeds - 1.0).max()) if len(speeds) == len(nominal) else 0.0
    levels = {name: _levels(campaign, name, runs, edges, apart) for name, runs in settings.items()}
    compared = [name for name in settings if name != reference]
    count = len(compared) * len(campaign.channels) * (len(edges) - 1)
    differences = [
        difference
        for name in compared
        for i, channel in enumerate(campaign.channels)
        for difference in _differences(
            (name, channel.name), levels[name][i], levels[reference][i], edges, count
        )
    ]
    return SettingsComparison(
        campaign.title,
        reference,
        tuple(settings),
        tuple(level.spectrum for own in levels.values() for level in own),
        tuple(differences),
        tuple(d for name, runs in settings.items() for d in free_decays(campaign, name, runs)),
        apart,
    )


def band_edges(band_hz: tuple[float, float]) -> Array:
    """Edges (b + 1,) of third-octave bands, Hz; those too narrow to be resolved are joined."""
    low, high = band_hz
    edges = [low]
    for band in third_octaves(band_hz):
        upper = min(band.edges_hz[1], high)
        if upper - edges[-1] >= low / WAVES:
            edges.append(upper)
    edges[-1] = high
    return np.array(edges)


@dataclass(frozen=True, eq=False)
class _Level:
    """Logarithms of band powers (b,) of one channel with one setting: their variance by the
    segments, its degrees of freedom, and the variance that another speed and other drives add."""

    spectrum: SettingSpectrum
    log_power: Array
    variance: Array
    freedom: float
    of_drives: Array


def _levels(
    campaign: Campaign, setting: str, runs: Sequence[Run], edges: Array, apart: float
) -> list[_Level]:
    segments = [_segments(campaign, run) for run in runs]  # of each (k, c, f)
    count = sum(len(of_run[1]) for of_run in segments)
    if count < LEAST_SEGMENTS:
        least = (LEAST_SEGMENTS + 1) / 2 * WAVES / campaign.band_hz[0]
        raise CampaignError(
            f'{campaign.folder / "campaign.toml"}: setting "{setting}" has too short a record:'
            f" {least:.0f} s are needed where the band begins at {campaign.band_hz[0]:g} Hz; drive"
            " it again, or raise the lower edge of band_hz"
        )
    frequency = segments[0][0]
    seconds = sum(len(run.time_s) for run in runs) / campaign.sample_rate_hz
    found = []
    for i, channel in enumerate(campaign.channels):
        own = [power[:, i] for _, power in segments]
        every = np.concatenate(own)
        density = every.mean(axis=0)
        around = stats.t.ppf(0.5 + SURE / 2, count - 1) * np.sqrt(_jackknifed(every))
        inside = _inside(frequency, campaign.band_hz)
        in_band = np.array(campaign.band_hz)
        spectrum = SettingSpectrum(
            setting,
            channel.name,
            channel.unit,
            tuple(run.id for run in runs),
            seconds,
            frequency[inside],
            density[inside],
            (density * np.exp(-around))[inside],
            (density * np.exp(around))[inside],
            float(np.sqrt(_band_power(frequency, density, in_band)[0])),
        )
        powers = _band_power(frequency, every, edges)
        found.append(
            _Level(
                spectrum,
                np.log(powers.mean(axis=0)),
                _jackknifed(powers),
                count - 1,
                _of_drives(frequency, own, edges, max(HELD, apart)),
            )
        )
    return found


def _segments(campaign: Campaign, run: Run) -> tuple[Array, Array]:
    """Frequencies (f,), Hz, and densities (k, c, f) of a run's segments."""
    rate_hz = campaign.sample_rate_hz
    length = min(round(WAVES / campaign.band_hz[0] * rate_hz), len(run.time_s))
    frequency, _, density = signal.spectrogram(
        run.record.T, rate_hz, "hann", length, length // 2, detrend="constant"
    )
    return frequency, np.moveaxis(density, -1, 0)


def _inside(frequency: Array, band_hz: tuple[float, float]) -> NDArray[np.bool_]:
    return np.asarray((frequency >= band_hz[0]) & (frequency <= band_hz[1]))


def _band_power(frequency: Array, density: Array, edges: Array) -> Array:
    """Power (…, b) between edges of densities (…, f): a bin's power lies evenly about it."""
    width = frequency[1]
    ends = np.concatenate([frequency - width / 2, [frequency[-1] + width / 2]])
    total = np.cumsum(density * width, axis=-1)
    total = np.concatenate([np.zeros((*total.shape[:-1], 1)), total], axis=-1)
    flat = total.reshape(-1, total.shape[-1])
    at = np.array([np.interp(edges, ends, row) for row in flat])
    return np.asarray(np.diff(at, axis=-1).reshape(*density.shape[:-1], len(edges) - 1))


def _jackknifed(powers: Array) -> Array:
    """Variance (…) of the logarithm of the mean of powers (k, …) over segments."""
    count = len(powers)
    without = np.log((powers.sum(axis=0) - powers) / (count - 1))
    return np.asarray(OVERLAPPING * (count - 1) * without.var(axis=0))


def _of_drives(frequency: Array, runs: Sequence[Array], edges: Array, held: float) -> Array:
    """Variance (b,) of a setting's log power from drive to drive, beside that of the segments:
    what a speed does that is higher or lower by `held`, or what runs (k, f) differ by if more."""
    density = np.concatenate(runs).mean(axis=0)
    level = np.log(_band_power(frequency, density, edges))
    faster, slower = (
        np.log(_band_power(frequency, density, edges * (1.0 + e)) / (1.0 + e)) - level
        for e in (-held, held)
    )
    by_speed = np.maximum(np.maximum(np.abs(faster), np.abs(slower)), held) ** 2
    if len(runs) < 2:
        return np.asarray(by_speed)
    powers = [_band_power(frequency, run, edges) for run in runs]
    spread = np.var([np.log(p.mean(axis=0)) for p in powers], axis=0, ddof=1)
    of_segments = np.mean([_jackknifed(p) for p in powers], axis=0) if _enough(powers) else 0.0
    return np.asarray(np.maximum(by_speed, spread - of_segments) / len(runs))


def _enough(powers: Sequence[Array]) -> bool:
    return all(len(power) >= LEAST_SEGMENTS for power in powers)


def _differences(
    names: tuple[str, str], own: _Level, reference: _Level, edges: Array, count: int
) -> list[BandDifference]:
    variance = own.variance + reference.variance
    freedom = variance**2 / (
        own.variance**2 / own.freedom + reference.variance**2 / reference.freedom
    )
    chance = 1.0 - SURE ** (1.0 / count)
    blurred = np.sqrt(variance + own.of_drives + reference.of_drives)
    around = stats.t.ppf(1.0 - chance / 2, freedom) * blurred
    ratio = own.log_power - reference.log_power
    db = 10.0 / np.log(10.0)
    return [
        BandDifference(*names, *map(float, (low, high, db * r, db * (r - a), db * (r + a))))
        for low, high, r, a in zip(edges[:-1], edges[1:], ratio, around, strict=True)
    ]
