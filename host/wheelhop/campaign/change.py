"""Changes of the TOML files of a campaign, which its gate, its critic, its verdict and its forms
propose alike: shown as lines that go and come, put into the file with every comment kept."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError

from wheelhop.campaign.channels import POINTS
from wheelhop.campaign.types import CampaignError
from wheelhop.files import locked, parse_toml, quoted, read_text, replacing, write_text

Check = Callable[[Path, Path], None]
CAMPAIGN, VEHICLE, SESSION = "campaign.toml", "vehicle.toml", "session.toml"
DIGITS = 6  # significant ones that a computed number is written with


@dataclass(frozen=True)
class Change:
    """One value of a file: `keys` are the names of the tables that lead to it and its own, of a run
    ("run", its id, …); `value` is written as in TOML, "" takes the key away."""

    file: str
    keys: tuple[str, ...]
    value: str


@dataclass(frozen=True)
class Proposal:
    """What a button does to the files of a campaign: its words, and every change it makes."""

    title: str
    changes: tuple[Change, ...]


def written(value: object) -> str:
    """A value as TOML has it; computed numbers with six significant digits."""
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key} = {written(item)}' for key, item in value.items())} }}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(written, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        short = repr(float(f"{value:.{DIGITS}g}"))
        return short if set(short) & set(".en") else f"{short}.0"
    return quoted(value) if isinstance(value, str) else repr(value)


def of_campaign(title: str, *pairs: tuple[tuple[str, ...], object]) -> Proposal:
    """A proposal for campaign.toml: keys and their new values."""
    changes = tuple(Change(CAMPAIGN, keys, written(value)) for keys, value in pairs)
    return Proposal(title, changes)


def changed(text: str, changes: Sequence[Change], file: Path) -> str:
    """The text of a file with these changes.

    Raises CampaignError for what is no TOML, and for a run or a table that is not there.
    """
    parse_toml(text, file, CampaignError)
    document: Any = tomlkit.parse(text)
    for change in changes:
        _put(document, change, file)
    return tomlkit.dumps(document)


def _put(document: Any, change: Change, file: Path) -> None:
    *path, key = change.keys
    table = document
    if path[:1] == ["channels"]:
        path, key = _channel(document, path, key)
    if path[:1] == ["run"]:
        table = _run(document, path[1], file)
        path = path[2:]
    for name in path:
        if name not in table:  # inline: a table with a head of its own would stand behind the runs
            table[name] = tomlkit.inline_table()
        table = table[name]
        if not isinstance(table, Mapping):
            raise CampaignError(f"{file}: {'.'.join(change.keys)}: {name} is no table")
    if not change.value:
        table.pop(key, None)
        return
    try:
        item: Any = tomlkit.value(change.value)
    except (TOMLKitError, ValueError):
        what = f"{'.'.join(change.keys)} = {change.value}"
        raise CampaignError(f"{file}: {what}: is no value of TOML: text stands in quotes") from None
    before = getattr(table.get(key), "trivia", None)
    if before is not None:  # the comment behind the old value stays
        item.trivia.comment_ws, item.trivia.comment = before.comment_ws, before.comment
    table[key] = item


def _channel(document: Any, path: list[str], key: str) -> tuple[list[str], str]:
    """Where the place of a channel stands, which may be all that is said of it: then no table, but
    that. Without [channels] the eight points are written first."""
    if "channels" not in document:
        document["channels"] = tomlkit.value(written({point: point for point in POINTS}))
    name = path[-1]
    plain = not isinstance(document["channels"].get(name), Mapping)
    return (["channels"], name) if plain and key == "position" else (path, key)


def _run(document: Any, id_: str, file: Path) -> Any:
    for run in document.get("run", []):
        if run.get("id") == id_:
            return run
    raise CampaignError(f'{file}: there is no [[run]] "{id_}" any more')


@dataclass(frozen=True)
class Rewritten:
    """A file of a campaign before and after a change, whole."""

    file: str
    before: str
    after: str

    def lines(self) -> list[str]:
        """Those that go ("-") and come ("+"), with the two about them (" "); "" between places."""
        both = self.before.splitlines(), self.after.splitlines()
        found = list(difflib.unified_diff(*both, n=2, lineterm=""))[2:]
        return ["" if line.startswith("@@") else line for line in found][1:]


def rewritten(folder: Path, changes: Sequence[Change]) -> list[Rewritten]:
    """What changes make of the files of the campaign in `folder`, with nothing written.

    Raises CampaignError for a file that cannot be read, and as `changed` does.
    """
    found = []
    for name in dict.fromkeys(change.file for change in changes):
        before = read_text(folder / name, CampaignError)
        own = [change for change in changes if change.file == name]
        found.append(Rewritten(name, before, changed(before, own, folder / name)))
    return found


def rewrite(folder: Path, files: Sequence[Rewritten], check: Check) -> None:
    """Write what `rewritten` made, unless a file is another one by now, or is wrong afterwards:
    then CampaignError, and all files are as before. `check` is given a file and the draft that will
    take its place, and raises it if that is wrong."""
    with locked(folder, CampaignError):
        for each in files:
            if read_text(folder / each.file, CampaignError) != each.before:
                raise CampaignError(
                    f"{folder / each.file}: was changed meanwhile: look at it again"
                )
        done: list[Rewritten] = []
        try:
            for each in files:
                with replacing(folder / each.file, CampaignError, within=folder) as draft:
                    draft.write_text(each.after, encoding="utf-8", newline="\n")
                    check(folder / each.file, draft)
                done.append(each)
        except BaseException:
            for each in done:
                write_text(folder / each.file, each.before, CampaignError, within=folder)
            raise
