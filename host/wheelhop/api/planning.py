"""`plan`: which runs to drive, before anyone has driven; `detectable`: what runs can show."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

from wheelhop.api.given import Folder, campaign_of
from wheelhop.campaign import CampaignError
from wheelhop.effects import Given, More, load_effects, pick
from wheelhop.files import Watching
from wheelhop.files.progress import shown
from wheelhop.vehicle import Vehicle, read_nominal, read_vehicle

if TYPE_CHECKING:
    from wheelhop.predict.detectable import Detectable
    from wheelhop.predict.plan import Plan

RUNS = 8
SHORTEST_S, LONGEST_S = 2.0, 600.0


def plan(
    vehicle: Vehicle | str | Path,
    tracks: Sequence[str],
    speeds_kmph: Sequence[float] = (),
    *,
    runs: int = RUNS,
    only: str | Given | Iterable[str | Given] = (),
    effects: More = None,
    noise_rms: float | None = None,
    seconds: float | None = None,
    jobs: int | None = None,
    progress: Watching = True,
) -> Plan:
    """Choose the runs that would tell most of a vehicle's numbers and of the effects it may have.

    Parameters
    ----------
    vehicle
        As it is believed to be, or its vehicle.toml.
    tracks
        Those there are, in words as `wheelhop simulate` takes them: "washboard/low", "table-5.1".
    speeds_kmph
        At which each of them could be driven; by default those the thesis drove a named track at.
    runs
        How many to choose.
    only
        The effects to tell apart, by id or as objects; by default all but faults of sensors.
    effects
        The library, as for `compare`.
    noise_rms
        Of a channel in band, m/s²; 0.1 by default.
    seconds
        Length of a run; 10.24 by default.
    jobs
        Threads; one a processor by default.
    progress
        As for `compare`.

    Returns
    -------
    Plan
        The runs to drive, the most telling first, and what they would tell.

    Raises
    ------
    CampaignError
        A track, a speed or an effect that is not known, more runs than could be driven, or a
        vehicle that runs away.
    """
    from wheelhop.predict.case import SECONDS, Case
    from wheelhop.predict.drives import read_drives
    from wheelhop.predict.foresee import foresee
    from wheelhop.predict.instrument import NOISE_RMS_M_S2
    from wheelhop.predict.plan import check_runs, choose

    noise_rms = NOISE_RMS_M_S2 if noise_rms is None else noise_rms
    seconds = SECONDS if seconds is None else seconds
    if not 0.0 < noise_rms < 100.0:
        raise CampaignError(f"noise {noise_rms:g}: must be above 0, below 100 m/s²")
    check_seconds(seconds)
    library = load_effects(effects)
    tried = pick(only, library) if only else [e for e in library.values() if e.place != "sensor"]
    drives = read_drives(tracks, speeds_kmph)
    check_runs(runs, len(drives))
    if not isinstance(vehicle, Vehicle):
        vehicle = read_vehicle(Path(vehicle))
    case = Case(vehicle, (), drives, seconds)
    with shown(progress) as tell:
        return choose(foresee(case, tried, noise_rms, tell, jobs), runs)


def detectable(
    campaign: Folder,
    *,
    vehicle: Vehicle | None = None,
    effects: More = None,
    jobs: int | None = None,
    progress: Watching = True,
) -> Detectable:
    """Tell before any diagnosis what a campaign's channels and roads can show: of each effect the
    least strength, and the channel that would add most.

    Parameters
    ----------
    campaign
        The campaign of a vehicle, or its folder.
    vehicle
        What is believed of the vehicle; that of the campaign by default.
    effects
        The library, as for `compare`.
    jobs
        Threads; one a processor by default.
    progress
        As for `compare`.

    Returns
    -------
    Detectable
        If nothing can be compared, `refused` says why, and what would cure it.

    Raises
    ------
    CampaignError
        The campaign's files are wrong.
    """
    from wheelhop.predict.detectable import detectable as found_in

    campaign = campaign_of(campaign)
    vehicle = vehicle or read_nominal(campaign)
    library = load_effects(effects)
    with shown(progress) as tell:
        return found_in(campaign, vehicle, library.values(), jobs, tell)


def check_seconds(seconds: float) -> float:
    """The length of a run, s; raises CampaignError where none is so short or long."""
    if not (isfinite(seconds) and SHORTEST_S <= seconds <= LONGEST_S):
        raise CampaignError(f"{seconds:g} s a run: must be from {SHORTEST_S:g} to {LONGEST_S:g}")
    return seconds
