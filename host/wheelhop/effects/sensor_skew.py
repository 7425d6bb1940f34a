"""The channels are not sampled at the same instant, but one after the other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wheelhop.campaign import Channel
from wheelhop.effects.base import Array, Effect, Values
from wheelhop.effects.parameters import Amplitude, Parameter
from wheelhop.effects.transfer import transferred


class SensorSkew(Effect):
    """Every column of the record is a little later than the one before it."""

    id = "sensor-skew"
    place = "sensor"
    title = "channels are sampled one after the other, in column order"
    equation = r"y_j(t) = a_j(t + j\,\tau),\quad j = 0, 1, \ldots"
    source = (
        "one analogue-to-digital converter behind a multiplexer, e.g. W. Kester (ed.), Data"
        " Conversion Handbook (Newnes 2005), ch. 8; a delay turns the phase by 2π f j τ"
    )

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """The time from channel to channel; negative if the last column is sampled first."""
        if len(channels) < 2:
            return ()
        most = 0.02 / len(channels)
        return (
            Amplitude(
                "delay_s",
                "s",
                "time from one channel's sample to the next one's",
                5e-4,
                lower=-most,
                upper=most,
            ),
        )

    def sense(
        self, theta: Values, acceleration: Array, channels: Sequence[Channel], rate_hz: float
    ) -> Array:
        """Read every channel at its own, later instant."""
        return _advanced(acceleration, rate_hz, theta["delay_s"])

    def restore(
        self, theta: Values, measured: Array, channels: Sequence[Channel], rate_hz: float
    ) -> Array:
        """Move every channel back."""
        return _advanced(measured, rate_hz, -theta["delay_s"])


def _advanced(record: Array, rate_hz: float, delay_s: float) -> Array:
    """Column j of the record (n, c) at the instants t + j · delay."""
    ahead_s = delay_s * np.arange(record.shape[1])
    return transferred(
        record, rate_hz, lambda hz: np.asarray(np.exp(2j * np.pi * np.outer(hz, ahead_s)))
    )
