"""Tracks that have a name: the thesis's proving ground, as data in proving_ground.toml."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from tomllib import loads
from types import MappingProxyType
from typing import Any


@dataclass(frozen=True)
class NamedTrack:
    """A track by the keys of campaign.toml, `kind` among them, and the speeds it was driven at."""

    keys: Mapping[str, str | float]
    speeds_kmph: tuple[float, ...]


@cache
def proving_ground() -> Mapping[str, NamedTrack]:
    """Every named track, such as "washboard/low"."""
    return MappingProxyType(
        {
            f"{group}/{severity}": NamedTrack(
                {key: value for key, value in keys.items() if key != "speeds_kmph"},
                tuple(map(float, keys["speeds_kmph"])),
            )
            for group, severities in _data().items()
            if isinstance(severities, dict)
            for severity, keys in severities.items()
        }
    )


@cache
def table_5_1() -> tuple[str, ...]:
    """Names of the tracks of the eighteen tests on which the thesis's models are developed."""
    return tuple(_data()["table_5_1"])


@cache
def _data() -> dict[str, Any]:
    text = files("wheelhop.campaign").joinpath("proving_ground.toml").read_text(encoding="utf-8")
    return loads(text)
