"""What an instrument makes of the motion: ideal sensors with noise, or the logger and its codes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.constants import (
    NOMINAL_CODES_PER_G,
    NOMINAL_CORNER_HZ,
    Constants,
    nominal_constants,
)
from wheelhop.campaign import Campaign, CampaignError
from wheelhop.campaign.recorded import read_recording
from wheelhop.campaign.write import DEFAULT_BAND_HZ
from wheelhop.compare.band import InBand
from wheelhop.effects.transfer import transferred
from wheelhop.files import replacing
from wheelhop.files.units import STANDARD_GRAVITY_M_S2
from wheelhop.hil_sim.double.card import Card
from wheelhop.hil_sim.double.device import Device
from wheelhop.hil_sim.double.faults import DoubleFaults
from wheelhop.hil_sim.signals import Signals
from wheelhop.logger.recording import ACCELERATION, Channel, Recording
from wheelhop.predict.case import AVERAGING_S, SAMPLE_RATE_HZ, Case
from wheelhop.predict.drives import CHANNELS

Array = NDArray[np.float64]
NOISE_RMS_M_S2 = 0.1
"""Of a channel in band, about that of an ADXL326 on a vehicle."""
SIGNAL_RATE_HZ = 1600.0
"""At which signals reach the logger's converter."""
CLOSING_S = 5.0
"""Of the logger's time, in which it closes the file."""
LEAD_S = 0.25
"""Signals stand before and after a session, for it begins and ends when it will."""


def measured(case: Case, noise_rms: float) -> Campaign:
    """All drives as `recording` gives them, in memory."""
    ideal, _ = case.campaign(noise_rms)
    runs = tuple(
        replace(run, role=drive.role, record=_with_noise(run.record, case, number, noise_rms))
        for number, (run, drive) in enumerate(zip(ideal.runs, case.drives, strict=True))
    )
    return replace(ideal, runs=runs, noise_rms=noise_rms or None)


def recording(case: Case, number: int, noise_rms: float) -> Recording:
    """A run as an ideal recorder gives it: means over 10 ms, with white noise.

    `noise_rms`, m/s², is what of the noise lies in the band of errors, as `noise_rms_m_s2` states.
    """
    values = case.record(number, SAMPLE_RATE_HZ, AVERAGING_S)
    return Recording(
        _with_noise(values, case, number, noise_rms),
        SAMPLE_RATE_HZ,
        tuple(Channel(c.name, ACCELERATION, c.point) for c in case.channels),
        averaging_s=AVERAGING_S,
    )


def _with_noise(values: Array, case: Case, number: int, noise_rms: float) -> Array:
    low, high = DEFAULT_BAND_HZ
    sigma = noise_rms / np.sqrt((high - low) / (SAMPLE_RATE_HZ / 2))
    rng = np.random.default_rng([case.seed, number, 1])
    return np.asarray(values + sigma * rng.normal(size=values.shape))


def logged(case: Case, number: int, noise_rms: float, file: Path) -> None:
    """Record a run with the double of the logger: write its log, of 10-bit codes.

    The sensors are nominal ADXL326: a low-pass of first order at 50 Hz, and noise that is white at
    the converter; `noise_rms`, m/s², is what of it lies in band before it is rounded to codes.
    """
    values = case.record(number, SIGNAL_RATE_HZ, 0.0, LEAD_S)
    # Inputs to which no sensor is connected are at rest.
    inputs = np.zeros((len(values), len(CHANNELS)))
    inputs[:, [CHANNELS.index(c) for c in case.channels]] = values
    seen = transferred(inputs, SIGNAL_RATE_HZ, _low_pass)
    _log(seen, np.random.default_rng([case.seed, number, 1]), noise_rms, file)


def noise_at_rest(noise_rms: float, seed: int, folder: Path) -> float | None:
    """What the logger shows in band, m/s², of sensors that lie still for 20 s, rounding included;
    None where nothing moves a code. The log comes and goes in `folder`."""
    file = folder / "rest.hop"
    rows = round(20.0 * SIGNAL_RATE_HZ)
    _log(np.zeros((rows, len(CHANNELS))), np.random.default_rng(seed), noise_rms, file)
    rest = read_recording(file, nominal=True)
    file.unlink()
    band = InBand(len(rest.values), rest.rate_hz, DEFAULT_BAND_HZ)
    found = float(np.sqrt((band.coefficients(rest.values) ** 2).sum() / rest.values.size))
    return found or None


def _log(seen: Array, rng: np.random.Generator, noise_rms: float, file: Path) -> None:
    """What the double makes of accelerations at its sensors (T, 8), m/s², as a log."""
    low, high = DEFAULT_BAND_HZ
    sigma = noise_rms / np.sqrt((high - low) / (SIGNAL_RATE_HZ / 2))
    noisy = seen + sigma * rng.normal(size=seen.shape)
    offset = constants().sensors[0].offset.value + 0.5  # the converter rounds down
    codes = offset + noisy / STANDARD_GRAVITY_M_S2 * NOMINAL_CODES_PER_G
    with replacing(file, CampaignError) as draft, TemporaryDirectory(dir=file.parent) as card:
        device = Device(Signals(codes, SIGNAL_RATE_HZ), Card(Path(card)), DoubleFaults())
        device.press_button()
        device.run(len(seen) / SIGNAL_RATE_HZ - LEAD_S)
        device.press_button()
        device.run(device.time_s + CLOSING_S)
        (log,) = Card(Path(card)).files()
        (Path(card) / log).replace(draft)


def constants() -> Constants:
    """Those of the simulated sensors, which are nominal."""
    return nominal_constants(channel.name for channel in CHANNELS)


def _low_pass(frequency_hz: Array) -> NDArray[np.complex128]:
    return np.asarray(1.0 / (1.0 + 1j * frequency_hz[:, None] / NOMINAL_CORNER_HZ))
