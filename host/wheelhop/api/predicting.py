"""`predict`: what a fitted model says of other runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from threadpoolctl import threadpool_limits

from wheelhop.api.given import ONE_EACH, Folder, campaign_of
from wheelhop.compare import Comparison, compare
from wheelhop.files import Watching
from wheelhop.files.progress import shown
from wheelhop.predict.other_runs import foresee
from wheelhop.simulate import Model

if TYPE_CHECKING:
    from wheelhop.api.results import ComparisonResult, DiagnosisResult


def predict(
    model: Model | ComparisonResult | DiagnosisResult,
    campaign: Folder,
    *,
    jobs: int | None = None,
    progress: Watching = True,
) -> Comparison:
    """Let a fitted model foresee the runs of a campaign, and compare it with their records.

    The model's numbers stay as they are. What every run leaves free, its mean speed, its start and
    what effects leave free in it, is fitted to that run alone, and charged for in the error.

    Parameters
    ----------
    model
        What `read_model` has read, or a result, whose last model is taken.
    campaign
        The runs to foresee, with any roles: another day's campaign, or one of `simulate`. Its
        vehicle is not asked for.
    jobs, progress
        As for `compare`.

    Returns
    -------
    Comparison
        `comparison["run"].model` is what the model foresees of a run.

    Raises
    ------
    CampaignError
        The campaign is wrong, or has channels that the model has no place for.
    """
    chosen = model if isinstance(model, Model) else model.model
    with threadpool_limits(ONE_EACH), shown(progress) as tell:
        read = campaign_of(campaign)
        responses, charged = foresee(read, chosen, jobs=jobs, progress=tell)
        return compare(read, responses, charged)
