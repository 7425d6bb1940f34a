"""What the user of a comparison should know, a line each."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from wheelhop.calibration.conditions import Conditions
from wheelhop.calibration.shaker.chain import Chain, fit_chain
from wheelhop.calibration.shaker.points import Points
from wheelhop.calibration.shaker.response import high_pass
from wheelhop.calibration.shaker.result import LEAST_COHERENCE, ChannelCalibration

COARSE = 0.003  # relative standard uncertainty by rounding
NONLINEAR = 1.75  # of the expanded uncertainty: it is the worst of several pairs
CONTRADICTION = 2.0  # of the frequencies: Birge ratio
HIGH_PASSES_HZ = np.geomspace(0.05, 2.0, 38)
EXPLAINED = 0.5  # what a high-pass has to bring the Birge ratio down to, relative


def find(
    channels: Sequence[ChannelCalibration],
    usable: Sequence[Points],
    chain: Chain,
    conditions: Conditions,
) -> Iterator[str]:
    """Findings; what holds for several channels is one line. `usable` are the points fitted."""
    lines: dict[str, list[str]] = {}
    for number, channel in enumerate(channels):
        for line in _of_channel(channel, chain, number):
            lines.setdefault(line, []).append(channel.name)
    yield from (f"{', '.join(names)}: {line}" for line, names in lines.items())
    if chain.birge.max() > CONTRADICTION:
        yield from _apparent_high_pass(usable, chain, conditions)
    if not conditions.reference_expanded:
        yield "the reference's uncertainty is not stated: what is given lacks it"


def _of_channel(channel: ChannelCalibration, chain: Chain, number: int) -> Iterator[str]:
    points = channel.points
    low, high = channel.usable_hz
    bad = points.coherence < LEAST_COHERENCE
    why = f"the coherence is below {LEAST_COHERENCE:g} there, the motion sinks into the noise"
    if (points.frequency_hz[bad] < low).any():
        yield f"unusable below {low:.2g} Hz: {why}"
    if (points.frequency_hz[bad] > high).any():
        yield f"unusable above {high:.3g} Hz: {why}"
    if chain.polarity[number] < 0:
        yield "reversed: its code falls when the reference goes up"
    if chain.birge[number] > CONTRADICTION:
        yield (
            f"the frequencies contradict each other, {chain.birge[number]:.1f} times what their"
            " own scatter allows; the uncertainty is widened by that"
        )
    if dict(channel.budget)["quantisation"] > COARSE:
        yield "the motion is few codes strong, so rounding makes the gain uncertain: drive harder"
    linear = channel.nonlinearity
    if linear and linear.value > NONLINEAR * linear.expanded:
        yield (
            f"the gain changes with amplitude by {100 * linear.value:.2f} %, where"
            f" {100 * linear.expanded:.2f} % are expected (k = 2)"
        )


def _apparent_high_pass(
    usable: Sequence[Points], chain: Chain, conditions: Conditions
) -> Iterator[str]:
    """Whether a high-pass in the reference's amplifier, not stated, explains the contradiction."""
    fixed = bool((chain.parameters[2::3] == 0).all())
    stated = conditions.high_pass_hz
    ratios = []
    for corner in HIGH_PASSES_HZ:
        tried = [
            replace(p, ratio=p.ratio * high_pass(p.frequency_hz, float(corner))) for p in usable
        ]
        ratios.append(float(fit_chain(tried, chain.clock, fixed).birge.max()))
    best = int(np.argmin(ratios))
    if ratios[best] < EXPLAINED * chain.birge.max() and not stated:
        yield (
            f"magnitude and phase look as if the reference had a high-pass at"
            f" {HIGH_PASSES_HZ[best]:.2g} Hz: if its amplifier has, give it as high_pass_hz"
        )
