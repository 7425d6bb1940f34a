"""Spectra of a recording: power densities, and the response of one channel to another."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import InputError, did_you_mean
from wheelhop.files.words import ending_of, squared

if TYPE_CHECKING:
    from pandas import DataFrame

    from wheelhop.logger.recording import Recording

SEGMENTS = 8
"""A spectrum is averaged over about so many half-overlapping segments, unless a resolution is
asked for: its standard error is then about a third."""

FEWEST = 8
"""Samples in a segment: fewer show no spectrum."""


def column_of(recording: Recording, name: str) -> int:
    """Which column a channel is.

    Raises
    ------
    InputError
        The recording has no such channel.
    """
    names = [channel.name for channel in recording.channels]
    if name not in names:
        near = did_you_mean(name, names) or f"; it has {', '.join(names)}"
        raise InputError(f'the recording has no channel "{name}"{near}')
    return names.index(name)


def power_density(recording: Recording, resolution_hz: float | None) -> DataFrame:
    """See `Recording.psd`."""
    import pandas
    from scipy import signal

    length = _segment(recording, resolution_hz)
    frequency, power = signal.welch(
        recording.values, recording.rate_hz, nperseg=length, axis=0
    )  # a channel with missing samples is NaN throughout
    names = [
        f"{c.name}{ending_of(squared(c.unit) + '/Hz' if c.unit else '/Hz')}"
        for c in recording.channels
    ]
    index = pandas.Index(frequency[1:], name="frequency_hz")
    return pandas.DataFrame(power[1:], index=index, columns=names)


def response(
    recording: Recording, cause: str, effect: str, resolution_hz: float | None
) -> DataFrame:
    """See `Recording.frf`."""
    import pandas
    from scipy import signal

    length = _segment(recording, resolution_hz)
    x, y = (recording.values[:, column_of(recording, name)] for name in (cause, effect))
    frequency, cross = signal.csd(x, y, recording.rate_hz, nperseg=length)
    _, coherence = signal.coherence(x, y, recording.rate_hz, nperseg=length)
    _, power = signal.welch(x, recording.rate_hz, nperseg=length)
    with np.errstate(divide="ignore", invalid="ignore"):
        h = cross / power
    index = pandas.Index(frequency[1:], name="frequency_hz")
    return pandas.DataFrame({"response": h[1:], "coherence": coherence[1:]}, index=index)


def _segment(recording: Recording, resolution_hz: float | None) -> int:
    """Samples in a segment."""
    count = len(recording.values)
    if resolution_hz is None:
        length = 2 * count // (SEGMENTS + 1)
    else:
        finest = recording.rate_hz / max(count, 1)
        if not finest <= resolution_hz * (1 + 1e-9) < recording.rate_hz:
            raise InputError(
                f"resolution_hz = {resolution_hz:g}: {count} samples at {recording.rate_hz:g} Hz"
                f" resolve {finest:.3g} Hz; give that or more"
            )
        length = round(recording.rate_hz / resolution_hz)
    if count < FEWEST:
        raise InputError(f"{count} samples show no spectrum: {FEWEST} or more are needed")
    return max(min(length, count), FEWEST)


def values_of(recording: Recording, name: str) -> NDArray[np.float64]:
    """See `Recording.__getitem__`."""
    return recording.values[:, column_of(recording, name)]
