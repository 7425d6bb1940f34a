"""Measured axle motion as an input that is uncertain itself.

It holds the sensors' noise and motion folded from above half the sample rate
(`wheelhop.simulate.folding`). What the vehicle hands on of both is in the prediction, not in the
record it is compared with: S = σ² + Σ |H|² (σ² + S_folded) is the variance of a datum about the
prediction, H the nominal vehicle's transmissibility from an axle to a point of the body.
"""

from __future__ import annotations

from dataclasses import replace
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, Run
from wheelhop.simulate import folded_power, frequency_response, sample_of
from wheelhop.vehicle import System

Array = NDArray[np.float64]


def doubt(campaign: Campaign, run: Run, system: System, frequency_hz: Array) -> tuple[Array, Array]:
    """√S/σ (2 f, c) of every in-band datum of a run, and what it is without the folded motion;
    `system` is the nominal vehicle's on measured axles. The campaign states its noise.

    The noise of the sensors is known, and no model leaves less. The folded motion is estimated:
    on periodic roads it may be many times less.
    """
    acceleration = frequency_response(system, frequency_hz)
    # What is not acceleration counts by its own noise.
    shown = acceleration / campaign.noise_scale[:, None]
    transmitted = np.abs(shown / (2 * np.pi * frequency_hz[:, None, None]) ** 2) ** 2
    uncertain = _input_power(campaign, run, frequency_hz) / _noise(campaign) ** 2
    once = np.sqrt(1.0 + np.einsum("fca,fa->fc", transmitted, uncertain))
    sensors = np.sqrt(1.0 + transmitted.sum(axis=2))
    return np.concatenate([once, once]), np.concatenate([sensors, sensors])


def led_astray(campaign: Campaign, run: Run) -> Run:
    """The run with axle motion that is as wrong as it may be: one draw, always the same."""
    n = len(run.time_s)
    frequency = np.fft.rfftfreq(n, 1.0 / campaign.sample_rate_hz).astype(float)
    power = _input_power(campaign, run, frequency)
    record = run.record.copy()
    record[:, _columns(campaign)] += sample_of(power, n, crc32(run.id.encode()))
    return replace(run, record=record)


def _input_power(campaign: Campaign, run: Run, frequency_hz: Array) -> Array:
    """Variance (f, axles), (m/s²)², of what is not the axles' motion in their records."""
    axles = run.record[:, _columns(campaign)]
    noise, rate_hz = _noise(campaign), campaign.sample_rate_hz
    return noise**2 + folded_power(axles, rate_hz, campaign.averaging, noise, frequency_hz)


def _columns(campaign: Campaign) -> list[int]:
    place = {int(c.point[1]): i for i, c in enumerate(campaign.channels) if c.is_axle}
    return [i for _, i in sorted(place.items())]


def _noise(campaign: Campaign) -> float:
    assert campaign.noise_rms is not None
    return campaign.noise_rms
