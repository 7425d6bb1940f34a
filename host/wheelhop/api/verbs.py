"""The verbs: from a campaign's folder to a result, each in one call."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from threadpoolctl import threadpool_limits

from wheelhop.api.given import ONE_EACH, Folder, campaign_of
from wheelhop.api.results import ComparisonResult, DiagnosisResult
from wheelhop.campaign import Campaign
from wheelhop.diagnose import Baseline, Step, axle_driven, fit_baseline
from wheelhop.diagnose.search.ladder import diagnose_gated, fit_with, own_floor, steps_with
from wheelhop.diagnose.search.look import steps_of
from wheelhop.effects import Effect, Given, More, beliefs, load_effects, pick
from wheelhop.files import Progress, Watching
from wheelhop.files.progress import shown
from wheelhop.gate import gate
from wheelhop.law import BeyondNames
from wheelhop.predict.known_car import MODEL_FILE
from wheelhop.vehicle import Vehicle, read_nominal

BUDGET_S = 60.0
"""What a person waits for who would rather have most of the answer."""


def compare(
    campaign: Folder,
    add: str | Given | Iterable[str | Given] = (),
    *,
    vehicle: Vehicle | None = None,
    effects: More = None,
    by_axles: bool = False,
    jobs: int | None = None,
    progress: Watching = True,
) -> ComparisonResult:
    """Fit the model to the runs of role "fit" and compare it with all runs.

    Parameters
    ----------
    campaign
        The campaign, or its folder.
    add
        Effects that become part of the model, one after the other: ids such as "dry-friction", or
        effects of the user's own as objects.
    vehicle
        What is believed before the fit; that of the campaign by default.
    effects
        The library: effects by id, or a Python file or objects that are added to it;
        `load_effects()` by default.
    by_axles
        Whether to compare, too, the same model with the measured motion of the axles driving it.
    jobs
        Threads; one a processor by default.
    progress
        True: a line in a terminal or notebook says how far the work is; False: nothing does. Or a
        function that is called with a line of text at every stage.

    Returns
    -------
    ComparisonResult
        The fitted models from the baseline to the last effect added, in SI.

    Raises
    ------
    CampaignError
        The campaign does not hold what a comparison needs, there is no such effect, or it does not
        apply to this campaign.
    """
    chosen = pick(add, load_effects(effects))
    campaign = campaign_of(campaign)
    vehicle = vehicle or read_nominal(campaign)
    with threadpool_limits(ONE_EACH), shown(progress) as tell:
        gated = gate(campaign, vehicle)
        base = fit_baseline(gated.campaign, vehicle, jobs=jobs, progress=tell)
        steps = tuple(steps_of(base.workshop, fit_with(base, chosen, tell)))
        axles = (
            _driven_by_axles(base, gated.campaign, vehicle, chosen, jobs, tell)
            if by_axles
            else None
        )
    return ComparisonResult(
        gated.campaign, vehicle, steps, gated.findings, base.workshop, axles, gated.symptoms
    )


def diagnose(
    campaign: Folder,
    *,
    vehicle: Vehicle | None = None,
    effects: More = None,
    max_effects: int = 4,
    to_the_end: bool = False,
    budget_s: float | None = BUDGET_S,
    law: bool = True,
    jobs: int | None = None,
    progress: Watching = True,
) -> DiagnosisResult:
    """Find out which effects the model is missing.

    Ctrl-C ends the search, too, once the baseline is fitted: the verdict so far is returned.

    Parameters
    ----------
    campaign, vehicle, effects, jobs, progress
        As for `compare`.
    max_effects
        The longest ladder.
    to_the_end
        Whether it goes on where a further effect lowers the logarithm of the error by less than a
        tenth of what the first one did.
    budget_s
        Work after which the search ends with the verdict so far, in seconds of one processor as
        `wheelhop.fit.Work` counts them, so that no verdict depends on how busy the computer is;
        None: it ends when nothing is left to try. `unfinished` of the diagnosis says what more
        might still change.
    law
        Whether to go on, of a component on a rig, where the names end above the floor: to a formula
        and a free law of the force that is left, within the same budget.

    Returns
    -------
    DiagnosisResult
        Verdict, confidence, the reasons, and the models from the baseline to the last, in SI.

    Raises
    ------
    CampaignError
        The campaign does not hold what a comparison needs.
    """
    library = load_effects(effects)
    campaign = campaign_of(campaign)
    vehicle = vehicle or read_nominal(campaign)
    with threadpool_limits(ONE_EACH), shown(progress) as tell:
        gated = gate(campaign, vehicle)
        beyond = BeyondNames(list(library.values()), tell, budget_s)
        gated, found, _ = diagnose_gated(
            gated,
            vehicle,
            library,
            max_effects=max_effects,
            to_the_end=to_the_end,
            budget_s=budget_s,
            jobs=jobs,
            progress=tell,
            beyond=beyond if law else own_floor,
        )
        rungs = beyond.last_rungs(found)
    # Its figures are of the channels and runs that were fitted: some may have been left out.
    return DiagnosisResult(
        gated.campaign, vehicle, found.ladder, found.findings, found, library, rungs
    )


def add(
    campaign: Folder,
    *names: str | Given,
    vehicle: Vehicle | None = None,
    effects: More = None,
    jobs: int | None = None,
    progress: Watching = True,
) -> ComparisonResult:
    """Make effects part of the model, refit it, and store it as model.toml in the campaign's
    folder.

    Parameters
    ----------
    campaign, vehicle, effects, jobs, progress
        As for `compare`, which stores nothing.
    names
        Effects of the library, effects as objects, or what the campaign itself may say wrong
        ("belief: …").

    Returns
    -------
    ComparisonResult
        As of `compare`.

    Raises
    ------
    CampaignError
        As for `compare`; then model.toml is as it was.
    """
    library = load_effects(effects)
    campaign = campaign_of(campaign)
    vehicle = vehicle or read_nominal(campaign)
    gated = gate(campaign, vehicle)
    chosen = pick(names, {**library, **beliefs(gated.campaign, vehicle)})
    with threadpool_limits(ONE_EACH), shown(progress) as tell:
        base = fit_baseline(gated.campaign, vehicle, jobs=jobs, progress=tell)
        steps = tuple(steps_of(base.workshop, fit_with(base, chosen, tell)))
    result = ComparisonResult(gated.campaign, vehicle, steps, gated.findings, base.workshop)
    result.write_model(campaign.folder / MODEL_FILE)
    return result


def _driven_by_axles(
    base: Baseline,
    campaign: Campaign,
    vehicle: Vehicle,
    effects: Sequence[Effect],
    jobs: int | None,
    progress: Progress,
) -> Step | None:
    """The fitted model with the measured axle motion driving the body, its fit begun at the
    baseline on the road; None where that is not possible, or is what was compared already."""
    driven = axle_driven(campaign, vehicle)
    if driven is None or all(run.track.kind == "unknown" for run in campaign.runs):
        return None
    acting = [effect for effect in effects if not effect.needs_road]
    values = base.rung.model.values

    def told(text: str) -> None:
        progress(f"measured axles: {text}")

    return steps_with(driven, vehicle, acting, told, values, jobs)[-1]
