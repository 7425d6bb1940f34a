"""The campaign's files as forms: which values there are, what each means, and what was typed as the
file writes it."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from wheelhop.campaign import Campaign, CampaignError
from wheelhop.campaign.change import CAMPAIGN, VEHICLE, Change, written
from wheelhop.files import quoted, read_toml
from wheelhop.files.schemas import schema

Keys = tuple[str, ...]
ELSEWHERE = ("format", "kind", "channels", "factors", "run", "measured")
"""Keys that have a form of their own, or none."""
ALWAYS = ("role", "speed_kmph", "setting", "track.kind")
"""Columns of the runs that are there although no run has them yet."""
UNCERTAINTY = "_uncertainty"


@dataclass(frozen=True)
class Field:
    """One value of a file: where it stands, what it says now ("" nothing), what it means, and
    whether it is a text."""

    file: str
    keys: Keys
    text: str
    meaning: str
    is_text: bool

    @property
    def name(self) -> str:
        """Its dotted key."""
        return ".".join(self.keys)

    def change(self, typed: str) -> Change:
        """What was typed, as the file writes it."""
        return Change(self.file, self.keys, as_toml(typed, is_text=self.is_text))


def as_toml(typed: str, *, is_text: bool) -> str:
    """What was typed as TOML has it: texts in quotes, numbers with a point, "" for nothing."""
    typed = typed.strip()
    if not typed:
        return ""
    if is_text:
        return quoted(typed)
    number = re.sub(r"^([+-]?\d+),(\d+)$", r"\1.\2", typed)
    try:
        tomllib.loads(f"x = {number}")
    except tomllib.TOMLDecodeError:
        return quoted(typed)
    return number


def plain(value: object) -> str:
    """A value of a file as it is typed: texts without quotes."""
    return "" if value is None else value if isinstance(value, str) else written(value)


def of_campaign(campaign: Campaign) -> list[Field]:
    """The values of campaign.toml that hold for all runs. Raises CampaignError."""
    values = read_toml(campaign.folder / CAMPAIGN, CampaignError).values
    name = "component" if values.get("kind") == "component" else "campaign"
    return list(_fields(CAMPAIGN, json.loads(schema(name)), values))


def of_vehicle(campaign: Campaign) -> list[Field]:
    """The values of vehicle.toml, in the tables that it has. Raises CampaignError."""
    values = read_toml(campaign.vehicle_file, CampaignError).values
    there = {key for key, value in values.items() if isinstance(value, Mapping)}
    every = _fields(VEHICLE, json.loads(schema("vehicle")), values)
    return [field for field in every if len(field.keys) == 1 or field.keys[0] in there]


def _fields(
    file: str, about: Mapping[str, Any], values: Mapping[str, Any], path: Keys = ()
) -> Iterator[Field]:
    for key, inner in about.get("properties", {}).items():
        if not path and key in ELSEWHERE:
            continue
        there = values.get(key)
        if inner.get("type") == "object":
            if isinstance(there, Mapping):
                yield from _fields(file, inner, there, (*path, key))
            continue
        is_text = inner.get("type") == "string"
        meaning = str(inner.get("description", ""))
        yield Field(file, (*path, key), plain(there), meaning, is_text)


def of_channels(campaign: Campaign) -> list[dict[str, Field]]:
    """Of every column that is compared: where it sits, its factor and its ratio."""
    top = read_toml(campaign.folder / CAMPAIGN, CampaignError)
    factors = top.values.get("factors", {})
    rows = []
    for channel in campaign.channels:
        name = channel.name
        row = {}
        if channel.point == "rig":
            continue
        if channel.is_acceleration:
            place: object = channel.point
            if channel.point == "body-xy":
                place = [channel.x_m, channel.y_m]
            keys = ("channels", name, "position")
            row["sits at"] = Field(CAMPAIGN, keys, plain(place), PLACE, False)
        elif channel.corner is not None:
            keys = ("channels", name, "corner")
            row["sits at"] = Field(CAMPAIGN, keys, str(channel.corner + 1), CORNER, False)
            keys = ("channels", name, "per_wheel")
            row["per wheel"] = Field(CAMPAIGN, keys, plain(channel.per_wheel), RATIO, False)
        row["times"] = Field(CAMPAIGN, ("factors", name), plain(factors.get(name)), FACTOR, False)
        rows.append(row)
    return rows


PLACE = "A1 to A4 on the axles, B1 to B4 on the body above them, body, or [x, y] in metres."
CORNER = "1 front left, 2 front right, 3 rear left, 4 rear right."
RATIO = "What the sensor shows per what the wheel does."
FACTOR = (
    "-1 for a sensor that was upside down, 9.80665 for one in g; nothing for one that is right."
)


@dataclass(frozen=True)
class RunTable:
    """The runs of campaign.toml: ids, the dotted keys that any has, and what each says."""

    ids: Sequence[str]
    names: Sequence[str]
    texts: Mapping[tuple[str, str], str]

    def field(self, run: str, name: str) -> Field:
        """One cell."""
        keys = ("run", run, *name.split("."))
        return Field(CAMPAIGN, keys, self.texts.get((run, name), ""), "", name in TEXTS)


TEXTS = ("file", "role", "setting", "track.kind", "track.side", "track.file")


def of_runs(campaign: Campaign) -> RunTable:
    """The runs as campaign.toml lists them. Raises CampaignError."""
    top = read_toml(campaign.folder / CAMPAIGN, CampaignError)
    texts: dict[tuple[str, str], str] = {}
    ids = []
    for run in top.tables("run", "id"):
        ids.append(run.text("id"))
        flat = {key: value for key, value in run.values.items() if key not in ("id", "track")}
        flat |= {f"track.{key}": value for key, value in run.values.get("track", {}).items()}
        texts |= {(ids[-1], key): plain(value) for key, value in flat.items()}
    on_rig = top.values.get("kind") == "component"
    names = dict.fromkeys([*(ALWAYS[:1] if on_rig else ALWAYS), *(name for _, name in texts)])
    return RunTable(ids, list(names), texts)


def filled(
    cell: tuple[str, str], rows: Sequence[str], columns: Sequence[str], text: str
) -> dict[tuple[str, str], str]:
    """What a text pasted at a cell fills in: its lines go down `rows`, its tabs to the right."""
    run, name = cell
    below, beside = rows[rows.index(run) :], columns[columns.index(name) :]
    lines = [line.split("\t") for line in text.rstrip("\n").splitlines()]
    return {
        (row, column): word.strip()
        for row, words in zip(below, lines, strict=False)
        for column, word in zip(beside, words, strict=False)
    }
