"""What every strut did in the runs, measured and modelled: travel, its velocity, and the force."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, ComponentCampaign
from wheelhop.compare import InBand
from wheelhop.diagnose import Step
from wheelhop.fit import Bench
from wheelhop.law.places import CORNER_NAMES
from wheelhop.report.cases import runs_of
from wheelhop.simulate import RunSimulator
from wheelhop.simulate.struts import strut_motion
from wheelhop.vehicle import wheels

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

LOW_SPEED_M_S = 0.05
"""Below this the velocity of a strut counts as low speed: bleed and seals rule there, the body's
roll, pitch and heave lie there; adjusters called low-speed act up to 25 to 75 mm/s."""

END_S, MOST_ENDS = 0.5, 0.125
"""So much of a run is left out at either end, but no more than this share of it. A band has no
beginning: taken out of a record that ends elsewhere than it began, velocity overshoots there."""

MEASURED, BASELINE, LAST = "measured", "baseline", "last model"


@dataclass(frozen=True, eq=False)
class StrutRun:
    """One strut in one run, in band, at the wheel, positive in rebound (extension): travel (n,), m,
    about its mean; velocity (n,), m/s; the force in it (n,), N, None where it was not measured."""

    travel: Array
    velocity: Array
    force: Array | None
    velocity_noise: float = 0.0  #: rms, m/s, that the noise of the sensor makes of it


@dataclass(frozen=True)
class Shares:
    """Share of the time a strut spends in bump (compression) and in rebound (extension), faster and
    slower than LOW_SPEED_M_S. They sum to 1."""

    bump_high: float
    bump_low: float
    rebound_low: float
    rebound_high: float


@dataclass(frozen=True, eq=False)
class StrutHistory:
    """What one strut did in the runs, by their ids: as measured, or as the model `name` has it."""

    name: str
    rate_hz: float
    runs: Mapping[str, StrutRun]

    @property
    def is_measured(self) -> bool:
        """Whether a sensor shows it."""
        return self.name == MEASURED

    @property
    def travel(self) -> Array:
        """Of all runs, one after the other, m."""
        return np.concatenate([run.travel for run in self.runs.values()])

    @property
    def velocity(self) -> Array:
        """Of all runs, one after the other, m/s."""
        return np.concatenate([run.velocity for run in self.runs.values()])

    @property
    def velocity_noise(self) -> float:
        """Rms over all runs of what in the velocity is noise of the sensor, m/s; 0 of a model."""
        runs = self.runs.values()
        return float(np.sqrt(np.mean([run.velocity_noise**2 for run in runs])))


def shares(velocity: Array) -> Shares:
    """How a strut's time is shared out, of its velocity (n,), m/s, positive in rebound."""
    fast = np.abs(velocity) > LOW_SPEED_M_S
    bump = velocity < 0
    parts = (bump & fast, bump & ~fast, ~bump & ~fast, ~bump & fast)
    return Shares(*(float(part.mean()) for part in parts))


def strut_histories(
    campaign: Campaign, steps: Sequence[Step]
) -> Mapping[int, tuple[StrutHistory, ...]]:
    """Every strut of a vehicle by its corner: measured, if its travel is, then as the first and the
    last model have it. A component has none."""
    if isinstance(campaign, ComponentCampaign):
        return {}
    found: dict[int, list[StrutHistory]] = {i: [] for i in wheels(steps[0].rung.model.values)}
    noise_rms = steps[-1].comparison.floor.of_channels
    for corner, histories in found.items():
        measured = {
            run.bench.run.id: _measured(campaign, run.bench, corner, noise_rms)
            for run in runs_of(steps[0].rung)
        }
        shown = {run_id: run for run_id, run in measured.items() if run is not None}
        if shown:
            histories.append(StrutHistory(MEASURED, campaign.sample_rate_hz, shown))
    models = [(steps[0], BASELINE)] + ([(steps[-1], LAST)] if len(steps) > 1 else [])
    for step, name in models:
        modelled = _modelled(campaign, step)
        for column, histories in enumerate(found.values()):
            own = {run_id: of_run[column] for run_id, of_run in modelled.items()}
            histories.append(StrutHistory(name, campaign.sample_rate_hz, own))
    return {corner: tuple(histories) for corner, histories in found.items()}


def _measured(campaign: Campaign, bench: Bench, corner: int, noise_rms: Array) -> StrutRun | None:
    """What the channels of a strut show of it; None where its travel is not measured."""
    columns = {
        channel.quantity: i
        for i, channel in enumerate(campaign.channels)
        if channel.corner == corner and channel.quantity in ("travel", "force")
    }
    if "travel" not in columns:
        return None
    band = bench.band
    ratio = {i: campaign.channels[i].per_wheel for i in columns.values()}
    of = {k: band.coefficients(bench.run.record[:, i] / ratio[i]) for k, i in columns.items()}
    pot = columns["travel"]
    omega_rms = 2 * np.pi * float(np.sqrt(np.mean(band.frequency_hz**2)))  # its noise is white
    noise = omega_rms * float(noise_rms[pot]) / abs(ratio[pot])
    return replace(_strut_run(band, of["travel"], of.get("force")), velocity_noise=noise)


def _modelled(campaign: Campaign, step: Step) -> dict[str, list[StrutRun]]:
    """Every strut of a model in every run, after the recorder's filter."""
    benches = [run.bench for run in runs_of(step.rung)]
    simulators = [b.simulator for b in benches if isinstance(b.simulator, RunSimulator)]
    found = {}
    for bench, motion in zip(benches, strut_motion(step.rung.model, simulators), strict=True):
        band = bench.band
        travel, force = (
            _filtered(campaign, quantity, band, band.coefficients(part))
            for quantity, part in zip(("travel", "force"), motion, strict=True)
        )
        columns = zip(travel.T, force.T, strict=True)
        found[bench.run.id] = [_strut_run(band, *column) for column in columns]
    return found


def _filtered(campaign: Campaign, quantity: str, band: InBand, coefficients: Array) -> Array:
    """Coefficients (2 n_bins, c) behind the filter of the channels of a quantity, if one is
    stated."""
    own = (c.low_pass for c in campaign.channels if c.quantity == quantity and c.low_pass)
    low_pass = next(own, campaign.low_pass)
    if low_pass is None:
        return coefficients
    real, imaginary = np.split(coefficients, 2)
    passed = low_pass.response(band.frequency_hz)[:, None] * (real + 1j * imaginary)
    return np.concatenate([passed.real, passed.imag])


def _strut_run(band: InBand, travel: Array, force: Array | None) -> StrutRun:
    """Of coefficients (2 n_bins,), without the ends of the run."""
    end = round(min(END_S * band.rate_hz, MOST_ENDS * band.n))

    def signal(coefficients: Array) -> Array:
        return band.from_coefficients(coefficients)[end : band.n - end]

    velocity = signal(band.differentiated(travel))
    return StrutRun(signal(travel), velocity, None if force is None else signal(force))


def struts_frame(campaign: Campaign, steps: Sequence[Step]) -> DataFrame:
    """A row for every strut and history: shares of the time, rms of the velocity, what of it is
    noise of the sensor, and the ends of travel and velocity, in SI, at the wheel, in band."""
    import pandas

    rows = [
        {
            "strut": CORNER_NAMES[corner],
            "history": history.name,
            **vars(shares(history.velocity)),
            "velocity_rms_m_s": float(np.sqrt(np.mean(history.velocity**2))),
            "velocity_noise_rms_m_s": history.velocity_noise,
            **_ends("velocity", "m_s", history.velocity),
            **_ends("travel", "m", history.travel),
        }
        for corner, histories in strut_histories(campaign, steps).items()
        for history in histories
    ]
    return pandas.DataFrame(rows).set_index(["strut", "history"]) if rows else pandas.DataFrame()


def _ends(what: str, unit: str, values: Array) -> dict[str, float]:
    return {
        f"{what}_min_{unit}": float(values.min()),
        f"{what}_max_{unit}": float(values.max()),
    }
