"""What runs nobody has driven yet would tell: of the vehicle's numbers, and of every effect.

A run that leaves nothing but the sensors' noise has the information matrix of the diagnosis:
products of derivatives over σ², with what the run leaves free eliminated. Its rows are the
vehicle's numbers, per standard deviation believed beforehand, and then the effects. The column of
an effect is what it adds to the record at its scale, which is clearly visible. An effect stands in
its first form, its shapes where they start.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from wheelhop.campaign import CampaignError
from wheelhop.diagnose.screen import Variant, tabulated
from wheelhop.diagnose.screen_table import Columns, Known, Table, run_table
from wheelhop.effects import Effect
from wheelhop.fit import Fit, Free, RunFit, Workshop, foreseen, vehicle_parameters
from wheelhop.predict.case import Case
from wheelhop.predict.drives import Drive

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Foreseen:
    """What each of some drives would tell.

    `numbers` (g) are those of the vehicle that the runs can show, `effects` (e) those that act in
    any of the drives with a strength they share. `information` (drives, g + e, g + e) is what one
    drive adds, and `prior` (g,) what is believed of the numbers before. `size` is the number of
    data of one run.
    """

    vehicle_name: str
    drives: tuple[Drive, ...]
    numbers: tuple[Free, ...]
    effects: tuple[Variant, ...]
    information: Array
    prior: Array
    size: int


def foresee(
    case: Case,
    effects: Iterable[Effect],
    noise_rms: float,
    progress: Callable[[str], None] = lambda text: None,
    jobs: int | None = None,
) -> Foreseen:
    """What all drives of a case would tell of its vehicle and of these effects.

    Parameters
    ----------
    case
        The vehicle as it is believed to be, without effects, and all drives that could be made.
    effects
        Those to be told apart. Of one that only leaves every run numbers of its own nothing can be
        said beforehand; it is left out.
    noise_rms
        Of a channel in band, m/s².

    Raises
    ------
    CampaignError
        The simulation runs away on one of the tracks, or there is nothing to find out.
    """
    with threadpool_limits(1):
        progress(f"driving {len(case.drives)} runs")
        campaign, model = case.campaign(noise_rms)
        workshop = Workshop(campaign, model, jobs=jobs)
        numbers = tuple(vehicle_parameters(campaign, case.vehicle))
        base = foreseen(workshop, model, numbers, tuple(workshop.benches.values()))
        if not np.isfinite(base.precision).all():
            raise CampaignError(
                "the simulation runs away when the vehicle's numbers change a little"
            )
        chosen = [variant for one in effects if (variant := _first(base, workshop, one))]
        if not (numbers or chosen):
            raise CampaignError("nothing to find out: every number is certain, no effect acts")
        progress(f"{len(chosen)} effects in {len(case.drives)} runs")
        tables = tabulated(workshop, base, chosen)
        information = np.stack(
            workshop.each(
                lambda pair: _information(base, *pair, chosen),
                list(zip(base.runs, tables, strict=True)),
            )
        )
    prior = np.array([(f.scale / f.sigma) ** 2 for f in numbers])
    size = max(run.bench.size for run in base.runs)
    return Foreseen(
        case.vehicle.name, case.drives, numbers, tuple(chosen), information, prior, size
    )


def _first(base: Fit, workshop: Workshop, effect: Effect) -> Variant | None:
    """An effect in its first form, shapes at their first starts; None where it has no strength."""
    settings = [run.bench.simulator.setting for run in base.runs]
    acting = [setting for setting in settings if effect.acts_in(setting)]
    choices = effect.choices(workshop.campaign.channels)
    if not (acting and choices) or effect.has_random_heights:
        return None
    form = effect.with_choice(choices[0]) if choices[0] else effect
    parameters = tuple(workshop.parameters_of(form))
    shapes = {p.name: p.starts[0] for p in parameters if p.is_shape}
    runs = {
        setting.run_id: {p.name: p.starts[0] for p in form.per_run(setting) if p.is_shape}
        for setting in acting
    }
    variant = Variant(form, choices[0], shapes, parameters, runs)
    return variant if variant.amplitudes else None


def _information(base: Fit, run: RunFit, tables: list[Table], chosen: list[Variant]) -> Array:
    """Of one run, (g + e, g + e). The effects' signatures are free of what each leaves free in the
    run already."""
    size = run.bench.size
    together = np.zeros((size, len(chosen)))
    for i, (table, variant) in enumerate(zip(tables, chosen, strict=True)):
        scale = np.array([p.scale for p in variant.amplitudes])
        together[:, i] = np.nan_to_num(table.signatures @ scale, posinf=0.0, neginf=0.0)
    columns = Columns(together, np.zeros((size, 0)))
    table = run_table(run, base, columns, Known.of(run).with_columns(run, columns))
    return table.at_noise / base.sigma**2
