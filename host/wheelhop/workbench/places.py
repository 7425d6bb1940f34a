"""Where campaigns are: those opened lately, examples, and the folders of this computer."""

from __future__ import annotations

import json
import shutil
from contextlib import suppress
from pathlib import Path

from wheelhop.files import InputError, is_draft, make_folder, new_folder, read_text, write_text

PACKED = Path(__file__).parent / "examples"
"""Examples that an installed wheel brings; they are copied before they are opened."""
EXAMPLES = Path(__file__).parents[3] / "examples"
CAMPAIGN = "campaign.toml"
MOST = 12
"""So many campaigns are remembered."""
FOLDERS = 500
"""So many folders of one place are listed."""


def home() -> Path:
    """Where the workbench keeps what is no campaign's."""
    return Path.home() / "wheelhop"


def examples() -> list[Path]:
    """Campaigns that come along: all of the repository's, or the small ones of a wheel."""
    place = EXAMPLES if EXAMPLES.is_dir() else PACKED
    return sorted(file.parent for file in place.glob(f"*/{CAMPAIGN}"))


def to_open(folder: Path) -> Path:
    """The folder itself; of an example that a wheel brings a copy of one's own, made once. Raises
    InputError."""
    if folder.parent != PACKED:
        return folder
    copy = home() / "examples" / folder.name
    if not copy.is_dir():
        with new_folder(copy) as draft:
            try:
                shutil.copytree(folder, draft, dirs_exist_ok=True)
            except OSError as error:
                raise InputError(f"{copy}: cannot be written: {error}") from None
    return copy


def for_tour(name: str) -> Path | None:
    """A copy of an example in which nothing was done yet; None where it does not come along.
    Raises InputError."""
    example = next((folder for folder in examples() if folder.name == name), None)
    if example is None:
        return None
    copy = home() / "tour" / name
    with suppress(OSError):
        shutil.rmtree(copy)
    with new_folder(copy) as draft:
        try:
            shutil.copytree(example, draft, dirs_exist_ok=True)
            (draft / "session.toml").unlink(missing_ok=True)
        except OSError as error:
            raise InputError(f"{copy}: cannot be written: {error}") from None
    return copy


def recent() -> list[Path]:
    """Campaigns opened lately that are still there, the last one first."""
    with suppress(InputError, ValueError, TypeError, OSError):
        named = [Path(str(name)) for name in json.loads(read_text(home() / "recent.json"))]
        return [folder for folder in named if (folder / CAMPAIGN).is_file()]
    return []


def remember(folder: Path) -> None:
    """A campaign was opened. Where that cannot be written down, it is forgotten."""
    folder = folder.resolve()
    named = [folder, *(other for other in recent() if other != folder)]
    with suppress(InputError):
        make_folder(home())
        write_text(home() / "recent.json", json.dumps([str(path) for path in named[:MOST]]))


def folders(place: Path) -> list[Path]:
    """The folders in one, those that hold a campaign first. Raises InputError where it cannot be
    read."""
    try:
        inside = [each for each in place.iterdir() if not each.name.startswith(".")]
        found = [each for each in inside if each.is_dir() and not is_draft(each)]
    except OSError as error:
        raise InputError(f"{place}: cannot be read: {error.strerror or error}") from None
    return sorted(found, key=lambda each: (not holds_one(each), each.name.lower()))[:FOLDERS]


def holds_one(folder: Path) -> bool:
    """Whether a folder holds a campaign."""
    with suppress(OSError):
        return (folder / CAMPAIGN).is_file()
    return False
