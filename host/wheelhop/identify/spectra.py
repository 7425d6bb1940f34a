"""Recordings as spectra in band: axle motion as input, body motion as output."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import AXLE_POINTS, BODY_POINTS, Campaign, CampaignError, Channel, Run
from wheelhop.compare import InBand
from wheelhop.identify.structure import VERTICAL

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

MOTIONS = {  # of four points: front left, front right, rear left, rear right
    "all wheels alike (heave)": np.array([1.0, 1.0, 1.0, 1.0]) / 2,
    "front against rear (pitch)": np.array([1.0, 1.0, -1.0, -1.0]) / 2,
    "left against right (roll)": np.array([1.0, -1.0, 1.0, -1.0]) / 2,
    "diagonally (warp)": np.array([1.0, -1.0, -1.0, 1.0]) / 2,
}
LEAST_POWER = 1e-6
"""A motion of the axles with less than this share of their power, noise apart, is not excited."""


@dataclass(frozen=True, eq=False)
class Spectra:
    """Runs of one length: r runs, k lines in band, m inputs, n outputs.

    The spectra are scaled so that their sums of squares are those of the band-passed signals over
    time. `samples` is the length of a run.
    """

    runs: tuple[str, ...]
    omega: Array  #: (k,) rad/s
    inputs: ComplexArray  #: (r, k, m)
    outputs: ComplexArray  #: (r, k, n)
    samples: int

    def only(self, which: NDArray[np.int64]) -> Spectra:
        """The runs of these numbers."""
        return replace(
            self,
            runs=tuple(self.runs[i] for i in which),
            inputs=self.inputs[which],
            outputs=self.outputs[which],
        )


@dataclass(frozen=True, eq=False)
class Measured:
    """What a campaign offers a transfer matrix: spectra by role, and which corners they are of.

    `inputs` and `outputs` are corners 0..3 of the axle and body points that were recorded.
    `noise_rms` is the stated noise of one channel in band, m/s², None if it is not stated.
    """

    fit: tuple[Spectra, ...]
    validate: tuple[Spectra, ...]
    inputs: tuple[int, ...]
    outputs: tuple[int, ...]
    noise_rms: float | None

    @property
    def fit_ids(self) -> tuple[str, ...]:
        """Ids of the runs to fit."""
        return tuple(name for part in self.fit for name in part.runs)


def measure(campaign: Campaign, *, fore_aft: bool = False) -> Measured:
    """Spectra of the axle and body points of every run.

    Channels at other places take no part. A point that was not recorded is left out, of the inputs
    or of the outputs. With `fore_aft` accelerations of the axles along x are inputs, too, numbered
    on from 4.

    Raises
    ------
    CampaignError
        No axle or no body point, a channel that is zero in every run, only one run to fit, or with
        `fore_aft` no acceleration of an axle along x.
    """
    where = campaign.folder / "campaign.toml"
    axles = _columns(campaign.channels, AXLE_POINTS)
    bodies = _columns(campaign.channels, BODY_POINTS)
    if not axles or not bodies:
        lacking = "an axle (A1..A4)" if not axles else "the body (B1..B4)"
        raise CampaignError(
            f"{where}: [channels] has no point on {lacking}: a transfer matrix from axles to"
            " body needs both"
        )
    if not campaign.fit_runs:
        raise CampaignError(f'{where}: no [[run]] has role = "fit": there is nothing to fit')
    if len(campaign.runs) == 1:
        raise CampaignError(
            f"{where}: there is one [[run]] only: a transfer matrix is fitted to some runs and"
            " judged on others; record another"
        )
    for corner_points, columns in ((AXLE_POINTS, axles), (BODY_POINTS, bodies)):
        for corner, column in columns.items():
            if all(not np.ptp(run.record[:, column]) for run in campaign.fit_runs):
                raise CampaignError(
                    f"{where}: channel {campaign.channels[column].name} ({corner_points[corner]})"
                    " never changes in any run to fit: leave it out under [channels]"
                )
    along = _along(campaign) if fore_aft else {}
    chosen = (list(axles.values()), list(along.values()), list(bodies.values()))
    return Measured(
        _of(campaign, campaign.fit_runs, *chosen),
        _of(campaign, campaign.validate_runs, *chosen),
        (*axles, *along),
        tuple(bodies),
        campaign.noise_rms,
    )


def _columns(channels: Sequence[Channel], points: Sequence[str]) -> dict[int, int]:
    """Column of each recorded point, by corner."""
    column = {channel.point: i for i, channel in enumerate(channels)}
    return {corner: column[p] for corner, p in enumerate(points) if p in column}


def _along(campaign: Campaign) -> dict[int, str]:
    """Names of the axles' channels along x, by the number of the input."""
    of = {c.point: c.name for c in campaign.known if c.is_acceleration and c.axis == "x"}
    found = {VERTICAL + i: of[p] for i, p in enumerate(AXLE_POINTS) if p in of}
    if not found:
        raise CampaignError(
            f"{campaign.folder / 'campaign.toml'}: [channels] has no acceleration of an axle along"
            ' x, such as A1_x = { quantity = "acceleration", axis = "x", position = "A1" }'
        )
    return found


def _of(
    campaign: Campaign, runs: Sequence[Run], axles: list[int], along: list[str], bodies: list[int]
) -> tuple[Spectra, ...]:
    """One `Spectra` for each length of record."""
    by_length: dict[int, list[Run]] = {}
    for run in runs:
        by_length.setdefault(len(run.time_s), []).append(run)
    out = []
    for n, alike in by_length.items():
        records = np.stack([run.record for run in alike])
        beside = [np.stack([run.known[name] for run in alike]) for name in along]
        driven = np.dstack([records[:, :, axles], *(one[:, :, None] for one in beside)])
        out.append(
            spectra(
                driven,
                records[:, :, bodies],
                campaign.sample_rate_hz,
                campaign.band_hz,
                tuple(run.id for run in alike),
            )
        )
        assert out[-1].samples == n
    return tuple(out)


def spectra(
    inputs: Array,
    outputs: Array,
    rate_hz: float,
    band_hz: tuple[float, float],
    runs: tuple[str, ...] = (),
) -> Spectra:
    """Spectra of records `inputs` (r, n, m) and `outputs` (r, n, n_out) inside the band."""
    count, n = inputs.shape[:2]
    band = InBand(n, rate_hz, band_hz)

    def lines(records: Array) -> ComplexArray:
        c = band.coefficients(np.moveaxis(records, 0, 1))
        half = band.count // 2
        return np.ascontiguousarray(np.moveaxis(c[:half] + 1j * c[half:], 1, 0))

    names = runs or tuple(str(i + 1) for i in range(count))
    return Spectra(names, 2 * np.pi * band.frequency_hz, lines(inputs), lines(outputs), n)


def through(matrix: ComplexArray, inputs: ComplexArray) -> ComplexArray:
    """Outputs (r, k, n) of a matrix (k, n, m) for inputs (r, k, m)."""
    moved: ComplexArray = (matrix @ inputs[..., None])[..., 0]
    return moved


def not_excited(spectra: Sequence[Spectra], noise_rms: float | None) -> tuple[str, ...]:
    """Motions of the four axles that no run excites beyond noise: what a transfer matrix says of
    them is not measured. Empty if not all four axles were recorded."""
    if spectra[0].inputs.shape[2] not in (VERTICAL, 2 * VERTICAL):
        return ()
    spectra = [replace(part, inputs=part.inputs[:, :, :VERTICAL]) for part in spectra]
    total = sum(float(np.sum(np.abs(part.inputs) ** 2)) for part in spectra)
    noise = sum(len(part.runs) * part.samples for part in spectra) * (noise_rms or 0.0) ** 2
    quiet = []
    for name, pattern in MOTIONS.items():
        power = sum(float(np.sum(np.abs(part.inputs @ pattern) ** 2)) for part in spectra)
        if power - noise < max(LEAST_POWER * total, noise):
            quiet.append(name)
    return tuple(quiet)
