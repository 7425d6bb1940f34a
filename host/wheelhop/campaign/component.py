"""A component's campaign: one strut, damper or mount on a rig, its numbers in campaign.toml."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign.common import (
    Entry,
    band,
    check_entries,
    check_resolved,
    column,
    entry,
    frozen,
)
from wheelhop.campaign.factors import read_factors, scaled
from wheelhop.campaign.paths import file_inside
from wheelhop.campaign.recordings import check_time, read_columns
from wheelhop.campaign.types import (
    CampaignError,
    Channel,
    ComponentCampaign,
    RigDrive,
    RigRun,
    TrackSpec,
)
from wheelhop.files import Table
from wheelhop.files.words import unit_of

FORCE = Channel("force", "rig", quantity="force", unit="N")
DISPLACEMENT = Channel("displacement", "rig", quantity="displacement", unit="m")
MEASURED = {"displacement": FORCE, "force": DISPLACEMENT}
"""What is measured, by what the rig imposes."""

COMPONENT_KEYS = ("mass_kg", "stiffness_N_m", "damping_N_s_m")
TOP_KEYS = (
    *("format", "kind", "title", "sample_rate_hz", "band_hz", "drive", "component", "factors"),
    "run",
)
NONE, UNKNOWN, MASSLESS = "none", "unknown", "massless"
"""What a key says of a part that the component does not have, and of one of which nothing is known,
as 0 does too; "massless" is another word for a mass that is "none"."""
PRELOAD = "preload"
"""What a spring carries beside the force recorded: a weight that hangs, or a load cell's zero."""
COLUMNS = ("time_s", "displacement_m", "force_N")
VELOCITY, INPUT = "velocity_m_s", "input_"
RECORDED = (
    f"a component's recording holds {', '.join(COLUMNS)} and, if recorded, {VELOCITY} and inputs"
    f" that laws may depend on, {INPUT}…"
)


def read_component(top: Table, folder: Path) -> ComponentCampaign:
    """Read the campaign.toml of a component, and its recordings.

    Raises `CampaignError`, one line naming file, key or row, and remedy, for every mistake.
    """
    drive: RigDrive = (
        "force" if top.text("drive", choices=tuple(MEASURED)) == "force" else "displacement"
    )
    channel = MEASURED[drive]
    noise_key = f"noise_rms_{channel.unit}"
    top.only((*TOP_KEYS, noise_key))
    rate = top.number("sample_rate_hz", above=0.0)
    part = top.table("component")
    about = _component(part)
    if drive == "displacement" and about["preloaded"]:
        raise part.error(
            "preload: of an imposed displacement a constant force lies in no band; leave it out"
        )
    if drive == "force" and "mass_kg" in about["without"]:
        raise part.error(
            'mass_kg: an imposed force moves a mass; state it, or "unknown" to have it estimated'
        )
    empty = ComponentCampaign(
        folder=folder,
        title=top.text("title"),
        vehicle_file=top.file,
        sample_rate_hz=rate,
        band_hz=band(top, rate),
        averaging_s=0.0,
        noise_rms=top.number(noise_key, above=0.0) if noise_key in top else None,
        channels=(channel,),
        runs=(),
        drive=drive,
        factors=read_factors(top),
        mount_file=file_inside(folder, part, "mount") if "mount" in part else None,
        **about,
    )
    entries = []
    for table in top.tables("run", "id"):
        table.only(("id", "file", "role"))
        entries.append(entry(table, folder))
    check_entries(top, entries)
    runs = tuple(_run(item, empty, drive) for item in entries)
    for run in runs:
        if missing := runs[0].inputs.keys() ^ run.inputs.keys():
            raise CampaignError(
                f"{run.file}: {', '.join(sorted(missing))} is a column of some recordings only:"
                " an input belongs into all of them"
            )
    return replace(empty, runs=runs)


def _component(table: Table) -> dict[str, Any]:
    """Nominal values and uncertainties by their keys; which of the three parts do not exist."""
    stated = [f"{key}_uncertainty" for key in COMPONENT_KEYS]
    table.only((*COMPONENT_KEYS, *stated, "relative_uncertainty", "mount", PRELOAD))
    relative = table.number("relative_uncertainty", above=0.0)
    nominal, uncertainty, without = {}, {}, set()
    for key in COMPONENT_KEYS:
        word = _word(table, key)
        nominal[key] = table.number(key, at_least=0.0) if word is None else 0.0
        uncertainty[key] = table.number(f"{key}_uncertainty", relative * nominal[key], at_least=0.0)
        if word is not None and uncertainty[key]:
            raise table.error(
                f'{key}_uncertainty: {key} = "{word}" has no uncertainty; state a number, or leave'
                " the uncertainty out"
            )
        if word == NONE:
            without.add(key)
    if len(without) == len(COMPONENT_KEYS):
        raise table.error('mass, spring and damper are all "none": nothing is left to compare')
    preloaded = PRELOAD in table and table.text(PRELOAD, choices=(NONE, UNKNOWN)) == UNKNOWN
    return {
        "nominal": nominal,
        "uncertainty": uncertainty,
        "without": frozenset(without),
        "preloaded": preloaded,
    }


def _word(table: Table, key: str) -> str | None:
    """What a key says in a word, "none" or "unknown"; None where it states a number."""
    if not isinstance(table.values.get(key), str):
        return None
    words = (NONE, UNKNOWN, *((MASSLESS,) if key == "mass_kg" else ()))
    word = table.text(key, choices=words)
    return NONE if word == MASSLESS else word


def _run(item: Entry, campaign: ComponentCampaign, drive: RigDrive) -> RigRun:
    rate_hz, band_hz = campaign.sample_rate_hz, campaign.band_hz
    units = {name: unit_of(name) for name in (*COLUMNS[1:], VELOCITY)}
    names, values = read_columns(item.file, wanted=units)
    values = scaled(item.file, names, values, campaign.factors)
    for name in names:
        if name not in (*COLUMNS, VELOCITY) and not name.startswith(INPUT):
            raise CampaignError(f"{item.file}: unexpected column {name}; {RECORDED}")
    time_s, displacement, force = (
        frozen(values[:, column(item.file, names, name, RECORDED)]) for name in COLUMNS
    )
    check_time(item.file, time_s, rate_hz, shortest_s=0.0)
    check_resolved(item.file, len(time_s), rate_hz, band_hz)
    _check_moving(item, displacement, force, drive)
    return RigRun(
        **vars(item),
        speed_m_s=0.0,
        track=TrackSpec("none", {}),
        time_s=time_s,
        record=frozen((force if drive == "displacement" else displacement)[:, None]),
        drive=drive,
        displacement=displacement,
        force=force,
        velocity=frozen(values[:, names.index(VELOCITY)]) if VELOCITY in names else None,
        inputs={
            name: frozen(values[:, i]) for i, name in enumerate(names) if name.startswith(INPUT)
        },
    )


def _check_moving(
    item: Entry, displacement: NDArray[np.float64], force: NDArray[np.float64], drive: str
) -> None:
    """A force of zero is a free decay; everything else that never changes says nothing."""
    columns = {"displacement_m": displacement}
    if drive == "displacement":
        columns["force_N"] = force
    for name, values in columns.items():
        if not np.ptp(values) > 0.0:
            raise CampaignError(
                f"{item.file}: {name} never changes: there is nothing to compare; leave the run out"
            )
