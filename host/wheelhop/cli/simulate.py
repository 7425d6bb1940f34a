"""`wheelhop simulate`: a vehicle on its way over tracks, as a campaign or a recording."""

from __future__ import annotations

from argparse import Namespace
from math import isfinite

from wheelhop.campaign import CampaignError
from wheelhop.cli.console import open_console
from wheelhop.cli.progress import stages
from wheelhop.effects import load_effects
from wheelhop.exchange import FORMATS
from wheelhop.predict import (
    Case,
    Instrument,
    make_campaign,
    make_recording,
    read_drives,
    read_effects,
)
from wheelhop.predict.case import SECONDS
from wheelhop.predict.instrument import NOISE_RMS_M_S2
from wheelhop.vehicle import read_vehicle

LONGEST_S = 600.0


def run(arguments: Namespace) -> int:
    """Simulate, write what was asked for, and print it; raises CampaignError."""
    case = _case(arguments)
    noise = NOISE_RMS_M_S2 if arguments.noise is None else arguments.noise
    if not 0.0 <= noise < 100.0:
        raise CampaignError(f"--noise {noise:g}: must be from 0 to 100 m/s²")
    instrument = Instrument(noise, arguments.logger)
    console, out = open_console(), arguments.out
    if out is not None:
        with stages() as progress:
            if out.suffix.lower() in FORMATS:
                make_recording(out, case, instrument)
            else:
                make_campaign(out, case, arguments.vehicle, instrument, progress)
        console.print(f"{out}: {_runs(case)} of {case.seconds:g} s", markup=False)
        if out.is_dir():
            console.print(f"Next: wheelhop compare {out}", markup=False)
    return 0


def _case(arguments: Namespace) -> Case:
    """What is asked for, checked."""
    seconds = SECONDS if arguments.seconds is None else arguments.seconds
    if not (isfinite(seconds) and 2.0 <= seconds <= LONGEST_S):
        raise CampaignError(f"--seconds {seconds:g}: must be from 2 to {LONGEST_S:g}")
    if arguments.seed < 0:
        raise CampaignError(f"--seed {arguments.seed}: must be a whole number from 0 up")
    vehicle = read_vehicle(arguments.vehicle)
    effects = read_effects(arguments.effects, load_effects(arguments.library))
    drives = read_drives(arguments.tracks, arguments.speed)
    return Case(vehicle, effects, drives, seconds, arguments.seed)


def _runs(case: Case) -> str:
    count = len(case.drives)
    return f"{count} run{'s' if count > 1 else ''}"
