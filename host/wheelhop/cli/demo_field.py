"""The first half of the demo: from sensors' voltages to a campaign, through a logger."""

from __future__ import annotations

import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import wheelhop.hil_sim as simulated
from wheelhop.calibration import Constants, write_constants
from wheelhop.calibration.flip import flip_calibration
from wheelhop.calibration.session import read_session
from wheelhop.campaign.activity import stretches
from wheelhop.campaign.read import CONSTANTS_FILE
from wheelhop.campaign.recorded import read_recording
from wheelhop.campaign.write import NewRun, add_run, cut, new_campaign
from wheelhop.files import write_text
from wheelhop.hil_sim.day import Day
from wheelhop.hil_sim.signals import Signals
from wheelhop.hil_sim.stand_in import stand_in
from wheelhop.logger.download import Downloader
from wheelhop.logger.error import LoggerError
from wheelhop.logger.link import connect

TURNED, DRIVEN, CARD = "turned.hop", "driven.hop", "card"
MARGIN_S = 1.0  # of logger time, for its start
BUILD = Path(simulated.__file__).parents[3] / "tools" / "firmware_build.py"
ELF = BUILD.parents[1] / "build" / "firmware" / "nano" / "firmware.elf"


@dataclass(frozen=True)
class Recorded:
    """How a session went, as the logger's summary tells."""

    file: Path
    due: int
    lost: int


def find_firmware() -> Path | None:
    """The firmware for the simulated board, built if need be; None without the tools for it."""
    if not (BUILD.exists() and shutil.which("avr-g++") and shutil.which("gcc")):
        return None
    built = subprocess.run([sys.executable, str(BUILD), "nano"], capture_output=True, text=True)
    if built.returncode or not ELF.exists():
        return None
    try:
        simulated.Board(ELF, powered=False).close()
    except simulated.SimulationError:  # no simavr
        return None
    return ELF


def record(signals: Signals, folder: Path, name: str, elf: Path | None) -> Recorded:
    """Let a logger record these signals, fetch its log over the line, and keep it as `name`."""
    card = folder / CARD
    card.mkdir(parents=True, exist_ok=True)
    seconds = len(signals.codes) / signals.rate_hz
    with stand_in(signals, card, elf) as logger:
        downloader = Downloader(connect(logger.url))
        try:
            link = downloader.link
            link.set_time()
            file = link.start()
            logger.wait(seconds - MARGIN_S)
            link.stop()
            status = link.status()
            downloaded = downloader.download(file, link.files()[file], folder)
        finally:
            downloader.close()
    downloaded.path.replace(folder / name)
    shutil.rmtree(card)
    return Recorded(folder / name, int(status["due"]), int(status["lost"]))


def calibrate(folder: Path) -> Constants:
    """Write the constants that the session tells in which the sensors were turned over."""
    session = read_session(folder / TURNED)
    constants = flip_calibration(session.log, session.conditions).constants()
    write_constants(constants, folder / CONSTANTS_FILE)
    return constants


def make_campaign(folder: Path, day: Day) -> list[tuple[float, float]]:
    """Make the drives of a day runs of a campaign in `folder`, in the order they were driven;
    from when to when they were found, seconds."""
    recording = read_recording(folder / DRIVEN, folder / CONSTANTS_FILE)
    found = stretches(recording)
    if len(found) != len(day.drives):
        raise LoggerError(f"{folder / DRIVEN}: {len(found)} drives found, not {len(day.drives)}")
    write_text(folder / "vehicle.toml", day.vehicle)
    new_campaign(folder, day.title, recording, {})
    time_s = recording.time_s
    spans = [(float(time_s[p.steady_first]), float(time_s[p.steady_last - 1])) for p in found]
    for drive, span in zip(day.drives, spans, strict=True):
        run = NewRun(drive.id, drive.role, drive.speed_kmph, drive.track, source=f"from {DRIVEN}")
        add_run(folder, cut(recording, *span), run)
    return spans
