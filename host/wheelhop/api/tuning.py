"""`tune`: the settings of a known car that are best on the roads it drives."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from wheelhop.api.planning import check_seconds
from wheelhop.campaign import CampaignError, Run, read_campaign
from wheelhop.effects import More, load_effects
from wheelhop.files import Watching
from wheelhop.files.progress import shown

if TYPE_CHECKING:
    from wheelhop.predict.drives import Drive
    from wheelhop.tune.tuning import Tuning

OBJECTIVES = ("comfort", "road-holding", "travel")
FEWEST_SETTINGS, MOST_SETTINGS = 40, 100_000


def tune(
    car: str | Path,
    vary: str | Sequence[str],
    tracks: str | Sequence[str] = (),
    speeds_kmph: float | Sequence[float] = (),
    objectives: Sequence[str] = OBJECTIVES,
    *,
    effects: More = None,
    settings: int | None = None,
    seconds: float | None = None,
    seed: int = 0,
    progress: Watching = True,
) -> Tuning:
    """Search the settings of a car that is known, on the roads it drives.

    Parameters
    ----------
    car
        The folder of a campaign in which `add` has stored model.toml, a model.toml, or a
        vehicle.toml.
    vary
        What may be set and how far: "front.damping=±50%", "rear.springs=springs.csv",
        "front.damper=valves.csv:now=8", "dry-friction.front_N=20:80".
    tracks
        In words as `wheelhop simulate` takes them; by default those of the campaign's runs.
    speeds_kmph
        By default those the thesis drove a named track at.
    objectives
        What shall be small: "comfort", "road-holding", "travel", "roll".
    effects
        The library, as for `compare`.
    settings
        How many the search rides; 800 by default.
    seconds
        Length of a run; 10.24 by default.
    seed
        Draws where runs start, and the cars that the real one may be.
    progress
        As for `compare`.

    Returns
    -------
    Tuning
        The present setting, the front of those tried, and what each gains, in SI.

    Raises
    ------
    CampaignError
        The car, a track, an objective or what is to be varied is not known, or the car runs away.
    """
    from wheelhop.predict.case import SECONDS
    from wheelhop.predict.drives import read_drives
    from wheelhop.predict.known_car import read_car
    from wheelhop.tune.objectives import read_objectives
    from wheelhop.tune.tuning import SETTINGS, tune_car
    from wheelhop.tune.variables import read_freedom

    settings = SETTINGS if settings is None else settings
    if not FEWEST_SETTINGS <= settings <= MOST_SETTINGS:
        raise CampaignError(
            f"{settings} settings: must be from {FEWEST_SETTINGS} to {MOST_SETTINGS}"
        )
    seconds = check_seconds(SECONDS if seconds is None else seconds)
    known = read_car(Path(car), load_effects(effects))
    freedom = read_freedom([vary] if isinstance(vary, str) else vary, known)
    words = [tracks] if isinstance(tracks, str) else tracks
    speeds = [speeds_kmph] if isinstance(speeds_kmph, int | float) else speeds_kmph
    drives = read_drives(words, speeds) if words else driven(Path(car))
    judged_by = read_objectives(objectives)
    with shown(progress) as tell:
        return tune_car(
            known,
            drives,
            judged_by,
            freedom,
            seconds=seconds,
            settings=settings,
            seed=seed,
            progress=tell,
        )


def driven(folder: Path) -> tuple[Drive, ...]:
    """The runs of a campaign on known ground."""
    from wheelhop.predict.drives import Drive

    if not folder.is_dir():
        raise CampaignError(f"{folder}: is no campaign: say with --tracks what it drives on")
    runs = [
        run
        for run in read_campaign(folder).runs
        if isinstance(run, Run) and run.track.kind != "unknown"
    ]
    if not runs:
        raise CampaignError(f"{folder}: no run is on known ground: give --tracks")
    return tuple(
        Drive(run.id, run.role, 3.6 * run.speed_m_s, {}, run.track, None, run.course)
        for run in runs
    )
