"""`Table`: what a reader found in a file, before it is a recording; and how it becomes one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.files.units import is_measured, to_si
from wheelhop.formats.cells import is_number
from wheelhop.formats.columns import plausible
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.grid import RESAMPLE, Grid, fit_grid
from wheelhop.formats.header import Header
from wheelhop.formats.labels import apart, name_and_unit
from wheelhop.formats.mapping import Map, Pick
from wheelhop.formats.places import good_for, likely_points
from wheelhop.logger.recording import ACCELERATION, CODE, Channel, Recording

POINTS = (*(f"A{k}" for k in range(1, 5)), *(f"B{k}" for k in range(1, 5)), "body")
"""The places of the campaign format that have a name."""


BETWEEN = "rms between samples: "
"""How a recording's notes begin that say how uncertain a channel is that was resampled, in its
unit."""


@dataclass(frozen=True)
class Between:
    """A channel's own samples a second, and how uncertain it is midway between them, rms."""

    rate_hz: float
    rms: float


@dataclass(frozen=True, eq=False)
class Table:
    """Columns (n, c) of one group of channels that were sampled together.

    Their instants are `time_s` (n,), or `start_s` + i / `rate_hz`; with both, the stamps are
    rounded and the rate is exact. `header` is there if wheelhop wrote the file. `lines` are the
    lines of the rows in a text file, empty: rows are counted from 1. `numbers` says which columns
    of the file the channels are, if not all of them; `remarks` are what else the history has to
    say, `asked` is why there is no time, and `granted` what of it is taken for granted. Tables of
    a file are on the `same_clock` if their `time_s` count from one instant. `between` is of
    channels that were resampled. What is `spare` nobody else holds: its values may be converted
    where they are. In wheelhop's `own` layout any rate is believed.
    """

    file: Path
    kind: str
    channels: tuple[Channel, ...]
    values: NDArray[np.float64]
    time_s: NDArray[np.float64] | None = None
    rate_hz: float | None = None
    start_s: float = 0.0
    start_unix_s: float | None = None
    notes: Mapping[str, str] = field(default_factory=dict)
    group: str = ""
    header: Header | None = None
    lines: Sequence[int] = ()
    numbers: tuple[int, ...] = ()
    remarks: tuple[str, ...] = ()
    asked: str = ""
    granted: str = ""
    same_clock: bool = False
    between: tuple[Between, ...] = ()
    spare: bool = False
    own: bool = False

    @property
    def columns(self) -> tuple[int, ...]:
        """Under which number, from 1, a mapping finds each channel."""
        return self.numbers or tuple(range(1, len(self.channels) + 1))

    def where(self, row: int) -> str:
        """How a user finds a row."""
        place = f"line {self.lines[row]}" if self.lines else f"row {row + 1}"
        return f"{self.file}: {place}"


def clocks_are_known(tables: Sequence[Table]) -> bool:
    """Whether it is known how far apart the tables' clocks began."""
    return all(table.same_clock for table in tables) or all(
        table.start_unix_s is not None for table in tables
    )


def choose(tables: Sequence[Table], group: str, file: Path) -> Table:
    """The table of this group, or the only one there is."""
    if group:
        for table in tables:
            if table.group == group:
                return table
    elif len(tables) == 1:
        return tables[0]
    if not tables:
        raise ExchangeError(f"{file}: holds no channels of numbers")
    names = ", ".join(f'"{table.group}" ({len(table.channels)} channels)' for table in tables)
    wrong = f'has no group "{group}"' if group else "holds groups that were not sampled together"
    together = f", or {RESAMPLE}" if not group and clocks_are_known(tables) else ""
    raise ExchangeError(
        f"{file}: {wrong}: choose with group = … in a mapping from {names}{together}"
    )


def to_recording(table: Table, mapping: Map | None, guess: bool = True) -> Recording:
    """Choose and name the channels, convert to SI, and lay the samples on a grid.

    A file that wheelhop has written comes back as it was.
    """
    if table.header is not None and mapping is None:
        return _restored(table, table.header)
    if not table.channels:
        raise ExchangeError(f"{table.file}: holds no channels of numbers")
    if not len(table.values):
        raise ExchangeError(f"{table.file}: holds no samples")
    if table.granted and not guess:
        raise ExchangeError(
            f"{table.file}: would have to be guessed: {table.granted}: say so in a mapping"
        )
    picks = mapping.picks if mapping is not None else ()
    grid = _grid(table, mapping)
    said = mapping is not None and (mapping.rate_hz or mapping.resample_hz or mapping.time_unit)
    if not said and (asked := odd_rate(table, grid.rate_hz)):
        raise ExchangeError(
            f"{table.file}: {asked}: if it is right, wheelhop import --answer rate_hz=… says so"
        )
    picks = picks or tuple(Pick(number) for number in table.columns)
    channels, values, steps = _converted(table, picks)
    uncertain = _uncertain(table, picks, channels)
    steps += [words for words, _ in uncertain.values()]
    if table.granted:
        steps.append(f"taken for granted: {table.granted}")
    if mapping is None and guess:
        channels, guesses = _placed(channels)
        steps += guesses
    if mapping is not None and mapping.rate_hz and table.rate_hz not in (None, mapping.rate_hz):
        steps.append(f"the file says {table.rate_hz:g} Hz, the mapping {mapping.rate_hz:g} Hz")
    origin = f"imported from {table.file.name} ({table.kind})"
    imported = Recording(
        values=grid.spread(values),
        rate_hz=grid.rate_hz,
        channels=channels,
        start_s=grid.start_s,
        start_unix_s=table.start_unix_s,
        history=(origin, *table.remarks, *steps, *grid.remarks()),
        notes={**table.notes, **{BETWEEN + name: rms for name, (_, rms) in uncertain.items()}},
    )
    return imported if table.header is None else _described(imported, table.header.bare)


def _described(imported: Recording, bare: Recording) -> Recording:
    """With what the header of a file of ours says beside."""
    return replace(
        imported,
        averaging_s=bare.averaging_s,
        start_unix_s=bare.start_unix_s,
        history=(*bare.history, *imported.history),
        notes=bare.notes,
    )


@np.errstate(over="ignore", invalid="ignore")
def _converted(
    table: Table, picks: Sequence[Pick]
) -> tuple[tuple[Channel, ...], NDArray[np.float64], list[str]]:
    """The channels that were picked, their samples (n, c) in SI, and what was done to them."""
    channels, steps = [], []
    chosen = columns_of(table, picks)
    in_place = table.spare and chosen == list(range(table.values.shape[1]))
    values = table.values if in_place else np.empty((len(table.values), len(picks)), order="F")
    found = [table.channels[column] for column in chosen]
    numbers = [table.columns[column] for column in chosen]
    names = apart([_name(old) for old in found], [old.unit for old in found], numbers)
    for k, (pick, old, column) in enumerate(zip(picks, found, chosen, strict=True)):
        unit, factor = to_si(pick.unit or old.unit)
        _convert(table.values[:, column], values[:, k], pick, factor)
        channels.append(
            Channel(
                name=pick.name or names[k],
                unit=unit,
                point=_point(table, pick, old, unit),
                sensor=pick.sensor or old.sensor,
                calibration=pick.calibration or old.calibration,
            )
        )
        steps += _conversion(pick, old, channels[-1], factor)
    _check_names(table.file, channels)
    missing = [int(np.isnan(column).sum()) for column in values.T]
    if any(missing):
        whole = np.logical_and.reduce([np.isnan(column) for column in values.T])
        own = [count - int(whole.sum()) for count in missing]
        if any(own):
            _check_dead(table.file, channels, values)
    else:
        own = missing
    for channel, count in zip(channels, own, strict=True):
        if count:
            steps.append(f"{channel.name}: rows without a value of its own: {count}; left empty")
    return tuple(channels), values, steps


def _convert(old: NDArray[np.float64], new: NDArray[np.float64], pick: Pick, factor: float) -> None:
    """Write (old × scale + offset) × factor to `new`, which may be where `old` is."""
    np.multiply(old, pick.scale, out=new)
    if pick.offset:
        new += pick.offset
    if factor != 1.0:
        new *= factor


def _uncertain(
    table: Table, picks: Sequence[Pick], channels: Sequence[Channel]
) -> dict[str, tuple[str, str]]:
    """How uncertain each channel is that was resampled, by its name: in words, and rms in its
    unit."""
    found = {}
    if table.between:
        for pick, channel, column in zip(picks, channels, columns_of(table, picks), strict=True):
            own = table.between[column]
            unit = pick.unit or table.channels[column].unit
            if rms := own.rms * abs(pick.scale) * to_si(unit)[1]:
                words = f"{own.rate_hz:.4g} samples a second, between which it is uncertain by"
                words = (
                    f"{channel.name}: {words} {' '.join((f'{rms:.2g}', channel.unit)).strip()} rms"
                )
                found[channel.name] = words, f"{rms:.3g}"
    return found


def uncertain_between(recording: Recording) -> dict[str, float]:
    """How uncertain channels are that were resampled, rms in their units, by their names."""
    found = {}
    for key, text in recording.notes.items():
        if key.startswith(BETWEEN) and is_number(text) and float(text) > 0.0:
            found[key.removeprefix(BETWEEN)] = float(text)
    return found


def _name(old: Channel) -> str:
    """A channel's name, without a unit that its values are converted from."""
    name, unit = name_and_unit(old.name)
    converted = to_si(old.unit)[1] != 1.0 and to_si(unit) == to_si(old.unit)
    return name if converted else old.name


def _point(table: Table, pick: Pick, old: Channel, unit: str) -> str:
    """Where a channel sits; one in a unit that is not known sits nowhere."""
    if table.header is not None:
        return pick.point or old.point
    if word := good_for(pick.name or old.name, unit):
        if pick.point:
            raise ExchangeError(
                f"{table.file}: {pick.name or old.name} is in {unit}, no acceleration, and so"
                f" cannot sit at {pick.point}: leave point out; it is good as {word}, which"
                " campaign new --place says"
            )
        return ""
    if is_measured(unit) or unit == CODE:
        return pick.point or old.point
    if pick.point:
        said = f"is in {unit}, which is not known" if unit else "does not say its unit"
        raise ExchangeError(
            f"{table.file}: {pick.name or old.name} {said}, and so cannot be placed at"
            f" {pick.point}: say its unit in the mapping"
        )
    return ""


def _placed(channels: tuple[Channel, ...]) -> tuple[tuple[Channel, ...], list[str]]:
    """The channels with the places that the accelerometers' names mean, and what was guessed."""
    felt = [c for c in channels if c.unit == ACCELERATION and not c.point]
    taken = {c.point for c in channels}
    found = {c.name: p for c, p in zip(felt, likely_points([c.name for c in felt]), strict=True)}
    guessed = {name: point for name, point in found.items() if point and point not in taken}
    placed = tuple(replace(c, point=guessed.get(c.name, c.point)) for c in channels)
    return placed, [f"{name}: taken for {point}, by its name" for name, point in guessed.items()]


def plain_channel(name: str, unit: str = "") -> Channel:
    """A channel of which a file tells no more than the name, and perhaps the unit; if the name is a
    place of the campaign format, then it is the place."""
    return Channel(name, unit, name if name in POINTS else "")


def campaign_channel(name: str, unit: str = "") -> Channel:
    """A channel of a table in the campaign format, where what sits at a place is in m/s²."""
    return plain_channel(name, unit or (ACCELERATION if name in POINTS else ""))


def _restored(table: Table, header: Header) -> Recording:
    if table.time_s is None:
        return header.with_values(table.values, table.start_s)
    bare = header.bare
    if not len(table.time_s):
        return header.with_values(table.values)
    grid = fit_grid(table.time_s, table.where, bare.rate_hz, bare.start_s)
    first = int(grid.index[0])
    if first == 0 and grid.rows == header.rows == len(table.values):
        return header.with_values(table.values)
    # Somebody has cut the file.
    cut = replace(grid, index=grid.index - first)
    return header.with_values(cut.spread(table.values), bare.start_s + first / bare.rate_hz).after(
        f"rows {first + 1} to {grid.rows} of {header.rows} read"
    )


def columns_of(table: Table, picks: Sequence[Pick]) -> list[int]:
    """Which column of a table's values each pick means. Raises `ExchangeError` for one that means
    none, or several."""
    places: dict[str | int, list[int]] = {}
    for k, (number, channel) in enumerate(zip(table.columns, table.channels, strict=True)):
        for key in (number, channel.name):
            places.setdefault(key, []).append(k)
    for pick in picks:
        count = len(places.get(pick.column, ()))
        if count > 1:
            raise ExchangeError(
                f'{table.file}: several columns are called "{pick.column}": give their numbers'
            )
        if not count and isinstance(pick.column, int):
            raise ExchangeError(f"{table.file}: there is no column {pick.column} of numbers")
        if not count:
            names = ", ".join(channel.name for channel in table.channels)
            raise ExchangeError(f'{table.file}: there is no column "{pick.column}"; it has {names}')
    return [places[pick.column][0] for pick in picks]


def _conversion(pick: Pick, old: Channel, new: Channel, factor: float) -> list[str]:
    terms = []
    if pick.scale != 1.0 or pick.offset != 0.0:
        terms.append(f"× {pick.scale:g} + {pick.offset:g} = {pick.unit or old.unit}")
    elif pick.unit and old.unit and to_si(pick.unit) != to_si(old.unit):
        terms.append(f"the file says {old.unit}, the mapping {pick.unit}")
    if factor != 1.0:
        terms.append(f"{pick.unit or old.unit} × {factor:g} = {new.unit}")
    return [f"{new.name}: {', '.join(terms)}"] if terms else []


def _check_names(file: Path, channels: Sequence[Channel]) -> None:
    name, count = Counter(channel.name for channel in channels).most_common(1)[0]
    if count > 1:
        raise ExchangeError(
            f'{file}: {count} channels are called "{name}": name them apart in a mapping'
        )


def _check_dead(file: Path, channels: Sequence[Channel], values: NDArray[np.float64]) -> None:
    for channel, column in zip(channels, values.T, strict=True):
        if np.isnan(column).all():
            raise ExchangeError(
                f"{file}: {channel.name} has no samples: leave it out with a mapping"
            )


def odd_rate(table: Table, rate_hz: float) -> str:
    """What is asked of a rate at which suspensions are not recorded, "" of any other."""
    if table.own or table.header is not None or plausible(rate_hz):
        return ""
    return f"the file says {rate_hz:.6g} Hz, at which no suspension is recorded"


def _grid(table: Table, mapping: Map | None) -> Grid:
    known = table.header.bare.rate_hz if table.header else table.rate_hz
    rate = mapping.rate_hz if mapping is not None and mapping.rate_hz else known
    if table.time_s is not None and len(table.time_s):
        return fit_grid(table.time_s, table.where, rate)
    if rate is None:
        asked = f" ({table.asked})" if table.asked else ""
        raise ExchangeError(f"{table.file}: has no time{asked}: give time or rate_hz in a mapping")
    return Grid(table.start_s, rate, np.arange(len(table.values)))
