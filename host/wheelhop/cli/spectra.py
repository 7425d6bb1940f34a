"""`wheelhop spectra`: runs on a road known by its spectrum, as spectra (thesis 4.52 ff.)."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from typing import Any

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from wheelhop.campaign import AXLE_POINTS, CampaignError, ComponentCampaign, read_campaign
from wheelhop.cli.output import open_console, write_json
from wheelhop.cli.show import print_findings
from wheelhop.effects import load_effects
from wheelhop.files.words import percent
from wheelhop.fit import initial_model
from wheelhop.gate import gate
from wheelhop.predict.known_car import MODEL_FILE
from wheelhop.predict.road_spectra import RoadRun, road_spectra
from wheelhop.report.model_file import read_model
from wheelhop.track.spectrum import RoadSpectrum
from wheelhop.vehicle import read_vehicle


def run(arguments: Namespace) -> int:
    """Compare, print, and write what was asked for; raises CampaignError."""
    campaign = read_campaign(arguments.campaign)
    if isinstance(campaign, ComponentCampaign):
        raise CampaignError(f"{campaign.folder}: is a component on a rig, which meets no road")
    vehicle = read_vehicle(campaign.vehicle_file)
    gated, console = gate(campaign, vehicle), open_console()
    print_findings(gated.findings, console)
    campaign, stored = gated.campaign, campaign.folder / MODEL_FILE
    fitted = stored.exists()
    model = read_model(stored, load_effects()) if fitted else initial_model(campaign, vehicle)
    road = None if arguments.road is None else RoadSpectrum(*arguments.road)
    found = road_spectra(campaign, model, road)
    console.print(f"model: {stored if fitted else campaign.vehicle_file}", markup=False)
    if len(model.system(campaign.channels, "road").port):
        console.print("Its force laws are not linear and left out.")
    _show(found, console)
    if arguments.json is not None:
        write_json(arguments.json, {"format": 1, "runs": [to_json(one) for one in found]})
    if arguments.figure is not None:
        from wheelhop.report.spectra import draw_spectra

        draw_spectra(found, arguments.figure)
        console.print(f"figure: {arguments.figure}", markup=False)
    return 0


def _show(found: Sequence[RoadRun], console: Console) -> None:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("run", overflow="fold")
    table.add_column("point")
    for heading in (
        *("rms\nis / expected", "largest\nis / expected"),
        *("rises a second\nis / expected", "bands within\nchance"),
    ):
        table.add_column(heading, justify="right")
    for one in found:
        (rms, expected), (peak, rises) = one.rms(), one.peaks()
        largest, crossed = one.shown_peaks()
        for i, channel in enumerate(one.channels):
            table.add_row(
                Text(one.run.id if i == 0 else ""),
                Text(f"{channel.name}, {channel.unit}"),
                f"{rms[i]:.2f} / {expected[i]:.2f}",
                f"{largest[i]:.1f} / {peak[i]:.1f}",
                f"{crossed[i]:.1f} / {rises[i]:.1f}",
                f"{int(one.inside[:, i].sum())} of {len(one.inside)}",
            )
    console.print(table)
    share = float(np.mean(np.concatenate([one.inside.ravel() for one in found])))
    console.print(
        f"{percent(share, 2)} of all thirds of an octave lie within what chance makes of a right"
        " model and road (95 %)."
    )
    for one in found:
        pair = _behind(one)
        if pair is not None:
            is_s, expected_s = one.delay_s(*pair)
            names = [one.channels[i].name for i in pair]
            console.print(
                f"{one.run.id}: {names[1]} comes {is_s:.3f} s after {names[0]}; at this speed"
                f" {expected_s:.3f} s",
                markup=False,
            )


def _behind(one: RoadRun) -> tuple[int, int] | None:
    """A front axle point, and the rear one of its side."""
    at = {channel.point: i for i, channel in enumerate(one.channels)}
    for front, rear in zip(AXLE_POINTS[:2], AXLE_POINTS[2:], strict=True):
        if front in at and rear in at:
            return at[front], at[rear]
    return None


def to_json(one: RoadRun) -> dict[str, Any]:
    """A run for programs: spectra in thirds of an octave, coherence of the first channel with the
    others."""
    (low, high), (rms, expected), (peak, rises) = one.chance, one.rms(), one.peaks()
    largest, crossed = one.shown_peaks()
    across = [one.coherence(0, i) for i in range(len(one.channels))]
    return {
        "run": one.run.id,
        "channels": [channel.name for channel in one.channels],
        "frequency_hz": one.middle_hz.tolist(),
        "chance": [low.tolist(), high.tolist()],
        "density": {
            "measured": one.measured_density.T.tolist(),
            "expected": one.predicted_density.T.tolist(),
        },
        "rms": {"measured": rms.tolist(), "expected": expected.tolist()},
        "largest": {"measured": largest.tolist(), "expected": peak.tolist()},
        "rises_per_s": {"measured": crossed.tolist(), "expected": rises.tolist()},
        "coherence_with_first": {
            "measured": [measured.tolist() for measured, _ in across],
            "expected": [foretold.tolist() for _, foretold in across],
        },
    }
