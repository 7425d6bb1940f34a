"""What runs nobody has driven yet would tell: of the vehicle's numbers, and of every effect.

A run that leaves nothing but the sensors' noise has the information matrix of the diagnosis:
products of derivatives over σ², with what the run leaves free eliminated. Its rows are the
vehicle's numbers, per standard deviation believed beforehand, and then the effects' amplitudes, per
scale, at which an effect is clearly visible. An effect stands there in each of its forms, its
shapes at each of their starts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from wheelhop.campaign import CampaignError
from wheelhop.diagnose.screen.first_order import tabulated
from wheelhop.diagnose.screen.signatures import Variant
from wheelhop.diagnose.screen.table import Columns, Known, Table, run_table
from wheelhop.effects import Effect, RandomHeights, Shape
from wheelhop.fit import Fit, Free, RunFit, Workshop, foreseen, vehicle_parameters
from wheelhop.predict.case import Case
from wheelhop.predict.drives import Drive

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Foreseen:
    """What each of some drives would tell.

    `numbers` (g) are those of the vehicle that the runs can show; `variants` the effects, those of
    one effect one after the other, with a amplitudes altogether. `information` (drives, g + a,
    g + a) is what one drive adds, and `prior` (g, g) what is believed of the numbers before. `size`
    is the number of data of one run.
    """

    vehicle_name: str
    drives: tuple[Drive, ...]
    numbers: tuple[Free, ...]
    variants: tuple[Variant, ...]
    information: Array
    prior: Array
    size: int

    @cached_property
    def effects(self) -> tuple[str, ...]:
        """Ids of the effects, each once."""
        return tuple(dict.fromkeys(variant.effect.id for variant in self.variants))

    @cached_property
    def places(self) -> tuple[slice, ...]:
        """Where each variant's amplitudes stand among all of them."""
        ends = np.cumsum([len(variant.amplitudes) for variant in self.variants]).tolist()
        return tuple(slice(first, last) for first, last in zip([0, *ends], ends, strict=False))


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
        workshop = Workshop(campaign, model, measured=case.vehicle.measured, jobs=jobs)
        numbers = tuple(vehicle_parameters(campaign, case.vehicle))
        base = foreseen(workshop, model, numbers, tuple(workshop.benches.values()))
        if not np.isfinite(base.precision).all():
            raise CampaignError(
                "the simulation runs away when the vehicle's numbers change a little"
            )
        chosen = [variant for one in effects for variant in forms_of(base, workshop, one)]
        if not (numbers or chosen):
            raise CampaignError("nothing to find out: every number is certain, no effect acts")
        progress(f"{len(chosen)} forms of effects in {len(case.drives)} runs")
        tables = [of_runs for _, of_runs in tabulated(workshop, base, chosen)]
        information = np.stack(
            workshop.each(
                lambda i: _information(base, base.runs[i], [t[i] for t in tables], chosen),
                range(len(base.runs)),
            )
        )
    size = max(run.bench.size for run in base.runs)
    return Foreseen(
        case.vehicle.name, case.drives, numbers, tuple(chosen), information, base.believed, size
    )


def forms_of(base: Fit, workshop: Workshop, effect: Effect) -> list[Variant]:
    """An effect in all its forms, shapes at each of their starts; none where it has no strength."""
    settings = [run.bench.simulator.setting for run in base.runs]
    acting = [setting for setting in settings if effect.acts_in(setting)]
    if not acting or isinstance(effect, RandomHeights):
        return []
    found = []
    for choice in effect.choices(workshop.campaign.channels):
        form = effect.with_choice(choice) if choice else effect
        parameters = tuple(workshop.parameters_of(form))
        runs = {
            setting.run_id: {p.name: p.start for p in form.per_run(setting) if isinstance(p, Shape)}
            for setting in acting
        }
        starts = {p.name: p.starts for p in parameters if isinstance(p, Shape)}
        for shapes in product(*starts.values()):
            values = dict(zip(starts, shapes, strict=True))
            found.append(Variant(form, choice, values, parameters, runs))
    return [variant for variant in found if variant.amplitudes]


def _information(base: Fit, run: RunFit, tables: list[Table], chosen: list[Variant]) -> Array:
    """Of one run, (g + a, g + a). The signatures are free of what each effect leaves free in the
    run already."""
    size = run.bench.size
    parts = []
    for table, variant in zip(tables, chosen, strict=True):
        scale = np.array([p.scale for p in variant.amplitudes])
        parts.append(np.nan_to_num(table.signatures * scale, posinf=0.0, neginf=0.0))
    together = np.hstack([np.zeros((size, 0)), *parts])
    columns = Columns(together, np.zeros((size, 0)))
    table = run_table(run, base, columns, Known.of(run))
    return table.at_noise / base.sigma**2
