"""`wheelhop emulate`: an emulated logger, for trying out a day in the field."""

from __future__ import annotations

import sys
from argparse import Namespace
from pathlib import Path
from threading import Event
from typing import TypeGuard

from wheelhop.campaign import read_campaign
from wheelhop.campaign.selection import run_of
from wheelhop.hil_sim.day import drive_lines, read_day
from wheelhop.hil_sim.double.codes import STROKE_M, from_campaign, inputs_of
from wheelhop.hil_sim.emulated import Acts, emulated_logger
from wheelhop.hil_sim.on_rigs import on_rig
from wheelhop.hil_sim.signals import CODES
from wheelhop.logger.error import LoggerError


def run(arguments: Namespace) -> int:
    """Serve until Ctrl-C; Enter presses the logger's button. Raises LoggerError."""
    if not 0.01 <= arguments.factor <= 1000.0:
        raise LoggerError(f"--factor {arguments.factor:g}: must be from 0.01 to 1000")
    card = arguments.card
    if card is not None and not card.is_dir():
        raise LoggerError(f"{card}: there is no such folder")
    if arguments.campaign is None and arguments.run is not None:
        raise LoggerError("--run is of a campaign: give --campaign, too")
    if arguments.on and (arguments.campaign or arguments.files is None):
        raise LoggerError("--on stands on a rig: give --files FOLDER for its files, no --campaign")
    if arguments.files is not None and not arguments.on:
        raise LoggerError("--files is for the files of a rig: give --on shaker or --on beam, too")
    acts: Acts = ()
    drives = drive_lines(read_day().drives)
    if arguments.on:
        acts, drives = (on_rig(arguments.on, arguments.files),), ()
    elif arguments.campaign is not None:
        acts = _of_campaign(arguments.campaign, arguments.run)
        drives = (_as_driven(arguments.campaign, arguments.run),)
    with emulated_logger(card, arguments.factor, acts) as (double, acts):
        print(
            f"An emulated logger is at {double.url}; its time runs {arguments.factor:g} times"
            " faster. wheelhop logger, record and download find it by themselves."
        )
        for number, (words, signals) in enumerate(acts, start=1):
            seconds = len(signals.codes) / signals.rate_hz
            print(f"session {number}: {words}; {seconds / arguments.factor:.0f} s")
        for line in drives:
            print(f"  {line}")
        print("Enter presses its button: start, stop. Ctrl-C switches it off.", flush=True)
        for _ in sys.stdin:
            double.press_button()
            print("pressed", flush=True)
        Event().wait()  # nobody at the keyboard: until it is interrupted
    return 0


def _as_driven(folder: Path, run: str | None) -> str:
    """Track and speed of a campaign's run, in SI but for the speed."""
    campaign = read_campaign(folder)
    one = run_of(campaign, run) if run else campaign.runs[0]
    values = [f"{key}={value:g}" for key, value in one.track.values.items() if _is_told(value)]
    how = " ".join([one.track.kind, *values])
    return f"{one.id} ({one.role}): {how} at {3.6 * one.speed_m_s:.3g} km/h"


def _is_told(value: float | str) -> TypeGuard[float]:
    return not isinstance(value, str) and value != 0


def _of_campaign(folder: Path, run: str | None) -> Acts:
    """One session, again and again: a run of a campaign, by default its first."""
    campaign = read_campaign(folder)
    run = run or campaign.runs[0].id
    places = inputs_of(campaign).items()
    shown = ", ".join(f"A{place} {campaign.channels[k].name}" for k, place in places)
    if any(campaign.channels[k].quantity == "travel" for k, _ in places):
        shown += f"; a potentiometer's {1e3 * STROKE_M:g} mm are codes 0 to {CODES}"
    return ((f"run {run} again and again, at inputs {shown}", from_campaign(folder, run)),)
