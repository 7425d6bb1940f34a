"""A fitted model on other runs: nothing but what each of them leaves free is fitted."""

from __future__ import annotations

import numpy as np

from wheelhop.campaign import Campaign, CampaignError
from wheelhop.diagnose.baseline import started
from wheelhop.diagnose.confirm.starts import placings
from wheelhop.files import Progress
from wheelhop.fit import Bench, Workshop, fit, initial_model, run_parameters
from wheelhop.simulate import Model, Response
from wheelhop.vehicle import Vehicle


def foresee(
    campaign: Campaign, model: Model, *, jobs: int | None, progress: Progress
) -> tuple[list[Response], dict[str, float]]:
    """Responses of a model to all runs of a campaign, and how many degrees of freedom each run was
    given for itself. Raises CampaignError where the vehicle lacks what a channel sits at."""
    own = tuple(f"{effect.id}." for effect in model.effects)
    values = {name: value for name, value in model.values.items() if not name.startswith(own)}
    try:
        nominal = initial_model(campaign, Vehicle(campaign.title, values, dict.fromkeys(values, 0)))
        workshop = Workshop(campaign, nominal, jobs=jobs)
    except KeyError as error:
        raise CampaignError(
            f"{campaign.folder / 'campaign.toml'}: the model has no number {error} that this"
            " campaign needs: it is of another kind of vehicle"
        ) from None
    model = Model({**nominal.values, **model.values}, model.effects, model.runs, model.heights)
    progress("finding each run's start and speed")
    begun = started(workshop, Model(model.values, model.effects), ())
    benches = list(workshop.benches.values())
    for bench in benches:
        free = run_parameters(bench.run, bench.simulator.setting, begun)
        means = {number.name: number.mean for number in free}
        begun = begun.with_run(bench.run.id, {**means, **begun.runs.get(bench.run.id, {})})

    def best(bench: Bench) -> Model:
        """Where the run fits best: found anew, or where the model has been in it."""
        known = bench.run.id in model.runs
        trials = [begun, model] if known else [begun, *placings(workshop, begun, bench)]
        left = [float(np.sum(bench.residual(m, workshop.systems(m)) ** 2)) for m in trials]
        return trials[int(np.argmin(np.nan_to_num(left, nan=np.inf)))]

    for bench, found in zip(benches, workshop.each(best, benches), strict=True):
        begun = begun.with_run(bench.run.id, found.runs.get(bench.run.id, {}))
        if bench.run.id in found.heights:
            begun = begun.with_heights({bench.run.id: found.heights[bench.run.id]})
    progress("fitting what each run leaves free")
    fitted = fit(workshop, begun, (), benches)
    charged = {run.bench.run.id: run.freedom for run in fitted.runs}
    return workshop.responses(fitted.model), charged
