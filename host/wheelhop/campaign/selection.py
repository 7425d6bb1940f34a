"""A part of a campaign: some of its runs, some of its channels."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from wheelhop.campaign.common import frozen
from wheelhop.campaign.types import Campaign, CampaignError, Run
from wheelhop.files import did_you_mean
from wheelhop.files.words import ending_of

if TYPE_CHECKING:
    from wheelhop.campaign.types import Role


def of_runs(
    campaign: Campaign, ids: Sequence[str], role: Role | None, track: str | None
) -> tuple[Run, ...]:
    """The runs of these ids (without any: all), of this role, on this kind of track, in the
    campaign's order; raises CampaignError where there are none."""
    wanted = {campaign[id_].id for id_ in ids} or {run.id for run in campaign}
    of_ids = [run for run in campaign if run.id in wanted]
    kept = [r for r in of_ids if role in (None, r.role) and track in (None, r.track.kind)]
    if of_ids and not kept:
        asked = {"role": role, "track": track}
        words = ", ".join(f'{key} "{value}"' for key, value in asked.items() if value)
        there = ", ".join(sorted({f"{run.role} on {run.track.kind}" for run in of_ids}))
        raise CampaignError(
            f"{campaign.folder / 'campaign.toml'}: there is no run of {words}; there are {there}"
        )
    return tuple(kept)


def of_channels(campaign: Campaign, names: Sequence[str]) -> dict[str, Any]:
    """What differs in the campaign had only these channels been recorded: the channels, the runs
    with those columns, and the noise of the leading quantity, which may be another one now. Raises
    CampaignError for a name that is not there, or none at all."""
    known = [channel.name for channel in campaign.channels]
    if isinstance(names, str) or not names:
        raise CampaignError('channels: give a list of names, such as ["B1", "B2"]')
    for name in names:
        if name not in known:
            raise no_such(campaign, "channel", name, known)
    columns = [i for i, name in enumerate(known) if name in names]
    channels = tuple(campaign.channels[i] for i in columns)
    runs = tuple(replace(run, record=frozen(run.record[:, columns])) for run in campaign)
    part = replace(campaign, channels=channels, runs=runs)
    noise = campaign.noise_rms
    if part.leading.quantity != campaign.leading.quantity:
        own = [c.noise_rms for c in channels if c.quantity == part.leading.quantity]
        stated = [rms for rms in own if rms is not None]
        noise = float(np.sqrt(np.mean(np.square(stated)))) if len(stated) == len(own) else None
    return {"channels": channels, "runs": runs, "noise_rms": noise}


def listed_runs(campaign: Campaign) -> list[dict[str, Any]]:
    """A row for each run: its description, and the rms of the leading quantity."""
    leading = [c.quantity == campaign.leading.quantity for c in campaign.channels]
    return [
        {
            "run": run.id,
            "role": run.role,
            "track": run.track.kind,
            "speed_m_s": run.speed_m_s,
            "duration_s": len(run.time_s) / campaign.sample_rate_hz,
            "samples": len(run.time_s),
            f"rms{ending_of(campaign.unit)}": float(
                np.sqrt(run.record[:, leading].var(axis=0).mean())
            ),
        }
        for run in campaign.runs
    ]


def run_of(campaign: Campaign, run_id: str) -> Run:
    """The run of this id; raises CampaignError where there is none."""
    known = {run.id: run for run in campaign.runs}
    if run_id not in known:
        raise no_such(campaign, "run", run_id, known)
    return known[run_id]


def no_such(campaign: Campaign, what: str, name: str, known: Collection[str]) -> CampaignError:
    """What is raised for a run or a channel that is not there."""
    near = did_you_mean(name, known) or f"; there are {', '.join(known)}"
    return CampaignError(f'{campaign.folder / "campaign.toml"}: there is no {what} "{name}"{near}')
