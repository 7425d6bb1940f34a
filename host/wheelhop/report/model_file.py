"""model.toml: a fitted model, for people and programs to read (docs/model-file.md)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from wheelhop.campaign import Campaign, CampaignError, ComponentCampaign
from wheelhop.diagnose import Step
from wheelhop.effects import Effect, form_of, pick
from wheelhop.files import Document, Table, dotted, read_toml, to_toml, write_text
from wheelhop.simulate import Model
from wheelhop.vehicle import Vehicle

FORMAT = 1
DIGITS = 9
"""Of a correlation: records tell the ratio of a force to a mass to some 1e-5 of what is believed of
their common scale, and one less its correlation is half the square of that."""
TOP_KEYS = (
    *("format", "campaign", "vehicle_name", "written_by", "floor", "ladder", "effect"),
    *("vehicle", "component", "rig", "mount", "channel", "correlation", "run"),
)
UNCERTAINTY = "_uncertainty"
"""How the name of a standard deviation ends, behind that of its number."""


def write_model(path: Path, campaign: Campaign, vehicle: Vehicle, steps: Sequence[Step]) -> None:
    """Write the last model of a ladder; a file that is there is replaced whole or not at all."""
    write_text(path, model_text(campaign, vehicle, steps))


def model_text(campaign: Campaign, vehicle: Vehicle, steps: Sequence[Step]) -> str:
    """The text of model.toml."""
    return to_toml(_document(campaign, vehicle, steps))


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
            found[f"{name}{UNCERTAINTY}"] = deviation
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


def read_model(path: Path, library: Mapping[str, Effect]) -> Model:
    """Read a file that `write_model` has written: numbers, effects in their forms, and what every
    run left free.

    Raises
    ------
    CampaignError
        The file is missing or wrong, or names an effect or a form that the library does not have.
    """
    top = read_toml(path, CampaignError)
    top.format()
    top.only(TOP_KEYS)
    values: dict[str, float] = {}
    for name in ("component", "rig", "mount"):
        values |= top.table_if_any(name).all_numbers(f"{name}.", UNCERTAINTY)
    values |= top.table_if_any("vehicle").all_numbers(but=UNCERTAINTY)
    if not values:
        raise top.error("holds no numbers: give the tables of [vehicle], or [component]")
    for name in (channels := top.table_if_any("channel")).values:
        values |= channels.table(name).all_numbers(f"channel.{dotted(name)}.", UNCERTAINTY)
    effects = []
    for table in top.tables("effect", "id") if "effect" in top else []:
        table.only(("id", "form", "parameters"))
        effect = _of_library(table, library)
        effects.append(effect)
        values |= table.table_if_any("parameters").all_numbers(f"{effect.id}.", UNCERTAINTY)
    runs: dict[str, dict[str, float]] = {}
    for run in top.tables("run", "id") if "run" in top else []:
        about = {key: value for key, value in run.values.items() if key != "id"}
        own = Table(about, path, run.heading, kind=CampaignError)
        runs[run.text("id")] = own.all_numbers(but=UNCERTAINTY)
    return Model(values, tuple(effects), runs)


def _of_library(table: Table, library: Mapping[str, Effect]) -> Effect:
    """An effect of the file, in its form."""
    try:
        (effect,) = pick(table.text("id"), library)
    except CampaignError as error:
        raise table.error(str(error)) from None
    return effect.with_choice(table.text("form")) if "form" in table else effect
