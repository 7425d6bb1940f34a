"""`wheelhop import`: recordings of other recorders, read as a mapping says, in SI."""

from __future__ import annotations

import sys
from argparse import Namespace
from pathlib import Path

from wheelhop.cli.convert import check_target, in_words
from wheelhop.cli.progress import stages
from wheelhop.files import made_folder
from wheelhop.formats import ExchangeError, Map, draft_mapping, losses, read, read_mapping, write


def run(arguments: Namespace) -> int:
    """Import each file, or print a draft of the mapping; raises ExchangeError."""
    if arguments.draft:
        for file in arguments.files:
            sys.stdout.write(draft_mapping(file))
        return 0
    mapping = read_mapping(arguments.map) if arguments.map else None
    with made_folder(arguments.out):
        _import(arguments, mapping)
    return 0


def _import(arguments: Namespace, mapping: Map | None) -> None:
    targets = [_target(file, arguments) for file in arguments.files]
    for target in targets:
        if targets.count(target) > 1:
            raise ExchangeError(f"{target}: two files would become this one: import them apart")
    for file, target in zip(arguments.files, targets, strict=True):
        with stages() as stage:
            stage(f"reading {file}")
            recording = read(file, mapping)
            check_target(target, arguments.force, *arguments.files)
            stage(f"writing {target}")
            write(recording, target)
        print(f"{target}: {in_words(recording)}", flush=True)
        for step in (*recording.history, *(f"lost: {x}" for x in losses(recording, target.suffix))):
            print(f"  {step}")


def _target(file: Path, arguments: Namespace) -> Path:
    folder: Path = arguments.out
    return folder / f"{file.stem}{arguments.to}"
