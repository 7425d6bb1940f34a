"""`plot`: the figure a result, a campaign's run or a recording is usually looked at with."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, get_args

from wheelhop.api.results import ComparisonResult, DiagnosisResult
from wheelhop.api.settings import SettingsResult
from wheelhop.files import InputError, did_you_mean
from wheelhop.files.words import listed
from wheelhop.logger import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from wheelhop.report.svg import Drawing

Kind = Literal[
    "ladder",
    "where",
    "worst",
    "typical",
    "case",
    "signal",
    "residual",
    "psd",
    "axles",
    "histograms",
    "loops",
]
OF_A_RUN = ("case", "signal", "residual", "psd")
"""Kinds that show one channel of one run."""


def plot(
    thing: ComparisonResult | DiagnosisResult | SettingsResult | Recording,
    kind: Kind | None = None,
    *,
    run: str | None = None,
    channel: str | None = None,
    ax: Axes | None = None,
) -> Figure:
    """Draw a result, or the channels of a recording against time.

    Parameters
    ----------
    thing
        A result of `compare`, `add` or `diagnose`, or of `compare_settings`, of which one channel,
        by default the first, is drawn, or a recording; `campaign.recording("slow")` is that of a
        run.
    kind
        Of a result: "ladder", the error of every model; "where", the residual by band, motion and
        what it is locked to; "signal", "residual" and "psd", measured and modelled signal of one
        channel in one run, their difference and their power spectral densities, and "case", all
        three; "worst" and "typical", the case at such a place; "axles", of a diagnosis, identified
        and modelled transfer functions from axles to body; "histograms", velocity and travel of
        every strut; "loops", force over displacement and velocity, of every strut or of a component
        on a rig. By default "ladder", or "case" where a run or a channel is
        named.
    run, channel
        Which run, by its id, and which channel, by its name; of what is not named that where the
        baseline fails worst.
    ax
        Axes to draw into, of kinds with one panel: "ladder", "signal" (the default with `ax`),
        "residual", "psd", and a recording of which a `channel` is named.

    Returns
    -------
    Figure
        Of matplotlib; `figure.savefig("ladder.png")` keeps it.

    Raises
    ------
    InputError
        There is no such run or channel, or the result has no such figure.
    ValueError
        There is no such kind, or it has several panels and cannot be drawn into `ax`.
    """
    if isinstance(thing, Recording):
        return _recording(thing, channel, ax)
    if isinstance(thing, SettingsResult):
        return _settings(thing, channel)
    if kind is None:
        named = run is not None or channel is not None
        kind = ("signal" if ax is not None else "case") if named else "ladder"
    if kind not in get_args(Kind):
        raise ValueError(f'kind "{kind}": choose {", ".join(get_args(Kind))}')
    if ax is None:
        return _figure(thing, kind, run, channel)
    from wheelhop.report import figures
    from wheelhop.report.cases import case_of

    if kind == "ladder":
        figures.draw_ladder(ax, thing.steps)
    elif kind in figures.ONE_PANEL:
        case = case_of(thing.campaign.channels, thing.steps, run, channel)
        figures.draw_panel(ax, case, kind, _added(thing))
    else:
        raise ValueError(f'kind "{kind}" has several panels: leave ax out')
    return _root(ax)


def _figure(
    result: ComparisonResult | DiagnosisResult, kind: Kind, run: str | None, channel: str | None
) -> Drawing:
    """A figure of its own."""
    from wheelhop.report import figures
    from wheelhop.report.cases import case_of, cases
    from wheelhop.report.svg import literal

    steps, channels = result.steps, result.campaign.channels
    if kind == "ladder":
        return figures.ladder_figure(steps)
    if kind == "where":
        after = steps[-1].comparison.breakdown if len(steps) > 1 else None
        return figures.where_figure(steps[0].comparison.breakdown, after)
    if kind in ("histograms", "loops"):
        return _of_struts(result, kind)
    if kind == "axles":
        return _axles(result)
    if kind in OF_A_RUN:
        case = case_of(channels, steps, run, channel)
        if kind != "case":
            return figures.panel_figure(case, kind, _added(result))
    else:
        case = cases(channels, steps)[("worst", "typical").index(kind)]
    drawing = figures.case_figure(case, _added(result))
    drawing.suptitle(literal(f"{case.channel} in {case.run_id}"), x=0.99, ha="right", fontsize=9.0)
    return drawing


def _added(result: ComparisonResult | DiagnosisResult) -> str:
    """The effects of the last model in words; nothing where it is the baseline."""
    added = result.steps[-1].added
    return listed(added) if added else ""


def _recording(recording: Recording, channel: str | None, ax: Axes | None) -> Figure:
    from wheelhop.report import figures

    if channel is None:
        if ax is not None:
            raise ValueError("a recording has a panel for every channel: name one, or leave ax out")
        return figures.recording_figure(recording)
    names = [each.name for each in recording.channels]
    if channel not in names:
        near = did_you_mean(channel, names) or f"; it has {', '.join(names)}"
        raise InputError(f'the recording has no channel "{channel}"{near}')
    column = names.index(channel)
    if ax is None:
        return figures.recording_figure(recording, [column])
    figures.draw_recorded(ax, recording, column)
    ax.set_xlabel("time, s")
    return _root(ax)


def _root(ax: Axes) -> Figure:
    figure = ax.get_figure(root=True)
    if figure is None:
        raise ValueError("ax belongs to no figure any more: make new axes")
    return figure


def _settings(result: SettingsResult, channel: str | None) -> Drawing:
    from wheelhop.report.settings import settings_figure

    names = list(dict.fromkeys(s.channel for s in result.comparison.spectra))
    if channel is not None and channel not in names:
        near = did_you_mean(channel, names) or f"; it has {', '.join(names)}"
        raise InputError(f'the comparison has no channel "{channel}"{near}')
    return settings_figure(result.comparison, channel or names[0])


def _of_struts(result: ComparisonResult | DiagnosisResult, kind: Kind) -> Drawing:
    from wheelhop.campaign import ComponentCampaign
    from wheelhop.report.loops import loops_figure
    from wheelhop.report.strut_figures import histograms_figure, strut_loops_figure
    from wheelhop.report.strut_motion import strut_histories

    campaign, steps = result.campaign, result.steps
    if isinstance(campaign, ComponentCampaign):
        if kind == "loops":
            return loops_figure(campaign, steps)
        raise InputError("histograms are of a vehicle's struts: of a component on a rig see loops")
    histories = strut_histories(campaign, steps)
    if kind == "histograms":
        return histograms_figure(histories)
    return strut_loops_figure(histories, result.model)


def _axles(result: ComparisonResult | DiagnosisResult) -> Drawing:
    from wheelhop.report.axle_to_body import linear_models, matrix_figure

    found = result.diagnosis.axle_to_body if isinstance(result, DiagnosisResult) else None
    if found is None or found.model is None:
        raise InputError(
            "from axles to body nothing was identified: it is where a diagnosis leaves something,"
            " and all axles and four points of the body were recorded"
        )
    return matrix_figure(found.model, result.campaign, linear_models(result.steps))
