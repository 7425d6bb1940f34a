"""A functional mock-up unit: the car with all its laws, for any tool that imports FMI 2.0."""

from __future__ import annotations

import hashlib
import platform
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import CampaignError
from wheelhop.export.c_laws import in_c
from wheelhop.export.plant import Plant
from wheelhop.files import replacing

Array = NDArray[np.float64]
MODEL, SOURCE, HEADER = "wheelhop_car", "fmu.c", "model.h"
PLATFORMS = {
    "linux": ("linux64", ".so", ()),
    "darwin": ("darwin64", ".dylib", ()),
    "win32": ("win64", ".dll", ("-static-libgcc",)),
}
"""Folder of the binary, its suffix, and what the linker is told besides."""
UNITS = {
    "m_s2": ("m/s2", 'm="1" s="-2"'),
    "m_s": ("m/s", 'm="1" s="-1"'),
    "rad": ("rad", 'rad="1"'),
    "N": ("N", 'kg="1" m="1" s="-2"'),
    "m": ("m", 'm="1"'),
}
"""By the end of a signal's name: the unit's name in FMI, and its base units."""
COMPILES_S = 120.0


def write_fmu(plant: Plant, longest_step_s: float, title: str, file: Path) -> bool:
    """Write the unit: its description, its sources in C, and where there is a compiler its binary
    for this machine; whether there is one. It integrates in steps of at most `longest_step_s`.

    Raises CampaignError where a law cannot be written in C, the compiler fails, or the file cannot
    be written.
    """
    header = _header(plant, longest_step_s)
    source = (files(__package__) / SOURCE).read_text(encoding="utf-8")
    guid = hashlib.sha256((header + source).encode()).hexdigest()[:32]
    header += f'#define GUID "{guid}"\n'
    with TemporaryDirectory() as place:
        folder = Path(place)
        binary = _compiled(folder, header, source)
        with replacing(file, CampaignError) as draft, zipfile.ZipFile(draft, "w") as unit:
            unit.writestr("modelDescription.xml", "".join(_description(plant, guid, title)))
            unit.writestr(f"sources/{SOURCE}", source)
            unit.writestr(f"sources/{HEADER}", header)
            if binary is not None:
                unit.write(binary, f"binaries/{PLATFORMS[sys.platform][0]}/{binary.name}")
    return binary is not None


def _compiled(folder: Path, header: str, source: str) -> Path | None:
    """The shared library, if there is a compiler and this machine is one of `PLATFORMS`."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    usual = platform.machine().lower() in ("x86_64", "amd64") or sys.platform == "darwin"
    if compiler is None or sys.platform not in PLATFORMS or not usual:
        return None
    for name, text in ((SOURCE, source), (HEADER, header)):
        with replacing(folder / name, CampaignError) as draft:
            draft.write_text(text, encoding="utf-8")
    _, suffix, more = PLATFORMS[sys.platform]
    made = folder / f"{MODEL}{suffix}"
    words = [compiler, "-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", *more]
    done = subprocess.run(
        [*words, SOURCE, "-o", made.name, "-lm"],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=COMPILES_S,
        check=False,
    )
    if done.returncode:
        said = [line for line in done.stderr.splitlines() if "error" in line] or ["it says no why"]
        raise CampaignError(f"export: {compiler} does not compile the model: {said[0]}")
    return made


def _header(plant: Plant, longest_step_s: float) -> str:
    """Sizes, matrices by rows over z = (q, q̇, u, u̇, w, f), and laws with their numbers."""
    system, n = plant.system, len(plant.system.mass)
    motion, extension, shown = system.explicit
    wide = n + len(system.reads)
    columns = np.r_[:n, wide : wide + n, 2 * wide : motion.shape[1]]
    sizes = {
        "N": n,
        "M": system.input_stiffness.shape[1],
        "K": system.force.shape[1],
        "P": len(system.port),
        "N_INPUTS": len(plant.inputs),
        "N_OUTPUTS": len(plant.outputs),
    }
    lines = [f"#define {name} {size}" for name, size in sizes.items()]
    lines.append(f"#define LONGEST_STEP {longest_step_s!r}")
    lines.append(_matrix("MOTION", motion[:n, columns]))
    lines.append(_matrix("EXTENSION", extension[:, columns]))
    lines.append(_matrix("SHOWN", (shown @ motion)[:, columns]))
    lines.append(in_c(system.laws))
    count = len(system.port)
    names = ", ".join(f"law_{i}" for i in system.port_law) or "0"
    lines.append(
        "typedef double (*Law)(double, double, double, double, double, const double *, double *);"
    )
    lines.append(f"static const Law LAWS[{max(count, 1)}] = {{{names}}};")
    width = system.law_parameters.shape[1]
    numbers = ", ".join(f"{{{_numbers(row)}}}" for row in system.law_parameters) or "{0}"
    lines.append(f"static const double NUMBERS[{max(count, 1)}][{width}] = {{{numbers}}};")
    return "\n".join(lines) + "\n"


def _matrix(name: str, matrix: Array) -> str:
    rows = ",\n  ".join(_numbers(row) for row in matrix) or "0"
    return f"static const double {name}[{max(matrix.size, 1)}] = {{\n  {rows}}};"


def _numbers(row: Array) -> str:
    """Numbers as C reads them back to the last bit."""
    return ", ".join(
        repr(value) if np.isfinite(value) else ("INFINITY" if value > 0 else "-INFINITY")
        for value in row.tolist()
    )


def _description(plant: Plant, guid: str, title: str) -> Iterator[str]:
    """modelDescription.xml."""
    yield '<?xml version="1.0" encoding="UTF-8"?>\n'
    yield (
        f'<fmiModelDescription fmiVersion="2.0" modelName={quoteattr(title)} guid="{guid}"'
        f' generationTool="wheelhop {version("wheelhop")}"'
        ' variableNamingConvention="flat">\n'
        f'<CoSimulation modelIdentifier="{MODEL}" canHandleVariableCommunicationStepSize="true"'
        ' canInterpolateInputs="true" canGetAndSetFMUstate="true">\n'
        f'<SourceFiles><File name="{SOURCE}"/></SourceFiles>\n</CoSimulation>\n'
    )
    yield "<UnitDefinitions>\n"
    for unit, base in UNITS.values():
        yield f'<Unit name="{unit}"><BaseUnit {base}/></Unit>\n'
    yield "</UnitDefinitions>\n<ModelVariables>\n"
    for number, name in enumerate((*plant.inputs, *plant.outputs)):
        is_input = number < len(plant.inputs)
        causality = "input" if is_input else "output"
        start = ' start="0"' if is_input else ""
        yield (
            f'<ScalarVariable name="{name}" valueReference="{number}" causality="{causality}"'
            f' variability="continuous"><Real unit="{unit_of(name)}"{start}/></ScalarVariable>\n'
        )
    yield "</ModelVariables>\n<ModelStructure>\n"
    first = len(plant.inputs) + 1
    outputs = range(first, first + len(plant.outputs))
    for part in ("Outputs", "InitialUnknowns"):
        unknown = "".join(f'<Unknown index="{i}"/>' for i in outputs)
        yield f"<{part}>{unknown}</{part}>\n"
    yield "</ModelStructure>\n</fmiModelDescription>\n"


def unit_of(name: str) -> str:
    """The unit in which FMI knows a signal, from the end of its name."""
    return next(unit for ending, (unit, _) in UNITS.items() if name.endswith(f"_{ending}"))
