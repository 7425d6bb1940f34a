"""`wheelhop modes`: how vehicles swing, and what they make of a road's waves."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from math import isfinite
from typing import Any

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from wheelhop.campaign import CampaignError
from wheelhop.cli.output import open_console, write_json
from wheelhop.effects import load_effects
from wheelhop.files.words import label_of, listed, titles
from wheelhop.predict import Case, read_drives, read_effects
from wheelhop.predict.modal import Modes, Transmissibility, modes, transmissibility
from wheelhop.predict.modal_words import SHOWN, by_part, by_place, strongest
from wheelhop.vehicle import read_vehicle

FREQUENCY_HZ = np.geomspace(0.3, 30.0, 241)


def run(arguments: Namespace) -> int:
    """Compute, print, and write what was asked for; raises CampaignError."""
    speed_kmph = arguments.speed
    if speed_kmph is not None and not (isfinite(speed_kmph) and speed_kmph > 0.0):
        raise CampaignError(f"--speed {speed_kmph:g}: must be above 0 km/h")
    effects = read_effects(arguments.effects, load_effects(arguments.library))
    found: list[tuple[Modes, Transmissibility]] = []
    vehicles = [read_vehicle(file) for file in arguments.vehicle]
    names = titles([vehicle.name for vehicle in vehicles], arguments.vehicle)
    for vehicle, name in zip(vehicles, names, strict=True):
        model = Case(vehicle, effects, read_drives(["flat"], [10.0])).nominal
        speed = None if speed_kmph is None else speed_kmph / 3.6
        found.append(
            (
                modes(model, name, vehicle.uncertainty),
                transmissibility(model, FREQUENCY_HZ, speed),
            )
        )
    console = open_console()
    for mode, passed in found:
        show(console, mode, passed)
    if arguments.json is not None:
        write_json(arguments.json, to_json(found, speed_kmph))
    if arguments.figure is not None:
        from wheelhop.report.modes import write_modes_figure

        write_modes_figure(found, arguments.figure)
        console.print(f"figure: {arguments.figure}", markup=False)
    return 0


def show(console: Console, found: Modes, passed: Transmissibility) -> None:
    """Print the modes of a vehicle."""
    console.print(found.name, style="bold", markup=False)
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("Hz", "± 1 sd", "damping\nratio"):
        table.add_column(heading, justify="right")
    for heading in ("moving", "bending", "damped by", "frequency follows"):
        table.add_column(heading)
    for k, frequency in enumerate(found.frequency_hz):
        follows = [
            f"{label_of(found.numbers[p])} {found.frequency_by[k, p]:+.2f}"
            for p in np.argsort(-np.abs(found.frequency_by[k]))[:SHOWN]
        ]
        swings = found.pole[k].imag > 0.0
        table.add_row(
            f"{frequency:.2f}",
            f"{found.frequency_sd_hz[k]:.2f}",
            f"{found.damping_ratio[k]:.2f}" if swings else "overdamped",
            strongest(by_place(found, k)),
            strongest(by_part(found, found.strain[k])),
            strongest(by_part(found, found.dissipated[k])),
            Text("\n".join(follows)),
        )
    console.print(table)
    peak = int(np.abs(passed.driver).argmax())
    console.print(
        f"Waves of the ground reach the driver {abs(passed.driver[peak]):.2f} times as strong at"
        f" {passed.frequency_hz[peak]:.2f} Hz, where it is most.",
        markup=False,
    )
    if found.left_out:
        console.print(
            f"Without the force laws of {listed(found.left_out)}: modes are those of linear parts.",
            markup=False,
        )


def to_json(
    found: Sequence[tuple[Modes, Transmissibility]], speed_kmph: float | None
) -> dict[str, Any]:
    """All numbers, SI: format 1."""
    return {
        "format": 1,
        "speed_kmph": speed_kmph,
        "vehicles": [
            {
                "name": mode.name,
                "modes": [_mode(mode, k) for k in range(len(mode.pole))],
                "force_laws_left_out": list(mode.left_out),
                "transmissibility": {
                    "frequency_hz": passed.frequency_hz.tolist(),
                    "driver": _parts(passed.driver),
                    "travel": {end: _parts(h) for end, h in passed.travel.items()},
                    "tyre_load_1_m": {end: _parts(h) for end, h in passed.tyre_load.items()},
                },
            }
            for mode, passed in found
        ],
    }


def _mode(found: Modes, k: int) -> dict[str, Any]:
    def named(names: Sequence[str], values: Any) -> dict[str, float]:
        return {name: float(v) for name, v in zip(names, values, strict=True) if abs(v) > 1e-9}

    return {
        "frequency_hz": float(found.frequency_hz[k]),
        "frequency_sd_hz": float(found.frequency_sd_hz[k]),
        "damping_ratio": float(found.damping_ratio[k]),
        "oscillates": bool(found.pole[k].imag > 0.0),
        "shape": {
            name: [float(x.real), float(x.imag)]
            for name, x in zip(found.coordinates, found.shape[k], strict=True)
        },
        "kinetic_energy": named(found.coordinates, found.kinetic[k]),
        "strain_energy": named(found.numbers, found.strain[k]),
        "dissipated_energy": named(found.numbers, found.dissipated[k]),
        "frequency_by": named(found.numbers, found.frequency_by[k]),
        "damping_by": named(found.numbers, found.damping_by[k]),
    }


def _parts(values: Any) -> dict[str, list[float]]:
    return {"real": values.real.tolist(), "imaginary": values.imag.tolist()}
