"""A plan for others to read: as JSON, and as the beginning of a campaign."""

from __future__ import annotations

import shlex
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from wheelhop.campaign import CampaignError
from wheelhop.campaign.write import new_campaign
from wheelhop.files import new_folder, read_text, write_text
from wheelhop.logger.recording import ACCELERATION, Channel, Recording
from wheelhop.predict.case import AVERAGING_S, SAMPLE_RATE_HZ
from wheelhop.predict.drives import CHANNELS, Drive
from wheelhop.predict.make import copy_survey
from wheelhop.predict.plan import Plan


def track_words(drive: Drive) -> list[str]:
    """A track as `wheelhop campaign add --track` takes it."""
    others = [f"{key}={_plain(value)}" for key, value in drive.keys.items() if key != "kind"]
    return [str(drive.keys["kind"]), *others]


def to_json(plan: Plan) -> dict[str, Any]:
    """The plan with everything it rests on; a strength that no run shows is null."""
    rank = {place: n for n, place in enumerate(plan.chosen, start=1)}
    return {
        "format": 1,
        "runs": [
            {
                "run": drive.id,
                "track": dict(drive.keys),
                "speed_kmph": drive.speed_kmph,
                "role": role,
                "together_numbers_nats": after.numbers,
                "together_effects_nats": after.effects,
            }
            for drive, role, after in zip(plan.drives, plan.roles, plan.after, strict=True)
        ],
        "candidates": [
            {
                "run": drive.id,
                "speed_kmph": drive.speed_kmph,
                "rank": rank.get(i),
                "alone_numbers_nats": alone.numbers,
                "alone_effects_nats": alone.effects,
            }
            for i, (drive, alone) in enumerate(zip(plan.foreseen.drives, plan.alone, strict=True))
        ],
        "numbers": {
            name: {"believed": believed, "after": after}
            for name, (believed, after) in plan.uncertainty.items()
        },
        "effects": [
            {
                "effect": told.effect,
                "form": told.form,
                "scale": told.amplitudes,
                "shown_from": _finite(told.shown_from),
                "told_from": _finite(told.told_from),
                "rival": told.rival,
                "angle_deg": told.angle_deg,
            }
            for told in plan.told
        ],
    }


def write_skeleton(folder: Path, plan: Plan, vehicle_file: Path, noise_rms: float) -> None:
    """Write a new folder: vehicle.toml, the surveys of tracks, and a campaign.toml without runs
    that lists those to drive, each with the command that adds its recording.

    Raises CampaignError, and then there is no folder.
    """
    nothing = Recording(
        np.zeros((2, len(CHANNELS))),
        SAMPLE_RATE_HZ,
        tuple(Channel(c.name, ACCELERATION, c.point) for c in CHANNELS),
        averaging_s=AVERAGING_S,
    )
    lines = ["", "# Runs to drive, the most telling first. Each command adds one; run it here."]
    with new_folder(folder, CampaignError) as draft:
        title = f"{plan.vehicle_name}, planned"
        new_campaign(draft, title, nothing, {}, vehicle_file, None, noise_rms)
        for number, (drive, role) in enumerate(zip(plan.drives, plan.roles, strict=True), start=1):
            copy_survey(drive, draft)
            words = ["wheelhop", "campaign", "add", ".", "RECORDING", "--id", drive.id]
            words += ["--role", role, "--speed-kmph", f"{drive.speed_kmph:g}"]
            words += ["--track", *track_words(drive)]
            lines += [f"# {number}. {shlex.join(words)}"]
        file = draft / "campaign.toml"
        write_text(file, read_text(file, CampaignError) + "\n".join(lines) + "\n", CampaignError)


def _plain(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None
