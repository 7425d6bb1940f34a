"""model.toml: a fitted model, for people and programs to read (docs/model-file.md)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from wheelhop.campaign import Campaign, ComponentCampaign
from wheelhop.diagnose import Step
from wheelhop.effects import Effect, form_of
from wheelhop.files import Document, to_toml, write_text
from wheelhop.vehicle import Vehicle

FORMAT = 1
DIGITS = 9
"""Of a correlation: records tell the ratio of a force to a mass to some 1e-5 of what is believed of
their common scale, and one less its correlation is half the square of that."""


def write_model(path: Path, campaign: Campaign, vehicle: Vehicle, steps: Sequence[Step]) -> None:
    """Write the last model of a ladder; a file that is there is replaced whole or not at all."""
    write_text(path, to_toml(_document(campaign, vehicle, steps)))


def _document(campaign: Campaign, vehicle: Vehicle, steps: Sequence[Step]) -> Document:
    last = steps[-1]
    floor = last.comparison.floor
    on_rig = isinstance(campaign, ComponentCampaign)
    tables = _tables(vehicle, last)
    return {
        "format": FORMAT,
        "campaign": campaign.title,
        **({} if on_rig else {"vehicle_name": vehicle.name}),
        "written_by": f"wheelhop {version('wheelhop')}",
        "floor": {
            "error_fit": floor.error_fit,
            "error_validate": floor.error_validate,
            "source": floor.source,
        },
        "ladder": [
            {
                "added": list(step.added),
                "error_fit": step.rung.error_fit,
                "error_validate": step.rung.error_validate,
            }
            for step in steps
        ],
        "effect": [_effect(effect, last, campaign) for effect in last.rung.model.effects],
        **(tables if on_rig else {"vehicle": tables}),
        "correlation": _correlation(last),
        "channel": _channels(campaign, last),
        "run": [{"id": run.id} | _run(last, run.id) for run in campaign.runs],
    }


def _effect(effect: Effect, step: Step, campaign: Campaign) -> Document:
    form = form_of(effect, campaign.channels)
    prefix = f"{effect.id}."
    own = {
        name.removeprefix(prefix): value
        for name, value in step.parameters.items()
        if name.startswith(prefix)
    }
    about: dict[str, Any] = {"id": effect.id}
    if form:
        about["form"] = form
    return about | {"parameters": _with_sd(own)}


def _with_sd(values: Mapping[str, tuple[float, float]]) -> dict[str, float]:
    """Every value and, beside it, its standard deviation if it has one."""
    found: dict[str, float] = {}
    for name, (value, deviation) in values.items():
        found[name] = value
        if isfinite(deviation) and deviation > 0:
            found[f"{name}_uncertainty"] = deviation
    return found


def _tables(vehicle: Vehicle, step: Step) -> Document:
    """The tables of vehicle.toml, or [component] and what the rig showed, [rig]; what was not
    fitted keeps its nominal value and uncertainty."""
    tables: dict[str, Any] = {}
    for key, nominal in vehicle.values.items():
        *groups, name = key.split(".")
        table = tables
        for group in groups:
            table = table.setdefault(group, {})
        known = (nominal, vehicle.uncertainty[key])
        table |= _with_sd({name: step.parameters.get(key, known)})
    return tables


def _correlation(step: Step) -> dict[str, list[float]]:
    """Of each fitted number with those fitted before it and with itself, 1."""
    fit = step.rung.fit
    spread = np.sqrt(np.diag(fit.covariance))
    matrix = np.round(fit.covariance / np.outer(spread, spread), DIGITS)
    return {free.name: matrix[i, : i + 1].tolist() for i, free in enumerate(fit.shared)}


def _channels(campaign: Campaign, step: Step) -> Document:
    """Places that were estimated, by channel."""
    found = {}
    for channel in campaign.channels:
        prefix = f"{channel.key}."
        own = {
            name.removeprefix(prefix): value
            for name, value in step.parameters.items()
            if name.startswith(prefix)
        }
        if own:
            found[channel.name] = _with_sd(own)
    return found


def _run(step: Step, run_id: str) -> dict[str, Any]:
    """What the run left free; what an effect left free in a table of its own."""
    found: dict[str, Any] = {}
    for name, value in step.rung.model.runs.get(run_id, {}).items():
        effect, _, own = name.rpartition(".")
        if effect:
            found.setdefault(effect, {})[own] = value
        else:
            found[own] = value
    return found
