"""Poles between axle and body beside the true ones: python -m benchmarks.identify_poles CAMPAIGN…

For campaigns whose truth.toml has the vehicle and hides nothing between axle and body. Every order
is fitted; each true mode is held against the nearest one found, with its standard error: what 18
runs do not tell better than that, no estimate can.

`--draws N` asks whether that standard error is honest: the campaign's runs are simulated again by
tests/truth, get N other noises, and the mean and scatter of the poles stand beside the standard
error; and, to see what sampling does, without noise at the campaign's rate and at ten times that.
Without a campaign the same is asked of runs made from the thesis's H(s).
"""

from __future__ import annotations

import argparse
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.truth import CHANNELS, read_truth, simulate_run
from wheelhop.campaign import Campaign, read_campaign
from wheelhop.fit import initial_model
from wheelhop.identify import (
    Structure,
    Suspensions,
    TransferMatrix,
    candidate,
    identify,
    measure,
    suspensions,
)
from wheelhop.identify.identify import WASTED
from wheelhop.identify.published import TABLE_5_2
from wheelhop.identify.spectra import spectra
from wheelhop.identify.synthetic import thesis_runs
from wheelhop.vehicle import Vehicle, read_vehicle

Array = NDArray[np.float64]
Modes = list[tuple[float, float]]

ORDERS = (6, 8, 10, 12, 14)


def main() -> None:
    """Print a table for each campaign."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("campaigns", nargs="*", type=Path)
    parser.add_argument("--draws", type=int, default=0, metavar="N", help="noises to draw")
    asked = parser.parse_args()
    if asked.draws and not asked.campaigns:
        thesis_draws(asked.draws)
    for folder in asked.campaigns:
        campaign = read_campaign(folder)
        vehicle = read_vehicle(campaign.vehicle_file)
        truth = tomllib.loads((folder / "truth.toml").read_text(encoding="utf-8"))
        modes = true_modes(campaign, vehicle, dict(flat(truth["vehicle_true"])))
        measured = measure(campaign)
        belief = suspensions(vehicle.values, vehicle.uncertainty)
        if asked.draws:
            campaign_draws(folder, campaign, belief, modes, asked.draws)
            continue
        for order in ORDERS:
            found = candidate(measured, Structure(), order, belief)
            judged = found.judging
            print(
                f"{folder.name}, {order} poles asked for, {found.order} kept: error"
                f" {judged.error:.4f}, noise {judged.floor:.4f}"
            )
            for (hz, zeta), (f, df, z, dz) in zip(modes, off(found.model, modes), strict=True):
                print(
                    f"  {hz:.3f} Hz, ζ {zeta:.4f}: {f:+.2f} % (s.e. {df:.2f} %),"
                    f" ζ {z:+.1f} % (s.e. {dz:.1f} %)"
                )


def off(model: TransferMatrix, modes: Modes) -> Array:
    """How far the nearest pole is from each mode, and its standard error, in frequency and in
    damping (modes, 4), per cent."""
    rows = np.array([row for row in model.poles_table() if row[2] <= WASTED])
    out = []
    for hz, zeta in modes:
        away = np.abs(np.log(rows[:, 0] / hz)) + np.abs(rows[:, 2] - zeta)
        f, df, z, dz = rows[int(np.argmin(away))]
        out.append([f / hz - 1, df / hz, z / zeta - 1, dz / zeta])
    return 100 * np.array(out)


def campaign_draws(
    folder: Path, campaign: Campaign, belief: Suspensions, modes: Modes, count: int
) -> None:
    """Print what many noises make of the runs to fit, and what sampling does without any."""
    truth = read_truth(folder)
    level = tomllib.loads((folder / "truth.toml").read_text(encoding="utf-8"))["noise"]
    sd = np.array([level[name] for name in CHANNELS])
    runs = {run.id: truth.runs[run.id] for run in campaign.fit_runs}

    def sampled(times: int) -> Array:
        fine = [
            replace(r, time_s=np.arange(len(r.time_s) * times) / (campaign.sample_rate_hz * times))
            for r in runs.values()
        ]
        return np.stack([simulate_run(truth.vehicle, r, truth.effects)[1] for r in fine])

    def fitted(records: Array, rate_hz: float, noise_rms: float | None) -> Array:
        both = records[:, :, 4:], records[:, :, :4]
        of = spectra(*both, rate_hz, campaign.band_hz)
        return off(identify([of], order=6, suspensions=belief, noise_rms=noise_rms), modes)

    rate, exact = campaign.sample_rate_hz, sampled(1)
    print(f"{folder.name}, without noise, at {rate:g} and at {10 * rate:g} Hz")
    for slow, fast in zip(
        fitted(exact, rate, None), fitted(sampled(10), 10 * rate, None), strict=True
    ):
        print(f"  {slow[0]:+.2f} %, ζ {slow[2]:+.2f} %; {fast[0]:+.2f} %, ζ {fast[2]:+.2f} %")
    rng = np.random.default_rng(1)
    _scatter(
        f"{folder.name}, {count} noises",
        np.stack(
            [
                fitted(exact + sd * rng.standard_normal(exact.shape), rate, campaign.noise_rms)
                for _ in range(count)
            ]
        ),
    )


def thesis_draws(count: int) -> None:
    """Print what many noises make of runs of the thesis's H(s)."""
    modes = list(zip(TABLE_5_2.frequency_hz.tolist(), TABLE_5_2.zeta.tolist(), strict=True))
    structure = Structure("symmetric", rigid=False)
    for noise in (0.01, 0.1):
        found = [
            off(identify([thesis_runs(noise, seed=seed)], structure, order=8), modes)
            for seed in range(1, count + 1)
        ]
        _scatter(f"H(s) of D.2, {noise:.0%} noise, {count} noises", np.stack(found))


def _scatter(what: str, found: Array) -> None:
    mean, sd = found.mean(axis=0), found.std(axis=0, ddof=1)
    print(f"{what}: mean, scatter, mean standard error")
    for m, s in zip(mean, sd, strict=True):
        hz, zeta = ((m[i], s[i], m[i + 1]) for i in (0, 2))
        print("  {:+.2f} %, {:.2f} %, {:.2f} %; ζ {:+.2f} %, {:.2f} %, {:.2f} %".format(*hz, *zeta))


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
