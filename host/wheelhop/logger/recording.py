"""`Recording`: samples at equal steps, where they come from, and what was done to them."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from html import escape
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import InputError
from wheelhop.files.words import ending_of

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

CODE = "code"
"""Unit of a raw sample: mean code of the converter, 0 … 1023, whose reference is code 1024."""
ACCELERATION = "m/s²"


@dataclass(frozen=True)
class Channel:
    """One column: `name` as recorded, its `unit`, and where it was measured.

    `point` is a place of the campaign format (A1 … A4, B1 … B4, body) or empty: not known.
    `sensor` is the serial number of the accelerometer, `calibration` the id of the constants that
    were applied; both empty if unknown.
    """

    name: str
    unit: str
    point: str = ""
    sensor: str = ""
    calibration: str = ""


@dataclass(frozen=True, eq=False)
class Recording:
    """What one recorder recorded in one go.

    `values` is (n, n_channels), float64, in the channels' units; a sample that is missing is NaN,
    in its whole row or in a channel that was recorded at times, and never invented. Row i is the
    mean over `averaging_s` seconds, centred on `start_s` + i / `rate_hz` of the recorder's own
    clock. `start_unix_s` is the true time of that
    clock's zero, None if unknown. `history` says what was done to the samples, oldest first;
    `notes` holds what else the recorder said (header keys and their values).
    """

    values: NDArray[np.float64]
    rate_hz: float
    channels: tuple[Channel, ...]
    start_s: float = 0.0
    averaging_s: float = 0.0
    start_unix_s: float | None = None
    history: tuple[str, ...] = ()
    notes: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.values.ndim != 2 or self.values.shape[1] != len(self.channels):
            raise ValueError(f"values {self.values.shape}, expected (n, {len(self.channels)})")

    def __repr__(self) -> str:
        rows, count = self.values.shape
        names = ", ".join(f"{c.name} ({c.unit})" for c in self.channels[:8])
        more = ", …" if count > 8 else ""
        seconds = f"{rows / self.rate_hz:.4g} s"
        return f"<Recording: {rows} samples at {self.rate_hz:g} Hz, {seconds}: {names}{more}>"

    @property
    def time_s(self) -> NDArray[np.float64]:
        """(n,) the instant of each row, seconds."""
        return self.start_s + np.arange(len(self.values)) / self.rate_hz

    @property
    def missing(self) -> NDArray[np.bool_]:
        """(n,) True where a sample of any channel is missing."""
        return np.asarray(np.isnan(self.values).any(axis=1))

    def __getitem__(self, channel: str) -> NDArray[np.float64]:
        """(n,) the samples of one channel, by its name, in its unit.

        Raises
        ------
        InputError
            The recording has no such channel.
        """
        from wheelhop.logger.spectra import values_of

        return values_of(self, channel)

    @staticmethod
    def from_dataframe(
        table: "DataFrame",
        *,
        rate_hz: float | None = None,
        unit: str = "",
        averaging_s: float = 0.0,
    ) -> "Recording":
        """A recording from a pandas DataFrame, a column per channel.

        "A1" … "B4" and "body" are places of the campaign format. Gaps of the time stamps become
        rows of NaN.

        Parameters
        ----------
        table
            Time is the column "time_s" or an index of times (seconds, timedeltas or dates). A
            column's name ends in its unit ("A1_m_s2", "A1 [g]"); known units become SI.
        rate_hz
            The sample rate, where the table has no time, or to say it exactly.
        unit
            Of columns whose names say none.
        averaging_s
            Each sample is the mean over so many seconds (0: ideal sampling).

        Returns
        -------
        Recording
            (n, n_channels), in SI.

        Raises
        ------
        ExchangeError
            A column without a unit or with something else than numbers, times that are not uniform.
        """
        from wheelhop.formats.frame import from_dataframe

        return replace(from_dataframe(table, rate_hz, unit), averaging_s=averaging_s)

    def to_dataframe(self) -> "DataFrame":
        """The samples as a pandas DataFrame.

        Returns
        -------
        DataFrame
            (n, n_channels), index `time_s`; each column's name ends in its unit ("A1_m_s2").
        """
        import pandas

        names = [f"{channel.name}{ending_of(channel.unit)}" for channel in self.channels]
        index = pandas.Index(self.time_s, name="time_s")
        return pandas.DataFrame(self.values.copy(), index=index, columns=names)

    def to_xarray(self) -> "Dataset":
        """The samples as an xarray Dataset.

        Returns
        -------
        Dataset
            A variable (n,) per channel over the coordinate `time_s`, each with the attribute
            `units`.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        try:
            import xarray
        except ImportError:
            raise InputError("xarray is not installed: pip install xarray") from None
        columns = zip(self.channels, self.values.T, strict=True)
        variables = {c.name: ("time_s", values, {"units": c.unit}) for c, values in columns}
        time = ("time_s", self.time_s, {"units": "s"})
        return xarray.Dataset(variables, {"time_s": time}, {"history": "; ".join(self.history)})

    def psd(self, resolution_hz: float | None = None) -> "DataFrame":
        """Power spectral density of every channel, one-sided, by Welch's method: half-overlapping
        Hann segments, means removed.

        Parameters
        ----------
        resolution_hz
            Distance of the lines, Hz, the reciprocal of a segment's length; by default that of
            about eight segments.

        Returns
        -------
        DataFrame
            (k, n_channels), index `frequency_hz` without 0; each column's name ends in its unit
            ("A1_m_s2_2_Hz": (m/s²)²/Hz). A channel with missing samples is NaN.

        Raises
        ------
        InputError
            The recording is too short, or does not resolve what is asked for.
        """
        from wheelhop.logger.spectra import power_density

        return power_density(self, resolution_hz)

    def frf(self, cause: str, effect: str, resolution_hz: float | None = None) -> "DataFrame":
        """Frequency response from one channel to another, H1: noise is on the effect alone.

        Parameters
        ----------
        cause, effect
            Names of two channels, such as "A1" and "B1".
        resolution_hz
            As for `psd`.

        Returns
        -------
        DataFrame
            (k, 2), index `frequency_hz` without 0: `response`, complex, in the effect's unit per
            the cause's, and `coherence`, 0 … 1.

        Raises
        ------
        InputError
            There is no such channel, or the recording is too short, or does not resolve what is
            asked for.
        """
        from wheelhop.logger.spectra import response

        return response(self, cause, effect, resolution_hz)

    def _repr_html_(self) -> str:
        table = self.to_dataframe().describe().drop("count")
        return f"<p>{escape(repr(self))}</p>{table.to_html(float_format='%.3g')}"

    def after(self, step: str, **changes: object) -> "Recording":
        """The recording with some fields changed, and a line of history more.

        Parameters
        ----------
        step
            What was done, for `history`.
        changes
            Fields and their new values.

        Returns
        -------
        Recording
            Another one.
        """
        return replace(self, history=(*self.history, step), **changes)  # type: ignore[arg-type]
