"""`simulate`: a campaign as if measured, without a vehicle."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from wheelhop.api.planning import check_seconds
from wheelhop.campaign import Campaign, CampaignError
from wheelhop.effects import Effect, Given, More, load_effects, pick
from wheelhop.vehicle import Vehicle, read_vehicle


def simulate(
    vehicle: Vehicle | str | Path,
    tracks: str | Sequence[str],
    speeds_kmph: float | Sequence[float] = (),
    add: str | Given | Iterable[str | Given] = (),
    *,
    effects: More = None,
    noise_rms: float | None = None,
    seconds: float | None = None,
    seed: int = 0,
) -> Campaign:
    """Drive a vehicle over tracks, every track at every speed, and record it as if measured.

    `campaign.recording(run)` has the samples of a drive; every third one is held out. The campaign
    is in memory alone: `new_campaign` and `add_run` write it, `wheelhop simulate --out` does both.

    Parameters
    ----------
    vehicle
        Its numbers, or its vehicle.toml; where they are given as numbers, `compare` and `diagnose`
        want them, too: `compare(campaign, vehicle=vehicle)`.
    tracks
        In words as `wheelhop simulate` takes them: "washboard/low", "table-5.1",
        "iso8608:unevenness_m3=4e-6:waviness=2:seed=1".
    speeds_kmph
        By default those the thesis drove a named track at.
    add
        Effects the vehicle has, and their numbers where they are stated, in the same words:
        "dry-friction:front_N=60"; or effects as objects. Other numbers are such that the effect
        shows clearly.
    effects
        The library, as for `compare`.
    noise_rms
        White noise of a channel in band, m/s²; 0.1 by default.
    seconds
        Length of a run; 10.24 by default.
    seed
        Draws noise, starts, and what effects leave free in every run; the same seed, the same
        campaign.

    Returns
    -------
    Campaign
        Eight channels of acceleration, m/s², at 100 Hz, a run for every drive.

    Raises
    ------
    CampaignError
        A track, a speed or an effect that is not known, or a vehicle that runs away.
    """
    from wheelhop.predict.case import SECONDS, Case
    from wheelhop.predict.drives import read_drives, read_effects
    from wheelhop.predict.instrument import NOISE_RMS_M_S2, measured

    noise_rms = NOISE_RMS_M_S2 if noise_rms is None else noise_rms
    if not 0.0 <= noise_rms < 100.0:
        raise CampaignError(f"noise {noise_rms:g}: must be from 0 to 100 m/s²")
    seconds = check_seconds(SECONDS if seconds is None else seconds)
    speeds = [speeds_kmph] if isinstance(speeds_kmph, int | float) else speeds_kmph
    given = [add] if isinstance(add, str | Effect | type) else list(add)
    objects = pick([one for one in given if not isinstance(one, str)], {})
    library = {**load_effects(effects), **{effect.id: effect for effect in objects}}
    words = [text for text in given if isinstance(text, str)]
    chosen = read_effects([*words, *(effect.id for effect in objects)], library)
    drives = read_drives([tracks] if isinstance(tracks, str) else tracks, speeds)
    known = vehicle if isinstance(vehicle, Vehicle) else read_vehicle(Path(vehicle))
    made = measured(Case(known, chosen, drives, seconds, seed), noise_rms)
    return made if isinstance(vehicle, Vehicle) else replace(made, vehicle_file=Path(vehicle))
