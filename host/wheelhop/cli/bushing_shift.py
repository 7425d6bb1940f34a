"""`wheelhop bushing shift`: one specimen at several temperatures, brought onto one master curve."""

from __future__ import annotations

from argparse import Namespace
from math import isfinite
from pathlib import Path

from rich import box
from rich.table import Table

from wheelhop.cli.output import open_console, write_json
from wheelhop.material import (
    MODELS,
    MaterialError,
    read_rig_data,
    shift_temperatures,
    specimen_of,
    write_specimen,
)
from wheelhop.material.shift import TemperatureShift

ABSOLUTE_ZERO_DEGC = -273.15
FAR = 3.0


def run(arguments: Namespace) -> int:
    """Fit, print the shifts, write JSON and specimen; raises MaterialError."""
    files = [_measured(text) for text in arguments.data]
    if arguments.model not in MODELS:
        raise MaterialError(f'there is no model "{arguments.model}"; known are {", ".join(MODELS)}')
    moduli = [read_rig_data(file).moduli for file, _ in files]
    temperatures = [temperature for _, temperature in files]
    model = MODELS[arguments.model](moduli[0].omega)
    found = shift_temperatures(moduli, temperatures, model, arguments.reference)
    _show([file for file, _ in files], found)
    if arguments.json is not None:
        write_json(arguments.json, as_json(found))
    if arguments.out is not None:
        name = arguments.out.stem
        write_specimen(arguments.out, specimen_of(name, found.master))
        print(f"{arguments.out}: the {model.title} model at {arguments.reference:g} °C")
    return 0


def as_json(found: TemperatureShift) -> dict[str, object]:
    """The result for programs."""
    fit = found.master
    return {
        "reference_degC": found.reference_degC,
        "c1": found.c1,
        "c2_K": found.c2_K,
        "temperatures_degC": found.temperatures_degC.tolist(),
        "log10_shift": found.log10_shift(found.temperatures_degC).tolist(),
        "rms": fit.rms,
        "rms_apart": found.apart.tolist(),
        "model": fit.model.id,
        "parameters": fit.model.name_values(fit.parameters),
    }


def _measured(text: str) -> tuple[Path, float]:
    """A file and its temperature, written FILE=DEGC."""
    name, _, degrees = text.rpartition("=")
    try:
        temperature = float(degrees)
    except ValueError:
        temperature = float("nan")
    if not name or not isfinite(temperature) or temperature <= ABSOLUTE_ZERO_DEGC:
        raise MaterialError(f"{text}: write FILE=TEMPERATURE in °C, such as cold.csv=-20")
    return Path(name), temperature


def _show(files: list[Path], found: TemperatureShift) -> None:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("file", "°C", "log₁₀ shift", "alone, rms %"):
        table.add_column(heading, justify="left" if heading == "file" else "right")
    shifts = found.log10_shift(found.temperatures_degC)
    rows = zip(files, found.temperatures_degC, shifts, found.apart, strict=True)
    for file, temperature, shift, rms in rows:
        table.add_row(str(file), f"{temperature:g}", f"{shift + 0.0:+.3f}", f"{100 * rms:.2f}")
    console = open_console()
    console.print(table)
    console.print(
        f"C₁ = {found.c1:.3g}, C₂ = {found.c2_K:.3g} K about {found.reference_degC:g} °C;"
        f" the master curve leaves {100 * found.master.rms:.2f} % rms",
        markup=False,
    )
    if found.master.rms > FAR * max(found.apart):
        console.print(
            f"  ! over {FAR:g} times what the model leaves of any temperature alone: no shift"
            " explains this specimen, or the model cannot follow so wide a curve",
            style="yellow", markup=False,
        )  # fmt: skip
