"""`wheelhop identify STEPS.csv`: damped sinusoids and H(s) from step responses."""

from __future__ import annotations

from argparse import Namespace

from rich import box
from rich.table import Table

from wheelhop.campaign import CampaignError
from wheelhop.cli.identify_study import print_car
from wheelhop.cli.output import open_console, write_json
from wheelhop.identify import (
    car_of_steps,
    fit_damped_sinusoids,
    read_steps,
    write_mat_of_states,
)
from wheelhop.vehicle import read_vehicle

CAMPAIGNS_ONLY = ("start", "physics", "figure", "frf", "fore_aft", "report")
MOST = 3
"""Damped sinusoids tried when no order is given, as in Table 2.1 of the thesis."""


def run_steps(arguments: Namespace) -> int:
    """Fit, print σ and ω for each number of sinusoids, export; raises CampaignError."""
    if arguments.order is not None and arguments.order % 2:
        raise CampaignError(f"--order {arguments.order}: damped sinusoids come in pairs of poles")
    given = [name for name in CAMPAIGNS_ONLY if getattr(arguments, name)]
    if given:
        raise CampaignError(
            f"--{given[0].replace('_', '-')} is for campaigns: leave it out with step responses"
        )
    steps = read_steps(arguments.source, arguments.force_N)
    counts = [arguments.order // 2] if arguments.order else list(range(1, MOST + 1))
    table = Table(box=box.SIMPLE_HEAD)
    for name in ("sinusoids", "σ, 1/s", "ω, rad/s", "error"):
        table.add_column(name, justify="right")
    fits = []
    for count in counts:
        found = fit_damped_sinusoids(
            steps.time_s, steps.responses, count, starts_at_rest=arguments.rigid
        )
        fits.append(found)
        for k in range(count):
            first = (f"{count}", f"{found.error:.2e}") if k == 0 else ("", "")
            table.add_row(first[0], f"{found.sigma[k]:.3f}", f"{found.omega[k]:.3f}", first[1])
    console = open_console()
    console.print(table)
    if arguments.study or arguments.half_car:
        if arguments.vehicle is None:
            raise CampaignError(
                "--study and --half-car of step responses need --vehicle VEHICLE.toml: the"
                " suspensions the body was on, and its wheels"
            )
        values = read_vehicle(arguments.vehicle).values
        print_car(arguments, car_of_steps(fits[-1], values), console)
    if arguments.mat:
        last = fits[-1]
        system = last.transfer(len(steps.points), len(steps.forces))
        exponents = {"sigma": last.sigma, "omega": last.omega}
        write_mat_of_states(system, steps.forces, steps.points, arguments.mat, exponents)
    if arguments.json:
        write_json(
            arguments.json,
            {
                "format": 1,
                "points": list(steps.points),
                "forces": list(steps.forces),
                "fits": [
                    {
                        "sigma_1_s": fit.sigma.tolist(),
                        "omega_rad_s": fit.omega.tolist(),
                        "residues": fit.residues.tolist(),
                        "error": fit.error,
                    }
                    for fit in fits
                ],
            },
        )
    return 0
