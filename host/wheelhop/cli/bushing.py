"""`wheelhop bushing`: from rig data to a model of each specimen's complex modulus."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from math import isfinite
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from wheelhop.cli import bushing_shift
from wheelhop.cli.output import open_console, write_json
from wheelhop.files import did_you_mean
from wheelhop.material import (
    MODELS,
    MaterialError,
    approximate,
    candidates,
    consistency,
    passive_range_hz,
    read_rig_data,
    specimen_of,
    violation,
    write_specimen,
)
from wheelhop.material.rational import BAND_HZ
from wheelhop.report.bushings import BushingResult, write_bushing_report


def run(arguments: Namespace) -> int:
    """Fit every file, print what was found, write report, JSON and specimens; or shift."""
    if arguments.action == "shift":
        return bushing_shift.run(arguments)
    files = _files(arguments.data)
    if arguments.out is not None:
        _check_folder(arguments.out)
    models = tuple(arguments.model or MODELS)
    for name in models:
        if name not in MODELS:
            guess = did_you_mean(name, tuple(MODELS)) or f"; known are {', '.join(MODELS)}"
            raise MaterialError(f'there is no model "{name}"{guess}')
    results = [examine(file, models) for file in files]
    console = open_console()
    for result in results:
        _show(console, result)
    if arguments.out is not None:
        for result in results:
            target = arguments.out / f"{result.name}.toml"
            write_specimen(target, specimen_of(result.name, result.best))
            console.print(f"{target}: the {result.best.model.title} model", markup=False)
    if arguments.json is not None:
        write_json(arguments.json, {result.name: as_json(result) for result in results})
    if arguments.report is not None:
        write_bushing_report(arguments.report, results)
        console.print(f"report: {arguments.report}", markup=False)
    return 0


def examine(file: Path, models: Sequence[str] = tuple(MODELS)) -> BushingResult:
    """Everything there is to say about one file of rig data."""
    data = read_rig_data(file)
    moduli = data.moduli
    found = candidates(moduli, models)
    best = found[0].fit
    inside = (float(moduli.frequency_hz[0]), float(moduli.frequency_hz[-1]))
    try:
        count = len(approximate(best.modulus).times_s)
        elements = f"In the time domain it takes {count} Maxwell elements, within 1 %"
        elements += f" over {BAND_HZ[0]:g} to {BAND_HZ[1]:g} Hz."
    except MaterialError as error:
        elements = f"In the time domain: {error}"
    return BushingResult(
        file.stem,
        data,
        found,
        consistency(moduli),
        passive_range_hz(best.modulus, inside),
        violation(best.modulus, moduli.omega),
        elements,
    )


def as_json(result: BushingResult) -> dict[str, Any]:
    """The result for programs."""
    return {
        "causal": result.consistency.causal,
        "disagreement": result.consistency.disagreement,
        "expansion_residual": result.consistency.expansion_residual,
        "passive_hz": result.passive_hz,
        "violation": result.violation,
        "models": [
            {
                "model": c.fit.model.id,
                "J": c.fit.error,
                "aicc": _finite(c.aicc),
                "held_out": _finite(c.held_out),
                "parameters": c.fit.model.name_values(c.fit.parameters),
                "half_widths_95": {
                    key: _finite(width)
                    for key, width in c.fit.model.name_values(c.fit.half_widths()).items()
                },
            }
            for c in result.candidates
        ],
        "amplitude": [
            {**vars(effect), "significant": effect.significant}
            for effect in result.data.amplitude_effects
        ],
    }


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None


def _files(given: Sequence[Path]) -> list[Path]:
    """Files as they are, folders as the tables and signals in them."""
    files: list[Path] = []
    for path in given:
        inside = sorted(path.glob("*.csv")) if path.is_dir() else [path]
        if not inside:
            raise MaterialError(f"{path}: there is no .csv file in this folder")
        files += inside
    stems = [file.stem for file in files]
    for stem in stems:
        if stems.count(stem) > 1:
            raise MaterialError(f"two files are called {stem}: a specimen has its file's name")
    return files


def _check_folder(folder: Path) -> None:
    if not folder.is_dir():
        raise MaterialError(f"{folder}: there is no such folder")


def _show(console: Console, result: BushingResult) -> None:
    moduli = result.data.moduli
    table = Table(
        title=f"{result.name}: {len(moduli.frequency_hz)} frequencies,"
        f" {moduli.frequency_hz[0]:g} to {moduli.frequency_hz[-1]:g} Hz",
        title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False,
    )  # fmt: skip
    for heading in ("model", "free", "J", "rms, %", "ΔAICc", "held out, %"):
        table.add_column(heading, justify="left" if heading == "model" else "right")
    for c in result.candidates:
        table.add_row(
            c.fit.model.id,
            str(c.fit.count),
            f"{c.fit.error:.4g}",
            f"{100 * c.fit.rms:.2f}",
            f"{c.aicc - result.candidates[0].aicc:.1f}",
            f"{100 * c.held_out:.2f}",
        )
    console.print(table)
    best, widths = result.best, result.best.half_widths()
    for own, value, width in zip(best.model.coefficients, best.parameters, widths, strict=True):
        console.print(f"  {own.name} = {value:.5g} ± {width:.2g} {own.unit}", markup=False)
    found = result.consistency
    if not found.causal:
        console.print(
            "  ! dynamic and loss modulus cannot both be right: a causal specimen has them"
            f" {100 * found.disagreement:.2g} % apart",
            style="yellow", markup=False,
        )  # fmt: skip
    console.print(f"  {result.elements}", markup=False)
    for effect in result.data.amplitude_effects:
        if effect.significant:
            console.print(
                f"  ! at {effect.frequency_hz:.3g} Hz linear theory ends: stiffness"
                f" {100 * effect.per_doubling:+.2g} % per doubling of the amplitude",
                style="yellow", markup=False,
            )  # fmt: skip
