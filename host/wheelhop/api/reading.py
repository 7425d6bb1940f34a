"""Reading: campaigns, vehicles, recordings, logs and models, each in one call."""

from __future__ import annotations

from pathlib import Path

from wheelhop.api.given import Folder, campaign_of
from wheelhop.campaign import Campaign, read_campaign
from wheelhop.campaign import recorded as recordings
from wheelhop.effects import More, load_effects
from wheelhop.logger import Log, Recording
from wheelhop.logger import read_log as read_log_file
from wheelhop.report.model_file import read_model as read_model_file
from wheelhop.simulate import Model
from wheelhop.vehicle import Vehicle, read_nominal
from wheelhop.vehicle import read_vehicle as read_vehicle_file


def read(folder: str | Path) -> Campaign:
    """Read the campaign in a folder: campaign.toml and every recording it names.

    Parameters
    ----------
    folder
        The folder that holds campaign.toml.

    Returns
    -------
    Campaign
        In SI; each run's `record` is (n, n_channels).

    Raises
    ------
    CampaignError
        Something in it is wrong: one line that says in which file, where, and what to do.
    """
    return read_campaign(folder)


def read_vehicle(source: Folder) -> Vehicle:
    """The nominal vehicle of a campaign, or that of a file like vehicle.toml.

    Parameters
    ----------
    source
        The file, or a campaign or its folder.

    Returns
    -------
    Vehicle
        Its numbers by their dotted names and their uncertainty (one standard deviation), in SI.

    Raises
    ------
    CampaignError
        The file is missing or wrong.
    """
    if isinstance(source, Campaign) or Path(source).is_dir():
        return read_nominal(campaign_of(source))
    return read_vehicle_file(Path(source))


def read_model(file: str | Path, effects: More = None) -> Model:
    """Read a fitted model, model.toml as `add` and `write_model` write it.

    Parameters
    ----------
    file
        The file (docs/model-file.md).
    effects
        Where effects of the user's own come from, as for `compare`.

    Returns
    -------
    Model
        The numbers of the vehicle, its effects, and what every run left free, in SI; `predict`
        takes it. Random heights of the ground are not in the file.

    Raises
    ------
    CampaignError
        The file is missing or wrong, or names an effect that the library does not have.
    """
    return read_model_file(Path(file), load_effects(effects))


def read_recording(
    file: str | Path, calibration: str | Path | None = None, *, nominal: bool = False
) -> Recording:
    """Read one recording, of the logger (.hop) or of any other instrument.

    Parameters
    ----------
    file
        .hop, .csv, .parquet, .mf4, .uff, .tdms, .lvm.
    calibration
        The sensors' constants; they turn the logger's codes into m/s².
    nominal
        Without constants, take the data sheet's, ±10 %.

    Returns
    -------
    Recording
        Samples (n, n_channels) at equal steps, in SI.

    Raises
    ------
    InputError
        The file is missing or wrong.
    """
    constants = None if calibration is None else Path(calibration)
    return recordings.read_recording(Path(file), constants, nominal)


def read_log(file: str | Path) -> Log:
    """Read a log of the logger (.hop), whatever has happened to it.

    Parameters
    ----------
    file
        The log.

    Returns
    -------
    Log
        Its gaps, damage and settings; `Log.recording` gives its samples, in codes 0 … 1023.

    Raises
    ------
    LoggerError
        It holds no session.
    """
    return read_log_file(Path(file))
