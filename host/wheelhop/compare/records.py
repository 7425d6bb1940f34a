"""Measured and modelled runs side by side, in band: what the figures are computed from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, Run
from wheelhop.compare.band import InBand

if TYPE_CHECKING:
    from wheelhop.simulate import Response

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Record:
    """One run in band, as coefficients (``band.count``, n_channels), each in its channel's unit
    over the channel's ``noise_scale`` (n_channels,): all are as noisy (`weights`).

    ``predicted`` (n_channels,) says which channels the model predicts. The others are zero
    in ``measured`` and ``residual`` (measured - model), and so count nowhere.
    ``position_m`` (n,) is the modelled x of the front axle, None where unknown. ``noise_ratio``
    and ``doubt`` (count, n_channels): see `Response`; None: the model is driven by nothing that is
    noisy itself.
    """

    run: Run
    band: InBand
    predicted: NDArray[np.bool_]
    measured: Array
    residual: Array
    position_m: Array | None
    doubt: Array | None = None
    noise_ratio: Array | None = None
    noise_scale: Array | float = 1.0

    def signal(self, coefficients: Array) -> Array:
        """Coefficients as a signal (n, n_channels) in the channels' own units."""
        return self.band.from_coefficients(coefficients) * self.noise_scale

    @property
    def model(self) -> Array:
        """The modelled coefficients."""
        return self.measured - self.residual

    @property
    def count(self) -> int:
        """Degrees of freedom: coefficients of the channels the model predicts."""
        return self.band.count * int(self.predicted.sum())

    def noise_power(self, noise: Array) -> Array:
        """Expected square (count, n_channels) of the sensors' noise in every coefficient about the
        model, that of the axles that drive it included: the truest model leaves as much.

        ``noise`` (n_channels,) is the mean square of each sensor's noise in band, per its scale's
        square; what the model does not predict has none.
        """
        return self._power(noise, self.noise_ratio)

    def folded_power(self, noise: Array) -> Array:
        """What motion folded into the records of the axles that drive the model may add to it
        (count, n_channels), as estimated: a right model leaves up to that, perhaps much less."""
        return self._power(noise, self.doubt) - self.noise_power(noise)

    def _power(self, noise: Array, ratio: Array | None) -> Array:
        power = self.band.n / self.band.count * noise * (1.0 if ratio is None else ratio**2)
        return np.where(self.predicted, np.broadcast_to(power, self.measured.shape), 0.0)


def in_band(campaign: Campaign, responses: Iterable[Response]) -> tuple[Record, ...]:
    """Pair each response with its run and take both into the campaign's band.

    Raises ValueError for a response to a run the campaign does not have, one whose shape
    differs from the run's, or a column that is NaN only in part.
    """
    runs = {run.id: run for run in campaign.runs}
    bands: dict[int, InBand] = {}
    scale = campaign.noise_scale
    records = []
    for response in responses:
        if response.run_id not in runs:
            raise ValueError(f"the campaign has no run {response.run_id!r}")
        run = runs[response.run_id]
        n = len(run.time_s)
        if response.record.shape != run.record.shape:
            raise ValueError(
                f"run {run.id}: response {response.record.shape}"
                f" does not fit the record {run.record.shape}"
            )
        predicted = np.logical_not(np.isnan(response.record).any(axis=0))
        if np.isfinite(response.record[:, ~predicted]).any():
            raise ValueError(f"run {run.id}: the response is not finite in every sample")
        if n not in bands:
            bands[n] = InBand(n, campaign.sample_rate_hz, campaign.band_hz)
        band = bands[n]
        measured = band.coefficients(np.where(predicted, run.record, 0.0)) / scale
        model = band.coefficients(np.where(predicted, response.record, 0.0)) / scale
        records.append(
            Record(
                run,
                band,
                predicted,
                measured,
                measured - model,
                response.position_m,
                response.doubt,
                response.noise_ratio,
                scale,
            )
        )
    return tuple(records)


def relative_error(
    records: Sequence[Record],
    charged: Mapping[str, float] | None = None,
    columns: NDArray[np.bool_] | None = None,
) -> float:
    """E = sqrt(Σ|r|² / Σ|y|²) over runs and channels in band, each channel in units of its noise;
    NaN without any signal. ``columns`` (n_channels,) chooses some of the channels.

    ``charged`` maps a run's id to the degrees of freedom that were fitted to that very run:
    its Σ|r|² is scaled by n / (n - charged), what it would be without them.
    """
    residual = measured = 0.0
    for record in records:
        spent = (charged or {}).get(record.run.id, 0.0)
        if record.count and spent >= record.count:
            raise ValueError(
                f"run {record.run.id}: {spent:g} degrees of freedom charged, it has {record.count}"
            )
        scale = record.count / (record.count - spent) if record.count else 0.0
        chosen = slice(None) if columns is None else columns
        residual += scale * float(np.sum(record.residual[:, chosen] ** 2))
        measured += float(np.sum(record.measured[:, chosen] ** 2))
    return float(np.sqrt(residual / measured)) if measured > 0.0 else float("nan")
