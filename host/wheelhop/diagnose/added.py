"""Effects the user names: added one after the other, whatever the judgement on them would be."""

from __future__ import annotations

from collections.abc import Sequence

from wheelhop.campaign import Campaign, CampaignError
from wheelhop.diagnose.baseline import Baseline, Progress, fit_baseline
from wheelhop.diagnose.confirm import confirm, refit
from wheelhop.diagnose.diagnosis import Step
from wheelhop.diagnose.look import step_of
from wheelhop.diagnose.ranking import why_not
from wheelhop.diagnose.rung import Rung
from wheelhop.diagnose.screen import screen
from wheelhop.effects import Effect
from wheelhop.fit import Workshop
from wheelhop.vehicle import Vehicle


def fit_with(base: Baseline, effects: Sequence[Effect], progress: Progress) -> list[Rung]:
    """The ladder from the fitted baseline through `effects`, in the order given.

    Raises
    ------
    CampaignError
        An effect does not apply to this campaign.
    """
    rungs = [base.rung]
    for effect in effects:
        rungs.append(one_more(base.workshop, rungs[-1], effect, progress))
    return rungs


def one_more(workshop: Workshop, rung: Rung, effect: Effect, progress: Progress) -> Rung:
    """The model of `rung` with one more effect, started from what screening suggests and refitted
    in full.

    Raises
    ------
    CampaignError
        The effect does not apply to this campaign.
    """
    progress(f"screening {effect.id}")
    screened = screen(workshop, rung.fit, [effect])
    if not screened:
        where = workshop.campaign.folder / "campaign.toml"
        reason = why_not(effect, workshop.drives)
        raise CampaignError(f"{where}: {effect.id} cannot be added: {reason}; leave it out")
    progress(f"simulating {effect.id}")
    rough = confirm(workshop, rung, screened[0])
    progress(f"fitting the vehicle with {effect.id}")
    return refit(workshop, rough)


def steps_with(
    campaign: Campaign, vehicle: Vehicle, effects: Sequence[Effect], progress: Progress
) -> list[Step]:
    """The same from the campaign on, each rung compared with the records.

    Raises
    ------
    CampaignError
        The campaign does not hold what a comparison needs, or an effect does not apply to it.
    """
    base = fit_baseline(campaign, vehicle, progress=progress)
    return [step_of(base.workshop, rung) for rung in fit_with(base, effects, progress)]
