"""Formats by the suffix of a file, and `read`, `write` and `losses` for all of them.

A format is a module of this package with `load(path, mapping) -> list of Table` and, if it can be
written, `save(recording, path)` and `losses(recording)`; it is imported when it is first needed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np

from wheelhop.files import check_plain, replacing, write_text
from wheelhop.formats.error import ExchangeError, guarded
from wheelhop.formats.header import read_sidecar, sidecar, to_text
from wheelhop.formats.mapping import Map
from wheelhop.formats.resample import onto_rate
from wheelhop.formats.table import Table, choose, to_recording
from wheelhop.logger.recording import Recording


@dataclass(frozen=True)
class Format:
    """A way of writing recordings; with `beside`, the header goes into NAME.suffix.toml, with
    `own_time` no column of it can be chosen as time."""

    title: str
    module: str
    writes: bool = False
    beside: bool = False
    own_time: bool = False

    def load_module(self) -> ModuleType:
        """The module that knows this format."""
        return import_module(f"wheelhop.formats.{self.module}")


CSV = Format("CSV", "own_csv", writes=True, beside=True)
TEXT = Format("text in columns", "text")
PARQUET = Format("Parquet", "parquet", writes=True)
MDF = Format("ASAM MDF", "mdf", writes=True, own_time=True)
MDF_READ = Format("ASAM MDF", "mdf", own_time=True)
MDF_BEGINS = (b"MDF     ", b"UnFinMF ")
UFF = Format("universal file, dataset 58", "uff", writes=True, beside=True, own_time=True)
FORMATS = {
    ".csv": CSV,
    ".parquet": PARQUET,
    ".mf4": MDF,
    ".mdf": MDF_READ,
    ".uff": UFF,
    ".unv": UFF,
    ".tdms": Format("National Instruments TDMS", "tdms"),
    ".lvm": Format("LabVIEW measurement", "lvm", own_time=True),
    ".mat": Format("MATLAB", "matlab"),
    **dict.fromkeys((".h5", ".hdf5", ".hdf"), Format("HDF5", "hdf5")),
    ".ide": Format("enDAQ", "ide", own_time=True),
    **dict.fromkeys((".mcap", ".bag", ".db3"), Format("ROS bag or MCAP", "bags", own_time=True)),
    **dict.fromkeys((".xrk", ".xrz"), Format("AiM", "aim", own_time=True)),
    ".vbo": Format("VBOX", "vbo", own_time=True),
    ".hop": Format("the logger's own", "hop", own_time=True),
    **dict.fromkeys((".txt", ".tsv", ".dat", ".asc", ".log"), TEXT),
}


def is_text(path: Path) -> bool:
    """Whether a file is text in columns of which somebody has to say what they are."""
    return _format_of(path).module in ("text", "own_csv")


def is_foreign(path: Path) -> bool:
    """Whether a file is such a text, and not a CSV as ours are."""
    if not is_text(path):
        return False
    if _format(path) is not CSV or not path.is_file():
        return True
    ours: bool = CSV.load_module().is_ours(path)
    return not ours


def _format_of(path: Path) -> Format:
    """The format of a file that may be there: .dat is MDF's suffix, too, which its first bytes
    tell."""
    known = _format(path)
    if known is TEXT and path.is_file():
        with path.open("rb") as file:
            return MDF_READ if file.read(8) in MDF_BEGINS else known
    return known


SHEETS = (".xlsx", ".xls", ".xlsm", ".ods")
EXPORTS = {
    ".ld": "MoTeC's own log: in i2 choose File, Export Data, CSV file, all channels at their rate",
    ".drk": "AiM's old log: in RaceStudio choose Export, CSV file",
    ".vbb": "VBOX's binary log: in VBOX Test Suite choose Export, VBO file",
    ".dxd": "DEWESoft's own log: in DewesoftX choose Export, MDF4 or MATLAB",
}
"""What is not read, and how its program writes something that is."""


def load(path: Path, mapping: Map | None = None) -> list[Table]:
    """What is in a file, a table for each group of channels that were sampled together.

    Raises `ExchangeError`.
    """
    known = _format(path)
    if not path.exists():
        raise ExchangeError(f"{path}: there is no such file")
    check_plain(path, ExchangeError)
    known = _format_of(path)
    if mapping is not None and mapping.time != "" and known.own_time:
        raise ExchangeError(
            f"{path}: {known.title} has its own time: leave time = {mapping.time!r} out of the"
            " mapping, or give rate_hz"
        )
    with guarded(path, f"be read as {known.title}"):
        tables: list[Table] = known.load_module().load(path, mapping)
    return tables


def read(path: Path, mapping: Map | None = None, guess: bool = True) -> Recording:
    """Read a recording, in SI. Raises `ExchangeError`.

    A file that `write` has written comes back as it was. Anything else is imported: units that are
    known become SI, gaps of the time stamps become rows of NaN, and the history says so. `mapping`
    says what a file does not tell itself; free-form text needs one. Without it accelerometers sit
    where their names mean; without `guess` nothing is guessed, and refused what would have to be.
    """
    return recording_of(path, load(path, mapping), mapping, guess)


def recording_of(
    path: Path, tables: list[Table], mapping: Map | None = None, guess: bool = True
) -> Recording:
    """The recording in the tables of a file, as `read` makes it. Raises `ExchangeError`."""
    group = mapping.group if mapping else ""
    if mapping is not None and mapping.resample_hz is not None:
        wanted = [choose(tables, group, path)] if group or not tables else tables
        table = onto_rate(wanted, mapping)
        mapping = replace(mapping, rate_hz=None)
    else:
        table = choose(tables, group, path)
    return to_recording(table, mapping, guess)


def write(recording: Recording, path: Path) -> None:
    """Write a recording; what stood there is replaced once all is written. Raises `ExchangeError`.

    Formats without room for all that is known put it into NAME.suffix.toml beside the file. That
    header says by a hash which samples it is of, and takes its place first: whatever ends the
    program in between, new header and old samples do not pass for a recording.
    """
    known = _writer(path)
    _check(recording, path)
    if not path.parent.is_dir():
        raise ExchangeError(f"{path}: cannot be written, there is no folder {path.parent}")
    with _header_of_before(path), replacing(path, ExchangeError) as draft:
        try:
            with guarded(path, "be written"):
                known.load_module().save(recording, draft)
        except ExchangeError as error:  # the draft is hidden, and gone when this is read
            raise ExchangeError(str(error).replace(str(draft), str(path))) from None
        if known.beside:
            write_text(sidecar(path), to_text(recording, draft), ExchangeError)


@contextmanager
def _header_of_before(path: Path) -> Iterator[None]:
    """If the block fails, the header is as it was, unless its samples have been replaced by then:
    the disk says whether they have, for an interruption may strike right after it."""
    header = sidecar(path)
    before = header.read_bytes() if header.is_file() else None
    try:
        yield
    except BaseException:
        if not _has_header(path):
            if before is None:
                header.unlink(missing_ok=True)
            elif header.read_bytes() != before:
                with replacing(header, ExchangeError) as draft:
                    draft.write_bytes(before)
        raise


def _has_header(path: Path) -> bool:
    try:
        return path.is_file() and read_sidecar(path) is not None
    except ExchangeError:
        return False


def losses(recording: Recording, suffix: str) -> tuple[str, ...]:
    """What a recording loses when it is written as `suffix` and read back; empty: nothing."""
    lost: tuple[str, ...] = _writer(Path(f"x{suffix}")).load_module().losses(recording)
    return lost


def _format(path: Path) -> Format:
    suffix = path.suffix.lower()
    if suffix in FORMATS:
        return FORMATS[suffix]
    if suffix in SHEETS:
        raise ExchangeError(
            f"{path}: is a spreadsheet: save the sheet as CSV (UTF-8) in the program it comes from,"
            " and import that; wheelhop import FILE.csv --draft begins a mapping"
        )
    if suffix in EXPORTS:
        raise ExchangeError(f"{path}: is {EXPORTS[suffix]}, and import what that writes")
    raise ExchangeError(f"{path}: '{suffix}' is no format known here: {', '.join(FORMATS)}")


def _writer(path: Path) -> Format:
    known = _format(path)
    if known.writes:
        return known
    able = [suffix for suffix, item in FORMATS.items() if item.writes]
    raise ExchangeError(f"{path}: {known.title} is read, not written: choose {', '.join(able)}")


def _check(recording: Recording, path: Path) -> None:
    if not recording.values.size:
        raise ExchangeError(f"{path}: the recording has no samples: there is nothing to write")
    _check_distinct(path, [channel.name for channel in recording.channels])
    if not np.isfinite(recording.rate_hz) or recording.rate_hz <= 0:
        raise ExchangeError(f"{path}: rate_hz = {recording.rate_hz} cannot be written")


def _check_distinct(path: Path, names: Sequence[str]) -> None:
    name, count = Counter(names).most_common(1)[0]
    blank = any(not name.strip() or not name.isprintable() for name in names)
    if count > 1 or blank:
        what = f'{count} channels are called "{name}"' if count > 1 else "a channel has no name"
        raise ExchangeError(f"{path}: {what}: give each a name of its own")
