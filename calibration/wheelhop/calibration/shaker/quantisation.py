"""What rounding to whole codes can do to the fit of a sine.

The error is no noise: it depends on where the sine lies between two codes and on which of its
phases are sampled, and a frequency that divides the rate meets few. With many phases and no noise
the amplitude of a sine of A codes is off by Σₖ 2/(πk) J₁(2πkA) cos(2πkc), up to 0.2/√A codes
(Widrow and Kollár, Quantization Noise, 2008: the characteristic function of a sine at the
quantiser). So it is played through, with random phases and levels (GUM supplement 1).
"""

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.shaker.response import conversion_instants_s, converted
from wheelhop.calibration.shaker.sine import Sine
from wheelhop.logger.recording import Recording

DRAWS = 32
MOST_SCANS = 1000
GOLDEN_SECTION = 0.618034  # spreads the draws evenly, whatever their levels
ROUNDING_VARIANCE = 1 / 12  # of one conversion, code²


def rounding_errors(log: Recording, column: int, sine: Sine, step: int) -> NDArray[np.complex128]:
    """(DRAWS,) relative errors of the fundamental: in magnitude (real) and phase (imaginary), rad.

    `sine` is what was fitted to the channel's codes in a step. The same draw of every step has the
    same level between two codes, as the sensor has: sines of like amplitude err alike. Noise that
    the residual shows beyond rounding dithers, and counts as common to a scan, which is cautious.
    """
    number, conversions = converted(log, column)
    rng = np.random.default_rng(step)
    scans = np.arange(min(sine.count, MOST_SCANS)) / log.rate_hz
    times = scans[:, None] + conversion_instants_s(number, conversions)
    turn = np.exp(2j * np.pi * sine.frequency_hz * times)[..., None]
    start = np.exp(1j * rng.uniform(0, 2 * np.pi, DRAWS))
    level = (np.arange(DRAWS) + 0.5) / DRAWS
    # The fitted amplitude is off itself, by part of a code: so all of a period of J₁ is tried.
    spread = (np.arange(DRAWS) * GOLDEN_SECTION) % 1 - 0.5
    dither = np.sqrt(max(0.0, sine.residual_rms**2 - ROUNDING_VARIANCE / conversions))
    noise = dither * rng.standard_normal((len(scans), 1, DRAWS))
    exact = (sine.amplitude + spread) * (turn * start).real + level + noise
    error = (np.rint(exact) - exact).mean(axis=1)
    base = 2 * np.pi * sine.frequency_hz * scans
    columns = np.column_stack([np.ones_like(base), np.cos(base), np.sin(base)])
    found = np.linalg.lstsq(columns, error, rcond=None)[0]
    return np.asarray((found[1] - 1j * found[2]) / (start * sine.amplitude))
