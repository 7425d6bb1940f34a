"""Recordings on disk as columns of numbers, and the check of their time stamps."""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign.types import CampaignError
from wheelhop.files import check_plain, read_text
from wheelhop.files.units import to_si
from wheelhop.formats.header import read_sidecar
from wheelhop.formats.labels import name_and_unit
from wheelhop.logger.recording import CODE

RECORDINGS = (".hop", ".mf4")
SHORTEST_S = 2.0
STEP_TOLERANCE = 0.01  # of the sample period
RATE_TOLERANCE = 1e-3
STAMP_DIGITS = range(7)  # decimals that time stamps may be rounded to


def read_columns(
    file: Path, constants: Path | None = None, wanted: Mapping[str, str] | None = None
) -> tuple[list[str], NDArray[np.float64]]:
    """Names (n_columns) and finite values (n_rows, n_columns) of a recording.

    A log of codes needs the file of its sensors' constants. `wanted` are columns by their names,
    and the SI units they are taken to be in. Raises `CampaignError` that names the file and the row
    for anything else than a full table of numbers under one row of distinct names, and the column
    where the file says another unit than the one wanted.
    """
    suffix = file.suffix.lower()
    if suffix == ".csv":
        names, values = _read_csv(file)
        header = read_sidecar(file)
        units = {c.name: c.unit for c in header.bare.channels} if header is not None else {}
    elif suffix == ".parquet":
        names, values, units = _read_parquet(file)
    elif suffix in RECORDINGS:
        names, values, units = _read_recording(file, constants)
    else:
        raise CampaignError(
            f"{file}: recordings are .csv, .parquet, .mf4 or .hop, not '{file.suffix}': "
            "wheelhop convert makes one of the others"
        )
    _check_names(file, names)
    for name, unit in (wanted or {}).items():
        if name in names:
            _check_unit(file, name, units.get(name, ""), unit)
    if not np.isfinite(values).all():
        row, column = np.argwhere(~np.isfinite(values))[0]
        raise CampaignError(
            f"{file}: {_row(file, row)}: {names[column]} is {values[row, column]}; cut the run "
            "before or after it, made-up samples would spoil the comparison"
        )
    return names, values


@np.errstate(all="ignore")  # absurd stamps are reported, not warned about
def check_time(
    file: Path, time_s: NDArray[np.float64], rate_hz: float, shortest_s: float = SHORTEST_S
) -> None:
    """Raise unless `time_s` (n,) is uniform at `rate_hz` over at least `shortest_s` seconds.

    Each step may differ from the period by 1 %, and by what rounding the stamps makes of it; the
    mean step by 0.1 %, since a clock that is off by more would shift every frequency.
    """
    period = 1.0 / rate_hz
    steps = np.diff(time_s) if len(time_s) > 1 else np.array([period])
    mean, typical = float(steps.mean()), float(np.median(steps))
    shortest = longest = period
    rounding = 0.0
    if np.abs(steps - period).max() > STEP_TOLERANCE * period:
        rounding = _rounding(time_s)
        shortest, longest = _rounded(period, rounding)
    slack = STEP_TOLERANCE * period
    wrong = (steps < shortest - slack) | (steps > longest + slack)
    if not shortest - slack <= typical <= longest + slack:
        raise _wrong_rate(file, typical, rate_hz)
    if wrong.any():
        row = int(np.argmax(wrong)) + 1
        what = "jumps" if steps[row - 1] > 0 else "does not rise"
        raise CampaignError(
            f"{file}: {_row(file, row)}: time_s {what} from {time_s[row - 1]:g} to "
            f"{time_s[row]:g}; cut the run there, a gap cannot be filled"
        )
    if abs(mean - period) > RATE_TOLERANCE * period + rounding / len(steps):
        raise _wrong_rate(file, mean, rate_hz)
    if shortest < longest and rounding > period / 2:  # a lost sample would hide in the rounding
        raise CampaignError(
            f"{file}: time_s is rounded to {rounding:g} s, too coarse for sample_rate_hz = "
            f"{rate_hz:g}: write it with more decimals"
        )
    if len(time_s) * period < shortest_s:
        raise CampaignError(
            f"{file}: {len(time_s)} rows at {rate_hz:g} Hz are {len(time_s) * period:.3g} s; "
            f"a run needs at least {shortest_s:g} s"
        )


def _check_unit(file: Path, name: str, said: str, wanted: str) -> None:
    """Raise where a column is said to be in another unit, beside the samples or by its name. A tail
    such as "_m" may be part of a name; one in the same dimension as the unit wanted is not."""
    if said and to_si(said) != (wanted, 1.0):
        raise CampaignError(
            f"{file}: column {name} is in {said}, the campaign takes {wanted}: convert it (wheelhop"
            " import, with a mapping that says its unit), or leave the channel out"
        )
    inside = name_and_unit(name)[1]
    si, factor = to_si(inside)
    if factor != 1.0 if si == wanted else inside and name.endswith(("]", ")")):
        raise CampaignError(
            f"{file}: column {name} is in {inside} by its name, the campaign takes {wanted}:"
            " convert it, or rename the column if it is converted"
        )


def _rounding(time_s: NDArray[np.float64]) -> float:
    """The decimal step that all stamps are multiples of, 0 if there is none."""
    for digits in STAMP_DIGITS:
        scaled = time_s * 10.0**digits
        if np.abs(scaled - np.round(scaled)).max() < 1e-6:
            return float(10.0**-digits)
    return 0.0


def _rounded(period: float, rounding: float) -> tuple[float, float]:
    """The shortest and the longest step that rounding the stamps makes of a period."""
    if rounding == 0.0:
        return period, period
    ratio = period / rounding
    return math.floor(ratio + 1e-6) * rounding, math.ceil(ratio - 1e-6) * rounding


def _wrong_rate(file: Path, step_s: float, rate_hz: float) -> CampaignError:
    if abs(step_s * rate_hz - 1e3) < 1.0:
        return CampaignError(f"{file}: time_s is in milliseconds; give it in seconds")
    rate = f" ({1 / step_s:.6g} Hz)" if step_s > 0 else ""
    return CampaignError(
        f"{file}: time_s steps by {step_s:.6g} s{rate}, but campaign.toml says sample_rate_hz = "
        f"{rate_hz:g}: correct the one that is wrong"
    )


def _read_csv(file: Path) -> tuple[list[str], NDArray[np.float64]]:
    lines = read_text(file, CampaignError).rstrip().split("\n")
    header = [name.strip().strip('"').strip() for name in lines[0].split(",")]
    _check_header(file, lines[0], header)
    body = lines[1:]
    commas = len(header) - 1
    if any(line.count(",") != commas for line in body):
        row = next(i for i, line in enumerate(body) if line.count(",") != commas)
        found = body[row].count(",") + 1 if body[row].strip() else 0
        raise CampaignError(
            f"{file}: {_row(file, row)} has {found} values, the header has {len(header)} columns: "
            "complete the row, or cut the run there"
        )
    # Parsing all cells in one go is several times faster than numpy's text readers.
    cells = ",".join(body).split(",") if body else []
    try:
        values = np.fromiter(map(float, cells), np.float64, len(cells))
    except ValueError:
        raise _bad_cell(file, header, cells) from None
    if any("_" in line for line in body):
        raise _bad_cell(file, header, cells)
    return header, values.reshape(len(body), len(header))


def _check_header(file: Path, line: str, header: list[str]) -> None:
    if not line.strip():
        raise CampaignError(f"{file}: is empty; the first line must name the columns: time_s,…")
    if len(header) == 1 and (";" in line or "\t" in line):
        found = "semicolons" if ";" in line else "tabs"
        raise CampaignError(
            f"{file}: columns are separated by {found}; save it with commas between columns and a "
            "point in the numbers (12.5, not 12,5)"
        )
    if line.startswith("#") or all(_is_number(name) for name in header):
        raise CampaignError(f"{file}: line 1 must name the columns: time_s,…")


def _bad_cell(file: Path, header: list[str], cells: list[str]) -> CampaignError:
    index = next(i for i, cell in enumerate(cells) if not _is_number(cell))
    row, column = divmod(index, len(header))
    cell = cells[index].strip()
    what = f"'{cell[:20]}' is not a number" if cell else "the cell is empty"
    return CampaignError(f"{file}: {_row(file, row)}: {header[column]}: {what}")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return "_" not in text  # Python reads 1_000


def _read_parquet(file: Path) -> tuple[list[str], NDArray[np.float64], dict[str, str]]:
    import pyarrow.parquet  # csv files do without it

    from wheelhop.formats.parquet import read_table

    check_plain(file, CampaignError)
    try:
        schema = pyarrow.parquet.read_schema(file)
        table = read_table(file, CampaignError)
    except (pyarrow.ArrowException, OSError) as error:
        reason = " ".join(str(error).split())[:120]
        raise CampaignError(f"{file}: cannot be read as Parquet: {reason}") from None
    for field in schema:
        if not (pyarrow.types.is_floating(field.type) or pyarrow.types.is_integer(field.type)):
            raise CampaignError(f"{file}: column {field.name} holds {field.type}, not numbers")
    columns = [column.to_numpy().astype(np.float64) for column in table.columns]
    said = {field.name: (field.metadata or {}).get(b"unit", b"") for field in table.schema}
    units = {name: unit.decode("utf-8", "replace") for name, unit in said.items()}
    values = np.column_stack(columns) if columns else np.empty((0, 0))
    return list(table.column_names), values, units


def _read_recording(
    file: Path, constants: Path | None
) -> tuple[list[str], NDArray[np.float64], dict[str, str]]:
    from wheelhop.campaign.recorded import read_recording  # csv files do without these packages

    recording = read_recording(file, constants)
    if any(channel.unit == CODE for channel in recording.channels):
        raise CampaignError(
            f"{file}: holds codes, and the campaign has no calibration.toml to make them m/s²: "
            "copy the one of this logger beside campaign.toml"
        )
    names = ["time_s", *(channel.name for channel in recording.channels)]
    values = np.column_stack([recording.time_s - recording.start_s, recording.values])
    return names, values, {channel.name: channel.unit for channel in recording.channels}


def _check_names(file: Path, names: list[str]) -> None:
    seen: set[str] = set()
    for index, name in enumerate(names):
        if not name:
            raise CampaignError(f"{file}: column {index + 1} has no name")
        if name in seen:
            raise CampaignError(f"{file}: column {name} appears twice: rename or delete one")
        seen.add(name)
    if "time_s" not in names:
        raise CampaignError(
            f"{file}: column time_s is missing: it holds the time of each row in seconds"
        )


def _row(file: Path, row: int) -> str:
    """How the user finds a row of the data: by line in a text file, else by number from 1."""
    return f"line {row + 2} (row {row + 1})" if file.suffix.lower() == ".csv" else f"row {row + 1}"
