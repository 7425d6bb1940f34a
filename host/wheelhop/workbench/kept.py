"""A draft on the disk: whatever was filled in is there again after a server that was killed."""

from __future__ import annotations

import json
from contextlib import ExitStack
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import Any

from wheelhop.files import InputError, claimed, make_folder, read_text, remove, write_text
from wheelhop.workbench.draft import Column, Draft, Piece

FILE = "draft.json"
MOST = 100  # drafts of new campaigns at a time


def draft_folder(into: Path | None, claims: ExitStack) -> Path:
    """Where a draft and its recordings are kept: one folder for every campaign that is open, else
    the first that no other workbench has; `claims` holds it. Raises InputError if none is free."""
    home = Path.home() / "wheelhop" / "drafts"
    if into is not None:
        return home / f"{into.name}-{sha256(str(into.resolve()).encode()).hexdigest()[:8]}"
    for number in range(1, MOST + 1):
        folder = home / f"new-{number}"
        try:
            claims.enter_context(claimed(folder, "draft"))
            return folder
        except InputError as error:
            refused = error
    raise refused


def keep(draft: Draft) -> None:
    """Write what has changed since it was written; an empty draft is no file. Raises InputError."""
    text = _text(draft) if draft.files else ""
    if text == draft.kept:
        return
    draft.kept = text
    if text:
        make_folder(draft.folder)
        write_text(draft.folder / FILE, text)


def resume(folder: Path, into: Path | None) -> Draft:
    """The draft of a folder; a new one where there is none, or none that can be understood."""
    draft = Draft(folder, into)
    if not (folder / FILE).is_file():
        return draft
    try:
        _fill(draft, json.loads(read_text(folder / FILE)))
    except (InputError, ValueError, TypeError, KeyError, AttributeError):
        return Draft(folder, into)
    return draft


def drop(draft: Draft) -> None:
    """Forget the recordings of a draft: its file, and those that were copied beside it."""
    draft.clear()
    draft.kept = ""
    inside = sorted(draft.folder.iterdir()) if draft.folder.is_dir() else []
    remove([draft.folder, *(path for path in inside if path.is_file())])


def _text(draft: Draft) -> str:
    document = {
        "files": [str(file) for file in draft.files],
        "constants": None if draft.constants is None else str(draft.constants),
        "columns": [asdict(column) for column in draft.columns],
        "pieces": [{**asdict(piece), "file": str(piece.file)} for piece in draft.pieces],
        "said": draft.said,
        "answers": draft.answers,
        "better": {key: value for key, value in draft.better.items() if value is not None},
        "recorder": draft.recorder,
        "title": draft.title,
        "target": draft.target,
    }
    return json.dumps(document, indent=1, ensure_ascii=False)


def _fill(draft: Draft, document: dict[str, Any]) -> None:
    """What the file says, as far as its recordings are still there."""
    draft.said = dict(document.get("said", {}))
    for file in map(Path, document["files"]):
        if file.is_file():
            draft.add(file)
    if document["constants"] is not None and Path(document["constants"]).is_file():
        draft.constants = Path(document["constants"])
    columns = [Column(**column) for column in document["columns"]]
    if [column.key for column in columns] == [column.key for column in draft.columns]:
        draft.columns = columns
    pieces = [Piece(**{**piece, "file": Path(piece["file"])}) for piece in document["pieces"]]
    draft.pieces = [piece for piece in pieces if piece.file in draft.files]
    draft.answers |= document["answers"]
    draft.better |= document["better"]
    draft.recorder |= document.get("recorder", {})
    draft.title, draft.target = str(document["title"]), str(document["target"])
