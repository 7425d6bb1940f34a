"""`wheelhop identify`: a transfer matrix from axle to body motion, or from step responses."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from typing import Any

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from wheelhop.campaign import Campaign, CampaignError, ComponentCampaign, read_campaign
from wheelhop.cli.identify_frf import run_frf
from wheelhop.cli.identify_steps import run_steps
from wheelhop.cli.identify_study import print_car
from wheelhop.cli.output import open_console, write_json
from wheelhop.cli.show import print_findings
from wheelhop.fit import initial_model
from wheelhop.gate import gate
from wheelhop.identify import (
    Candidate,
    Judged,
    Measured,
    Sections,
    Structure,
    Suspensions,
    best,
    candidate,
    car_of,
    measure,
    not_excited,
    of_orders,
    predict,
    relaxed,
    suspensions,
    to_json,
    write_mat,
)
from wheelhop.identify.linear import LASTING
from wheelhop.identify.physical import physical_matrix
from wheelhop.report.identified import write_identified_report
from wheelhop.vehicle import CORNERS, Vehicle, read_vehicle, wheels


def run(arguments: Namespace) -> int:
    """Fit, judge on held-out runs, print, draw and export; raises CampaignError."""
    if arguments.bushing and not (arguments.study or arguments.half_car):
        raise CampaignError("--bushing: what is asked of the car with it? --study or --half-car")
    if arguments.source.is_file():
        return run_steps(arguments)
    campaign = read_campaign(arguments.source)
    if isinstance(campaign, ComponentCampaign):
        raise CampaignError(
            f"{campaign.folder}: is a component on a rig; a transfer matrix needs axles and a body"
        )
    vehicle = read_vehicle(campaign.vehicle_file)
    if wheels(vehicle.values) != CORNERS:
        raise CampaignError(
            f"{campaign.vehicle_file}: has no four wheels; a transfer matrix is that of a full car"
        )
    gated, console = gate(campaign, vehicle), open_console()
    print_findings(gated.findings, console)
    campaign = gated.campaign
    measured = measure(campaign, fore_aft=arguments.fore_aft)
    if arguments.frf:
        return run_frf(arguments, campaign, measured, console)
    belief = suspensions(vehicle.values, vehicle.uncertainty)
    structure = Structure(
        arguments.structure, arguments.left_right, arguments.rigid, arguments.stable
    )
    candidates = _candidates(arguments, measured, structure, belief)
    chosen = best(candidates)
    _print_model(chosen, candidates, measured, console)
    _print_tracks(campaign, chosen, console)
    physics = _physics(measured, chosen, belief) if arguments.physics else {}
    if physics:
        _print_physics(physics, console)
    _write(arguments, campaign, vehicle, chosen, candidates, physics, measured)
    if arguments.study or arguments.half_car:
        print_car(arguments, car_of(chosen.model, vehicle.values), console)
    return 0


def _candidates(
    arguments: Namespace, measured: Measured, structure: Structure, belief: Suspensions
) -> list[Candidate]:
    if arguments.start is not None:
        numbers = np.array(arguments.start)
        start = Sections(2 * np.pi * numbers[:, 0], numbers[:, 1])
        return [candidate(measured, structure, start.order, belief, start)]
    if arguments.order is not None:
        return [candidate(measured, structure, arguments.order, belief)]
    return of_orders(measured, structure, belief)


def _print_model(
    chosen: Candidate, candidates: Sequence[Candidate], measured: Measured, console: Console
) -> None:
    if len(candidates) > 1:
        table = Table(box=box.SIMPLE_HEAD)
        table.add_column("poles", justify="right")
        table.add_column("kept", justify="right")
        for name in ("unknowns", "BIC", "AICc", "error fit", "held out", "floor"):
            table.add_column(name, justify="right")
        bic, aicc = min(c.bic for c in candidates), min(c.aicc for c in candidates)
        for c in candidates:
            held = "–" if c.validate is None else f"{c.validate.error:.4f}"
            mark = "←" if c is chosen else ""
            table.add_row(
                *(f"{c.asked}", f"{c.order}", f"{c.model.unknowns}"),
                *(f"+{c.bic - bic:.0f}", f"+{c.aicc - aicc:.0f}"),
                *(f"{c.fit.error:.4f}", held, f"{_floor(c.judging)} {mark}"),
            )
        console.print(table)
    table = Table(box=box.SIMPLE_HEAD)
    for name in ("mode", "frequency, Hz", "± 1 s.e.", "damping ratio", "± 1 s.e."):
        table.add_column(name, justify="right")
    table.add_column()
    longest_s = max(2 * np.pi / (part.omega[1] - part.omega[0]) for part in measured.fit)
    for number, (f, df, z, dz) in enumerate(sorted(chosen.model.poles_table()), start=1):
        rings = 2 * np.pi * f * z * longest_s < LASTING
        remark = "may be a driven line" if rings else "overdamped" if z >= 1.0 else ""
        table.add_row(f"{number}", f"{f:.3f}", f"{df:.3f}", f"{z:.4f}", f"{dz:.4f}", remark)
    console.print(table)
    for sentence in _judgement(chosen, measured):
        console.print(sentence)
    if len(candidates) == 1 and chosen.order < chosen.asked:
        console.print(
            f"{chosen.asked} poles were asked for; the runs do not need more than {chosen.order}"
        )


def _judgement(chosen: Candidate, measured: Measured) -> list[str]:
    """How far the matrix errs, and what of it no run has shown."""
    held = "runs held out" if chosen.validate else "fitted runs (none is held out)"
    judged = chosen.judging
    return [
        f"order {chosen.order}: error {judged.error:.4f} on {held};"
        f" noise alone leaves {_floor(judged)}",
        *(
            f"the axles never move {motion}: what H says of it is not measured"
            for motion in not_excited(measured.fit, measured.noise_rms)
        ),
    ]


def _floor(judged: Judged) -> str:
    return f"{judged.floor:.4f}" if np.isfinite(judged.floor) else "unknown"


def _print_tracks(campaign: Campaign, chosen: Candidate, console: Console) -> None:
    table = Table(box=box.SIMPLE_HEAD, title="residual over measured, each run's by track")
    table.add_column("track")
    table.add_column("runs", justify="right")
    for corner in chosen.model.outputs:
        table.add_column(f"B{corner + 1}", justify="right")
    table.add_column("all", justify="right")
    for kind, count, by_output, overall in tracks(campaign, chosen):
        table.add_row(kind, f"{count}", *(f"{e:.4f}" for e in by_output), f"{overall:.4f}")
    console.print(table)


def tracks(campaign: Campaign, chosen: Candidate) -> list[tuple[str, int, list[float], float]]:
    """Track kind, number of runs, error of each output and of all, over all runs."""
    kind = {run.id: run.track.kind for run in campaign.runs}
    judged = [j for j in (chosen.fit, chosen.validate) if j is not None]
    names = [name for j in judged for name in j.runs]
    residual = np.concatenate([j.residual for j in judged])
    power = np.concatenate([j.measured for j in judged])
    out = []
    for one in dict.fromkeys(kind.values()):
        rows = [i for i, name in enumerate(names) if kind[name] == one]
        per = np.sqrt(residual[rows].sum(axis=0) / np.maximum(power[rows].sum(axis=0), 1e-300))
        overall = float(np.sqrt(residual[rows].sum() / max(power[rows].sum(), 1e-300)))
        out.append((one, len(rows), per.tolist(), overall))
    return out


def _physics(measured: Measured, chosen: Candidate, belief: Suspensions) -> dict[str, Candidate]:
    """The chosen structure, and it with one piece of physics changed at a time."""
    return {
        name: candidate(measured, structure, chosen.order, belief)
        for name, structure in relaxed(chosen.model.structure).items()
    }


def _print_physics(physics: dict[str, Candidate], console: Console) -> None:
    table = Table(box=box.SIMPLE_HEAD, title="what each piece of physics does")
    table.add_column("structure")
    for name in ("unknowns", "error fit", "error held out"):
        table.add_column(name, justify="right")
    for name, c in physics.items():
        held = "–" if c.validate is None else f"{c.validate.error:.4f}"
        table.add_row(name, f"{c.model.unknowns}", f"{c.fit.error:.4f}", held)
    console.print(table)


def _write(
    arguments: Namespace,
    campaign: Campaign,
    vehicle: Vehicle,
    chosen: Candidate,
    candidates: Sequence[Candidate],
    physics: dict[str, Candidate],
    measured: Measured,
) -> None:
    physical = initial_model(campaign, vehicle)
    if arguments.report:
        said, predicted = _judgement(chosen, measured), predict(chosen.model, measured)
        write_identified_report(arguments.report, campaign, chosen, physical, predicted, said)
    if arguments.json:
        write_json(
            arguments.json,
            {
                "format": 1,
                **to_json(chosen.model),
                **_errors(chosen),
                "not_excited": list(not_excited(measured.fit, measured.noise_rms)),
                "tracks": [
                    {"track": kind, "runs": count, "error": error, "by_output": by_output}
                    for kind, count, by_output, error in tracks(campaign, chosen)
                ],
                "orders": [
                    {"order": c.asked, "kept": c.order, "bic": c.bic, "aicc": c.aicc, **_errors(c)}
                    for c in candidates
                ],
                "physics": {name: _errors(c) for name, c in physics.items()},
            },
        )
    if arguments.mat:
        write_mat(chosen.model, arguments.mat)
    if arguments.figure:
        low, high = campaign.band_hz
        frequency = np.geomspace(low, high, 300)
        from wheelhop.report.transfer_figures import draw_matrix

        nominal = physical_matrix(campaign.channels, physical, chosen.model, frequency)
        draw_matrix(chosen.model, nominal, frequency, arguments.figure)


def _errors(c: Candidate) -> dict[str, Any]:
    floor = c.judging.floor
    return {
        "error_fit": c.fit.error,
        "error_validate": None if c.validate is None else c.validate.error,
        "floor": floor if np.isfinite(floor) else None,
        "unknowns": c.model.unknowns,
    }
