"""The baseline: a campaign and a nominal vehicle, fitted and validated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from wheelhop.campaign import Campaign, CampaignError, ComponentCampaign, TrackSpec
from wheelhop.compare import Comparison, Floor, compare
from wheelhop.compare.band import InBand
from wheelhop.diagnose.confirm.validate import validate
from wheelhop.diagnose.score import Rung
from wheelhop.files import Progress
from wheelhop.files.words import listed
from wheelhop.fit import (
    Bench,
    Free,
    Watch,
    Workshop,
    begin_component,
    find_start,
    fit,
    initial_model,
    vehicle_parameters,
)
from wheelhop.simulate import Model, climbing, drive_of
from wheelhop.simulate.measured import driving
from wheelhop.vehicle import Drive, Vehicle, wheels

STILL = 1e-9
"""In-band coefficients of this size, m/s² (N, m on a rig), are rounding: nothing moves."""


@dataclass(frozen=True, eq=False)
class Baseline:
    """The workshop with its noise set, the vehicle's free parameters and the fitted baseline."""

    workshop: Workshop
    vehicle: tuple[Free, ...]
    rung: Rung


def fit_baseline(
    campaign: Campaign,
    vehicle: Vehicle,
    *,
    jobs: int | None = None,
    progress: Progress,
    watch: Watch = lambda iteration, error: None,
    known: Mapping[str, float] = MappingProxyType({}),
) -> Baseline:
    """Find every run's start, fit the nominal vehicle, validate it, and settle the noise floor;
    `watch` sees this fit and all later ones in the same workshop converge. The fit begins at what
    another of the same vehicle came to, as far as that is `known`.

    Raises
    ------
    CampaignError
        The campaign does not hold what a comparison needs.
    """
    check_comparable(campaign, vehicle)
    model = initial_model(campaign, vehicle)
    workshop = Workshop(campaign, model, measured=vehicle.measured, jobs=jobs)
    progress("finding each run's start and speed")
    free = tuple(vehicle_parameters(campaign, vehicle))
    model = model.with_values({f.name: known[f.name] for f in free if f.name in known})
    model = started(workshop, model, free)

    def told(iteration: int, error: float) -> None:
        progress(f"fitting the baseline: iteration {iteration}, error {error:.4f}")
        watch(iteration, error)

    workshop.watch = told
    fitted = fit(workshop, model, free, workshop.of_role("fit"))
    workshop.watch = watch
    if not np.isfinite(fitted.rss):
        raise CampaignError(
            f"{campaign.vehicle_file}: a vehicle with these numbers runs away from the road: one of"
            " them is far off, in a wrong unit perhaps"
        )
    rung = validate(workshop, fitted)
    for run in (*fitted.runs, *rung.judging.runs):
        if run.freedom >= run.bench.size:
            raise CampaignError(
                f'{campaign.folder / "campaign.toml"}: run "{run.bench.run.id}": {run.bench.size}'
                f" numbers in band do not tell the {run.freedom:g} that are free in it: widen"
                " band_hz, or record longer"
            )
    if campaign.noise_rms is None:
        # Only now is there a residual from which the noise can be told.
        noise = comparison_of(workshop, rung).floor.noise_rms
        workshop.set_noise(float(np.sqrt(np.nanmean(noise**2))))
    return Baseline(workshop, free, rung)


def axle_driven(campaign: Campaign, vehicle: Vehicle) -> Campaign | None:
    """The campaign with the measured axle motion driving the body, so that track, speed and tyres
    do not matter. None without the axles of all wheels, or a channel on the body that moves."""
    corners = {c.corner for c in campaign.channels if c.is_axle}
    body = [i for i, c in enumerate(campaign.channels) if c.is_on_body]
    if corners != set(wheels(vehicle.values)) or not body or _resting(campaign, body):
        return None
    unknown = TrackSpec("unknown", {})
    return replace(campaign, runs=tuple(replace(run, track=unknown) for run in campaign.runs))


def comparison_of(
    workshop: Workshop,
    rung: Rung,
    changes: Mapping[str, float] = MappingProxyType({}),
    floor: Floor | None = None,
) -> Comparison:
    """The fitted model, with some of its numbers changed if wanted, against all runs. Gains are
    fitted: what is left of a scale's uncertainty is what a sensor shows of motion across its
    axis."""
    campaign = workshop.campaign
    channels = tuple(
        replace(c, scale_uncertainty=float(np.sqrt(c.scale_uncertainty**2 - c.gain_uncertainty**2)))
        for c in campaign.channels
    )
    fitted = replace(campaign, channels=channels)
    responses = workshop.responses(rung.model.with_values(changes))
    return compare(fitted, responses, charged(rung), floor)


def charged(rung: Rung) -> dict[str, float]:
    """Degrees of freedom each validated run was given for itself."""
    if rung.validation is None:
        return {}
    return {run.bench.run.id: run.freedom for run in rung.validation.runs}


def started(workshop: Workshop, model: Model, free: Sequence[Free]) -> Model:
    """The model with where every run on the road began, and how fast it went; of a component, with
    its `free` numbers where they begin."""
    if isinstance(workshop.campaign, ComponentCampaign):
        return begin_component(workshop.campaign, model, free)
    systems = workshop.systems(model)
    benches = [b for b in workshop.benches.values() if b.drive == "road"]

    def place(bench: Bench) -> dict[str, float]:
        with climbing(workshop.campaign, bench.run):
            return find_start(workshop.campaign, bench.run, model, systems["road"])

    starts = workshop.each(place, benches)
    for bench, start in zip(benches, starts, strict=True):
        model = model.with_run(bench.run.id, start)
    return model


def _resting(campaign: Campaign, channels: list[int]) -> list[str]:
    """Roles in whose runs none of these channels holds more in band than rounding."""
    moves = dict[str, bool]()
    for run in campaign.runs:
        band = InBand(len(run.time_s), campaign.sample_rate_hz, campaign.band_hz)
        largest = np.abs(band.coefficients(run.record[:, channels])).max()
        moves[run.role] = moves.get(run.role, False) or bool(largest > STILL)
    return [role for role, any_moves in moves.items() if not any_moves]


def check_comparable(campaign: Campaign, vehicle: Vehicle) -> None:
    """Raise the CampaignError that says why no model can be compared with a campaign, and what
    would cure it: nothing moves, or nothing that is measured can move the model."""
    where = campaign.folder / "campaign.toml"
    for role in _resting(campaign, list(range(len(campaign.channels)))):
        raise CampaignError(
            f"{where}: nothing moves between {campaign.band_hz[0]:g} and {campaign.band_hz[1]:g} Hz"
            f' in the runs with role = "{role}": are the sensors connected, and the units right?'
        )
    unknown = [run for run in campaign.runs if run.track.kind == "unknown"]
    for run in unknown[:1]:
        drive = drive_of(campaign, run)
        missing = _unmoved(campaign, drive, vehicle)
        lacking = ", ".join(f"{'A' if drive == 'axles' else 'S'}{i}" for i in missing)
        if drive == "axles" and missing:
            pots = listed([str(i) for i in _unmoved(campaign, "travel", vehicle)])
            raise CampaignError(
                f'{where}: run "{run.id}" has track.kind = "unknown", so measured axle motion must'
                f" drive the model, but {lacking} is not among the channels; describe the"
                f" track, add accelerometers there or potentiometers at the struts {pots}, or leave"
                " the run out"
            )
        if missing:
            raise CampaignError(
                f'{where}: run "{run.id}" has track.kind = "unknown", so measured travel must drive'
                f" the model, but no channel shows it at {lacking}; describe the track, add the"
                " potentiometer, or leave the run out"
            )
    if unknown and not any(c.is_on_body for c in campaign.channels):
        raise CampaignError(
            f'{where}: run "{unknown[0].id}" has track.kind = "unknown" and no channel on the body:'
            " nothing can be compared; describe the track, or add a channel on the body"
        )


def _unmoved(campaign: Campaign, drive: Drive, vehicle: Vehicle) -> list[int]:
    """The corners, from 1, of which no channel shows the motion that drives the model."""
    corners = driving(campaign, drive)
    return [i + 1 for i in wheels(vehicle.values) if i not in corners]
