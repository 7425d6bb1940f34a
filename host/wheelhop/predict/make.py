"""A simulated campaign on disk, whole or not at all; or one recording."""

from __future__ import annotations

import filecmp
import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from wheelhop.calibration import write_constants
from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.campaign.read import CONSTANTS_FILE
from wheelhop.campaign.recorded import read_recording
from wheelhop.campaign.write import NewRun, add_run, new_campaign
from wheelhop.files import check_new, new_folder, replacing
from wheelhop.formats import write
from wheelhop.logger.recording import Recording
from wheelhop.predict.case import Case
from wheelhop.predict.drives import Drive
from wheelhop.predict.instrument import constants, logged, noise_at_rest, recording

LOG = ".hop"


@dataclass(frozen=True)
class Instrument:
    """`noise_rms`, m/s², of a channel in band; `logger`: through the logger, in 10-bit codes."""

    noise_rms: float
    logger: bool = False


def make_campaign(
    folder: Path,
    case: Case,
    vehicle_file: Path,
    instrument: Instrument,
    progress: Callable[[str], None] = lambda text: None,
) -> None:
    """Simulate all drives and write them into `folder` as a campaign that looks measured.

    Above each run campaign.toml says how it was made; that is the only place. With the logger its
    logs are in logs/, and what was recorded comes from them. Raises CampaignError, and then there
    is no folder.
    """
    with new_folder(folder, CampaignError) as draft:
        try:
            _fill(draft, case, vehicle_file, instrument, progress)
            read_campaign(draft)
        except CampaignError as error:
            raise CampaignError(str(error).replace(str(draft), str(folder))) from None


def make_recording(file: Path, case: Case, instrument: Instrument) -> None:
    """Simulate one drive and write its recording, or with the suffix .hop the logger's own.

    Raises CampaignError if there are several, ExchangeError for what cannot be written.
    """
    if len(case.drives) != 1:
        raise CampaignError(
            f"{file}: is one recording, and {len(case.drives)} runs were asked for: give one track"
            " and one --speed, or a folder"
        )
    check_new(file, CampaignError)
    if file.suffix.lower() == LOG:
        logged(case, 0, instrument.noise_rms, file)
    elif instrument.logger:
        with TemporaryDirectory() as place:
            write(_through_logger(case, 0, instrument, Path(place)), file)
    else:
        write(recording(case, 0, instrument.noise_rms), file)


def _fill(
    folder: Path,
    case: Case,
    vehicle_file: Path,
    instrument: Instrument,
    progress: Callable[[str], None],
) -> None:
    noise, constants_file = instrument.noise_rms or None, None
    if instrument.logger:
        noise = noise_at_rest(instrument.noise_rms, case.seed, folder)
        constants_file = folder / CONSTANTS_FILE
        write_constants(constants(), constants_file)
        (folder / "logs").mkdir()
    for number, drive in enumerate(case.drives):
        progress(f"simulating {drive.id}")
        if instrument.logger:
            made = _through_logger(case, number, instrument, folder / "logs")
        else:
            made = recording(case, number, instrument.noise_rms)
        if number == 0:
            title = f"{case.vehicle.name}, simulated"
            new_campaign(folder, title, made, {}, vehicle_file, constants_file, noise)
        copy_survey(drive, folder)
        source = f"simulated with seed {case.seed}{_effects(case)}"
        run = NewRun(drive.id, drive.role, drive.speed_kmph, drive.keys, source, drive.course)
        add_run(folder, made, run)


def _through_logger(case: Case, number: int, instrument: Instrument, folder: Path) -> Recording:
    """What the logger's log of a run says in m/s² of the channels that are recorded; the log stays
    in `folder`."""
    file = folder / f"{case.drives[number].id}{LOG}"
    logged(case, number, instrument.noise_rms, file)
    read = read_recording(file, nominal=True)
    there = {channel.name for channel in case.channels}
    kept = [i for i, channel in enumerate(read.channels) if channel.name in there]
    channels = tuple(read.channels[i] for i in kept)
    return replace(read, values=read.values[:, kept], channels=channels)


def _effects(case: Case) -> str:
    words = [
        ":".join([chosen.effect.id, *(f"{k}={v:g}" for k, v in chosen.values.items())])
        for chosen in case.effects
    ]
    return f", with {' '.join(words)}" if words else ""


def copy_survey(drive: Drive, folder: Path) -> None:
    """Copy the survey of a drive's track, if it has one, to where its keys say."""
    if drive.file is None:
        return
    target = folder / str(drive.keys["file"])
    target.parent.mkdir(exist_ok=True)
    if target.exists() and not filecmp.cmp(drive.file, target, shallow=False):
        raise CampaignError(f"{drive.file}: two surveys have this name: rename one")
    with replacing(target, CampaignError) as draft:
        shutil.copyfile(drive.file, draft)
