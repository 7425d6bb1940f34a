"""`wheelhop decode`: a log becomes a table of codes, or of m/s² where it is calibrated."""

from argparse import Namespace
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from wheelhop.calibration import Constants, read_constants
from wheelhop.cli.convert import check_target
from wheelhop.cli.progress import stages
from wheelhop.files import make_folder
from wheelhop.formats import write
from wheelhop.logger import (
    Log,
    LoggerError,
    Recording,
    correct_clock,
    correct_sensor,
    correct_window,
    read_log,
)
from wheelhop.logger.beside import with_beside
from wheelhop.logger.correct import TAPS

MARGIN = 2 * TAPS  # scans on either side that two filters look at
PART_SCANS = 4_000_000
"""A longer session becomes several files, since half a gigabyte of samples is enough at a time."""


def run(arguments: Namespace) -> int:
    """Decode one log after the other, and say what was done; raises what decoding raises."""
    constants = read_constants(arguments.calibration) if arguments.calibration else None
    like = read_log(arguments.header_from) if arguments.header_from else None
    targets = [_target(arguments, file) for file in arguments.files]
    for target in targets:
        if targets.count(target) > 1:
            raise LoggerError(f"{target}: two logs would become this file: decode them apart")
    if arguments.out is not None and not arguments.out.suffix:
        make_folder(arguments.out)
    for file, target in zip(arguments.files, targets, strict=True):
        with stages() as stage:
            stage(f"checking {file}")
            log = read_log(file, header_from=like)
            for path, recording in _parts(log, target, arguments, constants, stage):
                stage(f"writing {path}")
                write(recording, path)
                _tell(file, path, recording)
    return 0


def _target(arguments: Namespace, file: Path) -> Path:
    out: Path | None = arguments.out
    if out is None:
        return file.with_suffix(f".{arguments.format or 'csv'}")
    if out.suffix and not out.is_dir():
        if len(arguments.files) > 1 or arguments.format:
            raise LoggerError(f"{out}: one file for several logs or formats: give a folder")
        return out
    return out / f"{file.stem}.{arguments.format or 'csv'}"


def _parts(
    log: Log,
    target: Path,
    arguments: Namespace,
    constants: Constants | None,
    stage: Callable[[str], None],
) -> Iterator[tuple[Path, Recording]]:
    first, stop = arguments.scans or (0, log.due)
    stop = min(stop, log.due)
    if first >= stop:
        raise LoggerError(f"{log.name}: there are {log.due} scans in it, none from {first} on")
    many = stop - first > PART_SCANS
    for number, begin in enumerate(range(first, stop, PART_SCANS), start=1):
        end = min(begin + PART_SCANS, stop)
        name = f"{target.stem}-{number:03d}{target.suffix}" if many else target.name
        path = target.with_name(name)
        check_target(path, arguments.force)
        stage(f"decoding {log.name}: scans {begin} to {end - 1}")
        from_, to = max(begin - MARGIN, 0), min(end + MARGIN, log.due)
        recording = log.recording(from_, to, by_number=arguments.raw)
        margin, rows = _rows(log, from_, begin, end, arguments.raw)
        own_s = recording.time_s
        recording = _corrected(recording, arguments, constants)
        recording = with_beside(recording, log.beside, own_s)
        part = replace(
            recording,
            values=recording.values[margin:rows],
            start_s=recording.start_s + margin / recording.rate_hz,
        )
        yield path, part


def _rows(log: Log, zero: int, begin: int, end: int, by_number: bool) -> tuple[int, int]:
    """First row of scans `begin` … `end` − 1, and the one behind their last, counted from scan
    number `zero`: late triggers let rows run ahead of numbers."""
    late = log.late_before(np.array([zero, begin, end])) * (not by_number)
    first, stop = np.ceil((late[1:] - late[0]) / log.settings.steps).astype(int)
    return begin - zero + int(first), end - zero + int(stop)


def _corrected(
    recording: Recording, arguments: Namespace, constants: Constants | None
) -> Recording:
    corners: list[float | None] = [arguments.sensor_hz] * len(recording.channels)
    if constants is not None:
        recording = constants.apply(recording)
        if not arguments.sensor_hz:
            found = [constants.of(channel.name).corner_hz for channel in recording.channels]
            corners = [corner.value if corner else None for corner in found]
    if arguments.raw:
        return recording
    recording = correct_sensor(correct_window(recording), corners)
    return correct_clock(recording) if recording.notes.get("clock_ppm") else recording


def _tell(file: Path, path: Path, recording: Recording) -> None:
    missing = int(recording.missing.sum())
    gone = f", {missing} missing (rows of NaN)" if missing else ""
    print(f"{file} -> {path}: {len(recording.values)} scans{gone}")
    for step in recording.history:
        print(f"  {step}", flush=True)
