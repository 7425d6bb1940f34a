"""Travel and rates against what accelerometers say of them, whatever the road.

A strut's travel is what its two ends do, δ̈ = B̈ − Ä at its corner; the body's pitch and roll
accelerate as the differences of its points do, over their distance. Where those are recorded, too,
a potentiometer or a gyro is held against them: its sign, its unit, and of travel the corner.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, Channel
from wheelhop.campaign.change import of_campaign
from wheelhop.compare.band import InBand
from wheelhop.gate.descriptions import OTHER_UNITS
from wheelhop.gate.finding import Finding
from wheelhop.gate.fixes import ratio, scaled, turned
from wheelhop.vehicle.layout import CORNERS, corner_position

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

TOLD = 0.7
"""Share of a channel's power from which what it should show says something of it."""
ALIKE = np.log(3.0)
"""A gain within a factor of three of another unit's is that unit; no sensor is as far off."""
OFF = np.log(1.3)
"""So much, of the logarithm, no potentiometer's gain is off, noise of the accelerometers included,
that does not stand for another ratio to the wheel."""
USUAL_NOISE = 1e-3
"""Of its rms, taken for the noise of a channel of which nothing better is known."""


@dataclass(frozen=True)
class _Shown:
    """How a channel compares with what it should show: their correlation, squared, and the gain."""

    share: float
    gain: float


def identity_findings(campaign: Campaign, values: Mapping[str, float]) -> Iterator[Finding]:
    """What is wrong with potentiometers and gyros whose motion accelerometers show as well."""
    for i, channel in enumerate(campaign.channels):
        if channel.quantity == "travel" and channel.corner is not None:
            shown = {c: _compared(campaign, i, _ends(campaign, c)) for c in CORNERS}
            own = shown[channel.corner]
            better = max(shown, key=lambda c: shown[c].share)
            if own.share < TOLD / 2 and shown[better].share > TOLD:
                yield _of_another_corner(channel, better + 1)
            else:
                yield from _signed(campaign, channel, own)
        elif channel.quantity == "rate":
            turn = _compared(campaign, i, _turn(campaign, channel, values))
            yield from _signed(campaign, channel, turn)


def _ends(campaign: Campaign, corner: int) -> dict[str, float]:
    """Travel's acceleration by the channels at both ends of a strut, if there are."""
    named = {c.point: c.name for c in campaign.channels}
    upper, lower = (named.get(f"{place}{corner + 1}") for place in "BA")
    return {} if upper is None or lower is None else {upper: 1.0, lower: -1.0}


def _turn(campaign: Campaign, channel: Channel, values: Mapping[str, float]) -> dict[str, float]:
    """A rate's derivative as a sum of the body points' accelerations, if they tell it: pitch is
    positive nose down, roll left side up."""
    points = [c for c in campaign.channels if c.is_body_point and c.corner is not None]
    place = [corner_position(values, c.corner) for c in points if c.corner is not None]
    motions = np.array([(1.0, -x, y) for x, y in place]).reshape(-1, 3)
    told = np.linalg.pinv(motions)
    turns = ("heave", "pitch", "roll").index(channel.point)
    if not np.isclose((told @ motions)[turns, turns], 1.0):
        return {}
    return dict(zip([c.name for c in points], told[turns].tolist(), strict=True))


def _compared(campaign: Campaign, column: int, parts: Mapping[str, float]) -> _Shown:
    """A channel against accelerations added up. Every frequency counts by what noise leaves of it,
    which an acceleration has most of below, integrated, and a channel of travel above."""
    channel, names = campaign.channels[column], [c.name for c in campaign.channels]
    weights = np.array([parts.get(name, 0.0) for name in names])
    if not parts:
        return _Shown(0.0, np.nan)
    order = 2 if channel.quantity == "travel" else 1
    cross = power = square = 0.0
    for run in campaign.runs:
        band = InBand(len(run.time_s), campaign.sample_rate_hz, campaign.band_hz)
        half = band.count // 2
        seen = band.coefficients(np.column_stack([run.record[:, column], run.record @ weights]))
        lines: ComplexArray = seen[:half] + 1j * seen[half:]
        turn = (2j * np.pi * band.frequency_hz) ** order
        should = channel.per_wheel * lines[:, 1] / turn
        noise = [_noise(campaign, column), channel.per_wheel * _noise(campaign, None)]
        weight = 1.0 / (noise[0] ** 2 + (noise[1] * np.abs(1.0 / turn)) ** 2)
        cross += float(np.sum(weight * lines[:, 0] * should.conj()).real)
        power += float(np.sum(weight * np.abs(should) ** 2))
        square += float(np.sum(weight * np.abs(lines[:, 0]) ** 2))
    if not power * square > 0.0:
        return _Shown(0.0, np.nan)
    return _Shown(cross**2 / (power * square), cross / power)


def _noise(campaign: Campaign, column: int | None) -> float:
    """About how noisy a channel is, or, None, the accelerations are: from one channel to the next
    only the proportion counts."""
    if column is None:
        column = next(i for i, c in enumerate(campaign.channels) if c.is_acceleration)
    scale = campaign.channels[column].noise_scale
    if campaign.noise_rms is not None:
        return campaign.noise_rms * scale
    return float(USUAL_NOISE * scale)


def _of_another_corner(channel: Channel, corner: int) -> Finding:
    return Finding(
        "before",
        "misplaced",
        f"channels {channel.name}",
        f"{channel.name} does not show what body and axle do at corner {(channel.corner or 0) + 1},"
        f" but what they do at corner {corner}.",
        f"Look which potentiometer is {channel.name}, and at corner = … under [channels].",
        fixes=(
            of_campaign(
                f"Write {channel.name} at corner {corner}",
                (("channels", channel.name, "corner"), corner),
            ),
        ),
    )


def _signed(campaign: Campaign, channel: Channel, shown: _Shown) -> Iterator[Finding]:
    """Whether a channel has the sign and the unit that it should."""
    if shown.share < TOLD:
        return
    if shown.gain < 0.0:
        yield Finding(
            "before",
            "polarity",
            f"channels {channel.name}",
            f"{channel.name} counts the wrong way round: accelerometers show the opposite of it.",
            "Turn the sensor round, or change the sign of its column, or of per_wheel.",
            "certain",
            fixes=(turned(campaign, [channel.name]),),
        )
    gain = np.log(abs(shown.gain))
    away = {
        unit: abs(gain - np.log(factor)) for unit, factor in OTHER_UNITS[channel.quantity].items()
    }
    unit = min(away, key=lambda name: away[name])
    times = f"{channel.name} shows {abs(shown.gain):.3g} times what accelerometers say"
    if away[unit] < ALIKE and away[unit] < abs(gain):
        yield Finding(
            "before",
            "units",
            f"units of {channel.name}",
            f"{times}: it seems to be in {unit}, not in {channel.unit}.",
            f"Convert {channel.name} to {channel.unit}.",
            fixes=(
                scaled(
                    campaign,
                    {channel.name: 1.0 / OTHER_UNITS[channel.quantity][unit]},
                    f"Convert {channel.name} from {unit}",
                ),
            ),
        )
    elif channel.corner is not None and abs(gain) > OFF:
        yield Finding(
            "before",
            "ratio",
            f"per_wheel of {channel.name}",
            f"{times} and per_wheel = {channel.per_wheel:g} states.",
            "Look at per_wheel: what the sensor shows per what happens at the wheel.",
            fixes=(ratio(channel, float(abs(shown.gain))),),
        )
