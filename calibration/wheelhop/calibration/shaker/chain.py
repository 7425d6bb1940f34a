"""One model for all channels and frequencies: gains, the sensors' corners, and the two clocks.

The ratio of channel c to the reference, the averaging already taken out, is

    H(f, t) = g⁻¹ · 1 / (1 + i ω T) · exp(i ω (τ_c + d t)),   ω = 2π f

g gain, T the sensor's time constant, τ_c what the offset of the clocks lacks for this channel, d
what the drift lacks. The logarithm's real part and its phase are fitted by Gauss-Newton, weighted
by the uncertainties. A delay that all channels share cannot be told from the clocks' offset: the
offset is the mean of τ_c, and each channel's delay is against that mean.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.shaker.align import Clock
from wheelhop.calibration.shaker.points import Points
from wheelhop.calibration.shaker.response import one_pole

Array = NDArray[np.float64]

NOMINAL_TIME_CONSTANT_S = 1 / (2 * np.pi * 50.0)
PRIOR_CONSTANT_S = NOMINAL_TIME_CONSTANT_S
"""Standard uncertainty of the time constant before any data: it matters where the frequencies lie
too close together to show the filter, and widens the static gain there, as it should."""
ITERATIONS = 12
GAIN, CONSTANT, OFFSET = 0, 1, 2  # of a channel's parameters


@dataclass(frozen=True, eq=False)
class Chain:
    """The fit. Parameters: drift, then ln g, T and τ of each channel; `covariance` of the same.

    `gain` is signed: negative where a channel's polarity is reversed. `residuals` are complex, one
    array a channel: relative in magnitude (real) and rad (imaginary). `birge` is what the scatter
    of a channel's points is, relative to their own uncertainties; the covariance counts it if > 1.
    `noise_covariance` and `rounding_covariance` are what the points' two uncertainties contribute;
    rounding errs alike in like steps, which the latter knows.
    """

    clock: Clock
    parameters: Array
    covariance: Array
    polarity: NDArray[np.int_]
    residuals: tuple[NDArray[np.complex128], ...]
    birge: Array
    noise_covariance: Array
    rounding_covariance: Array

    def of(self, channel: int, kind: int) -> int:
        """Where a channel's parameter is."""
        return 1 + 3 * channel + kind

    def gain(self, channel: int) -> float:
        """Static gain, in m/s² per unit of the channel."""
        return float(self.polarity[channel] * np.exp(self.parameters[self.of(channel, GAIN)]))

    def parts(self, weights: Array) -> tuple[tuple[str, float], ...]:
        """What makes up `deviation`; the last is what the points' own uncertainties leave open."""
        noise = float(weights @ self.noise_covariance @ weights)
        rounding = float(weights @ self.rounding_covariance @ weights)
        rest = max(0.0, self.deviation(weights) ** 2 - noise - rounding)
        named = (("repeatability", noise), ("quantisation", rounding), ("fit", rest))
        return tuple((name, variance**0.5) for name, variance in named)

    def deviation(self, weights: Array) -> float:
        """Standard uncertainty of a linear combination of the parameters."""
        return float(np.sqrt(weights @ self.covariance @ weights))


def lock(points: Points, clock: Clock, reach_s: float, drifts: float = 0.0) -> tuple[Clock, int]:
    """The offset within `reach_s` (and drift within `drifts`) at which the phases agree best.

    Agreement is |Σ w cos| with the nominal filter; the sign is the channel's polarity. Offsets that
    differ by a period of every frequency look the same: several frequencies decide.
    """
    omega = 2 * np.pi * points.frequency_hz
    weight = 1 / (points.uncertainty + 0.05)
    phase = np.angle(points.ratio / one_pole(points.frequency_hz, NOMINAL_TIME_CONSTANT_S))
    offsets = np.arange(-reach_s, reach_s, 1 / (40 * points.frequency_hz.max()))
    best = (-1.0, 0.0, 0.0, 1)
    for drift in np.linspace(-drifts, drifts, 21) if drifts else (0.0,):
        shift = offsets[:, None] + drift * points.time_s
        score = np.cos(phase - omega * shift) @ weight
        top = int(np.argmax(np.abs(score)))
        best = max(best, (abs(score[top]), offsets[top], drift, int(np.sign(score[top]))))
    _, offset, drift, polarity = best
    return Clock(clock.offset_s + float(offset), clock.drift + float(drift)), polarity


def rephased(points: Points, old: Clock, new: Clock) -> Points:
    """The points as they would have come out with another clock."""
    shift = new.offset_s - old.offset_s + (new.drift - old.drift) * points.time_s
    return points.corrected(np.exp(2j * np.pi * points.frequency_hz * shift))


def fit_chain(channels: Sequence[Points], clock: Clock, fixed_corner: bool = False) -> Chain:
    """Fit all channels' points, whose phases are right to a fraction of a cycle at `clock`.

    With `fixed_corner` the sensors' time constants are held at 0: the channels are in m/s² and
    whatever filter they have is unknown.
    """
    polarity = np.array([_polarity(points) for points in channels])
    parameters = np.zeros(1 + 3 * len(channels))
    for number, points in enumerate(channels):
        heaviest = np.argmin(points.uncertainty)
        parameters[1 + 3 * number] = -np.log(np.abs(points.ratio[heaviest]))
        parameters[2 + 3 * number] = 0.0 if fixed_corner else NOMINAL_TIME_CONSTANT_S
    birge = np.ones(len(channels))
    for _ in range(2):  # a second time with weights that know the scatter
        for _ in range(ITERATIONS):
            sums = _Sums(len(parameters))
            residuals = [
                sums.add(
                    points, parameters, number, (polarity[number], birge[number]), fixed_corner
                )
                for number, points in enumerate(channels)
            ]
            inverse = _inverse(sums.normal)
            parameters = parameters + inverse @ sums.right
        birge = np.array([_birge(*pair) for pair in zip(residuals, channels, strict=True)])
    offset = float(parameters[1 + OFFSET :: 3].mean())
    exact = Clock(clock.offset_s + offset, clock.drift + float(parameters[0]))
    noise = inverse @ sums.noise @ inverse
    rounding = inverse @ sums.rounding @ inverse
    # The inverse takes rounding for independent from point to point, which it is not.
    covariance = inverse - inverse @ sums.independent @ inverse + noise + rounding
    return Chain(
        *(exact, parameters, covariance, polarity, tuple(residuals), birge, noise, rounding)
    )


class _Sums:
    """Normal equations over all channels, and how noise and rounding enter their right side."""

    def __init__(self, size: int):
        self.right = np.zeros(size)
        self.normal, self.noise, self.rounding, self.independent = np.zeros((4, size, size))

    def add(
        self,
        points: Points,
        parameters: Array,
        number: int,
        sign_and_birge: tuple[int, float],
        fixed_corner: bool,
    ) -> NDArray[np.complex128]:
        """Add a channel's points and return their residuals."""
        sign, birge = sign_and_birge
        rest, slopes = _linearised(points, parameters, number, int(sign))
        at = 1 + 3 * number + CONSTANT
        if fixed_corner:
            slopes[:, at] = 0
        else:
            self.normal[at, at] += PRIOR_CONSTANT_S**-2
            self.right[at] += (NOMINAL_TIME_CONSTANT_S - parameters[at]) / PRIOR_CONSTANT_S**2
        weighted = slopes.T / np.tile(max(birge, 1.0) * points.uncertainty, 2) ** 2
        self.normal += weighted @ slopes
        self.right += weighted @ np.concatenate([rest.real, rest.imag])
        self.noise += (weighted * np.tile(points.random**2, 2)) @ weighted.T
        self.independent += (weighted * np.tile(points.uncertainty**2, 2)) @ weighted.T
        drawn = weighted @ np.concatenate([points.rounding.real, points.rounding.imag])
        self.rounding += drawn @ drawn.T / drawn.shape[1]
        return rest


def _birge(residuals: NDArray[np.complex128], points: Points) -> float:
    """Birge ratio: root of χ² per degree of freedom, each point counting twice."""
    freedom = max(1, 2 * len(points) - 3)
    return float(np.sqrt((np.abs(residuals / points.uncertainty) ** 2).sum() / freedom))


def _inverse(normal: Array) -> Array:
    """The covariance; what nothing determines, such as a parameter held fixed, gets 0."""
    scale = 1 / np.sqrt(np.maximum(np.diag(normal), 1e-30))
    scaled = scale[:, None] * normal * scale
    return np.asarray(scale[:, None] * np.linalg.pinv(scaled, 1e-13, hermitian=True) * scale)


def _polarity(points: Points) -> int:
    """Sign of the response at low frequencies, where phases are small."""
    turned = points.ratio / one_pole(points.frequency_hz, NOMINAL_TIME_CONSTANT_S)
    weight = 1 / (points.uncertainty + 0.01)
    return 1 if float((np.cos(np.angle(turned)) * weight).sum()) >= 0 else -1


def _linearised(
    points: Points, parameters: Array, number: int, polarity: int
) -> tuple[NDArray[np.complex128], Array]:
    """Complex residuals (n,), and their slopes (2n, parameters), magnitudes before phases."""
    omega = 2 * np.pi * points.frequency_hz
    log_gain, constant, offset = parameters[1 + 3 * number : 4 + 3 * number]
    phase = omega * (offset + parameters[0] * points.time_s)
    pole = one_pole(points.frequency_hz, constant)
    model = polarity * np.exp(-log_gain + 1j * phase) * pole
    rest = np.log(points.ratio / model)
    slopes = np.zeros((2 * len(omega), len(parameters)))
    real, imaginary = slopes[: len(omega)], slopes[len(omega) :]
    real[:, 1 + 3 * number] = -1
    slope = -1j * omega * pole  # of ln pole by the time constant
    real[:, 2 + 3 * number], imaginary[:, 2 + 3 * number] = slope.real, slope.imag
    imaginary[:, 3 + 3 * number] = omega
    imaginary[:, 0] = omega * points.time_s
    return rest, slopes
