"""`wheelhop rates`: what strut and damper are worth at the wheel."""

from __future__ import annotations

from argparse import Namespace
from math import isfinite
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from wheelhop.campaign import CampaignError
from wheelhop.cli.output import open_console, write_json
from wheelhop.files.units import STANDARD_GRAVITY_M_S2
from wheelhop.vehicle import Vehicle, read_vehicle
from wheelhop.vehicle.rates import WheelRates, wheel_rates
from wheelhop.vehicle.rewrite import rewrite_vehicle

NOT_ITS_LOAD = 0.2
"""A strut that carries another load than the vehicle's, by this share, is not at ride height."""


def run(arguments: Namespace) -> int:
    """Compute, print, and write what was asked for; raises CampaignError."""
    for option in ("ride", "travel"):
        value = getattr(arguments, option)
        if value is not None and not (isfinite(value) and (value > 0 or option == "ride")):
            raise CampaignError(f"--{option} {value:g}: is no length in mm")
    if (arguments.into is None) != (arguments.axle is None):
        raise CampaignError("--into and --axle go together: say whose numbers are to be replaced")
    vehicle = None if arguments.into is None else read_vehicle(arguments.into)
    found = wheel_rates(
        arguments.strut,
        arguments.damper,
        _ratio(arguments.motion_ratio),
        ride_m=None if arguments.ride is None else 1e-3 * arguments.ride,
        travel_m=None if arguments.travel is None else 1e-3 * arguments.travel,
    )
    console = open_console()
    show(console, found)
    if arguments.json is not None:
        write_json(arguments.json, to_json(found))
    if arguments.figure is not None:
        from wheelhop.report.rates import write_rates_figure

        write_rates_figure(found, arguments.figure)
        console.print(f"figure: {arguments.figure}", markup=False)
    if vehicle is not None:
        source = f"from {arguments.strut.name} and {arguments.damper.name}"
        rewrite_vehicle(arguments.into, numbers(found, arguments.axle), source)
        console.print(
            f"{arguments.into}: [suspension.{arguments.axle}] has the new numbers", markup=False
        )
        _compare_load(console, found, vehicle, arguments.axle)
    return 0


def numbers(found: WheelRates, axle: str) -> dict[str, tuple[float, float]]:
    """Value and standard deviation under the keys of vehicle.toml."""
    return {
        f"suspension.{axle}.stiffness_N_m": (found.stiffness_N_m, found.stiffness_uncertainty_N_m),
        f"suspension.{axle}.damping_N_s_m": (found.damping_N_s_m, found.damping_uncertainty_N_s_m),
    }


def to_json(found: WheelRates) -> dict[str, Any]:
    """The result with what it was made of, in SI."""
    strut, damper, linkage = found.strut, found.damper, found.linkage
    return {
        "format": 1,
        "wheel": {
            "stiffness_N_m": found.stiffness_N_m,
            "stiffness_N_m_uncertainty": found.stiffness_uncertainty_N_m,
            "from_linkage_N_m": found.from_linkage_N_m,
            "damping_N_s_m": found.damping_N_s_m,
            "damping_N_s_m_uncertainty": found.damping_uncertainty_N_s_m,
            "load_N": found.load_N,
        },
        "strut": {
            "stiffness_N_m": strut.stiffness.value,
            "stiffness_N_m_uncertainty": strut.stiffness.uncertainty,
            "ride_m": strut.ride_m,
            "ride_force_N": strut.ride_force_N,
            "friction_N": strut.friction_N,
        },
        "damper": {
            "damping_N_s_m": damper.damping.value,
            "damping_N_s_m_uncertainty": damper.damping.uncertainty,
            "compression_N_s_m": damper.compression_N_s_m,
            "rebound_N_s_m": damper.rebound_N_s_m,
            "rest_force_N": damper.rest_force_N,
        },
        "motion_ratio": {
            "value": linkage.ratio.value,
            "uncertainty": linkage.ratio.uncertainty,
            "growth_per_m": linkage.growth,
        },
    }


def show(console: Console, found: WheelRates) -> None:
    """Print the numbers of the strut and those at the wheel."""
    strut, damper, ratio = found.strut, found.damper, found.linkage.ratio
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("")
    for heading in ("stiffness, N/mm", "damping, N s/mm"):
        table.add_column(heading, justify="right")
    table.add_row(
        "strut",
        _with(strut.stiffness.value, strut.stiffness.uncertainty),
        _with(damper.damping.value, damper.damping.uncertainty),
    )
    table.add_row(
        "at the wheel",
        _with(found.stiffness_N_m, found.stiffness_uncertainty_N_m),
        _with(found.damping_N_s_m, found.damping_uncertainty_N_s_m),
    )
    console.print(table)
    console.print(f"motion ratio {ratio.value:.3f} ± {ratio.uncertainty:.3f}")
    if found.linkage.growth:
        console.print(
            f"of the wheel rate {1e-3 * found.from_linkage_N_m:.2f} N/mm are the linkage's: its"
            f" ratio grows by {1e-2 * found.linkage.growth:.4f} a cm of bump, under"
            f" {strut.ride_force_N:.0f} N"
        )
    if strut.friction_N > 0.0:
        at_wheel = strut.friction_N * ratio.value
        console.print(
            f"friction of the strut {strut.friction_N:.0f} N, at the wheel {at_wheel:.0f} N"
        )
    console.print(
        f"damper: {1e-3 * damper.compression_N_s_m:.2f} N s/mm in compression,"
        f" {1e-3 * damper.rebound_N_s_m:.2f} in rebound"
    )


def _compare_load(console: Console, found: WheelRates, vehicle: Vehicle, axle: str) -> None:
    """Say it where the strut at ride height does not carry what the vehicle rests on it."""
    ahead = vehicle["geometry.cg_to_front_axle_m"] / vehicle["geometry.wheelbase_m"]
    share = 1.0 - ahead if axle == "front" else ahead
    load = 0.5 * share * vehicle["body.mass_kg"] * STANDARD_GRAVITY_M_S2
    if abs(found.load_N - load) > NOT_ITS_LOAD * load:
        console.print(
            f"At ride height the strut carries {found.load_N:.0f} N at the wheel, but the vehicle"
            f" rests on it with {load:.0f} N: is it at ride height there (--ride)?",
            markup=False,
        )


def _with(value: float, deviation: float) -> str:
    return f"{1e-3 * value:.4g} ± {1e-3 * deviation:.2g}"


def _ratio(text: str) -> Path | float:
    try:
        return float(text)
    except ValueError:
        return Path(text)
