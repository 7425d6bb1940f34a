"""The verbs: from a campaign's folder to a result, each in one call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from threadpoolctl import threadpool_limits

from wheelhop.api.results import ComparisonResult, DiagnosisResult
from wheelhop.campaign import Campaign, read_campaign
from wheelhop.campaign import recorded as recordings
from wheelhop.diagnose import Baseline, Progress, Step, axle_driven, fit_baseline
from wheelhop.diagnose.search.ladder import diagnose_gated, fit_with, steps_with
from wheelhop.diagnose.search.look import steps_of
from wheelhop.effects import Effect, beliefs, load_effects, pick
from wheelhop.files import Source
from wheelhop.gate import gate
from wheelhop.law import last_rungs
from wheelhop.logger import Log, Recording
from wheelhop.logger import read_log as read_log_file
from wheelhop.vehicle import Vehicle, read_nominal
from wheelhop.vehicle import read_vehicle as read_vehicle_file

MODEL_FILE = "model.toml"

ONE_EACH = 1
"""Threads of linear algebra: every run is worked on by a thread of ours, more are in the way."""

BUDGET_S = 60.0
"""What a person waits for who would rather have most of the answer."""

Folder = Campaign | str | Path
Library = Mapping[str, Effect] | str | Path | Source | None


def _silent(text: str) -> None:
    """Nobody listens."""


def read(folder: str | Path) -> Campaign:
    """Read the campaign in a folder: campaign.toml and every recording it names.

    Raises
    ------
    CampaignError
        Something in it is wrong: one line that says in which file, where, and what to do.
    """
    return read_campaign(folder)


def read_vehicle(source: Folder) -> Vehicle:
    """The nominal vehicle of a campaign (or its folder), or a file like vehicle.toml, in SI.

    Raises
    ------
    CampaignError
        The file is missing or wrong.
    """
    if isinstance(source, Campaign) or Path(source).is_dir():
        return read_nominal(_campaign(source))
    return read_vehicle_file(Path(source))


def read_recording(
    file: str | Path, calibration: str | Path | None = None, *, nominal: bool = False
) -> Recording:
    """Read one recording, of the logger (.hop) or of any other instrument, in SI.

    Parameters
    ----------
    file
        .hop, .csv, .parquet, .mf4, .uff, .tdms, .lvm.
    calibration
        The sensors' constants; they turn the logger's codes into m/s².
    nominal
        Without constants, take the data sheet's, ±10 %.

    Raises
    ------
    InputError
        The file is missing or wrong.
    """
    constants = None if calibration is None else Path(calibration)
    return recordings.read_recording(Path(file), constants, nominal)


def read_log(file: str | Path) -> Log:
    """Read a log of the logger (.hop), whatever has happened to it: its gaps, damage and settings;
    `Log.recording` gives its samples, in codes.

    Raises
    ------
    LoggerError
        It holds no session.
    """
    return read_log_file(Path(file))


def compare(
    campaign: Folder,
    add: str | Sequence[str] = (),
    *,
    vehicle: Vehicle | None = None,
    effects: Library = None,
    by_axles: bool = False,
    jobs: int | None = None,
    progress: Progress = _silent,
) -> ComparisonResult:
    """Fit the model to the runs of role "fit" and compare it with all runs.

    Parameters
    ----------
    campaign
        The campaign, or its folder.
    add
        Effects that become part of the model, one after the other: "dry-friction", say.
    vehicle
        What is believed before the fit; that of the campaign by default.
    effects
        The library: effects by id, or a Python file with more; `load_effects()` by default.
    by_axles
        Whether to compare, too, the same model with the measured motion of the axles driving it.
    jobs
        Threads; one a processor by default.
    progress
        Called with a line of text at every stage.

    Raises
    ------
    CampaignError
        The campaign does not hold what a comparison needs, there is no such effect, or it does not
        apply to this campaign.
    """
    chosen = pick([add] if isinstance(add, str) else add, _library(effects))
    campaign = _campaign(campaign)
    vehicle = vehicle or read_nominal(campaign)
    with threadpool_limits(ONE_EACH):
        gated = gate(campaign, vehicle)
        base = fit_baseline(gated.campaign, vehicle, jobs=jobs, progress=progress)
        steps = tuple(steps_of(base.workshop, fit_with(base, chosen, progress)))
        axles = (
            _driven_by_axles(base, gated.campaign, vehicle, chosen, jobs, progress)
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
    effects: Library = None,
    max_effects: int = 4,
    to_the_end: bool = False,
    budget_s: float | None = BUDGET_S,
    law: bool = True,
    jobs: int | None = None,
    progress: Progress = _silent,
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

    Raises
    ------
    CampaignError
        The campaign does not hold what a comparison needs.
    """
    library = _library(effects)
    campaign = _campaign(campaign)
    vehicle = vehicle or read_nominal(campaign)
    with threadpool_limits(ONE_EACH):
        gated = gate(campaign, vehicle)
        gated, found, base = diagnose_gated(
            gated,
            vehicle,
            library,
            max_effects=max_effects,
            to_the_end=to_the_end,
            budget_s=budget_s,
            jobs=jobs,
            progress=progress,
        )
        effects_of = list(library.values())
        rungs = last_rungs(base, found, effects_of, progress, budget_s) if law else None
    # Its figures are of the channels and runs that were fitted: some may have been left out.
    return DiagnosisResult(
        gated.campaign, vehicle, found.ladder, found.findings, found, library, rungs
    )


def add(
    campaign: Folder,
    *names: str,
    vehicle: Vehicle | None = None,
    effects: Library = None,
    jobs: int | None = None,
    progress: Progress = _silent,
) -> ComparisonResult:
    """Make effects part of the model, refit it, and store it as model.toml in the campaign's
    folder.

    `names` are effects of the library, or what the campaign itself may say wrong ("belief: …");
    the rest is as for `compare`, which stores nothing.

    Raises
    ------
    CampaignError
        As for `compare`; then model.toml is as it was.
    """
    library = _library(effects)
    campaign = _campaign(campaign)
    vehicle = vehicle or read_nominal(campaign)
    gated = gate(campaign, vehicle)
    chosen = pick(names, {**library, **beliefs(gated.campaign, vehicle)})
    with threadpool_limits(ONE_EACH):
        base = fit_baseline(gated.campaign, vehicle, jobs=jobs, progress=progress)
        steps = tuple(steps_of(base.workshop, fit_with(base, chosen, progress)))
    result = ComparisonResult(gated.campaign, vehicle, steps, gated.findings, base.workshop)
    result.write_model(campaign.folder / MODEL_FILE)
    return result


def _campaign(given: Folder) -> Campaign:
    return given if isinstance(given, Campaign) else read_campaign(given)


def _library(given: Library) -> Mapping[str, Effect]:
    return given if isinstance(given, Mapping) else load_effects(given)


def _driven_by_axles(
    base: Baseline,
    campaign: Campaign,
    vehicle: Vehicle,
    effects: Sequence[Effect],
    jobs: int | None,
    progress: Progress,
) -> Step | None:
    """The same model with the measured axle motion driving the body, its fit begun at the baseline
    on the road; None where that is not possible, or is what was compared already."""
    driven = axle_driven(campaign, vehicle)
    if driven is None or all(run.track.kind == "unknown" for run in campaign.runs):
        return None
    acting = [effect for effect in effects if not effect.needs_road]
    values = base.rung.model.values

    def told(text: str) -> None:
        progress(f"measured axles: {text}")

    return steps_with(driven, vehicle, acting, told, values, jobs)[-1]
