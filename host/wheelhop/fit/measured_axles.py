"""Measured motion as an input that is uncertain itself: of axles, or of struts.

It holds the sensors' noise and motion folded from above half the sample rate
(`wheelhop.simulate.folding`). What the vehicle hands on of both is in the prediction, not in the
record it is compared with: S = σ² + Σ |H|² (σ² + S_folded) is the variance of a datum about the
prediction, H the nominal vehicle's transmissibility from an axle, or from a strut's travel, to what
a sensor on the body shows.
"""

from __future__ import annotations

from dataclasses import replace
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, Run
from wheelhop.fit.shared_error import SharedError
from wheelhop.simulate import drive_of, folded_power, frequency_response, sample_of
from wheelhop.simulate.measured import driving, per_strut
from wheelhop.vehicle import System

Array = NDArray[np.float64]


def doubt(campaign: Campaign, run: Run, system: System, frequency_hz: Array) -> tuple[Array, Array]:
    """√S/σ (2 f, c) of every in-band datum of a run, and what it is without the folded motion;
    `system` is the nominal vehicle's on what moves it in the run. The campaign states its noise.

    The noise of the sensors is known, and no model leaves less. The folded motion is estimated:
    on periodic roads it may be many times less.
    """
    # What is not acceleration counts by its own noise.
    shown = frequency_response(system, frequency_hz) / campaign.noise_scale[:, None]
    if drive_of(campaign, run) == "axles":
        shown = shown / (2 * np.pi * frequency_hz[:, None, None]) ** 2
    transmitted, noise = np.abs(shown) ** 2, _noise(campaign, run)
    power = _input_power(campaign, run, frequency_hz) / _reference(campaign) ** 2
    once = np.sqrt(1.0 + np.einsum("fca,fa->fc", transmitted, power))
    sensors = np.sqrt(1.0 + (transmitted * (noise / _reference(campaign)) ** 2).sum(axis=2))
    return np.concatenate([once, once]), np.concatenate([sensors, sensors])


def shared_error(
    campaign: Campaign,
    run: Run,
    system: System,
    frequency_hz: Array,
    predicted: NDArray[np.bool_],
) -> SharedError:
    """What the channels `predicted` err together in a run that measured travel drives."""
    shown = frequency_response(system, frequency_hz) / campaign.noise_scale[:, None]
    power = _input_power(campaign, run, frequency_hz) / _reference(campaign) ** 2
    return SharedError.of(shown[:, predicted], power)


def led_astray(campaign: Campaign, run: Run) -> Run:
    """The run with what moves it as wrong as it may be: one draw, always the same."""
    n = len(run.time_s)
    frequency = np.fft.rfftfreq(n, 1.0 / campaign.sample_rate_hz).astype(float)
    power = _input_power(campaign, run, frequency)
    record, columns = run.record.copy(), _columns(campaign, run)
    wrong = sample_of(power, n, crc32(run.id.encode()))
    record[:, columns] += wrong * per_strut(campaign, columns)
    return replace(run, record=record)


def _input_power(campaign: Campaign, run: Run, frequency_hz: Array) -> Array:
    """Variance (f, wheels), (m/s²)² or m², of what is not the motion of axles or struts in their
    records."""
    columns = _columns(campaign, run)
    moved = run.record[:, columns] / per_strut(campaign, columns)
    noise, rate_hz = _noise(campaign, run), campaign.sample_rate_hz

    def recorded(f: Array) -> NDArray[np.complex128]:
        return campaign.recorded(f)[:, columns]

    return noise**2 + folded_power(moved, rate_hz, recorded, noise, frequency_hz)


def _columns(campaign: Campaign, run: Run) -> list[int]:
    return [i for _, i in sorted(driving(campaign, drive_of(campaign, run)).items())]


def _noise(campaign: Campaign, run: Run) -> Array:
    """Of what is measured at each wheel (w,)."""
    columns = _columns(campaign, run)
    return _reference(campaign) * campaign.noise_scale[columns] / abs(per_strut(campaign, columns))


def _reference(campaign: Campaign) -> float:
    assert campaign.noise_rms is not None
    return campaign.noise_rms
