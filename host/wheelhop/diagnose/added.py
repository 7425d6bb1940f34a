"""Effects the user names: added one after the other, whatever the judgement on them would be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from wheelhop.campaign import Campaign, CampaignError
from wheelhop.diagnose.baseline import Baseline, Progress
from wheelhop.diagnose.confirm import Rung, confirm, refit
from wheelhop.diagnose.screen import screen
from wheelhop.effects import Effect


def fit_with(base: Baseline, effects: Sequence[Effect], progress: Progress) -> list[Rung]:
    """The ladder from the fitted baseline through `effects`, in the order given.

    Every rung starts from what screening of its effect suggests and is refitted in full.

    Raises
    ------
    CampaignError
        An effect does not apply to this campaign.
    """
    workshop, rungs = base.workshop, [base.rung]
    for effect in effects:
        last = rungs[-1]
        reason = why_not(effect, workshop.campaign, last.model.values)
        if reason:
            where = workshop.campaign.folder / "campaign.toml"
            raise CampaignError(f"{where}: {effect.id} cannot be added: {reason}")
        progress(f"screening {effect.id}")
        screened = screen(workshop, last.fit, [effect])[0]
        progress(f"simulating {effect.id}")
        rough = confirm(workshop, last, screened)
        progress(f"fitting the vehicle with {effect.id}")
        rungs.append(refit(workshop, rough))
    return rungs


def why_not(effect: Effect, campaign: Campaign, vehicle: Mapping[str, float]) -> str:
    """Why an effect does not apply to a campaign, in one line; empty if it does."""
    if effect.needs_road and all(run.track.kind == "unknown" for run in campaign.runs):
        return "it acts upstream of the axle, and every run's track is unknown"
    channels = campaign.channels
    choices = effect.choices(channels)
    if not choices:
        return "none of its forms fits these channels"
    form = effect.with_choice(choices[0]) if choices[0] else effect
    if form.parameters_for(vehicle, channels) or effect.needs_road:
        return ""
    missing = [name for name in ("driver", "engine") if name in effect.id]
    if missing and f"{missing[0]}.mass_kg" not in vehicle:
        return f"vehicle.toml has no [{missing[0]}]"
    return "vehicle and channels leave it nothing to act on"
