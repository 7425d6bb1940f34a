"""`wheelhop convert`: write a recording in another format, and say what is lost by it."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

import numpy as np

from wheelhop.cli.progress import stages
from wheelhop.formats import ExchangeError, losses, read, write
from wheelhop.logger.recording import Recording


def run(arguments: Namespace) -> int:
    """Convert one recording; raises ExchangeError."""
    source, target = arguments.source, arguments.target
    check_target(target, arguments.force, source)
    with stages() as stage:
        stage(f"reading {source}")
        recording = read(source)
        lost = losses(recording, target.suffix)
        stage(f"writing {target}")
        write(recording, target)
    print(f"{target}: {in_words(recording)}")
    for loss in lost:
        print(f"  lost: {loss}")
    return 0


def check_target(target: Path, force: bool, *sources: Path) -> None:
    """Raise ExchangeError where writing would destroy something."""
    if any(target.exists() and source.exists() and target.samefile(source) for source in sources):
        raise ExchangeError(f"{target}: is what is read: choose another name")
    if target.exists() and not force:
        raise ExchangeError(f"{target}: exists: choose another name, or --force to replace it")


def in_words(recording: Recording) -> str:
    """A recording in a line."""
    rows, lost = len(recording.values), np.isnan(recording.values)
    missing = int(lost.all(axis=1).sum()) if rows else 0
    own = (lost.sum(axis=0) - missing).tolist()
    channels = ", ".join(
        f"{channel.name} {f'[{channel.unit}]' if channel.unit else '(unit unknown)'}"
        for channel in recording.channels
    )
    gaps = f", {missing} samples missing" if missing else ""
    for channel, count in zip(recording.channels, own, strict=True):
        gaps += f", {count} of {channel.name} alone" if count else ""
    return (
        f"{rows} samples at {recording.rate_hz:g} Hz ({rows / recording.rate_hz:.6g} s){gaps}: "
        f"{channels}"
    )
