"""The `track.…` keys of a run, checked and turned to SI."""

import math
from pathlib import Path
from typing import Any

from wheelhop.campaign.paths import file_inside
from wheelhop.campaign.proving_ground import proving_ground
from wheelhop.campaign.types import TrackSpec
from wheelhop.files import Table

REQUIRED = None
WAVE = {"amplitude_mm": REQUIRED, "pitch_mm": REQUIRED}
PITCHES = ("pitch_mm", "pitch_start_mm", "pitch_end_mm")
LEAST_PITCH_MM = 1.0
SIDES = ("both", "left", "right")

# The keys each kind of track takes, and their defaults.
KINDS: dict[str, dict[str, float | str | None]] = {
    "washboard": {**WAVE},
    "one-sided-washboard": {**WAVE},
    "herringbone": {**WAVE, "angle_deg": 20.0},
    "chassis-twist": {**WAVE, "width_mm": 4000.0, "lateral_offset_mm": 0.0},
    "sine-sweep": dict.fromkeys(("amplitude_mm", "pitch_start_mm", "pitch_end_mm", "length_mm")),
    "half-sine-bump": {"amplitude_mm": REQUIRED, "length_mm": REQUIRED, "side": "both"},
    "step-bump": {"height_mm": REQUIRED, "width_mm": REQUIRED, "side": "both"},
    "iso8608": dict.fromkeys(("unevenness_m3", "waviness", "seed")),
    "cobblestone": {
        "height_mm": REQUIRED,
        "seed": REQUIRED,
        "stone_length_mm": 150.0,
        "stone_width_mm": 150.0,
        "joint_mm": 10.0,
        "joint_depth_mm": 15.0,
    },
    "profile": {"file": REQUIRED},
    "flat": {},
    "unknown": {},
}

STEADY = (
    *("washboard", "one-sided-washboard", "herringbone", "chassis-twist"),
    *("iso8608", "cobblestone", "flat"),
)
"""Kinds that go on alike for as long as one drives. The others have a beginning, or no name."""


def is_steady(kind: str) -> bool:
    """Whether a track of this kind, or of this name of the proving ground, goes on alike: then the
    steady part of a drive is what was driven on it, and of the others the whole drive is."""
    named = proving_ground().get(kind)
    return (kind if named is None else named.keys["kind"]) in STEADY


def read_track(run: Table, folder: Path) -> TrackSpec:
    """The track of one [[run]]; a profile's `file` must lie inside `folder`.

    A kind with a slash is a track of the proving ground; keys beside it replace that track's own.
    """
    given = run.values.get("track")
    if isinstance(given, str):
        raise run.error(f'track is a table: write track.kind = "{given}"')
    table = run.table("track", heading=run.heading, prefix="track.")
    kind = table.text("kind", choices=(*KINDS, *proving_ground()))
    if kind in proving_ground():
        named = proving_ground()[kind].keys
        kind = str(named["kind"])
        values = {**named, **table.values, "kind": kind}
        table = Table(values, table.file, table.heading, table.prefix, table.kind)
    keys = KINDS[kind]
    takes = ", ".join(keys) or "no keys"
    table.only(("kind", *keys), f"; a {kind} track takes {takes}")
    found = dict(_value(table, key, default, folder) for key, default in keys.items())
    _check_slope(table, keys)
    return TrackSpec(kind, found)


def _value(table: Table, key: str, default: Any, folder: Path) -> tuple[str, float | str]:
    """One key of the track as its name and value in SI."""
    if key == "side":
        return key, table.text(key, default, choices=SIDES)
    if key == "file":
        return key, str(file_inside(folder, table, key).resolve())
    if key == "angle_deg":
        return "angle_rad", math.radians(table.number(key, default, above=-80.0, below=80.0))
    if key == "lateral_offset_mm":
        return "lateral_offset_m", table.number(key, default) * 1e-3
    if key == "seed":
        seed = table.number(key, at_least=0.0, below=2.0**53)
        if not seed.is_integer():
            raise table.error(f"track.seed = {seed:g} must be a whole number")
        return key, seed
    if key.endswith("_mm"):
        return key.removesuffix("mm") + "m", table.number(key, default, above=0.0) * 1e-3
    return key, table.number(key, above=0.0)


def _check_slope(table: Table, keys: dict[str, float | str | None]) -> None:
    """No wave is steeper than 1 in 1, or finer than a millimetre: else a length has another
    unit."""
    for key in PITCHES:
        if key in keys and 2 * math.pi * table.values["amplitude_mm"] > table.values[key]:
            raise table.error(
                f"track.amplitude_mm = {table.values['amplitude_mm']:g} on track.{key} = "
                f"{table.values[key]:g} is steeper than 45 degrees: give both in millimetres"
            )
        if key in keys and table.values[key] < LEAST_PITCH_MM:
            raise table.error(
                f"track.{key} = {table.values[key]:g} is shorter than {LEAST_PITCH_MM:g} mm, finer"
                " than any wheel feels: give it in millimetres"
            )
