"""The numbers of vehicle.toml: what the user believes about the vehicle before any fit."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wheelhop.campaign.channel import ABOARD
from wheelhop.campaign.paths import file_inside
from wheelhop.campaign.types import CampaignError
from wheelhop.files import Table, did_you_mean, read_toml, shown
from wheelhop.files.words import significant, unit_of
from wheelhop.frame import read_corner_modes
from wheelhop.vehicle.aboard import more_than_there_is, on_mounts
from wheelhop.vehicle.frame_modes import mode_values
from wheelhop.vehicle.layout import FULL_CAR, MODELS
from wheelhop.vehicle.measured import MEASURED, Measured, measurable
from wheelhop.vehicle.mount import mount_values

if TYPE_CHECKING:
    from pandas import DataFrame

WIDTH = "width_m"
"""Of a tyre's contact, optional and certain: a wheel without one is a thin disc."""
WHEEL = ("unsprung_mass_kg", "tyre_stiffness_N_m", "tyre_damping_N_s_m", "radius_m")
SUSPENSION = ("stiffness_N_m", "damping_N_s_m")
PLACED = ("mass_kg", "x_m", "y_m")
MOUNT = ("stiffness_N_m", "damping_N_s_m")
TABLES = {
    "geometry": ("wheelbase_m", "track_width_m", "cg_to_front_axle_m", "cg_height_m"),
    "body": ("mass_kg", "pitch_inertia_kg_m2", "roll_inertia_kg_m2"),
    "suspension.front": SUSPENSION,
    "suspension.rear": SUSPENSION,
    "wheel.front": WHEEL,
    "wheel.rear": WHEEL,
    **{name: PLACED for name in ABOARD},
}
"""Of the full car; the others have fewer. What is aboard may have `MOUNT` as well."""
NEEDS = {
    "pitch": (
        *("geometry.wheelbase_m", "geometry.cg_to_front_axle_m", "body.pitch_inertia_kg_m2"),
        *("suspension.rear", "wheel.rear", *(f"{name}.x_m" for name in ABOARD)),
    ),
    "roll": (
        *("geometry.track_width_m", "body.roll_inertia_kg_m2"),
        *(f"{name}.y_m" for name in ABOARD),
    ),
}
"""Tables and numbers that mean nothing without a motion of the body."""
BOLTED = ("driver", "engine")
"""May be without a mount: effects ask where they are. Anything else bolted down is body."""
ENDINGS = ("", "_uncertainty")
MAY_BE_ZERO = ("damping_N_s_m", "tyre_damping_N_s_m")
POSITIONS = ("x_m", "y_m")
LEAST_POSITION_UNCERTAINTY_M = 0.02
FRAME_MODES, MOST_FRAME_MODES, FRAME_DAMPING = 10, 40, 0.02
LEAST_LENGTH_M = 0.005  # of wheelbase, track and wheel: a toy's


@dataclass(frozen=True)
class Vehicle:
    """The numbers of a vehicle under flat dotted keys, "suspension.front.stiffness_N_m", in SI.
    Which of them it has says what it is, a quarter car, a half car or a full one
    (`wheelhop.vehicle.layout`).

    `uncertainty` holds one standard deviation for every key of `values`, in the same unit. The
    keys of what is aboard are there only if the file has its table, those of "mount.…" and
    "frame.…" if it names a specimen, or a frame: these are certain. `measured` are sums and
    relations of the values that were measured, too.
    """

    name: str
    values: Mapping[str, float]
    uncertainty: Mapping[str, float]
    measured: tuple[Measured, ...] = ()

    def __getitem__(self, key: str) -> float:
        return self.values[key]

    def with_values(self, changes: Mapping[str, float]) -> Vehicle:
        """This vehicle with some values changed.

        Parameters
        ----------
        changes
            Values in SI by their dotted names.

        Returns
        -------
        Vehicle
            Another one.

        Raises
        ------
        KeyError
            It has no such number.
        """
        for key in changes:
            self.values[key]
        return replace(self, values={**self.values, **changes})

    def to_dataframe(self) -> DataFrame:
        """The numbers as a table.

        Returns
        -------
        DataFrame
            By `number`: value, uncertainty (one standard deviation), unit (SI).
        """
        import pandas

        columns = {"value": dict(self.values), "uncertainty": dict(self.uncertainty)}
        table = pandas.DataFrame(columns).rename_axis("number")
        return table.assign(unit=[unit_of(name) for name in table.index])

    def __repr__(self) -> str:
        mass = self.values.get("body.mass_kg", self.values.get("component.mass_kg"))
        heavy = "" if mass is None else f", {significant(mass)} kg"
        return f"<Vehicle {shown(self.name)}{heavy}, {len(self.values)} numbers>"

    def _repr_html_(self) -> str:
        return f"<p>{escape(repr(self))}</p>{self.to_dataframe().to_html(float_format='%.4g')}"


def read_vehicle(path: Path) -> Vehicle:
    """Read vehicle.toml.

    The uncertainty of a value is its KEY_uncertainty if given, else `relative_uncertainty` times
    its magnitude, and for the position of what is aboard at least 0.02 m.

    `model` is one of `MODELS`, "full-car" if not given: half and quarter cars have fewer numbers.
    [driver], [engine], [battery], [payload] with stiffness_N_m and damping_N_s_m are on mounts.
    [measured] may hold what scales and a stopwatch tell of the whole vehicle
    (`wheelhop.vehicle.measured`), uncertainties as above.
    `mount` names a specimen's file beside it, the bushing that every strut may stand on; [frame]
    that of a frame whose modes the body of a full car has besides its rigid motions.

    Raises `CampaignError` for unknown or missing keys, masses and lengths that are not positive,
    a centre of mass that is not between the axles, more mass on mounts than the body has, and a
    value without uncertainty; `FrameError` for a frame's file that is wrong.
    """
    return vehicle_in(read_toml(path, CampaignError), path.parent)


def vehicle_in(top: Table, folder: Path) -> Vehicle:
    """What `read_vehicle` reads, of a table; `folder` has the files it names."""
    top.format()
    model = top.text("model", FULL_CAR, choices=tuple(MODELS))
    tables, absent = _tables(model), f"; a {model} has none"
    known = ["format", "name", "model", "relative_uncertainty", "mount", MEASURED]
    if model == FULL_CAR:
        known.append("frame")
    top.only((*known, *(name.split(".")[0] for name in tables)), absent)
    _refuse_gaps(top, tables)
    name = top.text("name")
    relative = top.number("relative_uncertainty", above=0.0)
    if relative > 1.0:
        raise top.error(f"relative_uncertainty = {relative:g} is a fraction: 0.10 for 10 %")
    values: dict[str, float] = {}
    uncertainty: dict[str, float] = {}
    for path_in_file, keys in tables.items():
        if path_in_file in ABOARD and path_in_file not in top:
            continue
        table = _descend(top, path_in_file, tables, absent)
        aboard = path_in_file in ABOARD
        wheel = path_in_file.startswith("wheel.")
        allowed = (*keys, *MOUNT) if aboard else keys
        known = [f"{key}{end}" for key in allowed for end in ENDINGS]
        table.only([*known, WIDTH] if wheel else known, absent)
        if wheel and WIDTH in table:
            values[f"{path_in_file}.{WIDTH}"] = _value(table, WIDTH)
            uncertainty[f"{path_in_file}.{WIDTH}"] = 0.0
        if aboard:
            keys = (*keys, *_mount(table))
        for key in keys:
            value = _value(table, key)
            values[f"{path_in_file}.{key}"] = value
            uncertainty[f"{path_in_file}.{key}"] = _uncertainty(table, key, value, relative)
    if "mount" in top:
        mount = mount_values(file_inside(folder, top, "mount"))
        values |= mount
        uncertainty |= dict.fromkeys(mount, 0.0)
    if "frame" in top:
        modes = _frame(top.table("frame"), folder)
        values |= modes
        uncertainty |= dict.fromkeys(modes, 0.0)
    vehicle = Vehicle(name, values, uncertainty, _measured(top, values, relative, absent))
    _check_whole(top, vehicle)
    return vehicle


def changed(vehicle: Vehicle, changes: Mapping[str, float], source: Path) -> Vehicle:
    """`vehicle` with some values changed, held to the same rules as those of vehicle.toml.

    Raises `CampaignError`, its line beginning with `source`: who asks for the change.
    """
    for key, value in changes.items():
        if key not in vehicle.values:
            near = did_you_mean(key, vehicle.values) or "; vehicle.toml names them"
            raise CampaignError(f"{source}: the vehicle has no number {key}{near}")
        group, _, last = key.rpartition(".")
        _value(Table({last: value}, source, f"[{group}]", kind=CampaignError), last)
    after = vehicle.with_values(changes)
    _check_whole(Table({}, source, kind=CampaignError), after)
    return after


def _measured(
    top: Table, values: Mapping[str, float], relative: float, absent: str
) -> tuple[Measured, ...]:
    """What [measured] holds; nothing if it is not there."""
    if MEASURED not in top:
        return ()
    table, keys = top.table(MEASURED), measurable(values)
    table.only([f"{key}{end}" for key in keys for end in ENDINGS], absent)
    for key in keys:
        if f"{key}{ENDINGS[1]}" in table:
            table.number(key)  # an uncertainty alone is a mistake
    found = {key: _value(table, key) for key in keys if key in table}
    return tuple(
        Measured(key, value, _uncertainty(table, key, value, relative))
        for key, value in found.items()
    )


def _frame(table: Table, folder: Path) -> dict[str, float]:
    """The modes of the frame whose file [frame] names."""
    table.only(("file", "modes", "damping_ratio"))
    count = table.number("modes", FRAME_MODES, at_least=1.0)
    damping_ratio = table.number("damping_ratio", FRAME_DAMPING, above=0.0)
    if count != int(count) or count > MOST_FRAME_MODES:
        raise table.error(f"modes = {count:g} must be a whole number up to {MOST_FRAME_MODES}")
    modes = read_corner_modes(file_inside(folder, table, "file"))
    return mode_values(modes, int(count), damping_ratio)


def _tables(model: str) -> dict[str, tuple[str, ...]]:
    """The tables of vehicle.toml, and their keys, for one of `MODELS`."""
    lacks = set(NEEDS) - set(MODELS[model])
    gone = {key for motion in lacks for key in NEEDS[motion]}
    if lacks == set(NEEDS):
        gone.add("geometry")
    return {
        name: tuple(key for key in keys if f"{name}.{key}" not in gone)
        for name, keys in TABLES.items()
        if name not in gone
    }


def _refuse_gaps(top: Table, tables: Mapping[str, tuple[str, ...]]) -> None:
    """Raise for all numbers that are missing, if there are several: one at a time is tedious."""
    missing = top.needs(("name", "relative_uncertainty"))
    for dotted, keys in tables.items():
        outer: Any = top.values
        for part in dotted.split("."):
            outer = outer.get(part, {}) if isinstance(outer, dict) else None
        if outer is None or (dotted in ABOARD and dotted not in top.values):
            continue  # what is no table at all is said in its own words
        missing += Table(outer, top.file, f"[{dotted}]").needs(keys) if outer else [f"[{dotted}]"]
    if len(missing) > 1:
        raise top.error(
            f"{len(missing)} things are missing: {', '.join(missing)}; docs/vehicle-file.md says"
            " what they are, and wheelhop new estimates them"
        )


def _descend(top: Table, dotted: str, tables: Collection[str], absent: str) -> Table:
    """The table [dotted]; its parent may hold nothing but such tables."""
    parent, _, last = dotted.rpartition(".")
    if not parent:
        return top.table(last)
    outer = top.table(parent)
    outer.only([name.split(".")[1] for name in tables if name.startswith(f"{parent}.")], absent)
    return outer.table(last)


def _mount(table: Table) -> tuple[str, ...]:
    """The keys of the mount under what is aboard: both or none."""
    given = [key for key in MOUNT if key in table]
    name = table.heading.strip("[]")
    if len(given) == len(MOUNT):
        return MOUNT
    if given or name not in BOLTED:
        missing = " and ".join(key for key in MOUNT if key not in given)
        why = "of its mount" if given else "of its mount; what is bolted down belongs to [body]"
        raise table.error(f"needs {missing} {why}")
    return ()


def _value(table: Table, key: str) -> float:
    if key in POSITIONS:
        return table.number(key)
    if key in MAY_BE_ZERO:
        return table.number(key, at_least=0.0)
    if key.endswith("_m") and not key.endswith("_N_m"):
        return table.number(key, at_least=LEAST_LENGTH_M)
    return table.number(key, above=0.0)


def _uncertainty(table: Table, key: str, value: float, relative: float) -> float:
    given = f"{key}_uncertainty"
    if given in table:
        return table.number(given, above=0.0)
    scaled = relative * abs(value)
    if key in POSITIONS:
        return max(scaled, LEAST_POSITION_UNCERTAINTY_M)
    if scaled == 0.0:
        raise table.error(f"{key} = 0 has no relative uncertainty: give {given} too")
    return scaled


def _check_whole(top: Table, vehicle: Vehicle) -> None:
    """What no single key can show: where the centre of mass lies, and what the body contains."""
    ahead = vehicle.values.get("geometry.cg_to_front_axle_m", 0.0)
    wheelbase = vehicle.values.get("geometry.wheelbase_m")
    if wheelbase is not None and not ahead < wheelbase:
        raise top.error(
            f"[geometry]: cg_to_front_axle_m = {ahead:g} must be less than wheelbase_m = "
            f"{wheelbase:g}: the centre of mass lies between the axles"
        )
    there = [name for name in ABOARD if f"{name}.mass_kg" in vehicle.values]
    aboard = sum(vehicle[f"{name}.mass_kg"] for name in there)
    if not aboard < vehicle["body.mass_kg"]:
        raise top.error(
            f"[body]: mass_kg = {vehicle['body.mass_kg']:g} includes {' and '.join(there)}, which "
            f"alone are {aboard:g} kg"
        )
    if more_than_there_is(vehicle.values):
        raise top.error(
            f"[body]: its inertia includes {' and '.join(on_mounts(vehicle.values))}, which alone"
            " have more of it there"
        )
