"""A pandas DataFrame as a recording: `Recording.from_dataframe`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wheelhop.formats.error import ExchangeError
from wheelhop.formats.labels import name_and_unit
from wheelhop.formats.table import Table, plain_channel, to_recording
from wheelhop.logger.recording import Recording

if TYPE_CHECKING:
    from pandas import DataFrame

HERE = Path("DataFrame")
"""What a mistake is said to be in, where other readers name a file."""
TIME = "time_s"


def from_dataframe(table: DataFrame, rate_hz: float | None, unit: str) -> Recording:
    """See `Recording.from_dataframe`."""
    names = [str(name) for name in table.columns]
    for name, kind in zip(names, table.dtypes, strict=True):
        if not hasattr(kind, "kind") or kind.kind not in "iuf":
            raise ExchangeError(
                f"{HERE}: column {name} holds {kind}, not numbers: make it numbers"
                " (pandas.to_numeric) or leave it out"
            )
    measured = [k for k, name in enumerate(names) if name != TIME]
    if not measured:
        raise ExchangeError(f"{HERE}: has no column beside the time: give one per channel")
    labels = [name_and_unit(names[k]) for k in measured]
    for name, found in labels:
        if not (found or unit):
            raise ExchangeError(
                f"{HERE}: column {name}: in which unit? rename it {name}_m_s2 or {name}_g, or give "
                'unit="m/s²"'
            )
    time_s = _time(table, names)
    if time_s is None and rate_hz is None:
        raise ExchangeError(f"{HERE}: has no time: add a column {TIME}, or give rate_hz")
    channels = tuple(plain_channel(name, found or unit) for name, found in labels)
    values = table.iloc[:, measured].to_numpy(np.float64, na_value=np.nan)
    return to_recording(Table(HERE, "pandas", channels, values, time_s, rate_hz), None)


def _time(table: DataFrame, names: list[str]) -> NDArray[np.float64] | None:
    """The time stamps (n,), s: of the column, or of an index that is no mere numbering."""
    import pandas

    if TIME in names:
        return np.asarray(table.iloc[:, names.index(TIME)], dtype=np.float64)
    index = table.index
    if isinstance(index, pandas.DatetimeIndex):
        index = index - index[0]
    if isinstance(index, pandas.TimedeltaIndex):
        return np.asarray(index.total_seconds(), dtype=np.float64)
    if index.name == TIME:
        return np.asarray(index, dtype=np.float64)
    return None
