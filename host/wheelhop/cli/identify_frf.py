"""`wheelhop identify CAMPAIGN --frf`: frequency responses without a model, with their coherence."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import Any

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from wheelhop.campaign import BODY_POINTS, Campaign, CampaignError
from wheelhop.cli.output import write_json
from wheelhop.files import replacing
from wheelhop.identify import Frf, Measured, frf, not_excited
from wheelhop.identify.structure import input_name


def run_frf(arguments: Namespace, campaign: Campaign, measured: Measured, console: Console) -> int:
    """Estimate from all runs, print coherence, draw and export; raises CampaignError."""
    found = frf([*measured.fit, *measured.validate], arguments.frf, lines=arguments.frf_lines)
    inside = _in_band(campaign, found)
    _print(arguments.frf, measured, found, inside, console)
    if arguments.json:
        write_json(arguments.json, as_json(arguments.frf, measured, found, inside))
    if arguments.mat:
        _write_mat(arguments.mat, measured, found, inside)
    if arguments.figure:
        from wheelhop.report.transfer_figures import draw_frf

        draw_frf(found, measured, inside, arguments.figure)
    return 0


def _in_band(campaign: Campaign, found: Frf) -> Any:
    """The lines (k,) in the campaign's band."""
    frequency = found.omega / (2 * np.pi)
    low, high = campaign.band_hz
    return (low <= frequency) & (frequency <= high)


def _names(measured: Measured) -> tuple[list[str], list[str]]:
    return [input_name(c) for c in measured.inputs], [BODY_POINTS[c] for c in measured.outputs]


def _print(kind: str, measured: Measured, found: Frf, inside: Any, console: Console) -> None:
    inputs, outputs = _names(measured)
    table = Table(
        box=box.SIMPLE_HEAD, title=f"{kind} from {', '.join(inputs)}", title_justify="left"
    )
    for heading in ("output", "coherence", "from", "to", "relative s.e."):
        table.add_column(heading, justify="left" if heading == "output" else "right")
    for row, name in enumerate(outputs):
        coherence = found.coherence[inside, row]
        size = np.sqrt(np.mean(np.abs(found.matrix[inside, row]) ** 2))
        error = np.sqrt(np.mean(found.standard_error[inside, row] ** 2))
        table.add_row(
            name,
            *(f"{x:.4f}" for x in (np.median(coherence), coherence.min(), coherence.max())),
            f"{100 * error / size:.2g} %",
        )
    console.print(table)
    console.print(
        f"{int(inside.sum())} lines, {found.averages:.0f} independent samples at each;"
        " coherence: its median, least and largest in band"
    )
    for motion in not_excited(measured.fit, measured.noise_rms):
        console.print(f"the axles never move {motion}: what H says of it is not measured")


def as_json(kind: str, measured: Measured, found: Frf, inside: Any) -> dict[str, Any]:
    """The estimate for programs: matrices are lists over lines, outputs and inputs."""
    inputs, outputs = _names(measured)
    return {
        "format": 1,
        "kind": kind,
        "inputs": inputs,
        "outputs": outputs,
        "averages": found.averages,
        "frequency_hz": (found.omega[inside] / (2 * np.pi)).tolist(),
        "real": found.matrix[inside].real.tolist(),
        "imag": found.matrix[inside].imag.tolist(),
        "standard_error": found.standard_error[inside].tolist(),
        "coherence": found.coherence[inside].tolist(),
    }


def _write_mat(path: Path, measured: Measured, found: Frf, inside: Any) -> None:
    from scipy.io import savemat

    inputs, outputs = _names(measured)
    with replacing(path, CampaignError) as draft:
        savemat(
            draft,
            {
                "frequency_hz": found.omega[inside] / (2 * np.pi),
                # As MATLAB's frd takes it: outputs, inputs, lines.
                "H": found.matrix[inside].transpose(1, 2, 0),
                "standard_error": found.standard_error[inside].transpose(1, 2, 0),
                "coherence": found.coherence[inside],
                "inputs": inputs,
                "outputs": outputs,
            },
            appendmat=False,
        )
