"""All of a recording but its samples, as TOML: a file beside the samples, or a text inside them."""

from __future__ import annotations

import hashlib
import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import check_plain, quoted, read_text_bytes
from wheelhop.formats.error import ExchangeError
from wheelhop.logger.recording import Channel, Recording

FORMAT = 1
CHANNEL_KEYS = ("name", "unit", "point", "sensor", "calibration")
SAMPLES = "samples_sha256"
"""Of the file that a header stands beside: by it the header knows its samples from others."""
CHUNK_BYTES = 1 << 20
NUMBERS = ("rate_hz", "start_s", "averaging_s", "start_unix_s")


@dataclass(frozen=True)
class Header:
    """`bare` is the recording without samples, `rows` how many of them there were."""

    bare: Recording
    rows: int

    def with_values(self, values: NDArray[np.float64], start_s: float | None = None) -> Recording:
        """The recording again; `start_s` if it begins elsewhere now."""
        start = self.bare.start_s if start_s is None else start_s
        return replace(self.bare, values=values, start_s=start)


def header_of(recording: Recording) -> Header:
    """What `recording` is apart from its samples."""
    return Header(replace(recording, values=recording.values[:0]), len(recording.values))


def to_text(recording: Recording, samples: Path | None = None) -> str:
    """The header as TOML; numbers are written so that they read back to the same bits. With the
    file of its `samples`, beside which it will stand, it says which these are."""
    lines = [f"format = {FORMAT}", f"rows = {len(recording.values)}"]
    if samples is not None and samples.is_file():  # a pipe cannot be read again
        lines.append(f'{SAMPLES} = "{_digest(samples)}"')
    for key in NUMBERS:
        value = getattr(recording, key)
        if value is not None:
            lines.append(f"{key} = {float(value)!r}")
    lines += ["history = [", *(f"    {quoted(step)}," for step in recording.history), "]"]
    for channel in recording.channels:
        lines += ["", "[[channel]]"]
        texts = {key: getattr(channel, key) for key in CHANNEL_KEYS}
        lines += [f"{key} = {quoted(text)}" for key, text in texts.items() if text]
    if recording.notes:
        lines += ["", "[notes]"]
        lines += [f"{quoted(key)} = {quoted(text)}" for key, text in recording.notes.items()]
    return "\n".join(lines) + "\n"


def sidecar(path: Path) -> Path:
    """Where the header of a file stands that has no room for it: NAME.csv.toml."""
    return path.with_name(f"{path.name}.toml")


def read_sidecar(path: Path) -> Header | None:
    """The header beside `path`, None if there is none.

    Raises `ExchangeError`, also for a header of other samples: one of the two files was replaced
    without the other. A header that does not say which its samples are is believed.
    """
    file = sidecar(path)
    if not file.exists():
        return None
    try:
        text = read_text_bytes(file, ExchangeError).decode("utf-8")
    except UnicodeDecodeError as error:
        raise ExchangeError(f"{file}: byte {error.start} is not UTF-8") from None
    table = _table(text, file)
    if SAMPLES in table and table[SAMPLES] != _digest(path):
        raise ExchangeError(
            f"{file}: is the header of other samples than {path.name} holds now: write both again;"
            f" if you have edited {path.name} yourself, delete the line {SAMPLES} from the header"
        )
    return _header(table, file)


def _digest(samples: Path) -> str:
    """SHA-256 of a file, with line ends as we write them: what copies text may change those."""
    found = hashlib.sha256()
    check_plain(samples, ExchangeError)
    with samples.open("rb") as file:
        while chunk := file.read(CHUNK_BYTES):
            if chunk.endswith(b"\r"):
                chunk += file.read(1)
            found.update(chunk.replace(b"\r\n", b"\n"))
    return found.hexdigest()


def from_text(text: str, file: Path) -> Header:
    """Read what `to_text` wrote; raises `ExchangeError` that names `file` and the key."""
    return _header(_table(text, file), file)


def _table(text: str, file: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ExchangeError(f"{file}: not valid TOML: {error}") from None


def _header(table: Mapping[str, Any], file: Path) -> Header:
    if table.get("format") != FORMAT or isinstance(table["format"], bool):
        raise ExchangeError(f"{file}: format must be {FORMAT}: this wheelhop reads no other")
    rows = table.get("rows")
    if not isinstance(rows, int) or isinstance(rows, bool) or rows < 0:
        raise ExchangeError(f"{file}: rows must be the number of samples")
    numbers = {key: _number(table, key, file) for key in NUMBERS}
    rate = numbers["rate_hz"]
    if rate is None or not 0.0 < rate < math.inf:
        raise ExchangeError(f"{file}: rate_hz must be a number of samples per second above 0")
    history = table.get("history", [])
    notes = table.get("notes", {})
    if not isinstance(history, list) or not all(isinstance(step, str) for step in history):
        raise ExchangeError(f"{file}: history must be a list of texts")
    if not isinstance(notes, dict) or not all(isinstance(note, str) for note in notes.values()):
        raise ExchangeError(f"{file}: [notes] must hold texts only")
    channels = _channels(table, file)
    bare = Recording(
        values=np.empty((0, len(channels))),
        rate_hz=rate,
        channels=channels,
        start_s=numbers["start_s"] or 0.0,
        averaging_s=numbers["averaging_s"] or 0.0,
        start_unix_s=numbers["start_unix_s"],
        history=tuple(history),
        notes=notes,
    )
    return Header(bare, rows)


def _number(table: Mapping[str, Any], key: str, file: Path) -> float | None:
    value = table.get(key)
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not _finite(value):
        raise ExchangeError(f"{file}: {key} must be a finite number")
    return float(value)


def _finite(value: float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer of 400 digits
        return False


def _channels(table: Mapping[str, Any], file: Path) -> tuple[Channel, ...]:
    entries = table.get("channel", [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise ExchangeError(f"{file}: begin each channel with [[channel]]")
    channels = []
    for number, entry in enumerate(entries, start=1):
        texts = {key: entry.get(key, "") for key in CHANNEL_KEYS}
        wrong = next((key for key, text in texts.items() if not isinstance(text, str)), None)
        if wrong or not texts["name"]:
            raise ExchangeError(f"{file}: channel {number}: {wrong or 'name'} must be a text")
        channels.append(Channel(**texts))
    return tuple(channels)
