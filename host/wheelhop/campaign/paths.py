"""Files a campaign refers to: always inside its own folder, so that it can be moved and shared."""

from collections.abc import Iterator
from pathlib import Path, PurePosixPath, PureWindowsPath

from wheelhop.campaign.types import CampaignError
from wheelhop.files import Table, read_toml, shown, similar_file


def file_inside(folder: Path, table: Table, key: str, default: str | None = None) -> Path:
    """The existing file that `key` names relative to `folder`.

    Raises `CampaignError` for a path that is absolute, climbs out of the folder with "..", leads
    out of it through a symbolic link, or does not lead to a file.
    """
    text = table.text(key, default)
    named = f"{table.prefix}{key} = {shown(text)}"
    if PurePosixPath(text).is_absolute() or PureWindowsPath(text).drive:
        raise table.error(f"{named} is an absolute path; give it relative to the campaign folder")
    if ".." in PureWindowsPath(text).parts:
        raise table.error(f"{named} leads out of the campaign folder; copy the file into it")
    path = folder / text
    try:
        exists = path.is_file()
        within = path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError):  # a name that is too long, a loop of symbolic links
        exists, within = False, True
    if not within:
        raise table.error(f"{named} is a link out of the campaign folder; copy the file into it")
    if not exists:
        slashes = " (write '/' between folders)" if "\\" in text else ""
        raise table.error(f"{named}: no such file in {folder}{similar_file(path)}{slashes}")
    return path


def named_by(vehicle: Path) -> Iterator[Path]:
    """The files that vehicle.toml stands on: mount, frame, and what that is made from.

    Raises `CampaignError` as `file_inside` does.
    """
    top = read_toml(vehicle, CampaignError)
    if "mount" in top:
        yield file_inside(vehicle.parent, top, "mount")
    if "frame" in top:
        frame = file_inside(vehicle.parent, top.table("frame"), "file")
        yield frame
        inner = read_toml(frame, CampaignError)
        yield from (file_inside(frame.parent, inner, key) for key in ("bdf", "f06") if key in inner)
