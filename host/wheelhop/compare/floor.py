"""The noise floor: what the sensors' noise alone leaves of the residual.

No model leaves less than the floor, but for what a fit follows of the noise: p/n of its square for
p fitted numbers on n data. A right model may leave more where scales are uncertain, or where
measured axles drive it: see `Floor.expected`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import comb, nan

import numpy as np
from numpy.typing import NDArray
from scipy import fft, special

from wheelhop.campaign import Campaign
from wheelhop.compare.quantisation import least_noise
from wheelhop.compare.records import Record
from wheelhop.compare.repeats import scatter
from wheelhop.compare.windows import blackman_harris

Array = NDArray[np.float64]

BLOCKS = 4  # equal parts of the band whose quietness is judged separately
LOBE = 4  # lines: half the main lobe of a Blackman-Harris window
PIECE = 50  # samples
QUIET_SHARE = 0.1  # of all (run, part of the band) pairs are taken to hold noise alone
OF_MEDIAN = 1.0 / np.log(2.0)
"""Scatter of the logarithm of the median of n exponentially distributed numbers, times √n."""
ALIKE = 2.0  # lines of a Blackman-Harris window tell as much as one that is independent


AXLES = "the axles that drive it"
ROLES = ("_fit", "_validate")

STATED, QUIET, SURE = 0.05, 0.15, 0.05
"""Relative standard uncertainty of a noise that is stated, and of one estimated from the quietest
parts of records, which nothing shows to hold noise alone; and the least of any other estimate."""

QUIETEST = "the quietest parts of records and residuals"
REPEATED = "the scatter between repeats of the same motion"
STEPS = "the steps in which the recorded values come"
NEIGHBOURS = "what no force of extension, rate and history explains"
"""What an estimate of the noise is taken from."""


@dataclass(frozen=True)
class Floor:
    """E that the sensors' noise alone would leave, over all compared runs and over those of each
    role: that of the truest model.

    ``expected``, ``expected_fit`` and ``expected_validate`` are E that a right model may leave: no
    bound, for it may leave less. It is more than the floor where the scales of channels are
    uncertain, and where measured axles drive the model: motion from above half the sample rate is
    folded into their records, and how much is estimated.

    ``source`` is the key under which the campaign states the noise ("noise_rms_m_s2"), or
    "estimated". ``noise_rms`` (n_channels,) is the noise in band assumed for each channel over its
    ``noise_scale`` (`weights`), in ``unit``, that of the leading quantity, NaN where none
    could be estimated because the model predicts nothing; ``noise_key`` is its name in files.
    ``basis`` says in words what an estimate is taken from, and ``uncertainty`` is the relative
    standard uncertainty of the noise. ``of_laws`` is how many times what is expected of the runs
    that judge no law leaves less than, named, in free form or a formula; 0 where none was sought.
    ``scales`` is what of `expected` the scales of the channels alone leave. ``driver`` is what was
    measured and drives the model, if anything does, in words.
    """

    error: float
    error_fit: float
    error_validate: float
    expected: float
    expected_fit: float
    expected_validate: float
    source: str
    noise_rms: Array
    noise_key: str
    unit: str
    scales: float
    noise_scale: Array | float = 1.0
    driver: str = AXLES
    basis: str = QUIETEST
    uncertainty: float = QUIET
    of_laws: float = 0.0

    @property
    def of_channels(self) -> Array:
        """Noise in band (n_channels,) of each channel in its own unit."""
        return np.asarray(self.noise_rms * self.noise_scale)

    @property
    def is_stated(self) -> bool:
        """Whether the campaign states the noise."""
        return self.source != "estimated"

    @property
    def beside_noise(self) -> str:
        """Why a right model may leave more than the floor, in words; empty if nothing lets it."""
        folded = self.expected**2 - self.error**2 - self.scales**2
        if folded > self.scales**2:
            return f"what is folded into the records of {self.driver}"
        return "the uncertain scales of the channels" if self.scales > 0.0 else ""

    @property
    def pooled_rms(self) -> float:
        """Rms over the channels."""
        return float(np.sqrt(np.nanmean(self.noise_rms**2)))

    @property
    def tolerance(self) -> float:
        """Relative uncertainty of the floor, on E: an excess below it means nothing."""
        return STATED if self.is_stated else self.uncertainty

    @property
    def origin(self) -> str:
        """Where the noise comes from, in words."""
        return "stated in campaign.toml" if self.is_stated else f"estimated from {self.basis}"

    @property
    def in_words(self) -> str:
        """What is at the floor, in words."""
        return self.basis if self.basis == NEIGHBOURS else "the sensors’ noise"

    @property
    def is_guess(self) -> bool:
        """Whether nothing shows that what it is taken from is noise."""
        return not self.is_stated and self.basis == QUIETEST and self.pooled_rms > 0.0

    def beside_laws(self, times: float) -> Floor:
        """The floor once no law was found to leave less than so many `times` it. If it was a guess,
        all of that may be noise: what records differ by where the states of the component are
        alike."""
        if not self.is_guess or times < 1.0:
            return replace(self, of_laws=times)
        of = [f"{error}{role}" for error in ("error", "expected") for role in ("", *ROLES)]
        grown = {name: times * getattr(self, name) for name in (*of, "noise_rms")}
        return replace(self, **grown, basis=NEIGHBOURS, uncertainty=SURE, of_laws=1.0)


def noise_floor(campaign: Campaign, records: Sequence[Record]) -> Floor:
    """E of the noise, sqrt(Σ noise² / Σ measured²) in band, and of what else a right model may
    leave, sqrt(Σ (noise² + folded² + (u · measured)²) / Σ measured²).

    The noise is stated by the campaign or estimated; where measured axles drive the model, what
    their noise does is part of it (`Record.noise_power`), and what is folded into their records is
    not (`Record.folded_power`). u is the standard uncertainty of a channel's scale, where a
    calibration states it.
    """
    if campaign.noise_rms is not None:
        source = campaign.noise_key if not campaign.unstated else "estimated"
        noise = np.full(len(campaign.channels), campaign.noise_rms)
        basis, uncertainty = QUIETEST, QUIET
    else:
        source = "estimated"
        noise, basis, uncertainty = _estimated(campaign, records)
    share = _Shares(campaign, records, noise)

    def ratio(role: str | None, *parts: str) -> float:
        return share.error(role, parts, slice(None))

    return Floor(
        error=ratio(None, "noise"),
        error_fit=ratio("fit", "noise"),
        error_validate=ratio("validate", "noise"),
        expected=ratio(None, "noise", "folded", "scales"),
        expected_fit=ratio("fit", "noise", "folded", "scales"),
        expected_validate=ratio("validate", "noise", "folded", "scales"),
        source=source,
        noise_rms=noise,
        noise_key=campaign.noise_key,
        unit=campaign.unit,
        scales=ratio(None, "scales"),
        noise_scale=campaign.noise_scale,
        driver=AXLES if any(c.is_axle for c in campaign.channels) else "travel that drives it",
        basis=basis,
        uncertainty=uncertainty,
    )


def _estimated(campaign: Campaign, records: Sequence[Record]) -> tuple[Array, str, float]:
    """Noise in band (n_channels,) of each channel per its scale, what it is taken from, and its
    relative uncertainty.

    What differs from repeat to repeat is the noise. Where nothing repeats, the quietest parts show
    what it is at most. It is never less than what the steps of the recorded values make.
    """
    scales = campaign.noise_scale
    where = campaign.runs, campaign.sample_rate_hz, campaign.band_hz
    found = scatter(*where)
    if found is None:
        every = tuple(channel.quantity for channel in campaign.channels)
        noise, basis, uncertainty = estimate_noise(records, every), QUIETEST, QUIET
    else:
        noise, basis = found.noise_rms / scales, REPEATED
        uncertainty = max(found.uncertainty, SURE)
    least = least_noise(*where) / scales
    if np.any(noise < least):
        return np.maximum(noise, least), STEPS, max(uncertainty, QUIET)
    return noise, basis, uncertainty


@dataclass(frozen=True, eq=False)
class _Shares:
    """What of the records is noise, and what else a right model may leave."""

    campaign: Campaign
    records: Sequence[Record]
    noise: Array

    def error(
        self, role: str | None, parts: Sequence[str], columns: slice | NDArray[np.bool_]
    ) -> float:
        """E of some of the parts "noise", "folded" and "scales", in the runs of a role, or in
        all."""
        scale = np.array([channel.scale_uncertainty for channel in self.campaign.channels])
        chosen = [r for r in self.records if role in (None, r.run.role)]
        of_part: dict[str, Callable[[Record], Array]] = {
            "noise": lambda r: r.noise_power(self.noise**2),
            "folded": lambda r: r.folded_power(self.noise**2),
            "scales": lambda r: np.asarray((r.measured * scale) ** 2),
        }
        power = {
            part: sum(float(np.sum(of_part[part](r)[:, columns])) for r in chosen) for part in parts
        }
        measured = sum(float(np.sum(r.measured[:, columns] ** 2)) for r in chosen)
        return float(np.sqrt(sum(power[p] for p in parts) / measured)) if measured > 0.0 else nan


def floor_of(
    campaign: Campaign, records: Sequence[Record], floor: Floor, columns: NDArray[np.bool_]
) -> float:
    """E that the noise alone would leave of some of the channels (n_channels,)."""
    return _Shares(campaign, records, floor.noise_rms).error(None, ("noise",), columns)


def estimate_noise(records: Sequence[Record], quantities: Sequence[str] = ()) -> Array:
    """Estimate the in-band rms of each channel's noise (n_channels,), as the records hold it, taken
    as white. Channels of different ``quantities`` (n_channels,) are quiet in different places.

    Noise is what is left where nothing else is: between the road's harmonics, in the part
    of the band and the run that are quietest. The spectrum's *median* over a part of the
    band ignores the harmonics in it, a Blackman-Harris window (side lobes at -92 dB) keeps
    them from leaking over it. All (run, part) pairs are ordered by their level averaged over
    the channels, which makes the choice nearly independent of any one channel's noise, and
    the median over the quietest tenth is taken channel by channel. Of a single channel the
    quietest are those in which its noise is weak by chance, in three runs by a quarter: what
    chance makes of so many of the least among those that are as quiet (within 2 s √(2 ln m)
    of the least of m, s being the scatter of a logarithm) is taken out. This is done on the
    measurements and on the residuals, which may be quieter; the smaller result counts. A
    vehicle that is never quiet anywhere gives too high a value.
    """
    heard = [record for record in records if record.predicted.any()]
    level = np.full(heard[0].measured.shape[1], np.nan)
    for alike in _alike(quantities, len(level)):
        some = [_chosen(record, alike) for record in heard]
        some = [record for record in some if record.predicted.any()]
        if some:
            measured = _quiet_level([(record.measured, record) for record in some])
            residual = _quiet_level([(record.residual, record) for record in some])
            level[alike] = np.fmin(measured, residual)
    return np.asarray(np.sqrt(level))


def _alike(quantities: Sequence[str], count: int) -> list[NDArray[np.bool_]]:
    """The channels of each quantity; all of them if nothing is said."""
    if len(set(quantities)) < 2:
        return [np.ones(count, dtype=bool)]
    return [np.array([q == each for q in quantities]) for each in dict.fromkeys(quantities)]


def _chosen(record: Record, columns: NDArray[np.bool_]) -> Record:
    """A record of some of its channels."""
    if columns.all():
        return record
    measured, residual = record.measured[:, columns], record.residual[:, columns]
    predicted = record.predicted[columns]
    return Record(record.run, record.band, predicted, measured, residual, None)


def estimate_noise_between_samples(records: Sequence[Array], share: float, order: int = 4) -> float:
    """A second estimate of the noise in band, from one sample to the next.

    ``records`` are (n, c) each; ``share`` is the part of white noise that lies in band. Motion is
    smooth on the scale of a few samples, noise is not: the difference of ``order`` m has C(2m, m)
    times the variance of white noise, 70 times for the fourth (J. von Neumann et al., Ann. Math.
    Stat. 12 (1941) 153, for the first one), that of a wave of a tenth of the sample rate a fiftieth
    of its own. The quietest pieces count, as far above the least as chance spreads so many of one
    noise, however few they are: with m of them and a logarithm that scatters by s, 2 s sqrt(2 ln
    m).
    """
    times = comb(2 * order, order)
    # So many differences of white noise tell as much as one that is independent.
    alike = 1.0 + 2.0 * sum(comb(2 * order, k) ** 2 for k in range(order)) / times**2
    pieces = np.array(
        [
            piece.mean(axis=0)
            for record in records
            for piece in np.array_split(
                np.diff(record, order, axis=0) ** 2, len(record) // PIECE or 1
            )
        ]
    )
    level = np.log(np.maximum(pieces, np.finfo(float).tiny)).mean(axis=1)
    scatter_of_level = np.sqrt(special.polygamma(1, PIECE / alike / 2) / pieces.shape[1])
    spread = 2.0 * scatter_of_level * np.sqrt(2.0 * np.log(len(pieces)))
    return float(np.sqrt(pieces[level <= level.min() + spread].mean() / times * share))


def _quiet_level(signals: Sequence[tuple[Array, Record]]) -> Array:
    """Mean square in band (n_channels,) that the quietest parts of the spectra imply."""
    found = [part for signal in signals for part in _levels(*signal)]
    levels = np.array([level for level, _ in found])
    lines = np.array([count for _, count in found])
    with np.errstate(divide="ignore"):
        loudness = np.nanmean(np.log(levels), axis=1)
    order, tenth = np.argsort(loudness), max(1, round(QUIET_SHARE * len(levels)))
    least = levels[order[:tenth]]
    out = np.full(levels.shape[1], np.nan)
    known = ~np.isnan(least).all(axis=0)
    out[known] = np.nanmedian(least[:, known], axis=0)
    if levels.shape[1] == 1:
        scatter = OF_MEDIAN / np.sqrt(np.maximum(lines / ALIKE, 1.0))
        spread = 2.0 * scatter * np.sqrt(2.0 * np.log(len(levels)))
        alike = max(int(np.sum(loudness <= loudness[order[0]] + spread)), tenth)
        out *= np.exp(-_of_least(tenth, alike) * scatter[order[:tenth]].mean())
    return out


def _of_least(count: int, among: int) -> float:
    """Median of the least `count` of so many normal deviates (G. Blom, Statistical Estimates and
    Transformed Beta-Variables, 1958, eq. 6.10.3)."""
    return float(special.ndtri(((count + 1) / 2 - 0.375) / (among + 0.25)))


def _levels(coefficients: Array, record: Record) -> Iterator[tuple[Array, int]]:
    """Level of white noise in band, as mean square, that each part of the band suggests, and the
    lines that it has."""
    band = record.band
    window = blackman_harris(band.n)
    spectrum = fft.rfft(band.from_coefficients(coefficients) * window[:, None], axis=0)
    # E|spectrum|² = Σ window² times one sample's variance; the in-band share of it is count / n.
    power = np.abs(spectrum) ** 2 / np.sum(window**2) * band.count / band.n
    power[:, ~record.predicted] = np.nan
    step = band.rate_hz / band.n
    first, last = (round(f / step) for f in band.frequency_hz[[0, -1]])
    margin = min(LOBE, (last - first) // BLOCKS)  # no more than one of the parts
    edges = np.linspace(first + margin, last + 1 - margin, BLOCKS + 1).astype(int)
    for low, high in pairwise(np.unique(edges)):
        # The median of an exponentially distributed periodogram is ln 2 times its mean.
        yield np.median(power[low:high], axis=0) / np.log(2.0), int(high - low)
