"""Poles between axle and body beside the true ones: python -m benchmarks.identify_poles CAMPAIGN…

For campaigns whose truth.toml has the vehicle and hides nothing between axle and body. Every order
is fitted; each true mode is held against the nearest one found, with its standard error: what 18
runs do not tell better than that, no estimate can.
"""

from __future__ import annotations

import argparse
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from wheelhop.campaign import Campaign, read_campaign
from wheelhop.fit import initial_model
from wheelhop.identify import Structure, candidate, measure, suspensions
from wheelhop.identify.identify import WASTED
from wheelhop.vehicle import Vehicle, read_vehicle

ORDERS = (6, 8, 10, 12, 14)


def main() -> None:
    """Print a table for each campaign."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("campaigns", nargs="+", type=Path)
    for folder in parser.parse_args().campaigns:
        campaign = read_campaign(folder)
        vehicle = read_vehicle(campaign.vehicle_file)
        truth = tomllib.loads((folder / "truth.toml").read_text(encoding="utf-8"))
        modes = true_modes(campaign, vehicle, dict(flat(truth["vehicle_true"])))
        measured = measure(campaign)
        for order in ORDERS:
            belief = suspensions(vehicle.values, vehicle.uncertainty)
            found = candidate(measured, Structure(), order, belief)
            judged = found.judging
            print(
                f"{folder.name}, {order} poles asked for, {found.order} kept: error"
                f" {judged.error:.4f}, noise {judged.floor:.4f}"
            )
            rows = np.array([row for row in found.model.poles_table() if row[2] <= WASTED])
            for hz, zeta in modes:
                away = np.abs(np.log(rows[:, 0] / hz)) + np.abs(rows[:, 2] - zeta)
                f, df, z, dz = rows[int(np.argmin(away))]
                print(
                    f"  {hz:.3f} Hz, ζ {zeta:.4f}: {100 * (f / hz - 1):+.2f} %"
                    f" (s.e. {100 * df / hz:.2f} %), ζ {100 * (z / zeta - 1):+.1f} %"
                    f" (s.e. {100 * dz / zeta:.1f} %)"
                )


def flat(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, float]]:
    """Nested tables as dotted keys."""
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from flat(value, f"{prefix}{key}.")
        else:
            yield prefix + key, float(value)


def true_modes(
    campaign: Campaign, vehicle: Vehicle, true: Mapping[str, float]
) -> list[tuple[float, float]]:
    """Frequency, Hz, and damping ratio of the body on its suspension, axles prescribed."""
    known = {key: value for key, value in true.items() if key in vehicle.values}
    actual = replace(vehicle, values={**vehicle.values, **known})
    poles = initial_model(campaign, actual).system(campaign.channels, "axles").poles()
    upper = poles[poles.imag > 0]
    return sorted((float(abs(p)) / (2 * np.pi), float(-p.real / abs(p))) for p in upper)


if __name__ == "__main__":
    main()
