"""`plot`: the figure a result, a campaign's run or a recording is usually looked at with."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from wheelhop.api.results import ComparisonResult, DiagnosisResult
from wheelhop.api.settings import SettingsResult
from wheelhop.campaign import ComponentCampaign
from wheelhop.files.words import listed
from wheelhop.logger import Recording

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Kind = Literal["ladder", "where", "worst", "typical", "histograms", "loops"]


def plot(
    thing: ComparisonResult | DiagnosisResult | SettingsResult | Recording, kind: Kind = "ladder"
) -> Figure:
    """Draw a result, or the channels of a recording against time.

    Parameters
    ----------
    thing
        A result of `compare`, `add` or `diagnose`, or of `compare_settings`, of which the first
        channel is drawn, or a recording; `campaign.recording("slow")` is that of a run.
    kind
        Of a result: "ladder", the error of every model; "where", the residual by band, motion and
        what it is locked to; "worst" and "typical", measured and modelled signals at one place;
        "histograms", velocity and travel of every strut; "loops", its force over both, or those of
        a component on a rig.

    Returns
    -------
    Figure
        Of matplotlib; `figure.savefig("ladder.png")` keeps it.
    """
    from wheelhop.report import figures
    from wheelhop.report.cases import cases

    if isinstance(thing, Recording):
        return figures.recording_figure(thing)
    if isinstance(thing, SettingsResult):
        from wheelhop.report.settings import settings_figure

        return settings_figure(thing.comparison, thing.comparison.spectra[0].channel)
    steps = thing.steps
    if kind == "ladder":
        return figures.ladder_figure(steps)
    if kind == "where":
        after = steps[-1].comparison.breakdown if len(steps) > 1 else None
        return figures.where_figure(steps[0].comparison.breakdown, after)
    if kind in ("worst", "typical"):
        case = cases(thing.campaign.channels, steps)[("worst", "typical").index(kind)]
        return figures.case_figure(case, listed(steps[-1].added) if steps[-1].added else "")
    if kind in ("histograms", "loops"):
        return _of_struts(thing, kind)
    raise ValueError(f'kind "{kind}": choose ladder, where, worst, typical, histograms or loops')


def _of_struts(result: ComparisonResult | DiagnosisResult, kind: Kind) -> Figure:
    from wheelhop.report.loops import loops_figure
    from wheelhop.report.strut_figures import histograms_figure, strut_loops_figure
    from wheelhop.report.strut_motion import strut_histories

    campaign, steps = result.campaign, result.steps
    if isinstance(campaign, ComponentCampaign):
        if kind == "loops":
            return loops_figure(campaign, steps)
        raise ValueError('kind "histograms" is of vehicles: of a component choose loops')
    histories = strut_histories(campaign, steps)
    if kind == "histograms":
        return histograms_figure(histories)
    return strut_loops_figure(histories, result.model)
