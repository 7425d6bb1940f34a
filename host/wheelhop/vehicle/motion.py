"""The motion a rig recorded: displacement, velocity and acceleration as functions of time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import interpolate

from wheelhop.campaign import ComponentCampaign, RigRun

Array = NDArray[np.float64]


class Motion:
    """Splines through a run's displacement and its velocity, which is the displacement's
    derivative unless it was recorded."""

    def __init__(self, campaign: ComponentCampaign, run: RigRun) -> None:
        smooth = _smooth(run.displacement, campaign.sample_rate_hz, campaign.band_hz[1])
        self._displacement = interpolate.make_interp_spline(run.time_s, smooth, k=5)
        self._velocity = self._displacement.derivative()
        if run.velocity is not None:
            self._velocity = interpolate.make_interp_spline(run.time_s, run.velocity, k=5)
        self._acceleration = self._velocity.derivative()

    def at(self, time_s: Array) -> Array:
        """Displacement (m), velocity (m/s) and acceleration (m/s²) at times (T,), as (3, T)."""
        return np.stack(
            [f(time_s) for f in (self._displacement, self._velocity, self._acceleration)]
        )


def _smooth(x: Array, rate_hz: float, band_end_hz: float) -> Array:
    """A record without what lies far above the band, its ends as they are.

    A local polynomial (A. Savitzky, M. Golay, Anal. Chem. 36 (1964) 1627) of half-power frequency
    2 × the band's upper end (R. Schafer, IEEE Signal Process. Mag. 28 (2011) 111, eq. 12).
    """
    from scipy.signal import savgol_filter  # takes long to import

    order, cutoff = 4, 2 * band_end_hz / (rate_hz / 2)
    length = 2 * round(((order + 1) / cutoff + 4.6) / 3.2 / 2) + 1
    if not order + 1 < length <= len(x):
        return x
    return np.asarray(savgol_filter(x, length, order, mode="interp"))
