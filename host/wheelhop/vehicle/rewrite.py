"""Numbers put into a vehicle.toml that somebody has written: all else in it stays as it is."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.items import Item

from wheelhop.campaign.types import CampaignError
from wheelhop.files import locked, read_text, replacing
from wheelhop.vehicle.vehicle import read_vehicle


def rewrite_vehicle(file: Path, numbers: Mapping[str, tuple[float, float]], source: str) -> None:
    """Replace numbers by their dotted keys ("suspension.front.stiffness_N_m"): value and one
    standard deviation, the latter under KEY_uncertainty.

    Comments stay; a number's own says `source` in place of what it said of the number before. The
    file is replaced whole, after it has been read as a vehicle, or stays as it was.

    Raises
    ------
    CampaignError
        It is no vehicle.toml, before or after.
    """
    with locked(file.parent, CampaignError):
        _rewrite(file, numbers, source)


def _rewrite(file: Path, numbers: Mapping[str, tuple[float, float]], source: str) -> None:
    read_vehicle(file)
    document: Any = tomlkit.parse(read_text(file, CampaignError))
    for dotted, (value, deviation) in numbers.items():
        *path, key = dotted.split(".")
        table = document
        for name in path:
            table = table[name]
        _put(table, key, value, source)
        _put(table, f"{key}_uncertainty", deviation, "")
    with replacing(file, CampaignError) as draft:
        draft.write_text(tomlkit.dumps(document), encoding="utf-8", newline="\n")
        try:
            read_vehicle(draft)
        except CampaignError as error:
            raise CampaignError(str(error).replace(str(draft), str(file))) from None


def _put(table: Any, key: str, value: float, comment: str) -> None:
    item: Item = tomlkit.item(float(f"{value:.4g}"))
    if comment:
        item.comment(comment)
    table[key] = item
