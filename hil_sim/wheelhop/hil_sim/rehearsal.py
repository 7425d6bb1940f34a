"""What the sensors of an emulated logger put out in each session of a day in the field."""

import numpy as np

from wheelhop.hil_sim.day import Day
from wheelhop.hil_sim.signals import CHANNELS, Signals

STRIKE_HZ, STRIKE_DECAY_S, STRIKE_CODES = 9.0, 0.12, 60.0
STRIKES_FROM_S, STRIKES_APART_S = 12.0, 4.0
BODY, BODIES, AXLE = 0.25, 0.1, 0.04
"""How much of a strike its own corner's other sensor, the rest of the body, and the axles feel."""


def rehearsal(day: Day) -> tuple[tuple[str, Signals], ...]:
    """What happens in the first session, the second, and every one after it, in words."""
    return (
        ("the sensors on a table, turned over and back", day.turning),
        ("the vehicle at rest, struck beside one sensor after the other", struck(day.driving)),
        (f"{len(day.drives)} drives with rests between", day.driving),
    )


def struck(at_rest: Signals) -> Signals:
    """The first seconds of these signals again and again, with a strike downwards beside every
    sensor, in the order of the inputs. Body B1 … B4 and axles A1 … A4 are inputs 0 … 7."""
    rate_hz = at_rest.rate_hz
    seconds = STRIKES_FROM_S + CHANNELS * STRIKES_APART_S
    rows = np.arange(round(seconds * rate_hz)) % round(STRIKES_APART_S * rate_hz)
    codes = at_rest.codes[rows].copy()
    for channel in range(CHANNELS):
        since_s = np.arange(round(2.0 * rate_hz)) / rate_hz
        pulse = -STRIKE_CODES * np.exp(-since_s / STRIKE_DECAY_S)
        pulse *= np.cos(2 * np.pi * STRIKE_HZ * since_s)
        first = round((STRIKES_FROM_S + channel * STRIKES_APART_S) * rate_hz)
        codes[first : first + len(pulse)] += pulse[:, None] * _felt(channel)
    return Signals(codes, rate_hz)


def _felt(struck: int) -> np.ndarray:
    """Part of a strike (8,) that every sensor feels."""
    half = CHANNELS // 2
    felt = np.full(CHANNELS, AXLE)
    if struck < half:
        felt[:half] = BODIES
    felt[(struck + half) % CHANNELS] = BODY
    felt[struck] = 1.0
    return felt
